"""Figures of an estimate: what is drawn is what the numbers say."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.pipeline import Estimate
from friction_audit.reporting.figures import panels
from friction_audit.reporting.figures.over_time import (
    dissipated_stairs,
    draw_coefficients,
    draw_energy,
    draw_signals,
    y_limits,
)
from friction_audit.reporting.figures.registry import Figure, figures_of
from friction_audit.reporting.figures.series import choose_series
from friction_audit.reporting.figures.velocity_torque import (
    centre_nm,
    draw_velocity_torque,
    filtered_curve,
    filtered_loop,
    fitted_label,
    fitted_torque,
    typical_strokes,
)
from tests.reporting.conftest import COULOMB, VISCOUS, build_estimate

KINDS = pytest.mark.parametrize("kind", figures_of("estimate"), ids=lambda kind: kind.name)


def legend(figure: Any) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


@KINDS
def test_a_joint_without_an_estimate_or_with_a_constant_torque_is_drawn(
    kind: Figure, seven: Estimate, single: Estimate
) -> None:
    texts = " ".join(text.get_text() for axes in kind.draw(seven, 3).axes for text in axes.texts)
    assert kind.name == "signals" or "not determined: the joint does not move" in texts.replace("\n", " ")
    still = replace(single.interaction, torque=np.zeros_like(single.interaction.torque))
    assert kind.draw(replace(single, interaction=still), 1).axes


def test_fitted_friction_is_odd_and_lacks_what_the_model_lacks(single: Estimate) -> None:
    friction = single.friction.joints[0]
    torque = fitted_torque(friction, np.array([-2.0, 2.0]))
    assert torque == pytest.approx(np.array([-1.0, 1.0]) * (COULOMB[0] + 2 * VISCOUS[0]))
    assert fitted_label(friction, 0.01) == r"fitted: $0.245\,\mathrm{sgn}\,\dot{q}+0.400\,\dot{q}+0.010$"
    assert fitted_label(replace(friction, model="viscous", coulomb=UNDETERMINED), 0.0) == r"fitted: $0.400\,\dot{q}$"
    coulomb = replace(friction, model="coulomb", viscous=UNDETERMINED)
    assert fitted_torque(coulomb, np.array([3.0])) == pytest.approx(COULOMB[0])
    assert fitted_torque(replace(friction, viscous=UNDETERMINED), np.array([3.0])) is None


def test_the_fit_is_drawn_where_the_torque_is_and_its_formula_is_one(single: Estimate) -> None:
    (series,) = choose_series(single, 1).joints
    assert centre_nm(series) == pytest.approx(0.0, abs=0.02)
    assert centre_nm(replace(series, torque=series.torque + 0.5)) == pytest.approx(0.5, abs=0.02)
    formula = fitted_label(series.friction, centre_nm(series))
    (text,) = (text for text in draw_velocity_torque(single, 1).legends[0].get_texts() if text.get_parse_math())
    assert text.get_text() == formula


def test_a_logged_compensator_acts_against_friction_too(single: Estimate) -> None:
    helped = replace(single.interaction, compensation=np.full_like(single.interaction.torque, 0.2))
    (series,) = choose_series(replace(single, interaction=helped), 1).joints
    assert centre_nm(series) == pytest.approx(0.2, abs=0.02)
    figure = draw_velocity_torque(replace(single, interaction=helped), 1)
    assert figure.get_supylabel() == "Interaction and compensator torque [N m]"


def test_arrows_run_along_two_neighbouring_cycles_that_count(single: Estimate) -> None:
    (series,) = choose_series(single, 1).joints
    cycles, strokes = series.cycles, typical_strokes(series)
    row = cycles.start.tolist().index(strokes.start)
    following = next(r for r in range(row + 1, len(cycles.joint)) if cycles.reason[r] == 0)
    assert cycles.reason[row] == 0
    assert strokes.stop == cycles.stop[following] + 1
    assert series.dq[strokes].min() < -0.3
    assert series.dq[strokes].max() > 0.3


def test_a_long_log_shows_whole_cycles_and_says_how_many(single: Estimate, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(panels, "MOST_POINTS", 1000)
    (series,) = choose_series(single, 1).joints
    loop = filtered_loop(series, filtered_curve(series))
    assert loop.every > 1
    assert loop.every % 2 == 1
    assert np.nanmin(loop.dq) < -0.3
    assert np.nanmax(loop.dq) > 0.3
    assert np.isfinite(loop.dq).sum() <= 1500
    assert f"1 cycle in {loop.every}" in " ".join(legend(draw_velocity_torque(single, 1)))


def test_the_net_energy_is_the_integral_of_power_and_meets_the_stairs(single: Estimate) -> None:
    (series,) = choose_series(single, 1).joints
    edges, stairs = dissipated_stairs(series)
    assert stairs[0] == 0.0
    assert stairs == pytest.approx(np.interp(edges, series.t, series.net_energy_j), abs=0.01)
    steady = replace(series, dq=np.full_like(series.t, 2.0), torque=np.full_like(series.t, 0.5))
    assert steady.net_energy_j == pytest.approx(series.t)


def test_rejected_cycles_are_hatched(single: Estimate) -> None:
    patches = draw_energy(single, 1).axes[0].patches
    assert len([one for one in patches if one.get_hatch()]) == int((single.cycles.reason != 0).sum()) == 1


@pytest.fixture(scope="module")
def crowded() -> Estimate:
    return build_estimate(3, count=90, rate=100.0)  # the third joint stands still


def test_a_long_log_shows_its_first_cycles_apart(crowded: Estimate) -> None:
    figure = draw_energy(crowded, 1)
    whole, zoomed = figure.axes
    assert (whole.get_title(loc="left"), zoomed.get_title(loc="left")) == ("joint 1", "cycles 1 to 40 of 87")
    assert zoomed.get_xlim()[1] == pytest.approx(choose_series(crowded, 1).joints[0].cycles.stop_s[39])
    assert len(whole.patches) == 1
    assert len([patch for patch in zoomed.patches if not patch.get_hatch()]) == 20
    (dots,) = [line for line in zoomed.lines if line.get_marker() == "o"]
    assert len(np.asarray(dots.get_xdata())) == 41
    assert {"part drawn below", "every other cycle", "zero velocity", "rejected cycle"} <= set(legend(figure))
    sheet = draw_energy(crowded, None)
    titles = [axes.get_title(loc="left") for axes in sheet.axes]
    assert titles == ["joint 1", "cycles 1 to 40 of 87", "joint 2", "cycles 1 to 40 of 86"]
    assert sheet.get_supxlabel().endswith("joint 3: did not move")
    assert "part drawn on the right" in legend(sheet)
    signals = draw_signals(crowded, 1)
    assert not signals.axes[0].patches
    assert "more than 80 cycles are not shaded" in legend(signals)


def test_first_cycles_hold_their_own_samples(crowded: Estimate) -> None:
    series, _, still = (choose_series(crowded, joint).joints[0] for joint in (1, 2, 3))
    part = series.first_cycles(5)
    assert len(part.cycles.joint) == 5
    assert part.t[part.cycles.start] == pytest.approx(series.cycles.start_s[:5])
    assert part.t[-1] == series.cycles.stop_s[4]
    assert still.first_cycles(5) is still


def test_a_coefficient_that_the_model_lacks_is_no_failure(single: Estimate) -> None:
    friction = single.friction.joints[0]
    nothing = np.full_like(friction.history.coulomb_nm, np.nan)
    history = friction.history.with_coefficient("viscous", nothing, nothing, nothing)
    bare = replace(friction, model="coulomb", viscous=UNDETERMINED, history=history)
    panels = draw_coefficients(replace(single, friction=replace(single.friction, joints=(bare,))), 1).axes
    assert [text.get_text() for axes in panels for text in axes.texts] == ["not in the coulomb model"]


def test_one_wild_window_does_not_flatten_a_panel() -> None:
    value = np.array([np.nan, -40.0, 0.30, 0.28, 0.29])
    low, high = value - 0.05, value + 0.05
    low[1], high[1] = -80.0, 80.0
    bottom, top = y_limits(value, low, high, Coefficient(value=0.29, low=0.25, high=0.33)) or (0, 0)
    assert -0.1 < bottom < 0.23
    assert 0.35 < top < 0.6
    nothing = np.full(3, np.nan)
    assert y_limits(nothing, nothing, nothing, UNDETERMINED) is None


def test_the_legend_says_how_long_the_window_is_and_whether_a_band_is_cut(single: Estimate) -> None:
    assert legend(draw_coefficients(single, 1))[:2] == ["last 15 cycles", "95 % interval"]
    friction = single.friction.joints[0]
    high = friction.history.coulomb_high_nm.copy()
    high[1] = 80.0
    wild = replace(friction, history=replace(friction.history, coulomb_high_nm=high))
    figure = draw_coefficients(replace(single, friction=replace(single.friction, joints=(wild,))), 1)
    assert "95 % interval, clipped" in legend(figure)
    assert figure.axes[0].get_ylim()[1] < 1
    last = replace(friction, window=1)
    figure = draw_coefficients(replace(single, friction=replace(single.friction, joints=(last,))), 1)
    assert legend(figure)[0] == "last cycle"
