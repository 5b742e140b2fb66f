"""Claims of the paper, the simulations that they are checked on, and the results."""

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from friction_audit.compensation.controller import run
from friction_audit.compensation.law import EnergyCompensator
from friction_audit.joint_log import Bool, Float
from friction_audit.reporting.figures.paper import Course
from friction_audit.simulation import simulate
from friction_audit.simulation.bench import Progress
from friction_audit.simulation.scenarios import PAPER_SCENARIOS
from friction_audit.simulation.settings import CONTROL_RATE_HZ, Simulation


@dataclass(frozen=True, slots=True)
class Claim:
    """A claim of the paper as a number."""

    figure: str  # figure of the paper
    claim: str  # the claim in a sentence
    paper: str  # what the paper says or shows, in its units
    ours: str  # our result, in words and with its unit
    value: float  # the number that is compared with the bound
    holds: bool  # whether it holds
    note: str = ""  # a remark for the reader
    own: bool = False  # whether it is an experiment of this project, not of the paper


def spread(values: Float, unit: str) -> str:
    """Return median and worst value in words; of one seed its value."""
    worst = f"{np.max(values):.3f} {unit}".rstrip()
    return worst if len(values) == 1 else f"median {np.median(values):.3f}, worst {worst}"


def share(holds: Bool) -> str:
    """Return in words the number of seeds for which something holds."""
    return f"{int(holds.sum())} of {len(holds)} seeds"


SMALLEST_PERCENT = 0.001  # below this, digits have no meaning


def relative(share: float) -> str:
    """Return the size of a share as a percentage with two digits: 1.2e-4 -> ``0.012 %``."""
    percent = 100.0 * abs(share)
    if percent < SMALLEST_PERCENT:
        return f"less than {SMALLEST_PERCENT:g} %"
    return f"{float(f'{percent:.2g}'):.6f}".rstrip("0").rstrip(".") + " %"


# Texts of the claims by name.
TEXTS = tomllib.loads(Path(__file__).with_name("claims.toml").read_text(encoding="utf-8"))


def claim(name: str, value: float, holds: object, *, own: bool = False, **numbers: object) -> Claim:
    """Return a claim by its name in the table, with its value, and numbers for its texts."""
    words: dict[str, Any] = {field: text.format(**numbers) for field, text in TEXTS[name].items()}
    return Claim(**words, value=float(value), holds=bool(holds), own=own)


def within(name: str, error: float, bound: float, **numbers: Any) -> Claim:  # noqa: ANN401 - for texts
    """Return a claim that holds where an error is below a bound, both shares."""
    found = claim(name, error, error < bound, error=relative(error), **numbers)
    return replace(found, ours=f"{found.ours} (bound {relative(bound)})")


Simulations = Mapping[str, Any]  # by name of the scenario, one simulation per seed; "fig13": the comparison


class Reproduction(NamedTuple):
    """A figure of the paper."""

    figure: str  # its number
    title: str  # what it shows
    scenarios: tuple[str, ...]  # names of its scenarios
    check: Callable[[Simulations], tuple[Claim, ...]]  # simulations -> claims
    draw: Callable[[Simulations], Any]  # simulations -> figure, of the first seed
    most_seeds: int = 1  # largest useful number of seeds: 1 without randomness, few where a simulation takes long
    # seeds -> the comparison that it shows in place of simulations, or None
    compare: Callable[[int, Progress | None], Any] | None = None


def simulate_figure(
    figure: Reproduction, seeds: int, progress: Progress | None = None, known: Simulations | None = None
) -> Simulations:
    """Simulate the scenarios of a figure for the seeds 0, 1, ...; add them to the known simulations."""
    done, seeds = dict[str, Any](known or {}), min(seeds, figure.most_seeds)
    missing = set(figure.scenarios) - done.keys()
    if figure.compare is not None:
        return done | {name: figure.compare(seeds, progress) for name in missing}
    todo = [(scenario, seed) for scenario in PAPER_SCENARIOS if scenario.name in missing for seed in range(seeds)]
    for row, (scenario, seed) in enumerate(todo):
        if progress is not None:
            progress(row / len(todo))
        done[scenario.name] = (*done.get(scenario.name, ()), simulate(scenario.settings, seed))
    return done


APPLIED = ("coulomb_nm", "viscous_nms_per_rad", "damping_nms_per_rad")


def make_course(simulation: Simulation, joint: int = 0, *, zero_crossings: bool = False) -> Course:
    """Return the course of a joint (0-based): signals of the log, and states of its compensator.

    Without a compensator in the loop, cycles end at ``zero_crossings`` of the velocity, or by the paper's thresholds.
    """
    log: Any = simulation.log
    interaction = log.gravity - log.tau_J if log.tau_interaction is None else log.tau_interaction
    dq, torque = log.dq[:, joint], interaction[:, joint]
    if simulation.truth.compensators:  # states of the compensator in the loop at the stamps of the log
        ticks = np.rint(log.t * CONTROL_RATE_HZ).astype(np.intp)
        known = simulation.truth.compensators
        traces: Any = {name: known[name][ticks, joint] for name in ("cycle", "energy_j", *APPLIED)}
    else:  # energy and cycles of a compensator without torque
        traces = run(EnergyCompensator(zero_crossings=zero_crossings, passivity=False, factor=0.0), log.t, dq, torque)
    ends = np.flatnonzero(np.diff(traces["cycle"])) + 1
    own = {name: traces[name] for name in ("energy_j", *APPLIED)}
    return Course(t=log.t, dq=dq, interaction_nm=torque, ends_s=log.t[ends], ends_j=own["energy_j"][ends], **own)
