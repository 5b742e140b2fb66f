"""The paper's comparison, made once for both of its figures."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING

from friction_audit.compare import METHODS, SCENES, Comparison, compare
from friction_audit.compare.draw import draw
from friction_audit.compare.method import BEST, PAPER
from friction_audit.compare.result import Row
from friction_audit.reproduce.reproduction import Simulations

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ORDER = ("none", "sigmoid", "disturbance_observer", "torque_regulation", "energy")
"""The paper's methods, from the steepest to the flattest net energy."""

SCENARIO = "fig13"

MOST_SEEDS = 5
"""Of an arm with all its methods and their sweeps; ``compare --arm panda`` takes more."""

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
    return draw(compared(simulations))[name]


ROLES = ((PAPER, "tuned as in the paper"), (BEST, "each at its best"))
"""Roles of tunings, in words."""
