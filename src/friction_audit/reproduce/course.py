"""The paper's comparison, made once for both of its figures."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.compensation.comparison import METHODS, SCENES, Comparison, compare
from friction_audit.compensation.comparison.methods import BEST, PAPER
from friction_audit.compensation.comparison.result import Row
from friction_audit.compensation.compensators import EnergyCompensator
from friction_audit.compensation.replay import run
from friction_audit.joint_log import Float
from friction_audit.reporting.figures.paper import Course
from friction_audit.reproduce.reproduction import Simulations
from friction_audit.simulation.settings import CONTROL_RATE_HZ
from friction_audit.simulation.simulation import Simulation

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
    from friction_audit.reporting.figures.comparison import draw_comparison

    return draw_comparison(compared(simulations))[name]


ROLES = ((PAPER, "tuned as in the paper"), (BEST, "each at its best"))
"""Roles of tunings, in words."""


SHOWN = ("energy_j", "cycle", "coulomb_nm", "viscous_nms_per_rad", "damping_nms_per_rad")


def make_course(simulation: Simulation, joint: int = 0, *, zero_crossings: bool = False) -> Course:
    """Return the course of a joint, counted from 0, as the log and the compensator in it know it.

    Args:
        simulation: Log and truth.
        joint: Column of the joint.
        zero_crossings: Where no compensator was in the loop: True if cycles end where the velocity changes its sign,
            False if they are found by the thresholds of the paper's section V.
    """
    log, torque = simulation.log, interaction_nm(simulation)[:, joint]
    traces = _known(simulation, joint) or _observed(log.t, log.dq[:, joint], torque, zero_crossings=zero_crossings)
    ends = np.flatnonzero(np.diff(traces["cycle"])) + 1
    return Course(
        t=log.t,
        dq=log.dq[:, joint],
        interaction_nm=torque,
        energy_j=traces["energy_j"],
        ends_s=log.t[ends],
        ends_j=traces["energy_j"][ends],
        coulomb_nm=traces["coulomb_nm"],
        viscous_nms_per_rad=traces["viscous_nms_per_rad"],
        damping_nms_per_rad=traces["damping_nms_per_rad"],
    )


def interaction_nm(simulation: Simulation) -> Float:
    """Return the interaction torque as logged, shape (n, j). [N m]"""
    log = simulation.log
    if log.tau_interaction is not None:
        return log.tau_interaction
    if log.gravity is None or log.tau_J is None:
        raise AssertionError("simulated logs hold the interaction torque, or the sensor's and gravity")
    return np.asarray(log.gravity - log.tau_J)


def _known(simulation: Simulation, joint: int) -> dict[str, Float]:
    """Return what the compensator in the loop knew at the stamps of the log; nothing if none was there."""
    compensators = simulation.truth.compensators
    if not compensators:
        return {}
    ticks = np.rint(simulation.log.t * CONTROL_RATE_HZ).astype(np.intp)
    return {name: compensators[name][ticks, joint] for name in SHOWN}


def _observed(t: Float, dq: Float, torque: Float, *, zero_crossings: bool) -> dict[str, Float]:
    """Return what a compensator that does nothing would have seen: energy and cycles."""
    observer = EnergyCompensator(zero_crossings=zero_crossings, passivity=False, factor=0.0)
    traces = run(observer, t, dq, torque)
    nothing = np.zeros_like(t)
    idle = dict.fromkeys(("coulomb_nm", "viscous_nms_per_rad", "damping_nms_per_rad"), nothing)
    return {"energy_j": traces["energy_j"], "cycle": traces["cycle"], **idle}
