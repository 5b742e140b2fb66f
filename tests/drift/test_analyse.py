from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st
from scipy import stats

from friction_audit.drift.analyse import analyse_arm
from friction_audit.drift.change_test import estimate_autocorrelation, make_directions, studentise
from friction_audit.drift.report import ArmDrift, CoefficientDrift, DriftSettings, parse_limit
from friction_audit.drift.session import Series, Session, make_series
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from friction_audit.reporting.drift_words import arm_sentence, describe, joint_sentence, limits_beyond_all
from tests.drift.made_sessions import FIRST_S, make_arm_sessions, make_joint, make_session, make_sessions, noisy
from tests.each_case import thorough, with_thorough

QUICK = DriftSettings(permutations=199)


def analyse(sessions: list[Session], chosen: DriftSettings = QUICK) -> ArmDrift:
    return analyse_arm(sessions, chosen)


def coulomb(sessions: list[Session], chosen: DriftSettings = QUICK) -> CoefficientDrift:
    return analyse(sessions, chosen).joints[0].coefficients[0]


def stepped(level: Float, at: int, factor: float = 1.15) -> Float:
    """Return a level that is higher from a session on."""
    return level * np.where(np.arange(len(level)) >= at, factor, 1.0)


def described(sessions: list[Session]) -> tuple[CoefficientDrift, str]:
    found = coulomb(sessions)
    return found, describe(found, sessions)


def test_step_of_15_percent_of_one_joint_is_found_sized_and_dated_and_leaves_the_others_alone() -> None:
    sessions = make_arm_sessions(stepped(noisy(24), 14))
    arm = analyse(sessions)
    assert [joint.joint for joint in arm.joints if joint.drift] == [1]
    assert joint_sentence(arm, arm.joints[0]).startswith("Coulomb friction rose by 1")
    assert joint_sentence(arm, arm.joints[0]).endswith("; no other change found")
    assert arm_sentence(arm).endswith("; no other change found")
    (text,) = limits_beyond_all([arm], [parse_limit(one) for one in ("coulomb=15", "coulomb=15%")])
    assert text.endswith(" N m; per cent is coulomb=15%")
    both = arm_sentence(replace(arm, joints=(*arm.joints[:1], replace(arm.joints[0], joint=4))))
    assert "; joint 4: Coulomb friction rose by 1" in both
    assert "no other change" not in both
    found = arm.joints[0].coefficients[0]
    text = describe(found, sessions)
    assert (found.drift, found.shape) == (True, "step")
    (step,) = found.change_points
    assert (step.session, step.low, step.high) == (14, 14, 14)
    assert step.relative.low < 0.15 < step.relative.high
    assert step.relative.high - step.relative.low < 0.03
    assert found.total.value == pytest.approx(0.15, abs=0.01)
    assert "Coulomb friction rose by 15 %" in text
    assert "between 2026-03-14 and 2026-03-15" in text


def test_slow_rise_is_a_ramp() -> None:
    found = coulomb(make_sessions(noisy(20) * (1.0 + 0.01 * np.arange(20))))
    assert (found.drift, found.shape, found.change_points) == (True, "ramp", ())
    assert found.trend_per_session.low < 0.003 < found.trend_per_session.high
    assert found.trend_per_day.value == pytest.approx(found.trend_per_session.value)
    assert found.total.value == pytest.approx(1.19 / 1.02 - 1, abs=0.02)


def test_nothing_changes() -> None:
    arm = analyse(make_sessions(noisy(30, 3)))
    assert not arm.drift
    found = arm.joints[0].coefficients[0]
    assert found.shape == "none"
    assert not any(point.outside for point in found.control)
    # A straight change is seen from (t + z) sd sqrt(12 / n) = (3.3 + 1.3) 1.05 % 0.63 on; 30 sessions of one joint do
    # not rule out autocorrelations up to 0.4, which make sqrt((1 + 0.4) / (1 - 0.4)) times that.
    assert 0.9 < found.smallest_drift / 0.0305 < np.sqrt(1.4 / 0.6)
    assert arm_sentence(arm).startswith("no drift in 30 sessions: changes of ")


@pytest.mark.parametrize("at", [0, 13, 29])
def test_one_broken_estimate_is_no_drift(at: int) -> None:
    level = noisy(30, 1)
    level[at] *= 1.6
    found, text = described(make_sessions(level))
    assert (found.drift, found.isolated) == (False, (at,))
    assert found.control[at].outside
    assert at != 29 or "session 30 (2026-03-30) does not fit: 6" in text


def rise(*, odd_at: int | None = None, back_for: int = 0, seed: int = 0) -> list[Session]:
    """30 sessions, 15 % higher from the 16th on, each known to 5 %; an old one dated later, or the last ones back."""
    level = np.where(np.arange(30) >= 15, 0.345, 0.3)
    level[30 - back_for :] = 0.3
    if odd_at is not None:
        level = np.insert(np.delete(level, 2), odd_at, 0.3)
    return make_sessions(level * noisy(30, seed, level=1.0, scatter=0.02), error=0.025 * 0.32, seed=seed)


