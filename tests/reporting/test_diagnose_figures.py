"""Figures of a diagnosis: every verdict can be drawn, and what is drawn is what the numbers say."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text

from friction_audit.diagnosis.gap import Gap
from friction_audit.diagnosis.result import Effect, Evidence, JointDiscrepancy, SimulationGap, Traces
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.pipeline import Diagnosis
from friction_audit.reporting.figures import save_figure
from friction_audit.reporting.figures.diagnose import DIAGNOSIS_FIGURES, DiagnosisFigure
from friction_audit.reporting.figures.diagnose_contacts import draw_verdicts, said_of
from friction_audit.reporting.figures.diagnose_evidence import (
    ALIKE,
    BEATEN,
    CHOSEN,
    ELSEWHERE,
    closed_words,
    draw_effects,
    draw_evidence,
    draw_ladder,
    mark_of,
    nearest,
    not_drawn,
)
from friction_audit.reporting.figures.diagnose_look import GROWN, STANDARD_ERRORS, mean_along, verdict_words
from friction_audit.reporting.figures.diagnose_residual import draw_residual, limits_for, rows_of
from friction_audit.reporting.figures.diagnose_simulation import (
    Piece,
    _date,
    draw_simulation,
    lay_out,
    limits_with,
    shown_cycles,
)
from friction_audit.reporting.figures.style import COLUMN_IN, SHEET_IN
from tests.reporting import diagnosis_by_hand as by_hand

CYCLES, ROWS, STEP_S = 30, 40, 0.01
LEFT_OUT = 3
"""Rows at the beginning of a cycle that are not there."""
NOISE_NM, MISSING_NM = 0.02, 0.3
ODD = r"a$\bad{$"
CORNER_HZ = 17.0
KINDS = pytest.mark.parametrize("kind", DIAGNOSIS_FIGURES, ids=lambda kind: kind.name)
FIRST_KIND = pytest.mark.parametrize(
    "kind",
    [DIAGNOSIS_FIGURES[0], *(pytest.param(kind, marks=pytest.mark.thorough) for kind in DIAGNOSIS_FIGURES[1:])],
    ids=lambda kind: kind.name,
)
"""All are painted by the same hands."""


def traces() -> Traces:
    """Return rows in which the declared model misses MISSING_NM in the direction of motion."""
    rng = np.random.default_rng(0)
    place = np.arange(CYCLES * ROWS)
    place = place[place % ROWS >= LEFT_OUT]
    cycle = place // ROWS
    direction = np.where(cycle % 2, -1.0, 1.0)
    t = np.asarray(STEP_S * place, np.float64)
    speed: Float = 0.05 + 0.3 * np.sin(np.pi * (place % ROWS) / ROWS)
    after = direction * (0.4 + speed)
    return Traces(
        t=t,
        q=direction * speed,
        dq=direction * speed,
        displacement=speed,
        cycle=cycle,
        locked=cycle % 3 == 1,
        measured=after + NOISE_NM * rng.standard_normal(len(place)),
        before=after - MISSING_NM * direction,
        after=after,
        along={"speed": speed, "time": t},
        corner_hz=CORNER_HZ,
    )


TRACES = traces()


def effect_of(effect: Effect) -> Effect:
    return replace(effect, torque=TRACES.measured * 0.0 + MISSING_NM * np.sign(TRACES.dq))


def joint_of(joint: JointDiscrepancy) -> JointDiscrepancy:
    """Return the joint with rows, where it was diagnosed."""
    if joint.gap is None:
        return joint
    effects = tuple(effect_of(effect) for effect in joint.effects)
    profiles = joint.profiles or (by_hand.profile("time", 0.0),)
    remaining = joint.remaining or (by_hand.profile("time", 0.0),)
    ladder = joint.ladder or (("declared model", joint.gap.before), ("floor of the noise", joint.gap.floor))
    return replace(
        joint, traces=TRACES, effects=effects, profiles=profiles, remaining=remaining, simulation=None, ladder=ladder
    )


def moved() -> SimulationGap:
    """Return a motion simulated on the locked cycles, NaN between them."""
    pieces = [np.append(np.arange(c * ROWS, (c + 1) * ROWS) * STEP_S, np.nan) for c in range(1, CYCLES, 3)]
    t = np.concatenate(pieces)[:-1]
    return SimulationGap(before=0.1, after=0.01, unit="rad/s", t=t, measured=np.sin(t), declared=0.9 * t, grown=t)


NAMED, AMBIGUOUS, NONE, UNEXPLAINED, NOT_TESTABLE, DATA_FAULT = map(joint_of, by_hand.VERDICTS_BY_HAND)
NAMED = replace(NAMED, simulation=moved())
ALL = by_hand.diagnosis((NAMED, AMBIGUOUS, NONE, UNEXPLAINED, NOT_TESTABLE, DATA_FAULT))


def of(joint: JointDiscrepancy) -> Diagnosis:
    return by_hand.diagnosis((joint,))


def words_in(figure: Figure) -> str:
    """Return all that is written inside panels and above them."""
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    ticks = [label.get_text() for axes in figure.axes for label in axes.get_yticklabels()]
    return " ".join([*texts, *titles, *ticks]).replace("\n", " ")


def legend_of(figure: Figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def line(axes: Axes, label: str) -> tuple[Float, Float]:
    (found,) = (one for one in axes.lines if one.get_label() == label)
    return np.asarray(found.get_xdata(), float), np.asarray(found.get_ydata(), float)


@KINDS
def test_joints_are_a_column_wide_and_a_sheet_of_all_a_page(kind: DiagnosisFigure) -> None:
    assert {kind.draw(ALL, joint).get_figwidth() for joint in range(1, 7)} == {COLUMN_IN}
    sheet = kind.draw(ALL, None)
    assert sheet.get_figwidth() == SHEET_IN
    words = words_in(sheet)
    assert [n for n in range(1, 7) if f"joint {n}" not in words] == []


@KINDS
def test_a_joint_without_an_answer_says_why(kind: DiagnosisFigure) -> None:
    assert "0 energy cycles with motion" in words_in(kind.draw(ALL, 5))
    assert by_hand.FAULT in words_in(kind.draw(ALL, 6))


@KINDS
def test_a_dollar_sign_in_a_word_of_the_log_is_a_dollar_sign(kind: DiagnosisFigure, tmp_path: Path) -> None:
    """As mathematics these words would be an error."""
    joints = tuple(replace(one, name=ODD, message=ODD) for one in (NAMED, NOT_TESTABLE, DATA_FAULT))
    odd = replace(ALL, discrepancy=replace(ALL.discrepancy, joints=joints))
    save_figure(kind.draw(odd, None), tmp_path / "sheet.svg")
    for joint in (None, 1, 5, 6):
        figure = kind.draw(odd, joint)
        written = [text for text in figure.findobj(Text) if isinstance(text, Text) and ODD in text.get_text()]
        assert written
        assert not any(text.get_parse_math() for text in written)


@KINDS
def test_a_joint_that_is_not_there_is_named(kind: DiagnosisFigure) -> None:
    with pytest.raises(UsageError, match=r"joint 9: .* holds 1, 2, 3, 4, 5, 6"):
        kind.draw(ALL, 9)


@FIRST_KIND
def test_the_same_result_gives_the_same_bytes(kind: DiagnosisFigure, tmp_path: Path) -> None:
    paths = [tmp_path / f"{k}.png" for k in range(2)]
    for path in paths:
        save_figure(kind.draw(ALL, 1), path)
    first, second = (path.read_bytes() for path in paths)
    assert first == second
    assert len(first) > 1000


def test_only_locked_cycles_are_shown_from_the_first_to_the_last() -> None:
    pieces = shown_cycles(TRACES, most=4)
    cycles = [int(np.unique(TRACES.cycle[(TRACES.t >= p.start) & (TRACES.t <= p.stop)])[0]) for p in pieces]
    assert [cycle % 3 for cycle in cycles] == [1, 1, 1, 1]
    assert (cycles[0], cycles[-1]) == (1, 28)
    ends = [p.place + p.stop - p.start for p in pieces]
    assert all(end < following.place for end, following in zip(ends, pieces[1:], strict=False))


def test_fewer_locked_cycles_than_asked_for_are_shown_once_each() -> None:
    two = replace(TRACES, locked=TRACES.cycle < 2)
    assert [piece.start for piece in shown_cycles(two, most=4)] == pytest.approx([0.03, 0.43])


def test_cycles_that_were_simulated_are_shown_before_others() -> None:
    whole = moved()
    late = replace(whole, **{name: getattr(whole, name)[-ROWS:] for name in ("t", "measured", "declared", "grown")})
    (piece,) = shown_cycles(TRACES, late)
    assert piece.start == pytest.approx((28 * ROWS + LEFT_OUT) * STEP_S)


def test_a_ripple_is_shown_with_its_waves_laid_over_each_other() -> None:
    waves = 8.0
    rippled = effect_of(replace(NAMED.effects[0], parameters={"ripple_order": by_hand.coefficient(waves, 0.1)}))
    rippled = replace(rippled, torque=np.sin(waves * TRACES.q))
    axes = draw_effects(of(replace(NAMED, effects=(rippled,))), 1).axes[0]
    x, y = line(axes, "fitted, forwards")
    assert y == pytest.approx(np.sin(2 * np.pi * x), abs=0.05)
    assert axes.get_xlabel() == "Position within a wave [waves]"


def test_cycles_are_put_behind_each_other_and_left_out_rows_are_not_bridged() -> None:
    t = np.array([0.0, 1.0, 2.0, 5.0, 6.0, 20.0, 21.0])
    x, y = lay_out((Piece(0.0, 6.0, 0.0), Piece(20.0, 21.0, 7.0)), t, np.arange(7.0))
    nan = np.nan
    assert x == pytest.approx(np.array([0, 1, 2, 5, 6, nan, 7, 8, nan]), nan_ok=True)
    assert y == pytest.approx(np.array([0, 1, nan, 3, 4, nan, 5, 6, nan]), nan_ok=True)


@pytest.mark.parametrize(("cycles", "said"), [(5, "from 10.0 s"), (6, "10.0 s")])
def test_dates_of_many_cycles_are_numbers_alone(cycles: int, said: str) -> None:
    """Of n cycles of a second each, centres are a second apart: a fifth of the panel, or a sixth."""
    axes = draw_simulation(ALL, 1).axes[0]
    _date(axes, [Piece(start=10.0 * k, stop=10.0 * k + 1.0, place=float(k)) for k in range(cycles)])
    assert axes.texts[-cycles + 1].get_text() == said


def test_torque_is_shown_raw_and_filtered_and_the_corner_is_said() -> None:
    figure = draw_simulation(ALL, 1)
    said = ["measured, raw", "measured, below 17 Hz", "declared model", "with stribeck", "measured velocity"]
    assert legend_of(figure) == said
    assert [axes.get_ylabel().replace("\n", " ") for axes in figure.axes] == [
        "Torque [N m]",
        "Measured less model [N m]",
        "Velocity [rad/s]",
    ]


def test_the_residual_below_is_measured_less_model() -> None:
    axes = draw_simulation(ALL, 1).axes[1]
    x, y = line(axes, "declared model")
    first = TRACES.cycle == 1
    count = int(first.sum())
    assert x[:count] == pytest.approx(TRACES.t[first] - TRACES.t[first][0])
    assert y[:count] == pytest.approx((TRACES.measured - TRACES.before)[first])


def test_the_motion_is_drawn_where_it_was_simulated() -> None:
    _, grown = line(draw_simulation(ALL, 1).axes[2], "with stribeck")
    assert np.nanmin(grown) == pytest.approx((ROWS + LEFT_OUT) * STEP_S)
    assert len(draw_simulation(ALL, 3).axes) == 2


def test_a_wild_sample_and_a_motion_that_runs_away_leave_the_panel() -> None:
    shown = (np.array([0.0, np.nan, 2.0]), np.array([1.0]))
    assert limits_with(shown, np.array([np.nan, 1.0]), 0.5) == pytest.approx((-0.08, 2.08))
    assert limits_with(shown, np.array([2.5, 1.0]), 0.5) == pytest.approx((-0.1, 2.6))
    assert limits_with(shown, np.array([-90.0, 90.0]), 0.5) == pytest.approx((-1.16, 3.16))
    assert limits_with((np.zeros(3),), np.array([np.nan]), 0.5)[1] > 0.0


def test_a_model_that_nothing_was_added_to_is_drawn_once() -> None:
    assert legend_of(draw_simulation(ALL, 3))[-1] == "declared model"


def test_grown_models_of_several_joints_have_one_name() -> None:
    assert [label for label in legend_of(draw_simulation(ALL, None)) if "with" in label] == ["with the effects named"]


def test_the_residual_is_shown_along_the_axis_of_each_effect_before_and_after() -> None:
    (row,) = rows_of(replace(NAMED, remaining=(by_hand.profile("time", 0.0), by_hand.profile("speed", 0.0))))
    assert row.before is not None
    assert row.after is not None
    assert (row.before.axis, row.after.axis) == ("speed", "speed")


def test_what_stays_unexplained_beside_an_effect_has_a_row_of_its_own() -> None:
    both = replace(UNEXPLAINED, effects=NAMED.effects, profiles=NAMED.profiles, remaining=NAMED.remaining)
    axes = [row.after.axis if row.after else None for row in rows_of(both)]
    assert axes == [None, "time"]


def test_where_it_is_unexplained_is_written_above_its_profile() -> None:
    words = words_in(draw_residual(ALL, 4))
    assert "joint 4: declared model below 0.15 unit, in both directions" in words
    assert len(draw_residual(ALL, 4).axes) == 1


def test_noise_is_given_no_place() -> None:
    assert "below" not in words_in(draw_residual(ALL, 3))


def test_means_stand_at_the_bins_with_two_standard_errors() -> None:
    axes = draw_residual(ALL, 4).axes[0]
    shown = UNEXPLAINED.profiles[0]
    means = [box for box in axes.containers if str(box.get_label()).startswith("backwards")]
    x, y = (np.asarray(data) for data in means[0].lines[0].get_data())  # type: ignore[attr-defined]
    assert x == pytest.approx(shown.centre)
    assert y == pytest.approx(shown.backwards)
    (bars,) = means[0].lines[2]  # type: ignore[attr-defined]
    half = np.array([np.ptp(segment[:, 1]) / 2 for segment in bars.get_segments()])
    assert half == pytest.approx(STANDARD_ERRORS * shown.backwards_se)


def test_the_ladder_is_as_long_as_the_gaps() -> None:
    axes = draw_ladder(ALL, 1).axes[0]
    assert [bar.get_width() for bar in axes.patches] == pytest.approx([rms for _, rms in NAMED.ladder])  # type: ignore[attr-defined]
    assert [label.get_text() for label in axes.get_yticklabels()] == [step for step, _ in NAMED.ladder]
    assert axes.get_title(loc="left") == "joint 1: 97.6 ± 1.0 % closed\non 9 locked cycles"


CONTACTS = effect_of(
    replace(
        NAMED.effects[0],
        name="contact_event",
        parameters={"contacts": by_hand.coefficient(2.0, 0.0)},
        evidence=(Evidence(name="contact_event", delta_bic=0.0, correlation=1.0),),
    )
)
TOUCHED = replace(
    NAMED,
    effects=(CONTACTS,),
    ladder=(("declared model", 0.3), ("+ contact_event", 0.02), ("floor of the noise", 0.02)),
    gap=by_hand.gap(0.02, 0.02, 0.02),
)


def test_contacts_are_left_out_and_no_model_has_them() -> None:
    alone = of(TOUCHED)
    assert legend_of(draw_simulation(alone, 1))[-2:] == ["declared model", "measured velocity"]
    (axes,) = draw_residual(alone, 1).axes
    assert axes.get_title(loc="left") == "joint 1: declared model, contacts left out"
    ladder = words_in(draw_ladder(alone, 1))
    assert "joint 1: nothing added on 9 locked cycles, contacts left out" in ladder
    assert "+ contact_event" not in ladder
    assert "no other candidate was held against it" in words_in(draw_evidence(alone, 1))


def test_beside_contacts_the_grown_model_has_the_other_effects() -> None:
    left = (by_hand.profile("speed", 0.0),)
    both = of(replace(TOUCHED, effects=(CONTACTS, *NAMED.effects), gap=NAMED.gap, remaining=left))
    assert "with stribeck" in legend_of(draw_simulation(both, 1))
    assert len(draw_residual(both, 1).axes) == 2
    assert "97.6 ± 1.0 % closed on 9 locked cycles, contacts left out" in words_in(draw_ladder(both, 1))


def test_a_gap_that_was_never_open_is_not_closed() -> None:
    shut = Gap(before=0.02, after=0.02, floor=0.02, shrink=np.nan, shrink_se=np.nan, over_floor=1.0, cycles=4)
    assert closed_words(replace(NAMED, gap=shut)) == "at the floor from the start\non 4 locked cycles"
    assert closed_words(replace(NONE, gap=shut)) == "nothing added\non 4 locked cycles"


def test_rivals_that_cannot_be_told_apart_are_marked() -> None:
    (effect,) = AMBIGUOUS.effects
    names = {"torque_bias": 0.0, "asymmetric_coulomb": -3.0, "warm_up": 41.3, "stribeck": -239.0}
    rivals = [Evidence(name=name, delta_bic=worse, correlation=0.5) for name, worse in names.items()]
    assert [mark_of(effect, rival) for rival in rivals] == [CHOSEN, ALIKE, BEATEN, ELSEWHERE]


def test_one_of_a_pair_is_told_apart_where_both_together_are_not() -> None:
    (effect,) = AMBIGUOUS.effects
    pair = ("asymmetric_coulomb", "inertia_error")
    one = replace(effect, alternatives=pair, together=(pair,))
    assert mark_of(one, Evidence(name="inertia_error", delta_bic=126.0, correlation=0.7)) == BEATEN
    assert not_drawn(one, (one,)) == "nor told from asymmetric_coulomb with inertia_error"


def test_a_sheet_leaves_out_only_rivals_that_are_told_apart() -> None:
    (effect,) = AMBIGUOUS.effects
    last = Evidence(name="asymmetric_coulomb", delta_bic=50.0, correlation=1.0)
    assert [one.name for one in nearest(replace(effect, evidence=(*effect.evidence, last)), most=1)] == [
        "torque_bias",
        "asymmetric_coulomb",
    ]


def test_a_sheet_shows_the_axis_of_the_strongest_effect() -> None:
    two = replace(NAMED, effects=(NAMED.effects[0], replace(NAMED.effects[0], curve=by_hand.profile("time", 0.1))))
    assert len(draw_residual(of(two), None).axes) == 2
    assert len(draw_residual(of(two), 1).axes) == 3


def test_evidence_stands_at_its_difference_in_bic() -> None:
    (effect,) = AMBIGUOUS.effects
    rivals = (*effect.evidence, Evidence(name="asymmetric_coulomb", delta_bic=1.5, correlation=1.0))
    figure = draw_evidence(of(replace(AMBIGUOUS, effects=(replace(effect, evidence=rivals),))), 2)
    marks = {str(one.get_label()): float(np.asarray(one.get_xdata())[0]) for one in figure.axes[0].lines}
    assert marks[CHOSEN.label] == 0.0
    assert marks[BEATEN.label] == 41.3
    assert marks[ALIKE.label] == 1.5
    assert "r = 0.31" in words_in(figure)


def test_names_that_have_no_line_are_told_above_the_evidence() -> None:
    (effect,) = AMBIGUOUS.effects
    drawn = (*effect.evidence, Evidence(name="asymmetric_coulomb", delta_bic=1.5, correlation=1.0))
    names = ("asymmetric_coulomb", "joint_limit_stop")
    one = replace(effect, alternatives=names, evidence=drawn)
    whole = replace(NAMED.effects[0], name="torque_drift")
    part = replace(one, alternatives=(*names, "torque_drift"))
    assert not_drawn(replace(one, alternatives=names[:1]), (one,)) == ""
    assert not_drawn(one, (one,)) == "nor told from joint_limit_stop"
    assert not_drawn(part, (whole, part)) == "nor told from joint_limit_stop, a part of torque_drift"
    titles = [axes.get_title(loc="left") for axes in draw_evidence(of(replace(AMBIGUOUS, effects=(one,))), 2).axes]
    assert titles == [f"joint 2: {effect.name}\nnor told from joint_limit_stop"]


def test_the_fitted_torque_lies_over_what_the_log_shows() -> None:
    axes = draw_effects(ALL, 1).axes[0]
    _, forwards = line(axes, "fitted, forwards")
    _, backwards = line(axes, "fitted, backwards")
    assert forwards == pytest.approx(np.full(len(forwards), MISSING_NM))
    assert backwards == pytest.approx(np.full(len(backwards), -MISSING_NM))
    dots = np.concatenate([np.asarray(one.get_ydata(), float) for one in axes.lines if one.get_marker() == "."])
    assert np.abs(dots).mean() == pytest.approx(MISSING_NM, abs=0.01)


def test_parameters_of_an_effect_stand_below_its_curve() -> None:
    assert "0.150 ± 0.010 N m" in words_in(draw_effects(ALL, 1))


def test_means_along_an_axis_by_hand() -> None:
    x, y = mean_along(np.array([3.0, 1.0, 2.0, 4.0]), np.array([30.0, 10.0, 20.0, 50.0]), points=2)
    assert x == pytest.approx([1.5, 3.5])
    assert y == pytest.approx([15.0, 40.0])


@given(arrays(float, 50, elements=st.floats(-10.0, 10.0)))
def test_a_panel_holds_zero_and_all_means_and_is_not_filled_by_noise(rows: Float) -> None:
    shown = by_hand.profile("speed", 0.5)
    bottom, top = limits_for(rows, shown)
    assert bottom < min(0.0, np.nanmin(shown.backwards - 2 * shown.backwards_se))
    assert top > np.nanmax(shown.forwards + 2 * shown.forwards_se)
    assert top - bottom < 5 * 0.14


def test_a_verdict_is_said_with_its_names() -> None:
    assert [verdict_words(joint) for joint in ALL.discrepancy.joints] == [
        "named: stribeck",
        "ambiguous: torque_bias or asymmetric_coulomb",
        "none",
        "unexplained",
        "not testable",
        "data fault",
    ]
    both = replace(UNEXPLAINED, effects=NAMED.effects)
    assert verdict_words(both) == "unexplained, beside stribeck"
    assert said_of(DATA_FAULT) == f"data fault: {by_hand.FAULT}"


def test_all_joints_fit_one_figure_each_on_its_line() -> None:
    axes = draw_verdicts(ALL, None).axes[0]
    grown = {
        float(np.asarray(one.get_ydata())[0]): float(np.asarray(one.get_xdata())[0])
        for one in axes.lines
        if one.get_color() == GROWN
    }
    assert grown == {0.0: 0.021, 1.0: 0.03}
