"""What the paper says, and what we got."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.compensators import EnergyCompensator
from friction_audit.compensation.controller import run
from friction_audit.joint_log import Float
from friction_audit.reporting.figures.paper import Course
from friction_audit.simulation import simulate
from friction_audit.simulation.scenarios import PAPER_SCENARIOS
from friction_audit.simulation.settings import CONTROL_RATE_HZ
from friction_audit.simulation.simulation import Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True, slots=True)
class Claim:
    """A claim of the paper as a number."""

    figure: str  # figure of the paper
    claim: str  # the claim in a sentence
    paper: str  # what the paper says or shows, in its units
    ours: str  # what we got, in words and with its unit
    value: float  # the number that decides
    holds: bool  # whether it holds
    note: str = ""  # what a reader should know about it, or nothing
    own: bool = False  # whether it is an experiment of this project that the paper does not make


def spread(values: Float, unit: str, *, worst: Callable[[Float], float] = np.max) -> str:
    """Return median and worst in words; of one seed only that."""
    if len(values) == 1:
        return f"{values[0]:.3f} {unit}".rstrip()
    return f"median {np.median(values):.3f}, worst {worst(values):.3f} {unit}".rstrip()


def share(holds: "NDArray[np.bool_]") -> str:
    """Return in how many seeds something holds, in words."""
    return f"{int(holds.sum())} of {len(holds)} seeds"


Simulations = Mapping[str, Any]  # by name of the scenario, one simulation per seed; "fig13": the comparison
MANY = 1000  # as many seeds as are asked for


@dataclass(frozen=True, kw_only=True, slots=True)
class Reproduction:
    """A figure of the paper."""

    figure: str  # its number
    title: str  # what it shows
    scenarios: tuple[str, ...]  # names of the scenarios that it needs
    check: Callable[[Simulations], tuple[Claim, ...]]  # simulations -> claims
    draw: "Callable[[Simulations], Figure]"  # simulations -> figure, of the first seed
    # most seeds that make sense: 1 where nothing is drawn at random, few where a simulation takes long
    most_seeds: int = 1
    # seeds -> the comparison that it shows in place of simulations, kept by its first scenario; or None
    compare: "Callable[[int, Progress | None], Any] | None" = None


SMALLEST_PERCENT = 0.001  # below this, digits have no meaning


def relative(share: float) -> str:
    """Return the size of a share as a percentage with two digits: 1.2e-4 -> ``0.012 %``."""
    percent = 100.0 * abs(share)
    if percent < SMALLEST_PERCENT:
        return f"less than {SMALLEST_PERCENT:g} %"
    return f"{float(f'{percent:.2g}'):.6f}".rstrip("0").rstrip(".") + " %"


Progress = Callable[[float], None]  # receives the share that is done, 0 to 1


def simulate_figures(
    reproductions: Sequence[Reproduction],
    seeds: int,
    progress: Progress | None = None,
    known: Simulations | None = None,
) -> Simulations:
    """Simulate what the figures need.

    The persons' seeds are 0, 1, 2 and so on; scenarios that are known already are returned too.
    """
    done: dict[str, Any] = dict(known or {})
    for one in reproductions:
        if one.compare is not None and one.scenarios[0] not in done:
            done[one.scenarios[0]] = one.compare(min(seeds, one.most_seeds), progress)
    most = {name: min(seeds, each.most_seeds) for each in reproductions for name in each.scenarios}
    wanted = [scenario for scenario in PAPER_SCENARIOS if scenario.name in most.keys() - done.keys()]
    todo = [(scenario, seed) for scenario in wanted for seed in range(most[scenario.name])]
    effort = [len(scenario.settings.joints) ** 2 * scenario.settings.duration_s for scenario, _ in todo]
    for row, (scenario, seed) in enumerate(todo):
        if progress is not None:
            progress(sum(effort[:row]) / sum(effort))
        done[scenario.name] = (*done.get(scenario.name, ()), simulate(scenario.settings, seed))
    return done


APPLIED = ("coulomb_nm", "viscous_nms_per_rad", "damping_nms_per_rad")
SHOWN = ("energy_j", "cycle", *APPLIED)


def make_course(simulation: Simulation, joint: int = 0, *, zero_crossings: bool = False) -> Course:
    """Return the course of a joint, counted from 0, as the log and the compensator in it know it.

    Where no compensator was in the loop, cycles end where the velocity changes its sign (``zero_crossings``), or are
    found by the thresholds of the paper's section V.
    """
    log, torque = simulation.log, interaction_nm(simulation)[:, joint]
    if simulation.truth.compensators:  # what the compensator in the loop knew at the stamps of the log
        ticks = np.rint(log.t * CONTROL_RATE_HZ).astype(np.intp)
        traces = {name: simulation.truth.compensators[name][ticks, joint] for name in SHOWN}
    else:  # what a compensator that does nothing would have seen: energy and cycles
        observer = EnergyCompensator(zero_crossings=zero_crossings, passivity=False, factor=0.0)
        seen = run(observer, log.t, log.dq[:, joint], torque)
        traces = {name: seen[name] for name in SHOWN} | dict.fromkeys(APPLIED, np.zeros_like(log.t))
    ends = np.flatnonzero(np.diff(traces["cycle"])) + 1
    return Course(
        t=log.t,
        dq=log.dq[:, joint],
        interaction_nm=torque,
        energy_j=traces["energy_j"],
        ends_s=log.t[ends],
        ends_j=traces["energy_j"][ends],
        **{name: traces[name] for name in APPLIED},
    )


def interaction_nm(simulation: Simulation) -> Float:
    """Return the interaction torque as logged, shape (n, j). [N m]"""
    log = simulation.log
    if log.tau_interaction is not None:
        return log.tau_interaction
    if log.gravity is None or log.tau_J is None:
        raise AssertionError("simulated logs hold the interaction torque, or the sensor's and gravity")
    return np.asarray(log.gravity - log.tau_J)
