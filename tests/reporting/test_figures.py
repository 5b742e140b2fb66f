"""What holds for every figure of the registry, and for the parts that they are made of."""

import re
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text

from friction_audit.batch.work import session_of
from friction_audit.compensation.settings import ReplaySettings
from friction_audit.drift.two_sides import compare_sides
from friction_audit.errors import UsageError
from friction_audit.friction.history import UNDETERMINED, Band
from friction_audit.joint_log import Float
from friction_audit.pipeline import AuditSettings, Estimate, estimate_log, replay_estimate
from friction_audit.reporting.figures import FIGURES, FigureKind, figures_of, panels
from friction_audit.reporting.figures.estimate import COEFFICIENTS, ENERGY, SIGNALS, VELOCITY_TORQUE
from friction_audit.reporting.figures.style import COLUMN_IN, FORMATS, SHEET_IN, STYLE, figure_bytes, load_style
from tests.each_case import thorough
from tests.reporting import batch_by_hand
from tests.reporting.conftest import build_estimate
from tests.reporting.diagnosis_by_hand import VERDICTS_BY_HAND, diagnosis

EVERY = pytest.mark.parametrize("kind", FIGURES, ids=lambda kind: f"{kind.result}-{kind.name}")
ODD = r"a$\bad{$"
"""As mathematics this name would be an error."""
LAST = {kind.result: kind for kind in FIGURES}
"""Of each result one figure."""


@cache
def result_of(kind: str, name: str = "") -> Any:
    if kind == "drift":
        arm = batch_by_hand.arm(8, 3)
        return replace(arm, joints=(replace(arm.joints[0], name=name or arm.joints[0].name), *arm.joints[1:]))
    if kind == "diagnosis":
        first, *others = VERDICTS_BY_HAND
        return diagnosis(replace(first, name=name or first.name), *others)
    log = build_estimate(3).log
    log = replace(log, joint_names=(name or log.joint_names[0], *log.joint_names[1:]))
    estimate = estimate_log(log, AuditSettings())
    if kind == "diff":
        return compare_sides([session_of(estimate)], [session_of(estimate)])
    return estimate if kind == "estimate" else replay_estimate(estimate, ReplaySettings())


def words_in(figure: Figure) -> str:
    """Return all that is written inside panels, above them and at their sides."""
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    titles = [axes.get_title(loc=side) for axes in figure.axes for side in ("left", "right")]
    labels = [label.get_text() for axes in figure.axes for label in (*axes.get_yticklabels(), axes.yaxis.label)]
    return " ".join([*texts, *titles, *labels, figure.get_supxlabel()]).replace("\n", " ")


