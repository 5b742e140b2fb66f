"""Fig. 13: net energy between person and arm, compensated by five methods."""

from typing import TYPE_CHECKING

from friction_audit.compensation.comparison import Comparison
from friction_audit.reproduce.course import (
    MOST_SEEDS,
    NOTE,
    ROLES,
    SCENARIO,
    compared,
    draw_compared,
    in_words,
    is_ranked,
    rows_of,
    steps_down,
)
from friction_audit.reproduce.reproduction import Claim, Reproduction, Simulations

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KEPT = 0.1
"""Slope, over that without compensation, up to which the net energy counts as kept."""


def check(simulations: Simulations) -> tuple[Claim, ...]:
    """Check the order of the slopes, and that the proposed method keeps the energy, with both kinds of tuning."""
    comparison = compared(simulations)
    return tuple(
        claim for role, words in ROLES for claim in (_order(comparison, role, words), _keeps(comparison, role, words))
    )


def _order(comparison: Comparison, role: str, words: str) -> Claim:
    rows = rows_of(comparison, role)
    slopes = [row.interval(lambda outcome: outcome.energy_slope_w).value for row in rows]
    return Claim(
        figure="13",
        claim=f"the net energy rises most without compensation, then model-based, disturbance observer, torque "
        f"regulation, proposed; {words}",
        paper="none > model > DOB > torque regulation > proposed",
        ours=in_words(rows, slopes, 1000.0, "mW"),
        value=float(steps_down(slopes)),
        holds=is_ranked(slopes),
        note=NOTE,
    )


def _keeps(comparison: Comparison, role: str, words: str) -> Claim:
    none, *_, proposed = rows_of(comparison, role)
    slope, alone = (row.interval(lambda outcome: outcome.energy_slope_w).value for row in (proposed, none))
    return Claim(
        figure="13",
        claim=f"the proposed method keeps the net energy after two cycles; {words}",
        paper="maintains the energy value",
        ours=f"{slope / alone:.2f} of the slope without compensation (bound {KEPT:g}); stable in "
        f"{proposed.stable_share:.0%} of seeds",
        value=slope / alone,
        holds=abs(slope / alone) < KEPT and proposed.stable_share == 1.0,
        note="cycles of the hand give single joints wrong coefficients where two are alike or the joint does not rest; "
        "what the passivity controller then does may ring",
    )


def draw(simulations: Simulations) -> "Figure":
    """Draw the net energies of all methods."""
    return draw_compared(simulations, "energy")


FIGURE_13 = Reproduction(
    figure="13",
    title="Net energy of a Panda guided by a hand, with five compensation methods",
    scenarios=(SCENARIO,),
    most_seeds=MOST_SEEDS,
    check=check,
    draw=draw,
)
