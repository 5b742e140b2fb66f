"""The gap in motion: none for the model that made the motion, that of what is missing for another."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from friction_audit.diagnosis.augmented_model import gap_in_motion, simulate_cycles
from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.joint_model import FittedTerm, JointModel, simple_model
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from tests.dynamics.joints import simulate
from tests.effects.joint_data_by_hand import joint_of
from tests.reporting.diagnosis_by_hand import STRIBECK

NOMINAL = simple_model(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07)
AUGMENTED = replace(NOMINAL, terms=(*NOMINAL.terms, FittedTerm("stribeck", (0.15, 0.1, 2.0))))


CYCLES = np.array([4, 9])


@cache
def moved() -> JointData:
    """A joint that the augmented model moved under a sinusoidal torque of 2 s, a cycle per half period."""
    t = np.arange(4400) / 400.0
    torque = (0.6 + 0.02 * t) * np.sin(np.pi * t)
    motion = simulate(AUGMENTED, t, torque)
    return data_of(t, torque, motion.q, motion.dq, motion.ddq)


def data_of(t: Float, torque: Float, q: Float, dq: Float, ddq: Float) -> JointData:
    return joint_of(t, q, dq, ddq, torque, cycle=np.floor(t).astype(np.int64), dead_speed_rad_s=1e-3)


def diagnosed(viscous_nms_per_rad: float = 0.07) -> JointDiagnosis:
    numbers = {"inertia_kg_m2": 0.3, "coulomb_nm": 0.3, "viscous_nms_per_rad": 0.07}
    simple = {name: Coefficient(value=one, low=one, high=one) for name, one in numbers.items()}
    wrong = Coefficient(value=viscous_nms_per_rad, low=viscous_nms_per_rad, high=viscous_nms_per_rad)
    return JointDiagnosis(
        joint=1, name="joint1", verdict="named", effects=(STRIBECK,), nominal=simple,
        augmented=simple | {"viscous_nms_per_rad": wrong},
    )  # fmt: skip


def test_the_model_that_made_the_motion_leaves_nothing_from_the_measured_start_of_every_cycle() -> None:
    data = moved()
    gap: Any = simulate_cycles(NOMINAL, AUGMENTED, data, CYCLES)
    assert gap.before > 0.05
    assert gap.after < 0.01 * gap.before
    assert list(np.flatnonzero(np.isnan(gap.t))) == [400]
    assert gap.t[[0, 401]] == pytest.approx([4.0, 9.0])
    for signal in (gap.nominal, gap.augmented, gap.measured):
        assert signal[[0, 401]] == pytest.approx(data.dq[[1600, 3600]])
        assert np.array_equal(np.isnan(signal), np.isnan(gap.t))
    same: Any = gap_in_motion(diagnosed(), None, data, CYCLES)
    assert (same.before, same.after) == (gap.before, gap.after)


def test_by_hand_a_torque_that_is_wrong_adds_up() -> None:
    """A constant 0.03 N m too much for 1 s at 0.3 kg m^2 is 0.1 rad/s at the end: 0.1 / sqrt(3) on average."""
    t = np.arange(0.0, 4.0, 0.0025)
    model = JointModel(inertia_kg_m2=0.3)
    data = data_of(t, np.full(len(t), 0.3), 0.5 * t**2 + t, 1.0 + t, np.ones(len(t)))
    wrong = JointModel(inertia_kg_m2=0.3, terms=(FittedTerm("offset", (-0.03,)),))
    gap: Any = simulate_cycles(wrong, model, data, np.array([1]))
    assert gap.before == pytest.approx(0.1 / np.sqrt(3.0), rel=5e-3)
    assert gap.after < 1e-9


def test_cycles_with_a_gap_are_left_out() -> None:
    valid = moved().valid.copy()
    valid[1700] = False
    gapped = replace(moved(), valid=valid)
    gap: Any = simulate_cycles(NOMINAL, AUGMENTED, gapped, CYCLES)
    assert gap.t[0] == pytest.approx(9.0)
    assert simulate_cycles(NOMINAL, AUGMENTED, gapped, np.array([4])) is None


def test_a_joint_whose_inertia_was_taken_out_needs_it_back() -> None:
    light = replace(moved(), torque=moved().torque - 0.2999 * moved().ddq)
    nominal, found = (replace(model, inertia_kg_m2=1e-4) for model in (NOMINAL, AUGMENTED))
    assert simulate_cycles(nominal, found, light, CYCLES) is None
    gap: Any = simulate_cycles(nominal, found, light, CYCLES, known_inertia_kg_m2=0.2999)
    assert gap.after < 0.1 * gap.before


def test_a_model_that_cannot_be_simulated_has_no_gap_in_motion() -> None:
    runaway = replace(NOMINAL, terms=(*NOMINAL.terms, FittedTerm("nonlinear_viscous", (-40.0, 1.0, 0.1, 0.0))))
    assert simulate_cycles(NOMINAL, runaway, moved(), CYCLES) is None
    assert gap_in_motion(diagnosed(-0.01), None, moved(), CYCLES) is None
