"""Figures of an arm over its sessions: what is drawn is what the numbers say, for any arm."""

import pickle
from dataclasses import replace
from itertools import cycle

import numpy as np
import pytest

from friction_audit.drift.report import ArmDrift, CoefficientDrift
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.reporting.figures import FigureKind, figures_of
from friction_audit.reporting.figures.drift import CONTROL, CURVES, DRIFT, MOST_MARKED, draw_changes, stretches
from friction_audit.reporting.figures.style import figure_bytes
from friction_audit.reporting.html.batch_page import as_drawn, drawings_of, write_page
from friction_audit.reporting.html.page import ON_A_SHEET
from tests.each_case import with_thorough
from tests.reporting import batch_by_hand as by_hand
from tests.reporting.test_figures import legend_of, line, words_in

ARM = by_hand.arm()
MANY = by_hand.arm(MOST_MARKED + 20, 1)
STEP = ARM.joints[1].coefficients[0]
RISE = ARM.joints[4].coefficients[0]
KINDS = pytest.mark.parametrize("kind", figures_of("drift"), ids=lambda kind: kind.name)


def one_joint(joint: int, coefficient: CoefficientDrift) -> ArmDrift:
    whole = ARM.joints[joint - 1]
    return replace(ARM, joints=(replace(whole, coefficients=(coefficient, *whole.coefficients[1:])),))


@KINDS
def test_a_joint_that_never_moves_takes_no_room_on_a_sheet(kind: FigureKind) -> None:
    sheet = kind.draw(ARM, None)
    assert f"joint {by_hand.STILL_JOINT}: no " in words_in(sheet)
    still = replace(ARM, joints=ARM.joints[by_hand.STILL_JOINT - 1 :])
    assert f"joint {by_hand.STILL_JOINT}" in words_in(kind.draw(still, None))
    words = words_in(kind.draw(ARM, by_hand.STILL_JOINT))
    assert any(reason in words for reason in ("0 comparable", "no session moves", "not testable"))


def test_too_few_sessions_show_their_values_and_no_figure_is_empty() -> None:
    arm = by_hand.arm(3, 2)
    untested = tuple(replace(one, shape="too_few", control=()) for one in arm.joints[0].coefficients)
    few = replace(arm, joints=(replace(arm.joints[0], coefficients=untested), arm.joints[1]))
    assert line(DRIFT(few, None).axes[0], "session")[0].tolist() == [1, 2, 3]
    assert "drift needs 4 sessions" in words_in(DRIFT(few, None))
    assert "3 comparable sessions, at least 4" in words_in(CONTROL(few, None))
    none = replace(few, joints=few.joints[:1])
    for one, kinds in ((few, [kind.name for kind in figures_of("drift")]), (none, ["drift", "curves"])):
        assert [drawing.kind.name for drawing in drawings_of([one], {}, ())] == kinds
    assert "no figure of changes and no control chart: 3 comparable" in write_page(by_hand.batch(none), {})


STRANGE = replace(by_hand.arm(3, 1, dated=False), reference=(), compared=())
DRAWN = {"one": by_hand.arm(1, 1), "many": MANY, "strange": STRANGE}
IN_STEP = [*zip(figures_of("drift"), cycle(DRAWN))]


@pytest.mark.parametrize(("kind", "arm"), with_thorough(IN_STEP, figures_of("drift"), DRAWN))
def test_any_arm_can_be_drawn(kind: FigureKind, arm: str) -> None:
    kind.draw(DRAWN[arm], 1).draw_without_rendering()


@KINDS
def test_a_worker_draws_the_same_from_what_is_sent_to_it(kind: FigureKind) -> None:
    arm = by_hand.arm(14, 2)
    assert figure_bytes(kind.draw(as_drawn(arm), 1), "svg") == figure_bytes(kind.draw(arm, 1), "svg")
    assert len(pickle.dumps(as_drawn(MANY))) < len(pickle.dumps(MANY)) / 2


