"""Torque feedback in a joint whose gear twists: the limit from eigenvalues, against the simulator."""

from dataclasses import replace
from math import inf, sqrt

import numpy as np
import pytest

from friction_audit.compensation.compensators import TorqueRegulation
from friction_audit.simulation import IDEAL_SENSORS, JointParameters, Operator
from friction_audit.simulation.bench import BenchSettings, simulate_bench
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.structure import JointElasticity
from friction_audit.simulation.motion import Sinusoid
from tests.compensation.competitor_bench import TICK_S
from tests.compensation.stability import regulation_limit

INERTIA, HAND = 0.3, 0.3
REDUCED = 0.15


def rings(regulation: TorqueRegulation, compliance: float, damping_ratio: float) -> bool:
    """Return True if what noise sets ringing grows, with next to nobody there to damp it."""
    settings = BenchSettings(
        joints=(JointParameters(inertia_kg_m2=INERTIA, coulomb_nm=0.0, viscous_nms_per_rad=0.0),),
        hidden=(
            Hidden(joint_elasticity=JointElasticity(compliance_rad_per_nm=compliance, damping_ratio=damping_ratio)),
        ),
        sensors=(replace(IDEAL_SENSORS, torque_noise_nm=0.02),),
        operator=Operator(
            inertia_kg_m2=HAND,
            stiffness_nm_per_rad=20.0,
            damping_nms_per_rad=0.05,
            motion=Sinusoid(amplitude_rad=0.01, ease_s=0.5),
        ),
        compensator=regulation,
        duration_s=30.0,
    )
    return bool(np.abs(simulate_bench(settings, 0).truth.motion.compensation_nm).max() > 30.0)


@pytest.mark.parametrize("cutoff_hz", [inf, 100.0, 30.0])
@pytest.mark.parametrize(("compliance", "damping_ratio"), [(1e-4, 0.03), (2e-4, 0.03), (1e-5, 0.03)])
def test_the_loop_rings_just_below_the_limit(compliance: float, damping_ratio: float, cutoff_hz: float) -> None:
    settings = TorqueRegulation(inertia_kg_m2=INERTIA, desired_inertia_kg_m2=INERTIA, cutoff_hz=cutoff_hz)
    limit = regulation_limit(
        settings,
        inertia_kg_m2=INERTIA,
        outer_inertia_kg_m2=HAND,
        period_s=TICK_S,
        stiffness_nm_per_rad=1.0 / compliance,
        damping_nms_per_rad=2.0 * damping_ratio * sqrt(REDUCED / compliance),
    )
    assert not rings(replace(settings, desired_inertia_kg_m2=1.05 * limit), compliance, damping_ratio)
    assert rings(replace(settings, desired_inertia_kg_m2=0.95 * limit), compliance, damping_ratio)
