"""What it takes to reproduce a figure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from friction_audit.reproduce.claim import Claim
from friction_audit.simulate.simulation import Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Simulations = Mapping[str, tuple[Simulation, ...]]
"""By name of the scenario, one simulation per seed."""

MANY = 1000
"""As many seeds as are asked for."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Reproduction:
    """A figure of the paper.

    Attributes:
        figure: Its number.
        title: What it shows.
        scenarios: Names of the scenarios that it needs.
        most_seeds: Most seeds that make sense: 1 where nothing is drawn at random, few where a simulation takes long.
        check: Simulations -> claims.
        draw: Simulations -> figure, of the first seed.
    """

    figure: str
    title: str
    scenarios: tuple[str, ...]
    most_seeds: int
    check: Callable[[Simulations], tuple[Claim, ...]]
    draw: "Callable[[Simulations], Figure]"
