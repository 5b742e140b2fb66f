"""Viscous friction over-compensated in a joint whose gear twists: the passivity controller must not drive the mode."""

from dataclasses import replace
from math import pi, sqrt

import pytest

from friction_audit.compensation.comparison.trial import vibration_nm
from friction_audit.compensation.compensators import Coefficients, EnergyCompensator
from friction_audit.compensation.compensators.law import payback_s
from friction_audit.simulation import PANDA_SENSORS, JointParameters, Operator
from friction_audit.simulation.bench import BenchSettings, simulate_bench
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.structure import JointElasticity

MOTOR, OUTER, DAMPING_RATIO = 0.3, 1.0, 0.1
OVER = EnergyCompensator(
    forced=Coefficients(viscous_nms_per_rad=2.5),
    forced_from_cycle=1,
    forced_until_acted=False,
    max_torque_nm=87.0,
    max_torque_rate_nm_s=1000.0,
)


def vibration(hz: float, compensator: EnergyCompensator, seed: int = 0, duration_s: float = 10.0) -> float:
    """Return the rms of the interaction torque that is faster than a person, from the second second on. [N m]"""
    compliance = (1.0 / MOTOR + 1.0 / OUTER) / (2.0 * pi * hz) ** 2
    settings = BenchSettings(
        joints=(JointParameters(inertia_kg_m2=MOTOR, coulomb_nm=0.311, viscous_nms_per_rad=0.075),),
        hidden=(
            Hidden(joint_elasticity=JointElasticity(compliance_rad_per_nm=compliance, damping_ratio=DAMPING_RATIO)),
        ),
        sensors=(PANDA_SENSORS[0],),
        operator=Operator(inertia_kg_m2=OUTER, stiffness_nm_per_rad=375.0, damping_nms_per_rad=62.0),
        compensator=compensator,
        duration_s=duration_s,
    )
    motion = simulate_bench(settings, seed).truth.motion
    return float(sqrt((vibration_nm(motion.interaction_nm)[2000:] ** 2).mean()))


@pytest.mark.parametrize("hz", [10.0, 18.0, 33.0, 71.0])
def test_over_compensation_does_not_make_the_joint_ring(hz: float) -> None:
    mode = 2.0 * pi * hz
    assert vibration(hz, replace(OVER, payback_s=payback_s(mode, DAMPING_RATIO))) < 0.2


def test_within_a_tick_it_does() -> None:
    assert vibration(33.0, replace(OVER, payback_s=0.0)) > 0.5