ODD = ((None, 1), (29, 2), (28, 3), (21, 1))


@pytest.mark.parametrize(("odd_at", "seed"), with_thorough(ODD, (None, 29, 28, 21), range(1, 4)))
def test_one_odd_session_does_not_hide_a_step(odd_at: int | None, seed: int) -> None:
    found, text = described(rise(odd_at=odd_at, seed=seed))
    assert (found.drift, found.shape) == (True, "step")
    assert found.isolated == (() if odd_at is None else (odd_at,))
    assert found.total.low < 0.15 < found.total.high
    assert found.total.high - found.total.low < 0.13
    assert found.change_points[0].low <= (15 if odd_at is None else 14) <= found.change_points[0].high
    assert odd_at is None or f"session {odd_at + 1} (2026-03-{odd_at + 1}) does not fit: 1" in text


@pytest.mark.parametrize("back_for", [3, 5])
def test_a_joint_that_recovered_is_no_odd_session(back_for: int) -> None:
    found, text = described(rise(back_for=back_for, seed=1))
    assert (found.drift, found.shape, found.isolated) == (True, "steps", ())
    assert [point.session for point in found.change_points] == [15, 30 - back_for]
    assert found.total.low < 0.0 < found.total.high
    assert "changed in 2 steps: rose by 1" in text


@pytest.mark.parametrize(("error", "drift"), [(0.003, True), (0.012, False)])
def test_a_step_within_the_errors_of_the_sessions_is_no_drift(error: float, drift: bool) -> None:
    found = coulomb(make_sessions(stepped(noisy(30, 1), 10, 1.03), error=error))
    assert [found.drift, found.p_value <= 0.05, found.total.low > 0.0] == [drift] * 3


@pytest.mark.parametrize("count", [1, 2, 3])
def test_too_few_sessions_say_how_many_are_needed(count: int) -> None:
    arm = analyse(make_sessions(noisy(count)))
    assert arm.joints[0].coefficients[0].shape == "too_few"
    assert not arm.drift
    assert "at least 4 are needed" in arm_sentence(arm)


def test_temperature_that_varies_explains_the_changes() -> None:
    warmth = 25.0 + 4.0 * np.random.default_rng(4).standard_normal(24)
    level = noisy(24) * np.exp(-0.01 * (warmth - 25.0))
    found = coulomb(make_sessions(level, temperature=warmth))
    assert not found.drift
    assert found.temperature_slope.low < -0.01 < found.temperature_slope.high
    changed = coulomb(make_sessions(stepped(level, 9), temperature=warmth))
    assert (changed.shape, changed.change_points[0].session) == ("step", 9)
    assert np.std([value.value for value in changed.values[:9]]) < 0.02 * 0.3


def test_temperature_that_rises_with_time_cannot_be_separated_from_drift() -> None:
    warmth = 20.0 + np.arange(20.0)
    found, text = described(make_sessions(noisy(20, 1) * np.exp(-0.01 * (warmth - 20.0)), temperature=warmth))
    assert (found.drift, found.shape) == (False, "temperature")
    assert "cannot be separated" in text
    assert "while it became 16.0 K warmer" in text


def test_coefficient_near_zero_has_no_relative_change() -> None:
    level = noisy(20, 2, level=0.0) + np.where(np.arange(20) >= 10, 0.02, 0.0)
    found, text = described(make_sessions(level))
    assert found.drift
    assert np.isnan(found.total.value)
    assert found.change.low < 0.02 < found.change.high
    assert "N m" in text
    assert "%" not in text


def test_warm_up_within_sessions_is_separated() -> None:
    warm = {"coulomb_nm": Coefficient.around(-0.08, 0.04)}
    levels = zip(noisy(12), noisy(12, 7, level=0.07), strict=True)
    found, text = described([make_session(i, [make_joint(1, *level, within=warm)]) for i, level in enumerate(levels)])
    assert not found.drift
    assert found.within.value == pytest.approx(-0.08)
    assert found.within.high < 0.0
    assert "within a session it falls by 8 %" in text


def test_reference_is_the_first_sessions_or_those_asked_for() -> None:
    sessions = make_sessions(stepped(noisy(20), 3))
    assert analyse(sessions).reference == (0, 1, 2, 3, 4)
    arm = analyse(sessions, replace(QUICK, baseline=(10, 11, 12)))
    found = arm.joints[0].coefficients[0]
    assert arm.reference == (10, 11, 12)
    assert found.total.low < 0.0 < found.total.high
    assert found.level.value == pytest.approx(0.345, abs=0.004)


@settings(max_examples=3, deadline=None)
@given(factor=st.floats(0.01, 100.0), seed=st.integers(0, 100))
def test_scale_changes_nothing(factor: float, seed: int) -> None:
    level = stepped(noisy(14, seed), 7, 1.08)
    one, other = (
        coulomb(make_sessions(scale * level, error=scale * 0.003), replace(QUICK, permutations=99))
        for scale in (1.0, factor)
    )
    assert one.shape == other.shape
    assert one.p_value == pytest.approx(other.p_value, rel=1e-6)
    assert one.total.value == pytest.approx(other.total.value, rel=1e-6)


