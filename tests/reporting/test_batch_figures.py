"""Figures of a batch: what is drawn is what the numbers say, for any arm."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from friction_audit.drift.session import SpeedCurve
from friction_audit.errors import UsageError
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_log import Float
from friction_audit.reporting.figures import save_figure
from friction_audit.reporting.figures.batch import BATCH_FIGURES, BatchFigure
from friction_audit.reporting.figures.batch_changes import chart_limits, draw_changes, draw_control
from friction_audit.reporting.figures.batch_drift import (
    draw_curves,
    draw_drift,
    mean_curve,
    stretches,
    trend_line,
    value_limits,
)
from friction_audit.reporting.figures.batch_look import MOST_MARKED, runs, tick_places
from friction_audit.reporting.figures.style import COLUMN_IN, SHEET_IN
from tests.reporting import batch_by_hand as by_hand

ARM = by_hand.arm()
STEP = ARM.joints[1].coefficients[0]
RISE = ARM.joints[4].coefficients[0]
KINDS = pytest.mark.parametrize("kind", BATCH_FIGURES, ids=lambda kind: kind.name)
FIRST_KIND = pytest.mark.parametrize(
    "kind",
    [BATCH_FIGURES[0], *(pytest.param(kind, marks=pytest.mark.thorough) for kind in BATCH_FIGURES[1:])],
    ids=lambda kind: kind.name,
)
"""All are painted by the same hands."""


def line(axes: Axes, label: str) -> tuple[Float, Float]:
    (found,) = (one for one in axes.lines if one.get_label() == label)
    return np.asarray(found.get_xdata(), float), np.asarray(found.get_ydata(), float)


def words_in(figure: Figure) -> str:
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    titles = [axes.get_title(loc=side) for axes in figure.axes for side in ("left", "right")]
    ticks = [label.get_text() for axes in figure.axes for label in axes.get_yticklabels()]
    return " ".join([*texts, *titles, *ticks]).replace("\n", " ")


@KINDS
def test_a_joint_is_a_column_wide_and_a_sheet_of_all_a_page(kind: BatchFigure) -> None:
    assert kind.draw(ARM, 2).get_figwidth() == COLUMN_IN
    sheet = kind.draw(ARM, None)
    assert sheet.get_figwidth() == SHEET_IN
    moving = [one.joint for one in ARM.joints if one.joint != by_hand.STILL_JOINT]
    assert [n for n in moving if f"joint {n}" not in words_in(sheet)] == []


@KINDS
def test_a_joint_that_never_moves_takes_no_room_on_a_sheet(kind: BatchFigure) -> None:
    sheet = kind.draw(ARM, None)
    assert f"joint {by_hand.STILL_JOINT}" not in words_in(sheet)
    assert sheet.get_supxlabel().endswith(f"not drawn, for lack of any estimate: joint {by_hand.STILL_JOINT}")
    still = replace(ARM, joints=ARM.joints[by_hand.STILL_JOINT - 1 :])
    assert f"joint {by_hand.STILL_JOINT}" in words_in(kind.draw(still, None))


@KINDS
def test_a_joint_that_is_not_there_is_named(kind: BatchFigure) -> None:
    with pytest.raises(UsageError, match=r"joint 9: .* holds 1, 2, 3, 4, 5, 6, 7"):
        kind.draw(ARM, 9)


@KINDS
def test_a_joint_without_any_estimate_says_so(kind: BatchFigure) -> None:
    words = words_in(kind.draw(ARM, 7))
    assert any(said in words for said in ("does not move", "no session moves", "not testable"))


@KINDS
def test_any_arm_can_be_drawn(kind: BatchFigure, tmp_path: Path) -> None:
    arms = (
        by_hand.arm(1, 1),
        by_hand.arm(2, 1, dated=False),
        by_hand.arm(MOST_MARKED + 20, 1),
        by_hand.hostile().arms[0],
        replace(by_hand.arm(3, 1), reference=(), compared=()),
    )
    for number, arm in enumerate(arms):
        save_figure(kind.draw(arm, 1), tmp_path / f"{number}.svg")


@FIRST_KIND
def test_the_same_result_gives_the_same_bytes(kind: BatchFigure, tmp_path: Path) -> None:
    paths = [tmp_path / f"{k}.svg" for k in range(2)]
    for path in paths:
        save_figure(kind.draw(ARM, 2), path)
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_sessions_stand_at_their_numbers_with_their_intervals() -> None:
    coulomb = draw_drift(ARM, 2).axes[0]
    place, value = line(coulomb, "session")
    assert place.tolist() == [k + 1 for k in STEP.sessions]
    assert value == pytest.approx([one.value for one in STEP.values])
    _, bars = line(coulomb, "95 % of a session")
    assert bars[0::3] == pytest.approx([one.low for one in STEP.values])
    assert bars[1::3] == pytest.approx([one.high for one in STEP.values])
    place, _ = line(coulomb, "not compared")
    assert place.tolist() == [9.0]


def test_a_step_lies_between_two_sessions_and_levels_meet_there() -> None:
    before, after = stretches(STEP)
    assert before[:2] == (0.5, 12.5)
    assert after[:2] == (12.5, 24.5)
    assert (before[2].value, after[2].value) == pytest.approx((0.152, 0.1748))
    assert "+15.0 ± 1.5 % at session 13" in words_in(draw_drift(ARM, 2))


def test_a_step_behind_a_session_that_was_not_compared_lies_midway() -> None:
    change = replace(STEP.change_points[0], session=9)
    (_, border, _), _ = stretches(replace(STEP, change_points=(change,)))
    assert border == 9.0


def test_a_trend_goes_through_the_middle_of_the_sessions() -> None:
    exact = tuple(Coefficient(value=2.0 + 0.1 * k, low=1.0, high=3.0) for k in RISE.sessions)
    slope = Coefficient(value=0.1, low=0.05, high=0.15)
    place, trend, low, high = trend_line(replace(RISE, values=exact, trend_per_session=slope))
    assert trend == pytest.approx(2.0 + 0.1 * (place - 1.0))
    assert low[1] == trend[1] == high[1]
    assert high[-1] - trend[-1] == pytest.approx(0.05 * (place[-1] - place[1]))
    assert trend[0] - low[0] == pytest.approx(0.05 * (place[1] - place[0]))


def test_an_isolated_session_is_ringed() -> None:
    coulomb = replace(STEP, isolated=(3,))
    arm = replace(ARM, joints=(replace(ARM.joints[1], coefficients=(coulomb, ARM.joints[1].coefficients[1])),))
    place, value = line(draw_drift(arm, 2).axes[0], "isolated, not counted")
    assert place.tolist() == [4.0]
    assert value == pytest.approx([STEP.values[3].value])


def test_a_wild_interval_does_not_flatten_the_panel() -> None:
    wild = (Coefficient(value=0.15, low=-50.0, high=50.0), *STEP.values[1:])
    bottom, top = value_limits(replace(STEP, values=wild))
    assert top - bottom < 0.2


def test_noise_is_not_stretched_to_look_like_drift() -> None:
    quiet = tuple(Coefficient(value=1.0 + 1e-4 * (k % 2), low=0.9999, high=1.0002) for k in range(23))
    bottom, top = value_limits(replace(RISE, values=quiet))
    assert top - bottom > 1e-2


def test_points_outside_of_the_limits_are_marked() -> None:
    coulomb = draw_control(ARM, 2).axes[0]
    place, value = line(coulomb, "outside")
    assert place.tolist() == list(range(13, 25))
    assert value.min() > 4.8
    assert "12 sessions outside" in words_in(draw_control(ARM, 2))
    assert coulomb.get_ylabel() == "Coulomb\n[%]"


def test_near_a_level_of_zero_the_chart_is_absolute() -> None:
    control = tuple(replace(point, relative=UNDETERMINED) for point in STEP.control)
    joint = replace(ARM.joints[1], coefficients=(replace(STEP, control=control),))
    axes = draw_control(replace(ARM, joints=(joint,)), 2).axes[0]
    assert axes.get_ylabel() == "Coulomb\n[N m]"
    _, value = line(axes, "within the limits")
    assert value == pytest.approx([point.deviation.value for point in STEP.control])


def test_limits_of_a_session_that_tells_little_do_not_stretch_the_chart() -> None:
    value, limit = np.array([1.0, -2.0, 0.5, 40.0, np.nan]), np.array([5.0, 5.0, 4000.0, 6.0, np.nan])
    bottom, top = chart_limits(value, -limit, limit)
    assert bottom == pytest.approx(-40.0 - 0.06 * 80.0)  # every deviation is shown
    assert top == pytest.approx(40.0 + 0.06 * 80.0)
    _, top = chart_limits(value[:3], -limit[:3], limit[:3])
    assert top == pytest.approx(10.0 + 0.06 * 20.0)  # twice the usual limit


def test_changes_stand_at_their_size_over_what_is_too_small_to_be_seen() -> None:
    coulomb = draw_changes(ARM, 2).axes[0]
    place, _ = line(coulomb, "changed")
    assert place.tolist() == pytest.approx([15.0])
    (bar,) = coulomb.patches
    assert bar.get_extents().width > 0
    assert (bar.get_x(), bar.get_width()) == pytest.approx((-3.3, 6.6))  # type: ignore[attr-defined]


def test_a_change_with_temperature_has_a_mark_of_its_own() -> None:
    warm = replace(RISE, shape="temperature", drift=False)
    arm = replace(ARM, joints=(replace(ARM.joints[4], coefficients=(warm,)),))
    place, _ = line(draw_changes(arm, 5).axes[0], "changes with temperature")
    assert place.tolist() == pytest.approx([23.0])


def test_what_can_hardly_be_seen_does_not_flatten_the_others() -> None:
    blind = replace(STEP, smallest_drift=500.0)
    axes = draw_changes(replace(ARM, joints=(replace(ARM.joints[1], coefficients=(blind,)),)), 2).axes[0]
    assert axes.get_xlim()[1] == pytest.approx(1.15 * 2 * 16.5)


def test_curves_of_first_reference_and_last_lie_on_one_another() -> None:
    axes = draw_curves(ARM, 2).axes[0]
    _, first = line(axes, "first (session 1)")
    _, reference = line(axes, "reference (mean of 5)")
    _, last = line(axes, "last (session 24)")
    own = [ARM.sessions[k].joints[1].curve.torque_nm for k in range(5)]
    assert np.delete(reference, 9) == pytest.approx(np.mean(own, axis=0))
    assert np.isnan(first[9])
    assert np.nanmax(last) > np.nanmax(first)


def test_a_mean_curve_by_hand() -> None:
    one = SpeedCurve(speed_rad_s=(-1.0, 1.0, 2.0), torque_nm=(-1.0, 1.0, 2.0))
    other = SpeedCurve(speed_rad_s=(1.0, 1.5), torque_nm=(3.0, 4.0))
    mean = mean_curve([SpeedCurve(), one, other])
    assert mean is not None
    nan = np.nan
    assert mean.speed == pytest.approx([-1.0, nan, 1.0, 2.0], nan_ok=True)
    assert mean.torque == pytest.approx([-1.0, nan, 2.0, 2.0], nan_ok=True)
    assert mean.high == pytest.approx([-1.0, nan, 3.0, 2.0], nan_ok=True)
    assert mean_curve([SpeedCurve()]) is None


def test_ticks_are_few_and_begin_with_the_first() -> None:
    assert tick_places(0) == []
    assert tick_places(3) == [1, 2, 3]
    assert tick_places(24) == [1, 5, 9, 13, 17, 21]
    assert all(len(tick_places(n)) <= 6 for n in range(1, 400))


def test_ticks_name_the_day_or_over_years_the_month() -> None:
    axes = draw_drift(ARM, 2)
    assert axes.get_supxlabel() == "Session (month-day, 2026)"
    assert axes.axes[1].get_xticklabels()[1].get_text() == "5\n03-09"
    long = draw_drift(by_hand.arm(300, 2), 2)
    assert long.get_supxlabel() == "Session (year-month)"
    assert long.axes[1].get_xticklabels()[-1].get_text() == "251\n2027-03"
    assert draw_drift(by_hand.arm(3, 2, dated=False), 2).get_supxlabel() == "Session"


def test_runs_of_sessions() -> None:
    assert runs([5.0, 1.0, 2.0]) == [(1.0, 2.0), (5.0, 5.0)]
