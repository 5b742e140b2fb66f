"""Figures of a diagnosis: every verdict can be drawn, and what is drawn is what the numbers say."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.result import ContactTrace, OwnAxis
from friction_audit.pipeline import without_samples
from friction_audit.reporting.figures import FigureKind, figures_of
from friction_audit.reporting.figures.profiles import EFFECTS, LADDER, RESIDUAL, STANDARD_ERRORS
from friction_audit.reporting.figures.simulation import SIMULATION, shown_cycles
from tests.reporting import diagnosis_by_hand as by_hand
from tests.reporting.diagnosis_by_hand import ALL, NAMED, TRACES, diagnosis
from tests.reporting.test_figures import legend_of, line, words_in

KINDS = pytest.mark.parametrize("kind", figures_of("diagnosis"), ids=lambda kind: kind.name)


@KINDS
def test_a_joint_without_an_answer_says_why(kind: FigureKind) -> None:
    assert "0 energy cycles with motion" in words_in(kind.draw(ALL, 5))
    assert by_hand.FAULT in words_in(kind.draw(ALL, 6))


def test_held_out_cycles_are_shown_from_the_first_to_the_last_and_simulated_ones_before_others() -> None:
    pieces = shown_cycles(TRACES, most=4)
    cycles = [int(np.unique(TRACES.cycle[(TRACES.t >= p.start) & (TRACES.t <= p.stop)])[0]) for p in pieces]
    assert (len(cycles), cycles[0], cycles[-1], {cycle % 3 for cycle in cycles}) == (4, 1, 28, {1})
    whole, names = by_hand.moved(), ("t", "measured", "nominal", "augmented")
    late = replace(whole, **{name: getattr(whole, name)[-by_hand.ROWS :] for name in names})
    start = (28 * by_hand.ROWS + by_hand.LEFT_OUT) * by_hand.STEP_S
    assert [piece.start for piece in shown_cycles(TRACES, late)] == pytest.approx([start])


def test_torque_residual_and_motion_are_those_of_the_result() -> None:
    figure = SIMULATION(ALL, 1)
    assert {"measured, raw", "measured, below 17 Hz", "with Stribeck"} < set(legend_of(figure))
    _, residual, motion = figure.axes
    x, y = line(residual, "nominal model")
    first = TRACES.cycle == 1
    count = int(first.sum())
    assert x[:count] == pytest.approx(TRACES.t[first] - TRACES.t[first][0])
    assert y[:count] == pytest.approx((TRACES.measured - TRACES.before)[first])
    _, augmented = line(motion, "with Stribeck")
    assert np.nanmin(augmented) == pytest.approx((by_hand.ROWS + by_hand.LEFT_OUT) * by_hand.STEP_S)
    freed = replace(ALL, estimate=without_samples(ALL.estimate))  # as the command has it
    assert "measured, raw" not in legend_of(SIMULATION(freed, 1))
    alone = SIMULATION(ALL, 3)
    assert (len(alone.axes), legend_of(alone)[-1]) == (2, "nominal model")


def test_means_stand_at_the_bins_with_two_standard_errors() -> None:
    (axes,) = RESIDUAL(ALL, 4).axes
    shown = by_hand.UNEXPLAINED.profiles[0]
    means = [box for box in axes.containers if str(box.get_label()).startswith("backwards")]
    x, y = (np.asarray(data) for data in means[0].lines[0].get_data())  # type: ignore[attr-defined]
    assert x == pytest.approx(shown.centre)
    assert y == pytest.approx(shown.backwards)
    (bars,) = means[0].lines[2]  # type: ignore[attr-defined]
    half = np.array([np.ptp(segment[:, 1]) / 2 for segment in bars.get_segments()])
    assert half == pytest.approx(STANDARD_ERRORS * shown.backwards_se)


def test_the_ladder_is_as_long_as_the_residuals() -> None:
    axes = LADDER(ALL, 1).axes[0]
    assert [bar.get_width() for bar in axes.patches] == pytest.approx([rms for _, rms in NAMED.ladder])  # type: ignore[attr-defined]
    steps = [label.get_text() for label in axes.get_yticklabels()]
    assert steps == ["nominal model", "+ Stribeck", "noise floor"]
    assert axes.get_title(loc="left") == "joint 1: 97.6 ± 1.0 % explained\non 9 held-out cycles"


TWO = {"contacts": by_hand.coefficient(2.0, 0.0)}
CONTACTS = replace(NAMED.effects[0], name="contact_event", parameters=TWO, evidence=())
T = np.arange(0.0, 12.0, 0.1)
TRACE = ContactTrace(t=T, residual_nm=np.sin(T / 5.0), spans_s=((1.0, 1.3), (8.0, 8.4)))
TOUCHED = replace(NAMED, effects=(CONTACTS,), ladder=by_hand.NONE.ladder, gap=by_hand.NONE.gap, contacts=TRACE)


def test_contacts_are_left_out_and_no_model_has_them() -> None:
    alone = diagnosis(TOUCHED)
    assert not any(label.startswith("with ") for label in legend_of(SIMULATION(alone, 1)))
    assert "joint 1: nothing added on 9 held-out cycles, contacts left out" in words_in(LADDER(alone, 1))
    left = (by_hand.profile("speed", 0.0),)
    both = diagnosis(replace(TOUCHED, effects=(CONTACTS, *NAMED.effects), gap=NAMED.gap, remaining=left))
    assert "with Stribeck" in legend_of(SIMULATION(both, 1))
    assert len(RESIDUAL(both, 1).axes) == 2


def test_contacts_are_shaded_over_the_whole_log_and_the_largest_close_by() -> None:
    whole, largest = EFFECTS(diagnosis(TOUCHED), 1).axes
    assert (whole.get_title(loc="left"), largest.get_title(loc="left")) == ("joint 1: contact event", "the largest")
    assert [len(axes.patches) for axes in (whole, largest)] == [2, 2]
    assert largest.get_xlim() == pytest.approx((7.0, 9.4))  # sin(t / 5) is 0.2 at the first, 1.0 at the second
    sheet = diagnosis(TOUCHED, replace(TOUCHED, joint=2))
    assert [len(axes.patches) for axes in EFFECTS(sheet, None).axes] == [2, 2]


def test_an_effect_with_an_axis_of_its_own_is_drawn_along_it() -> None:
    curve, before, after = (by_hand.profile("wave", share) for share in (0.1, 0.2, 0.0))
    values, order = np.mod(TRACES.t, 1.0), {"ripple_order": by_hand.coefficient(1.0, 0.1)}
    own = OwnAxis(label="Position within a wave [waves]", values=values, curve=curve, before=before, after=after)
    ripple = replace(NAMED.effects[0], own=own, torque=np.sin(2 * np.pi * values), parameters=order)
    joint = diagnosis(replace(NAMED, effects=(ripple,)))
    x, y = line(EFFECTS(joint, 1).axes[0], "fitted, forwards")
    assert y == pytest.approx(np.sin(2 * np.pi * x), abs=0.05)
    assert [axes.get_xlabel() for axes in RESIDUAL(joint, 1).axes] == ["Wave [unit]", "Wave [unit]"]
    other = diagnosis(replace(NAMED, effects=(replace(ripple, parameters=NAMED.effects[0].parameters),)))
    assert "Wave [unit]" not in [axes.get_xlabel() for axes in (*RESIDUAL(other, 1).axes, *EFFECTS(other, 1).axes)]


def test_the_fitted_torque_lies_over_the_curve_of_the_log() -> None:
    axes = EFFECTS(ALL, 1).axes[0]
    _, forwards = line(axes, "fitted, forwards")
    _, backwards = line(axes, "fitted, backwards")
    assert forwards == pytest.approx(np.full(len(forwards), by_hand.MISSING_NM))
    assert backwards == pytest.approx(np.full(len(backwards), -by_hand.MISSING_NM))
    dots = np.concatenate([np.asarray(one.get_ydata(), float) for one in axes.lines if one.get_marker() == "."])
    assert np.abs(dots).mean() == pytest.approx(by_hand.MISSING_NM, abs=0.01)
    assert "0.150\u00a0±\u00a00.010 N m" in words_in(EFFECTS(ALL, 1))


def test_a_joint_whose_model_is_adequate_shows_its_residual_within_the_detection_limit() -> None:
    figure = EFFECTS(diagnosis(replace(NAMED, verdict="adequate", effects=())), None)
    (axes,) = figure.axes
    assert axes.get_title(loc="left") == "joint 1: adequate, no effect named"
    limit = [patch for patch in axes.patches if patch.get_label() == "below the detection limit"]
    assert limit[0].get_height() == pytest.approx(2 * NAMED.detection_limit_nm)  # type: ignore[attr-defined]
