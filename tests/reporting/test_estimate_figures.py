"""Figures of an estimate: what is drawn is what the numbers say."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from friction_audit.friction.history import UNDETERMINED
from friction_audit.joint_log import Float
from friction_audit.pipeline import Estimate
from friction_audit.reporting.figures import panels
from friction_audit.reporting.figures.estimate import COEFFICIENTS, ENERGY, SIGNALS, VELOCITY_TORQUE
from friction_audit.reporting.figures.registry import FigureKind, figures_of
from tests.reporting.conftest import build_estimate
from tests.reporting.test_figures import legend_of, line, words_in

KINDS = pytest.mark.parametrize("kind", figures_of("estimate"), ids=lambda kind: kind.name)


def with_friction(estimate: Estimate, **changes: Any) -> Estimate:
    joints = tuple(replace(joint, **changes) for joint in estimate.friction.joints)
    return replace(estimate, friction=replace(estimate.friction, joints=joints))


@KINDS
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
    nothing = np.full_like(history.coulomb_nm, np.nan)
    history = history.with_coefficient("viscous", nothing, nothing, nothing)
    figure = COEFFICIENTS(with_friction(single, model="coulomb", viscous=UNDETERMINED, history=history), 1)
    assert [text.get_text() for axes in figure.axes for text in axes.texts] == ["not in the coulomb model"]