@settings(max_examples=3, deadline=None)
@given(order=st.permutations(range(10)))
def test_order_of_the_arguments_changes_nothing(order: list[int]) -> None:
    sessions = [replace(session, start_s=FIRST_S + i // 3) for i, session in enumerate(make_sessions(noisy(10)))]
    quick = replace(QUICK, permutations=99)
    assert repr(analyse([sessions[i] for i in order], quick)) == repr(analyse(sessions, quick))  # NaN is not NaN


@settings(max_examples=8, deadline=None)
@example(value=286.0, error=1.0000000000000003e-09, count=10)
@given(value=st.floats(1e-4, 1e4), error=st.floats(1e-9, 1e-2), count=st.integers(1, 15))
def test_what_is_constant_never_drifts(value: float, error: float, count: int) -> None:
    sessions = [make_session(i, [make_joint(1, value, error=error * value)]) for i in range(count)]
    found = coulomb(sessions, replace(QUICK, permutations=99))
    assert (found.drift, found.change_points) == (False, ())


@pytest.mark.parametrize(("arms", "too_many"), [(8, 3), *thorough([(24, 5)])])
def test_false_alarms_are_as_rare_as_said(arms: int, too_many: int) -> None:
    """Of arms on which nothing changes, at most 5 % drift; 3 or more of 8, 5 or more of 24 have probability 0.006."""
    alarms = 0
    for k in range(arms):
        rng = np.random.default_rng((9, k))
        rows = 0.3 + 0.003 * rng.standard_normal((16, 2))
        sessions = [make_session(i, [make_joint(j + 1, row[j]) for j in range(2)]) for i, row in enumerate(rows)]
        alarms += analyse(sessions, DriftSettings(permutations=99)).drift
    assert alarms < too_many


def test_errors_of_zero_or_far_below_the_scatter_raise_nothing() -> None:
    found = coulomb(make_sessions(stepped(np.full(12, 0.3), 6, 1.1), error=0.0))
    assert (found.drift, found.shape) == (True, "step")
    assert found.change_points[0].relative.value == pytest.approx(0.1)
    found = coulomb(make_sessions([0.001, 0.5, 0.0002, 0.9], error=1e-5))  # a warning is an error in all tests
    assert not any(point.outside for point in found.control)


def test_missing_intervals_are_taken_from_the_others() -> None:
    sessions = make_sessions(stepped(noisy(12), 6))
    bare = Coefficient.around(0.3)
    own = sessions[2].joints[0]
    sessions[2] = replace(sessions[2], joints=(replace(own, coefficients={**own.coefficients, "coulomb_nm": bare}),))
    assert coulomb(sessions).change_points[0].session == 6


# The parts of the tests, each against numbers known by hand.


def series_of(level: np.ndarray, error: float = 0.003) -> Series:
    sessions = make_sessions(level, error=error)
    return replace(make_series(sessions, range(len(level)), 1, "coulomb_nm", by_start=True), temperature=None)


def test_statistics_of_a_step_and_of_a_ramp_are_those_of_the_usual_tests() -> None:
    level = noisy(12, 5)
    directions = make_directions(series_of(level, error=1e-9))
    assert np.ptp(directions.weight) < 1e-6 * directions.weight[0]  # errors are far below the scatter
    t, y = studentise(directions.residual[None, :], directions)[0], np.log(level)
    step = t[directions.split == 5][0]
    assert step == pytest.approx(stats.ttest_ind(y[5:], y[:5]).statistic, rel=1e-4)
    line = stats.linregress(np.arange(12), y)
    assert t[directions.split == 0] == pytest.approx(line.slope / line.stderr, rel=1e-4)


def wandering(rng: np.random.Generator, count: int, length: int, correlation: float) -> Float:
    """Return series, each session of which remembers the one before it, shape (count, length)."""
    noise = rng.standard_normal((count, length))
    for i in range(1, length):
        noise[:, i] = correlation * noise[:, i - 1] + np.sqrt(1 - correlation**2) * noise[:, i]
    return noise


@pytest.mark.parametrize("correlation", [0.0, 0.4, 0.7])
def test_autocorrelation_of_many_series(correlation: float) -> None:
    """The estimate is near the truth, steps and ramps notwithstanding; what it does is not underrated."""
    rng = np.random.default_rng(1)
    drifts = [0.0, 0.3 * np.arange(60), 8.0 * (np.arange(60) >= 40)]
    noise = wandering(rng, 14, 60, correlation)
    family = [make_directions(series_of(0.3 + 0.003 * (one + drifts[k % 3]), 1e-5)) for k, one in enumerate(noise)]
    found = estimate_autocorrelation(family, rng)
    assert found.first == pytest.approx(correlation, abs=0.15)
    largest = [
        np.quantile(np.max(np.abs(studentise(wandering(rng, 2000, 60, c), family[0])), axis=1), 0.99)
        for c in (0.0, correlation)
    ]
    assert 0.95 < found.growth * largest[0] / largest[1] < 1.6