def legend_of(figure: Figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def line(axes: Axes, label: str) -> tuple[Float, Float]:
    (found,) = (one for one in axes.lines if one.get_label() == label)
    return np.asarray(found.get_xdata(), float), np.asarray(found.get_ydata(), float)


@EVERY
def test_sheets_are_a_page_wide_and_name_every_joint_and_joints_are_a_column(kind: FigureKind) -> None:
    result = result_of(kind.result, ODD)
    sheet, column = kind.draw(result), kind.draw(result, 1)
    assert (sheet.get_figwidth(), column.get_figwidth()) == (SHEET_IN, COLUMN_IN)
    for figure in (sheet, column):
        texts = [text for text in figure.findobj(Text) if isinstance(text, Text) and ODD in text.get_text()]
        assert texts
        assert not any(text.get_parse_math() for text in texts)
    left_out = re.findall(r"joints? ([\d, ]+): (?:did|no)", words_in(sheet))
    shown = {number for number in (1, 2, 3) if f"joint {number}" in words_in(sheet)}
    assert shown | {int(number) for found in left_out for number in found.split(",")} >= {1, 2, 3}
    assert sheet.legends or kind.name == "ladder"
    lines = [one for legend in sheet.legends for one in legend.get_lines()]
    looks = [(one.get_color(), one.get_linestyle(), one.get_marker()) for one in lines]
    assert len(looks) == len(set(looks))


@EVERY
def test_a_joint_that_is_not_there_is_named(kind: FigureKind) -> None:
    with pytest.raises(UsageError, match=r"joint 9: .* holds 1, 2, 3"):
        kind.draw(result_of(kind.result), 9)


@pytest.mark.parametrize("kind", [*LAST.values(), *thorough({*FIGURES} - {*LAST.values()})])
def test_a_name_that_is_no_mathematics_can_be_painted(kind: FigureKind) -> None:
    kind.draw(result_of(kind.result, ODD), 1).draw_without_rendering()


@pytest.mark.parametrize("kind", [FIGURES[1], FIGURES[-1]], ids=lambda kind: kind.name)
def test_numbers_of_axes_are_mathematics_in_the_fonts_of_latex(kind: FigureKind) -> None:
    token = STYLE.set(load_style("latex"))
    try:
        figure = kind.draw(result_of(kind.result), 1)
        figure_bytes(figure, "svg")
    finally:
        STYLE.reset(token)
    texts = [text for text in figure.findobj(Text) if isinstance(text, Text) and text.get_visible()]
    numbers = [text for text in texts if "mathdefault" in text.get_text()]
    assert numbers
    assert all(text.get_parse_math() for text in numbers)


@pytest.mark.parametrize("suffix", FORMATS)
def test_the_same_result_gives_the_same_undated_bytes(suffix: str) -> None:
    first, second = (figure_bytes(FIGURES[0].draw(result_of("estimate"), 1), suffix) for _ in range(2))
    assert first == second
    assert len(first) > 1000
    assert not re.search(rb"20\d\d-\d\d-\d\dT", first)


def test_axes_have_the_unit_of_the_torque() -> None:
    axes = panels.label_in_unit(FIGURES[0].draw(result_of("estimate"), 1), "A").axes
    assert "[A]" in axes[0].get_ylabel()
    assert not any("N m" in one.get_ylabel() for one in axes)


def test_the_users_own_matplotlib_settings_change_nothing() -> None:
    with rc_context({"font.size": 30, "lines.linewidth": 9}):
        assert FIGURES[0].draw(result_of("estimate"), 1).axes[0].yaxis.label.get_fontsize() == 7.5


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=400), st.integers(8, 60))
def test_no_extreme_is_lost_and_time_keeps_its_order(values: list[float], most: int) -> None:
    signal = np.array(values)
    t, thinned = panels.thin_extremes(np.arange(len(signal), dtype=np.float64), signal, most)
    width = -(-2 * len(signal) // most)
    whole = len(signal) // width * width if len(signal) > most else len(signal)
    assert thinned.min() <= signal[:whole].min()
    assert thinned.max() >= signal[:whole].max()
    assert (np.diff(t) > 0).all()
    assert len(t) <= max(most, 2) + 1 or len(signal) <= most
    assert (signal[t.astype(int)] == thinned).all()


def test_no_line_bridges_a_gap() -> None:
    t, axes = np.append(np.arange(50.0), [90.0, 91.0]), Figure().subplots()
    panels.draw_curve(axes, t, np.ones(52), 100, label="curve")
    assert np.flatnonzero(np.isnan(line(axes, "curve")[1])).tolist() == [49]


def test_a_slow_signal_passes_the_filter_without_delay_and_a_fast_one_is_gone() -> None:
    t = np.arange(0, 10, 0.001)
    slow, fast = np.sin(2 * np.pi * 0.5 * t), np.sin(2 * np.pi * 100 * t)
    inside = slice(1000, -1000)
    assert panels.smooth(t, slow + fast)[inside] == pytest.approx(slow[inside], abs=2e-3)
    assert panels.smooth(t[:5], t[:5]) is not None
    assert panels.cutoff_hz(t) == panels.CUTOFF_HZ
    assert panels.cutoff_hz(np.arange(0, 10, 1 / 30)) == pytest.approx(6.0)


# Figures of an estimate: what is drawn is what the numbers say.


def with_friction(estimate: Estimate, **changes: Any) -> Estimate:
    joints = tuple(replace(joint, **changes) for joint in estimate.friction.joints)
    return replace(estimate, friction=replace(estimate.friction, joints=joints))


@pytest.mark.parametrize("kind", figures_of("estimate"), ids=lambda kind: kind.name)
def test_without_an_estimate_or_at_constant_torque_it_is_drawn(
    kind: FigureKind, seven: Estimate, single: Estimate
) -> None:
    assert kind.name == "signals" or "not determined: did not move" in words_in(kind.draw(seven, 3))
    still = replace(single.interaction, torque=np.zeros_like(single.interaction.torque))
    assert kind.draw(replace(single, interaction=still), 1).axes


def fitted(figure: Figure) -> tuple[str, Float]:
    """Return the formula of the fitted curve in the legend, and its torque from the largest speed back to the other."""
    (formula,) = (label for label in legend_of(figure) if label.startswith("fitted"))
    return formula, line(figure.axes[0], formula)[1]


def test_fitted_friction_is_odd_lies_where_the_torque_is_and_lacks_what_the_model_lacks(single: Estimate) -> None:
    formula, torque = fitted(VELOCITY_TORQUE(single, 1))
    coulomb, viscous = (one.value for one in (single.friction.joints[0].coulomb, single.friction.joints[0].viscous))
    assert formula.startswith(rf"fitted: ${coulomb:.3f}\,\mathrm{{sgn}}\,\dot{{q}}+{viscous:.3f}\,\dot{{q}}")
    assert np.ptp(torque[1:3]) == pytest.approx(2 * coulomb)
    reach = np.abs(single.interaction.dq).max()
    assert np.ptp(torque) == pytest.approx(2 * (coulomb + reach * viscous))
    assert torque.mean() == pytest.approx(0.0, abs=0.02)
    shifted = replace(single, interaction=replace(single.interaction, torque=single.interaction.torque + 0.5))
    assert fitted(VELOCITY_TORQUE(shifted, 1))[1].mean() == pytest.approx(0.5, abs=0.02)
    only = with_friction(single, model="coulomb", viscous=UNDETERMINED)
    assert np.ptp(fitted(VELOCITY_TORQUE(only, 1))[1]) == pytest.approx(2 * coulomb)
    neither = VELOCITY_TORQUE(with_friction(single, viscous=UNDETERMINED), 1)
    assert not [label for label in legend_of(neither) if "fitted" in label]


def test_a_logged_compensator_acts_against_friction_too(single: Estimate) -> None:
    helped = replace(single.interaction, compensation=np.full_like(single.interaction.torque, 0.2))
    assert fitted(VELOCITY_TORQUE(replace(single, interaction=helped), 1))[1].mean() == pytest.approx(0.2, abs=0.02)


def test_arrows_run_in_the_direction_of_time(single: Estimate) -> None:
    """While a joint speeds up its inertia takes torque: every loop is run through clockwise."""
    arrows = [text for text in VELOCITY_TORQUE(single, 1).axes[0].texts if text.arrow_patch]  # type: ignore[attr-defined]
    moves = [np.subtract(arrow.xy, arrow.xyann) for arrow in arrows]  # type: ignore[attr-defined]
    assert [np.sign(move[0]) for move in moves] == [1.0, -1.0, -1.0, 1.0]


def test_a_long_log_shows_whole_cycles_and_says_how_many(single: Estimate, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(panels, "MOST_POINTS", 1000)
    figure = VELOCITY_TORQUE(single, 1)
    (label,) = (label for label in legend_of(figure) if "1 cycle in" in label)
    speed, _ = line(figure.axes[0], label)
    assert int(label.rpartition(" ")[2]) % 2 == 1
    assert np.nanmin(speed) < -0.3 < 0.3 < np.nanmax(speed)
    assert np.isfinite(speed).sum() <= 1500


def test_net_energy_is_the_integral_of_power_meets_the_stairs_and_rejected_cycles_are_hatched(single: Estimate) -> None:
    (cycles,) = single.cycles
    reason = np.where(np.arange(len(cycles.start)) == 3, 1, 0)
    axes = ENERGY(replace(single, cycles=(replace(cycles, reason=reason),)), 1).axes[0]
    t, energy = line(axes, "net energy")
    edges, stairs = line(axes, "dissipated, per cycle")
    assert stairs[0] == 0.0
    assert stairs == pytest.approx(np.interp(edges, t, energy), abs=0.01)
    assert len([one for one in axes.patches if one.get_hatch()]) == 1
    steady: dict[str, Any] = {name: np.full_like(single.interaction.dq, 1.0) for name in ("dq", "torque")}
    moving = replace(single, interaction=replace(single.interaction, **steady))
    t, energy = line(ENERGY(moving, 1).axes[0], "net energy")
    assert np.diff(energy) == pytest.approx(np.diff(t))


def test_many_cycles_are_not_shaded() -> None:
    crowded = build_estimate(1, count=90, rate=100.0)
    for layout in (ENERGY, SIGNALS):
        figure = layout(crowded, 1)
        assert not figure.axes[0].patches
        assert "more than 80 cycles are not shaded" in legend_of(figure)


def test_a_coefficient_that_the_model_lacks_is_no_failure(single: Estimate) -> None:
    history = single.friction.joints[0].history
    history = history._replace(viscous=Band(*np.full_like(history.viscous, np.nan)))
    figure = COEFFICIENTS(with_friction(single, model="coulomb", viscous=UNDETERMINED, history=history), 1)
    assert [text.get_text() for axes in figure.axes for text in axes.texts] == ["not in the coulomb model"]
