"""One effect hidden in an ideal recording: its own candidate explains what the plain model leaves."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.cycles.segment import segment_cycles
from friction_audit.cycles.settings import CycleSettings
from friction_audit.discrepancy.candidate import Baseline
from friction_audit.discrepancy.candidates import CANDIDATES
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.prepare import prepare
from friction_audit.interaction.extract import extract_interaction
from friction_audit.interaction.settings import TorqueSettings
from friction_audit.joint_log import Float
from friction_audit.simulate import IDEAL_SENSORS, SCENARIOS, simulate
from friction_audit.simulate.hide import hide

SEED = 2
EXPLAINED = (
    "stribeck",
    "nonlinear_viscous",
    "asymmetric_coulomb",
    "asymmetric_viscous",
    "presliding",
    "position_dependent_friction",
    "gravity_error",
    "cable_spring",
    "joint_limit_stop",
    "torque_bias",
    "time_delay",
    "warm_up",
    "friction_step",
)
"""Those of which an ideal recording of one joint leaves little; the others need another motion or more columns."""
WEAK = {"joint_elasticity": 0.4, "torque_ripple": 0.6}
"""Share that a candidate explains at least, where its columns are known to be a part of the effect."""


def recorded(scenario: str, *effects: str) -> JointData:
    settings = next(s.settings for s in SCENARIOS if s.name == scenario)
    settings = hide(replace(settings, duration_s=60.0, sensors=(IDEAL_SENSORS,)), effects)
    log = simulate(settings, SEED).log
    interaction = extract_interaction(log, TorqueSettings())
    return prepare(interaction, segment_cycles(interaction, CycleSettings()), log)[0]


def plain_fit(data: JointData) -> tuple[Float, Baseline]:
    plain: Float = np.column_stack([data.ddq, np.sign(data.dq), data.dq]).astype(np.float64)
    factors = np.linalg.lstsq(plain[data.used], data.torque[data.used], rcond=None)[0]
    j, fc, fv = (float(f) for f in factors)
    return plain, Baseline(inertia_kg_m2=j, coulomb_nm=fc, viscous_nms_per_rad=fv, torque=plain @ factors)


def share_explained(data: JointData, name: str) -> float:
    """Of the plain model's residual, by the best shape with possible factors."""
    plain, baseline = plain_fit(data)
    candidate = next(c for c in CANDIDATES if c.name == name)
    used = data.used
    left = data.torque[used] - baseline.torque[used]
    best = 0.0
    for shape in candidate.tried(data):
        full = np.hstack([plain, candidate.columns(data, baseline, shape)])[used]
        factors = np.linalg.lstsq(full, data.torque[used], rcond=None)[0]
        if candidate.admissible(factors[plain.shape[1] :].astype(np.float64), shape):
            rest = data.torque[used] - full @ factors
            best = max(best, 1.0 - float(rest @ rest) / float(left @ left))
    return best


def test_the_sign_is_not_biased_by_the_filter_where_motion_is_certain() -> None:
    _, baseline = plain_fit(recorded("joint"))
    assert baseline.coulomb_nm == pytest.approx(0.30, rel=0.01)
    assert baseline.viscous_nms_per_rad == pytest.approx(0.07, rel=0.02)
    assert baseline.inertia_kg_m2 == pytest.approx(0.30, rel=0.01)


@pytest.mark.parametrize("name", EXPLAINED)
def test_its_own_candidate_explains_an_effect(name: str) -> None:
    assert share_explained(recorded("joint", name), name) > 0.9


def test_load_is_explained_where_gravity_is_logged() -> None:
    assert share_explained(recorded("joint-loaded", "load_dependent_friction"), "load_dependent_friction") > 0.9


@pytest.mark.parametrize("name", WEAK)
def test_its_own_candidate_explains_a_part_of_an_effect(name: str) -> None:
    assert share_explained(recorded("joint", name), name) > WEAK[name]
