"""Quantities that a residual is held against, curves over them, and where it lies: a sentence, a share, errors."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from statsmodels.regression.linear_model import OLS

from friction_audit.diagnosis.problem import AXES, Curve, RegressionProblem, curve, knots_of
from friction_audit.diagnosis.residual_checks import own_axis, profiles_of, shows_along
from friction_audit.diagnosis.result import NamedEffect, Profile
from friction_audit.joint_log import Float
from friction_audit.reporting.diagnosis_words import UNITS, where_words
from tests.effects.joint_data_by_hand import moved_joint
from tests.reporting.diagnosis_by_hand import STRIBECK, coefficient, traces

CYCLES, PER_CYCLE = 40, 120
CYCLE = np.repeat(np.arange(CYCLES), PER_CYCLE)
N = len(CYCLE)
RNG = np.random.default_rng(0)
VALUES = RNG.uniform(0.0, 1.2, N)
UP = np.repeat(np.arange(CYCLES) % 2 == 0, PER_CYCLE)
DQ = np.where(UP, 1.0, -1.0)
NOISE = 0.02 * RNG.standard_normal(N)


def over(name: str, values: Float) -> Curve:
    axis = next(axis for axis in AXES if axis.name == name)
    columns = curve(values, knots_of(values, np.ones(N, bool)), DQ)
    return Curve(axis=axis, columns=np.ascontiguousarray(columns.T), values=values)


def profile(residual: Float, dq: Float = DQ) -> Profile:
    curves, samples = (over("speed", VALUES),), SimpleNamespace(cycle=CYCLE)
    problem: Any = SimpleNamespace(curves=curves, kinematics=(None, dq), samples=samples)
    (found,) = profiles_of(problem, residual, {})
    return found


@pytest.mark.parametrize(
    ("residual", "said"),
    [
        (0.1 * (VALUES < 0.3) * DQ, "below 0.301 rad/s, against the motion"),
        (0.1 * (VALUES > 0.9), "above 0.899 rad/s, same sign in both directions"),
        (0.1 * ((VALUES > 0.4) & (VALUES < 0.7)) * UP, "from 0.4 to 0.7 rad/s, forwards only"),
        (-0.1 * (VALUES < 0.6) * ~UP, "below 0.599 rad/s, backwards only"),
        (0.1 * DQ, "over the whole range of speed, against the motion"),
    ],
)
def test_the_sentence_says_where_and_which_way(residual: Float, said: str) -> None:
    words, expected = where_words(profile(residual + NOISE)).split(), said.split()
    assert len(words) == len(expected)
    for word, wanted in zip(words, expected, strict=True):
        if wanted[0].isdigit():
            # A border of a bin: a twelfth of the samples, 0.1 rad/s.
            assert float(word) == pytest.approx(float(wanted), abs=0.03)
        else:
            assert word == wanted


def test_means_and_errors_are_those_of_cluster_robust_least_squares() -> None:
    residual = NOISE + 0.05 * np.random.default_rng(1).standard_normal(CYCLES)[CYCLE]
    found = profile(residual)
    inside = UP & (found.edges[3] <= VALUES) & (found.edges[4] > VALUES)
    fit = OLS(residual[inside], np.ones(inside.sum())).fit(
        cov_type="cluster", cov_kwds={"groups": CYCLE[inside], "use_correction": False}
    )
    assert found.forwards[3] == pytest.approx(fit.params[0])
    assert found.forwards_se[3] == pytest.approx(fit.bse[0] * np.sqrt(20 / 19))
    assert found.centre[3] == pytest.approx(VALUES[(found.edges[3] <= VALUES) & (found.edges[4] > VALUES)].mean())


def test_share_is_that_of_cycles_not_seen_and_never_below_zero() -> None:
    line = 0.1 * DQ * (VALUES - 0.6)
    explained = float(np.mean(line**2))
    assert profile(line + NOISE).share == pytest.approx(explained / (explained + 0.02**2), rel=0.02)
    assert profile(NOISE).share == 0.0
    assert profile(np.zeros(N)).share == 0.0


DATA = moved_joint(duration_s=10.0)


AXIS = {axis.name: axis.value for axis in AXES}


def test_what_the_log_does_not_hold_is_no_axis_and_each_has_a_unit() -> None:
    there = {name for name, value in AXIS.items() if value(DATA) is not None}
    assert there == {"speed", "position", "displacement", "acceleration", "time"}
    warm = replace(DATA, temperature=DATA.t, load=np.cos(DATA.q))
    assert AXIS["temperature"](warm) is warm.temperature
    assert AXIS["load"](warm) is warm.load
    assert set(UNITS) == set(AXIS)


def test_the_neighbour_is_the_one_that_moves_most_and_never_the_joint_itself() -> None:
    others = np.column_stack([0.1 * DATA.dq, 9.0 * DATA.ddq, 2.0 * DATA.dq])
    among = replace(DATA, others=replace(DATA.others, ddq=others, joint=1))
    assert AXIS["neighbour"](among) == pytest.approx(2.0 * DATA.dq)


# The axis along which an effect is drawn.

TRACES = traces(4)
TORQUE = np.linspace(-0.1, 0.2, len(TRACES.t))


def effect(name: str, **parameters: float) -> NamedEffect:
    numbers = {key: coefficient(value, 0.0) for key, value in parameters.items()}
    return replace(STRIBECK, name=name, parameters=numbers, torque=TORQUE)


def test_waves_are_laid_over_each_other() -> None:
    own: Any = own_axis(effect("torque_ripple", ripple_order=100.0), replace(TRACES, q=TRACES.q * 0.0 + 0.0125 * np.pi))
    assert own.label == "Position within a wave [waves]"
    assert own.values == pytest.approx(0.625)


def test_an_effect_of_other_joints_is_drawn_along_its_torque_and_a_curve_over_the_joint_s_own_motion_is_not() -> None:
    own: Any = own_axis(effect("gravity_error", gravity_error_source=-1.0), TRACES)
    assert (own.label, own.values is TORQUE) == ("Fitted torque of gravity_error [N m]", True)
    assert own_axis(effect("gravity_error", gravity_error_source=0.0), TRACES) is None


def test_ringing_is_drawn_along_its_torque_and_its_means_are_those_of_the_samples() -> None:
    rows = np.arange(4800)
    motion = traces(1600)
    along = motion.along | {"speed": rows % 400 / 400.0}
    ringing = np.sin(0.77 * rows)
    motion = replace(motion, dq=np.where(rows % 2, 1.0, -1.0), along=along, after=motion.measured - 0.5)
    own: Any = own_axis(replace(STRIBECK, torque=ringing), motion)
    assert own.values is ringing
    assert own.after.edges == pytest.approx(np.linspace(ringing.min(), ringing.max(), 13))
    assert own.after.forwards == pytest.approx(0.5)
    assert own.curve.backwards == pytest.approx(0.5 + own.curve.centre, abs=0.05)


X, SIGN, RINGING = np.tile(np.linspace(0.0, 1.0, 600), 8), np.repeat([1.0, -1.0] * 4, 600), np.sin(np.arange(4800))


@pytest.mark.parametrize(
    ("torque", "shown"),
    [
        (np.full(4800, 0.1), True),
        (SIGN * np.exp(-X / 0.1), True),
        (np.sin(400.0 * X), False),
        (np.repeat([1.0, 1.0, -1.0, -1.0] * 2, 600), False),
        (1.1 + np.sqrt(2.0) * RINGING, True),
        (0.9 + np.sqrt(2.0) * RINGING, False),
    ],
    ids=["an offset", "fading", "fine waves", "now this way, now that way", "over half of it", "less than half"],
)
def test_a_place_is_given_where_most_of_the_torque_is_a_curve_over_the_axis(torque: Float, shown: bool) -> None:
    assert shows_along(torque, X, SIGN) is shown


def test_a_quantity_that_changes_between_the_samples_alone_has_no_curve() -> None:
    data = moved_joint(duration_s=20.0)
    between = np.setdiff1d(np.flatnonzero(data.used), RegressionProblem.build(data, None).samples.fine)[0]
    warm = replace(data, temperature=np.where(np.arange(len(data.t)) == between, 25.0, 20.0))
    problem = RegressionProblem.build(warm, None)
    assert {curve.axis.name for curve in problem.curves} >= {"speed", "position"}
    assert "temperature" not in {curve.axis.name for curve in problem.curves}
