"""Figures -> simulations, each scenario once."""

from collections.abc import Callable, Sequence

from friction_audit.reproduce.reproduction import Reproduction, Simulations
from friction_audit.simulation import Scenario, Simulation, simulate
from friction_audit.simulation.scenarios import PAPER_SCENARIOS

Progress = Callable[[float], None]
"""Told the share that is done, 0 to 1."""


def simulate_figures(
    reproductions: Sequence[Reproduction], seeds: int, progress: Progress | None = None
) -> Simulations:
    """Simulate what the figures need.

    Args:
        reproductions: The figures.
        seeds: Number of persons where one moves the joint; their seeds are 0, 1, 2 and so on.
        progress: Told how far it is.
    """
    wanted = _count(reproductions, seeds)
    todo = [(scenario, seed) for scenario, count in wanted for seed in range(count)]
    effort = [len(scenario.settings.joints) ** 2 * scenario.settings.duration_s for scenario, _ in todo]
    done: dict[str, tuple[Simulation, ...]] = {}
    for row, (scenario, seed) in enumerate(todo):
        if progress is not None:
            progress(sum(effort[:row]) / sum(effort))
        done[scenario.name] = (*done.get(scenario.name, ()), simulate(scenario.settings, seed))
    return done


def _count(reproductions: Sequence[Reproduction], seeds: int) -> list[tuple[Scenario, int]]:
    """Return the scenarios that are needed, each with its number of seeds."""
    most = {name: min(seeds, each.most_seeds) for each in reproductions for name in each.scenarios}
    return [(scenario, most[scenario.name]) for scenario in PAPER_SCENARIOS if scenario.name in most]
