"""Figs 13 and 14: a Panda guided by a hand, compensated by five methods; the comparison is made once for both."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise
from typing import TYPE_CHECKING

from friction_audit.compensation.comparison import METHODS, SCENES, Comparison, compare
from friction_audit.compensation.comparison.methods import BEST, PAPER
from friction_audit.compensation.comparison.result import Row
from friction_audit.reporting.figures.comparison import draw_comparison
from friction_audit.reproduce.reproduction import Claim, Reproduction, Simulations

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# The paper's methods, from the steepest to the flattest net energy.
ORDER = ("none", "sigmoid", "disturbance_observer", "torque_regulation", "energy")
SCENARIO = "fig13"
MOST_SEEDS = 5  # of an arm with all its methods and their sweeps; ``compare --arm panda`` takes more
NOTE = (
    "friction-audit compare --arm panda has more persons, intervals and sweeps; torque regulation by its law leaves a "
    "share of all friction, while an observer leaves none of what is slow"
)


def compared(simulations: Simulations) -> Comparison:
    """Return the comparison for as many persons as moved the uncompensated arm."""
    return _compare(len(simulations[SCENARIO]))


@cache
def _compare(seeds: int) -> Comparison:
    (arm,) = (scene for scene in SCENES if scene.name == "panda")
    arm = replace(arm, plan=replace(arm.plan, margin_seeds=0))
    return compare(arm, seeds, [method for method in METHODS if method.name in ORDER])


def rows_of(comparison: Comparison, role: str) -> list[Row]:
    """Return the paper's methods with a role, in the paper's order."""
    rows = [comparison.row(name, role) or comparison.row(name, PAPER) for name in ORDER]
    return [row for row in rows if row is not None]


def steps_down(values: Sequence[float]) -> int:
    """Return how many values are below the one before."""
    return sum(after < before for before, after in pairwise(values))


def is_ranked(values: Sequence[float]) -> bool:
    """Return True if every value is below the one before."""
    return steps_down(values) == len(values) - 1


def in_words(rows: Sequence[Row], values: Sequence[float], factor: float, unit: str) -> str:
    """Return the methods with their values, largest first, and how often a loop was lost."""
    pairs = sorted(zip(values, rows, strict=True), key=lambda pair: -pair[0])
    order = " > ".join(f"{row.label} {factor * value:.3g}" for value, row in pairs)
    lost = [f"{row.label} lost in {1 - row.stable_share:.0%} of seeds" for row in rows if row.stable_share < 1.0]
    return "; ".join([f"{order} {unit}", *lost])


def draw_compared(simulations: Simulations, name: str) -> "Figure":
    """Draw a figure of the comparison."""
    return draw_comparison(compared(simulations))[name]


ROLES = ((PAPER, "tuned as in the paper"), (BEST, "each at its best"))  # roles of tunings, in words


KEPT = 0.1  # slope, over that without compensation, up to which the net energy counts as kept


def check_13(simulations: Simulations) -> tuple[Claim, ...]:
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


FIGURE_13 = Reproduction(
    figure="13",
    title="Net energy of a Panda guided by a hand, with five compensation methods",
    scenarios=(SCENARIO,),
    most_seeds=MOST_SEEDS,
    check=check_13,
    draw=partial(draw_compared, name="energy"),
)


def check_14(simulations: Simulations) -> tuple[Claim, ...]:
    """Check the order of the largest torques and what is left of Coulomb friction, with both kinds of tuning."""
    comparison = compared(simulations)
    return tuple(
        claim
        for role, words in ROLES
        for claim in (_peaks(comparison, role, words), _plateaus(comparison, role, words))
    )


def _peaks(comparison: Comparison, role: str, words: str) -> Claim:
    rows = rows_of(comparison, role)[:-1]
    peaks = [row.interval(lambda outcome: outcome.peak_torque_nm).value for row in rows]
    return Claim(
        figure="14",
        claim=f"the largest torque falls from none to model-based, disturbance observer, torque regulation; {words}",
        paper="none > model > DOB > torque regulation",
        ours=in_words(rows, peaks, 1.0, "N m"),
        value=float(steps_down(peaks)),
        holds=is_ranked(peaks),
        note="the largest torque is mostly inertia: what makes the motor lighter wins, what removes friction alone "
        "cannot",
    )


def _plateaus(comparison: Comparison, role: str, words: str) -> Claim:
    rows = rows_of(comparison, role)
    left = [abs(row.interval(lambda outcome: outcome.coulomb_left).value) for row in rows]
    return Claim(
        figure="14",
        claim=f"the proposed method leaves least of the plateaus of Coulomb friction; {words}",
        paper="significantly reduced, outperforms the others",
        ours=in_words(rows, left, 1.0, "of it left"),
        value=left[-1],
        holds=left[-1] == min(left) and rows[-1].stable_share == 1.0,
        note="an observer that knows the motor's inertia within 20 % leaves as little or less",
    )


FIGURE_14 = Reproduction(
    figure="14",
    title="Velocity and interaction torque of a joint of a Panda, with five compensation methods",
    scenarios=(SCENARIO,),
    most_seeds=MOST_SEEDS,
    check=check_14,
    draw=partial(draw_compared, name="velocity-torque"),
)