def test_sessions_stand_at_their_numbers_with_their_intervals() -> None:
    coulomb = DRIFT(one_joint(2, replace(STEP, isolated=(3,))), 2).axes[0]
    place, value = line(coulomb, "session")
    assert place.tolist() == [k + 1 for k in STEP.sessions]
    assert value == pytest.approx([one.value for one in STEP.values])
    _, bars = line(coulomb, "95 % of a session")
    assert bars[0::3] == pytest.approx([one.low for one in STEP.values])
    assert line(coulomb, "not compared")[0].tolist() == [9.0]
    assert line(coulomb, "isolated, not counted")[0].tolist() == [4.0]
    joint = replace(ARM.sessions[by_hand.LEFT_OUT].joints[1], coefficients={"coulomb_nm": by_hand.number(9.0, 0.1)})
    far = list(ARM.sessions)
    far[by_hand.LEFT_OUT] = replace(far[by_hand.LEFT_OUT], joints=(joint,))
    figure = DRIFT(replace(one_joint(2, STEP), sessions=tuple(far)), 2)
    assert figure.axes[0].get_ylim()[1] < 1.0
    assert "not compared" not in legend_of(figure)


def test_a_step_lies_midway_between_two_compared_sessions_and_levels_meet_there() -> None:
    before, after = stretches(STEP)
    assert (before[:2], after[:2]) == ((0.5, 12.5), (12.5, 24.5))
    assert (before[2].value, after[2].value) == pytest.approx((0.152, 0.1748))
    assert "+15.0 ± 1.5 % at session 13" in words_in(DRIFT(ARM, 2))


def test_points_outside_of_the_limits_are_marked_and_wide_limits_do_not_stretch_the_chart() -> None:
    figure = CONTROL(ARM, 2)
    coulomb = figure.axes[0]
    place, value = line(coulomb, "outside")
    assert place.tolist() == list(range(13, 25))
    assert value.min() > 4.8
    assert "12 sessions outside" in words_in(figure)
    assert coulomb.get_ylabel() == "Coulomb\n[%]"
    wide = Coefficient(value=STEP.control[3].relative.value, low=-40.0, high=40.0)
    control = (*STEP.control[:3], replace(STEP.control[3], relative=wide), *STEP.control[4:])
    stretched = CONTROL(one_joint(2, replace(STEP, control=control)), 2).axes[0].get_ylim()
    assert np.ptp(stretched) < 3.0 * np.ptp(coulomb.get_ylim())
    control = tuple(replace(point, relative=UNDETERMINED) for point in STEP.control)
    axes = CONTROL(one_joint(2, replace(STEP, control=control)), 2).axes[0]
    assert axes.get_ylabel() == "Coulomb\n[N m]"  # near a level of zero


def test_changes_stand_at_their_size_over_what_is_not_detectable() -> None:
    coulomb = draw_changes(ARM, 2).axes[0]
    place, _ = line(coulomb, "changed")
    assert place.tolist() == pytest.approx([15.0])
    (bar,) = coulomb.patches
    assert (bar.get_x(), bar.get_width()) == pytest.approx((-3.3, 6.6))  # type: ignore[attr-defined]
    warm = replace(RISE, shape="temperature", drift=False)
    place, _ = line(draw_changes(one_joint(5, warm), 5).axes[0], "changes with temperature")
    assert place.tolist() == pytest.approx([23.0])
    # What is hardly detectable does not flatten the others.
    axes = draw_changes(one_joint(2, replace(STEP, smallest_drift=500.0)), 2).axes[0]
    assert axes.get_xlim()[1] == pytest.approx(1.15 * 2 * 16.5)


def test_curves_of_first_reference_and_last_lie_on_one_another() -> None:
    axes = CURVES(ARM, 2).axes[0]
    _, first = line(axes, "first (session 1)")
    _, reference = line(axes, "reference (mean of 5)")
    _, last = line(axes, "last (session 24)")
    own = [ARM.sessions[k].joints[1].curve.torque_nm for k in range(5)]
    assert np.delete(reference, 9) == pytest.approx(np.mean(own, axis=0))
    assert np.isnan(first[9])
    assert np.nanmax(last) > np.nanmax(first)


def test_more_joints_than_fit_on_a_sheet_make_several_for_the_page_and_one_for_the_files() -> None:
    arms = [replace(by_hand.arm(4, count), robot=f"arm{count}") for count in (2, ON_A_SHEET + 2)]
    found = [one for one in drawings_of(arms, {"arm2": "a-"}, ["png", "svg"]) if one.kind.name == "drift"]
    assert [(one.name, one.anchor) for one in found[:2]] == [("a-drift", "arm-1-drift-1"), ("", "arm-2-drift-1")]
    assert [one.which for one in found] == ["", ", joints 1 to 8", ", joints 9 to 10", ""]
    assert [len(one.arm.joints) for one in found] == [2, ON_A_SHEET, 2, ON_A_SHEET + 2]
    assert list(drawings_of([replace(arms[0], joints=())], {}, ["png"])) == []
