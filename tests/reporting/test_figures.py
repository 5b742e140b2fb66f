"""Every figure draws; what it draws is what the numbers say."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.text import Text

from friction_audit.errors import UsageError
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.friction.settings import FrictionSettings
from friction_audit.pipeline import Estimate
from friction_audit.reporting.figures import FIGURES, FigureKind, coefficients, energy, save_figure, velocity_torque
from friction_audit.reporting.figures.energy import dissipated_stairs, net_energy
from friction_audit.reporting.figures.style import COLUMN_IN, FORMATS, SHEET_IN, joint_series
from friction_audit.reporting.figures.velocity_torque import (
    centre_nm,
    filtered_curve,
    filtered_loop,
    fitted_label,
    fitted_torque,
    typical_strokes,
)
from tests.reporting.conftest import COULOMB, VISCOUS, build_estimate

KINDS = pytest.mark.parametrize("kind", FIGURES, ids=lambda kind: kind.name)
WRITTEN = [
    pytest.param(
        kind,
        suffix,
        id=f"{suffix}-{kind.name}",
        marks=[] if kind is FIGURES[0] else pytest.mark.thorough,
    )
    for kind in FIGURES
    for suffix in FORMATS
]
"""One kind of figure in every format; the others are drawn and saved by the same hands, and take long."""


@KINDS
def test_sheets_are_a_page_wide_and_joints_a_column(kind: FigureKind, seven: Estimate) -> None:
    assert kind.draw(seven, None).get_figwidth() == SHEET_IN
    assert kind.draw(seven, 1).get_figwidth() == COLUMN_IN


@KINDS
def test_a_sheet_names_every_joint(kind: FigureKind, seven: Estimate) -> None:
    titles = {axes.get_title(loc="left") for axes in kind.draw(seven, None).axes} - {""}
    assert titles == {f"joint {j}" for j in range(1, 8)}


@KINDS
def test_a_name_that_says_more_than_the_number_is_in_the_title(kind: FigureKind, single: Estimate) -> None:
    elbow = replace(single, interaction=replace(single.interaction, joint_names=("elbow",)))
    assert kind.draw(elbow, 1).axes[0].get_title(loc="left") == "joint 1 elbow"


@pytest.mark.parametrize("kind", [k for k in FIGURES if k.name != "signals"], ids=lambda kind: kind.name)
def test_a_joint_without_an_estimate_says_why(kind: FigureKind, seven: Estimate) -> None:
    texts = " ".join(text.get_text() for axes in kind.draw(seven, 3).axes for text in axes.texts)
    assert "not determined: the joint does not move" in texts.replace("\n", " ")


@KINDS
def test_a_joint_that_is_not_there_is_named(kind: FigureKind, single: Estimate) -> None:
    with pytest.raises(UsageError, match=r"joint 4: .* holds 1"):
        kind.draw(single, 4)


@pytest.mark.parametrize(("kind", "suffix"), WRITTEN)
def test_the_same_result_gives_the_same_bytes(kind: FigureKind, suffix: str, single: Estimate, tmp_path: Path) -> None:
    paths = [tmp_path / f"{k}.{suffix}" for k in range(2)]
    for path in paths:
        save_figure(kind.draw(single, 1), path)
    first, second = (path.read_bytes() for path in paths)
    assert first == second
    assert len(first) > 1000
    assert not re.search(rb"20\d\d-\d\d-\d\dT", first)


def test_the_users_own_matplotlib_settings_change_nothing(single: Estimate) -> None:
    with rc_context({"font.size": 30, "lines.linewidth": 9}):
        figure = FIGURES[0].draw(single, 1)
        assert figure.axes[0].xaxis.label.get_fontsize() == 7.5


def test_fitted_friction_is_odd(single: Estimate) -> None:
    torque = fitted_torque(single.friction.joints[0], np.array([-2.0, 2.0]))
    assert torque == pytest.approx(np.array([-1.0, 1.0]) * (COULOMB[0] + 2 * VISCOUS[0]))


def test_the_curve_is_drawn_where_the_torque_is(single: Estimate) -> None:
    series = joint_series(single, 1)
    assert centre_nm(series) == pytest.approx(0.0, abs=0.02)
    assert centre_nm(replace(series, torque=series.torque + 0.5)) == pytest.approx(0.5, abs=0.02)


def test_a_model_without_a_coefficient_is_drawn_without_it(single: Estimate) -> None:
    friction = single.friction.joints[0]
    assert fitted_label(friction, 0.01) == r"fitted: $0.245\,\mathrm{sgn}\,\dot{q}+0.400\,\dot{q}+0.010$"
    assert fitted_label(replace(friction, model="viscous", coulomb=UNDETERMINED), 0.0) == r"fitted: $0.400\,\dot{q}$"
    coulomb = replace(friction, model="coulomb", viscous=UNDETERMINED)
    assert fitted_torque(coulomb, np.array([3.0])) == pytest.approx(COULOMB[0])
    assert fitted_torque(replace(friction, viscous=UNDETERMINED), np.array([3.0])) is None


def test_arrows_run_along_two_neighbouring_cycles_that_count(single: Estimate) -> None:
    series = joint_series(single, 1)
    cycles, strokes = series.cycles, typical_strokes(series)
    row = cycles.start.tolist().index(strokes.start)
    following = next(r for r in range(row + 1, len(cycles.joint)) if cycles.reason[r] == 0)
    assert cycles.reason[row] == 0
    assert strokes.stop == cycles.stop[following] + 1
    assert series.dq[strokes].min() < -0.3
    assert series.dq[strokes].max() > 0.3


def test_friction_is_drawn_on_all_that_acts_against_it(single: Estimate) -> None:
    helped = replace(single.interaction, compensation=np.full_like(single.interaction.torque, 0.2))
    series = joint_series(replace(single, interaction=helped), 1)
    assert centre_nm(series) == pytest.approx(0.2, abs=0.02)
    figure = FIGURES[0].draw(replace(single, interaction=helped), 1)
    assert figure.get_supylabel() == "Interaction and compensator torque [N m]"


def test_a_long_log_shows_whole_cycles_and_says_how_many(single: Estimate, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(velocity_torque, "MOST_POINTS", 1000)
    series = joint_series(single, 1)
    loop = filtered_loop(series, filtered_curve(series))
    assert loop.every > 1
    assert loop.every % 2 == 1
    assert np.nanmin(loop.dq) < -0.3
    assert np.nanmax(loop.dq) > 0.3
    assert np.isfinite(loop.dq).sum() <= 1500
    legend = velocity_torque.draw_velocity_torque(single, 1).legends[0]
    assert f"1 cycle in {loop.every}" in " ".join(text.get_text() for text in legend.get_texts())


def test_the_stairs_meet_the_net_energy_at_the_borders(single: Estimate) -> None:
    series = joint_series(single, 1)
    edges, stairs = dissipated_stairs(series)
    energy = np.interp(edges, series.t, net_energy(series))
    assert stairs[0] == 0.0
    assert stairs == pytest.approx(energy, abs=0.01)


def test_the_net_energy_of_constant_power_is_a_line(single: Estimate) -> None:
    series = joint_series(single, 1)
    steady = replace(series, dq=np.full_like(series.t, 2.0), torque=np.full_like(series.t, 0.5))
    assert net_energy(steady) == pytest.approx(series.t)


def test_cycles_left_out_are_hatched(single: Estimate) -> None:
    figure = next(kind for kind in FIGURES if kind.name == "energy").draw(single, 1)
    hatched = [patch for patch in figure.axes[0].patches if patch.get_hatch()]
    assert len(hatched) == int((single.cycles.reason != 0).sum()) == 1


def test_a_coefficient_that_the_model_lacks_is_no_failure(single: Estimate) -> None:
    friction = single.friction.joints[0]
    nothing = np.full_like(friction.history.coulomb_nm, np.nan)
    history = replace(friction.history, viscous_nms_per_rad=nothing)
    bare = replace(friction, model="coulomb", viscous=UNDETERMINED, history=history)
    result = replace(single, friction=replace(single.friction, joints=(bare,)))
    panels = next(kind for kind in FIGURES if kind.name == "coefficients").draw(result, 1).axes
    assert [text.get_text() for axes in panels for text in axes.texts] == ["not in the coulomb model"]


@KINDS
def test_a_torque_that_never_changes_is_drawn(kind: FigureKind, single: Estimate) -> None:
    still = replace(single.interaction, torque=np.zeros_like(single.interaction.torque))
    assert kind.draw(replace(single, interaction=still), 1).axes


def legend(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


@pytest.fixture(scope="module")
def crowded() -> Estimate:
    return build_estimate(3, count=90, rate=100.0)  # the third joint stands still


def test_a_long_log_shows_its_first_cycles_apart(crowded: Estimate) -> None:
    figure = energy.draw_energy(crowded, 1)
    whole, zoomed = figure.axes
    assert (whole.get_title(loc="left"), zoomed.get_title(loc="left")) == ("joint 1", "cycles 1 to 40 of 87")
    assert zoomed.get_xlim()[1] == pytest.approx(joint_series(crowded, 1).cycles.stop_s[39])
    (window,) = whole.patches
    assert window.get_extents().x1 == pytest.approx(whole.transData.transform((zoomed.get_xlim()[1], 0))[0])
    assert len([patch for patch in zoomed.patches if not patch.get_hatch()]) == 20
    assert len([patch for patch in zoomed.patches if patch.get_hatch()]) == 1
    (dots,) = [line for line in zoomed.lines if line.get_marker() == "o"]
    assert len(np.asarray(dots.get_xdata())) == 41
    assert {"part drawn below", "cycle (every other)", "zero velocity", "cycle left out"} <= set(legend(figure))


def test_a_sheet_of_a_long_log_has_the_first_cycles_on_the_right(crowded: Estimate) -> None:
    figure = energy.draw_energy(crowded, None)
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == ["joint 1", "cycles 1 to 40 of 87", "joint 2", "cycles 1 to 40 of 86", "joint 3"]
    assert "part drawn on the right" in legend(figure)


def test_first_cycles_hold_their_own_samples(crowded: Estimate) -> None:
    series = joint_series(crowded, 1)
    part = series.first_cycles(5)
    assert len(part.cycles.joint) == 5
    assert part.t[part.cycles.start] == pytest.approx(series.cycles.start_s[:5])
    assert part.t[-1] == series.cycles.stop_s[4]
    still = joint_series(crowded, 3)
    assert still.first_cycles(5) is still


def test_signals_say_that_too_many_cycles_are_not_shaded(crowded: Estimate) -> None:
    figure = next(kind for kind in FIGURES if kind.name == "signals").draw(crowded, 1)
    assert not figure.axes[0].patches
    assert "more than 80 cycles are not shaded" in legend(figure)


def test_one_wild_window_does_not_flatten_a_panel() -> None:
    value = np.array([np.nan, -40.0, 0.30, 0.28, 0.29])
    low, high = value - 0.05, value + 0.05
    low[1], high[1] = -80.0, 80.0
    bottom, top = coefficients.y_limits(value, low, high, Coefficient(value=0.29, low=0.25, high=0.33)) or (0, 0)
    assert -0.1 < bottom < 0.23
    assert 0.35 < top < 0.6


@given(st.lists(st.floats(-5, 5), min_size=1, max_size=30), st.floats(0.01, 2))
def test_values_of_like_intervals_are_all_inside(values: list[float], width: float) -> None:
    value = np.array(values)
    whole = Coefficient(value=value.mean(), low=value.min() - width, high=value.max() + width)
    bottom, top = coefficients.y_limits(value, value - width, value + width, whole) or (0, 0)
    assert bottom < whole.low
    assert top > whole.high
    assert top - bottom < 4 * (whole.high - whole.low)


def test_nothing_determined_needs_no_limits() -> None:
    nothing = np.full(3, np.nan)
    assert coefficients.y_limits(nothing, nothing, nothing, UNDETERMINED) is None


def test_the_legend_says_how_long_the_window_is_and_whether_a_band_is_cut(single: Estimate) -> None:
    draw = coefficients.draw_coefficients
    assert legend(draw(single, 1))[:2] == ["last 20 cycles", "95 %"]
    friction = single.friction.joints[0]
    high = friction.history.coulomb_high_nm.copy()
    high[1] = 80.0
    wild = replace(friction, history=replace(friction.history, coulomb_high_nm=high))
    figure = draw(replace(single, friction=replace(single.friction, joints=(wild,))), 1)
    assert "95 %, cut at the edge" in legend(figure)
    assert figure.axes[0].get_ylim()[1] < 1
    paper = FrictionSettings(estimator="paper", model="coulomb")
    assert legend(draw(replace(single, settings=replace(single.settings, friction=paper)), 1))[0] == "last cycle"


@pytest.fixture(scope="module")
def pair() -> Estimate:
    return build_estimate(2)


def formulas_in(figure: Figure) -> list[str]:
    """Return the texts that are read as mathematics."""
    texts = [text for text in figure.findobj(Text) if isinstance(text, Text)]
    return [text.get_text() for text in texts if "$" in text.get_text() and text.get_parse_math()]


def shown_formulas(kind: FigureKind, estimate: Estimate) -> list[str]:
    """Return the formulas in the figure of joint 1: that of the fitted curve."""
    series = joint_series(estimate, 1)
    return [fitted_label(series.friction, centre_nm(series))] if kind.name == "velocity-torque" else []


@KINDS
def test_dollar_signs_in_a_name_are_no_mathematics(kind: FigureKind, pair: Estimate, tmp_path: Path) -> None:
    """As mathematics this name would be an error."""
    names = (r"arm$\bad{$", *pair.interaction.joint_names[1:])
    joints = tuple(replace(one, name=name) for one, name in zip(pair.friction.joints, names, strict=True))
    odd = replace(
        pair,
        interaction=replace(pair.interaction, joint_names=names),
        friction=replace(pair.friction, joints=joints),
    )
    save_figure(kind.draw(odd, None), tmp_path / "sheet.svg")
    figure = kind.draw(odd, 1)
    assert any(r"arm$\bad{$" in axes.get_title(loc="left") for axes in figure.axes)
    assert formulas_in(figure) == shown_formulas(kind, odd)
