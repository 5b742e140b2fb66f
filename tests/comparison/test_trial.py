"""Measures of a trial, by hand where a hand can."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.compensation.comparison import METHODS
from friction_audit.compensation.comparison.methods import Tuning
from friction_audit.compensation.comparison.trial import (
    Reference,
    energy_slope_w,
    find_reference,
    make_course,
    measure,
    vibration_nm,
)
from friction_audit.compensation.compensators import FixedCompensation, TorqueRegulation
from friction_audit.errors import AnalysisError
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.scenarios import simulate
from friction_audit.simulation.settings import IDEAL_SENSORS
from friction_audit.simulation.simulation import Simulation
from tests.comparison.conftest import short_joint

IDLE = FixedCompensation(coulomb_nm=0.0, viscous_nms_per_rad=0.0)


def rigid(compensator: FixedCompensation | TorqueRegulation) -> Simulation:
    settings = short_joint().settings
    return simulate(replace(settings, hidden=(Hidden(),), sensors=(IDEAL_SENSORS,), compensator=compensator), 0)


def test_without_compensation_a_person_feels_the_joint() -> None:
    alone = rigid(IDLE)
    outcome = measure(alone, find_reference(alone))
    assert outcome.stable
    assert outcome.lost_s == np.inf
    assert (outcome.coulomb_left, outcome.viscous_left, outcome.inertia_left) == pytest.approx((1, 1, 1), abs=1e-3)
    assert outcome.standstill_rad_s == 0.0
    motion, ends = alone.truth.motion, find_reference(alone).ends
    per_cycle = (motion.dissipated_j[ends[-1], 0] - motion.dissipated_j[ends[1], 0]) / (
        motion.t[ends[-1]] - motion.t[ends[1]]
    )
    assert outcome.energy_slope_w == pytest.approx(per_cycle, rel=0.1)


def test_a_competitor_that_is_unstable_is_caught_and_drawn_up_to_there() -> None:
    scene = short_joint()
    (method,) = (one for one in METHODS if one.name == "torque_regulation")
    wild: Tuning = method.sweeps[0].at(40.0)
    reference = find_reference(simulate(scene.compensated(METHODS[0].paper), 0))
    simulation = simulate(scene.compensated(wild), 0)
    outcome, course = measure(simulation, reference), make_course(simulation, reference)
    assert not outcome.stable
    assert 0.0 < outcome.lost_s < scene.settings.duration_s
    assert course.lost_s == outcome.lost_s == course.t[-1]
    assert len(course.t) == len(course.dq) == len(course.interaction_nm) == len(course.energy_j)


def test_slope_is_read_at_the_ends_of_cycles() -> None:
    t = np.linspace(0.0, 4.0, 401)
    ends = np.array([100, 200, 300, 400])
    reference = Reference(ends=ends, resting=np.zeros((401, 1), bool), rms_torque_nm=np.ones(1))
    rising = np.where(t < 2.0, 5.0 * t, 10.0 + 0.5 * (t - 2.0)) + np.sin(np.pi * t) ** 2
    assert energy_slope_w(rising, t, reference) == pytest.approx(0.5)


def test_vibration_is_what_is_fast() -> None:
    t = np.arange(0.0, 4.0, 1e-3)[:, None]
    assert np.abs(vibration_nm(np.sin(2 * np.pi * 0.5 * t))[500:-500]).max() < 0.01
    fast = vibration_nm(np.sin(2 * np.pi * 60.0 * t))[500:-500]
    assert np.sqrt(np.mean(fast**2)) == pytest.approx(np.sqrt(0.5), rel=0.1)


def test_too_short_a_trial_is_refused() -> None:
    scene = short_joint(duration_s=2.0)
    with pytest.raises(AnalysisError, match="longer --duration"):
        find_reference(simulate(scene.compensated(METHODS[0].paper), 0))
