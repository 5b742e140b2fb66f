"""Figs 3, 6 and 7: viscous friction, its estimate, and the passivity controller."""

from typing import Any

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.reporting.figures import paper
from friction_audit.reporting.figures.paper import Course
from friction_audit.reproduce.reproduction import Claim, Simulations, make_course, within
from friction_audit.simulation.settings import CONTROL_RATE_HZ, Simulation

CLOSURE_BOUND = 1e-5
MINIMA_BOUND = 1e-4


def check_3(simulations: Simulations) -> tuple[Claim, ...]:
    """Check (3), that dissipation never falls, and what the minima of the net energy rise by."""
    course, kinetic, dissipated = energies(simulations)
    closure = float(np.abs(course.energy_j - kinetic - dissipated).max() / dissipated[-1])
    falls = float(np.diff(dissipated).min())
    rises, error = minima(course.energy_j, dissipated)
    return (
        within(
            "3", "net energy = kinetic + dissipated energy, at every sample", "(3), (6)",
            "differs by * of what was dissipated", closure, CLOSURE_BOUND,
            "the difference is that of the 1 ms sum (2) as trapezoids; the mechanics are finer",
        ),
        Claim(
            "3", "the dissipated energy never falls", "monotonically increasing", f"smallest step {falls:.1e} J",
            falls, falls >= 0.0,
        ),
        within(
            "3", "the minima of the net energy rise by what the cycle dissipated", "(7)",
            f"{rises} cycles, worst * off", error, MINIMA_BOUND,
        ),
    )  # fmt: skip


def energies(simulations: Simulations) -> tuple[Course, Float, Float]:
    """Return the course and its kinetic and dissipated energy, shape (n,) each. [J]"""
    (simulation,) = simulations["fig3"]
    truth = simulation.truth
    kinetic = 0.5 * truth.settings.joints[0].inertia_kg_m2 * truth.motion.dq[:, 0] ** 2
    return make_course(simulation, zero_crossings=True), kinetic, truth.motion.dissipated_j[:, 0]


def minima(energy: Float, dissipated: Float) -> tuple[int, float]:
    """Return how many minima rise over the one before, the start included, and the largest relative difference."""
    inner = energy[1:-1]
    places = np.append(0, np.flatnonzero((inner < energy[:-2]) & (inner <= energy[2:])) + 1)
    rise, lost = np.diff(energy[places]), np.diff(dissipated[places])
    return len(rise), float(np.abs(rise / lost - 1.0).max()) if len(rise) else np.inf


BOUND = 1e-3


def check_6(simulations: Simulations) -> tuple[Claim, ...]:
    """Check the estimates after the first and the fourth cycle, and the energy between."""
    (simulation,) = simulations["fig6"]
    course, settings = make_course(simulation), simulation.truth.settings
    before = settings.joints[0].viscous_nms_per_rad
    after = before * (1.0 + settings.hidden[0].friction_step.change)
    first, last = (abs(_applied(course, cycle) / truth - 1.0) for cycle, truth in ((1, before), (4, after)))
    ends = course.ends_j
    return (
        within(
            "6", "the estimate is right after the first cycle", "10 Ns/mm",
            f"{_applied(course, 1):.5f} N m s/rad, * off", first, BOUND,
        ),
        within(
            "6", "no net dissipation in cycles 2 and 3", "does not occur",
            "its energy differs by * from that of cycle 1", float(np.abs(ends[1:3] / ends[0] - 1.0).max()), BOUND,
        ),
        within(
            "6", "right again after the fourth cycle, friction having doubled at 6 s", "20 Ns/mm",
            f"{_applied(course, 4):.5f} N m s/rad, * off", last, BOUND,
            f"cycle 4 dissipates {(ends[3] - ends[2]) / ends[0]:.2f} times what cycle 1 did: half is compensated",
        ),
    )  # fmt: skip


def _applied(course: Course, cycle: int) -> float:
    """Return the coefficient applied after a cycle, counted from 1. [N m s/rad]"""
    return float(course.viscous_nms_per_rad[np.searchsorted(course.t, course.ends_s[cycle - 1])])


def draw_6(simulations: Simulations) -> Any:  # noqa: ANN401 - a figure of Matplotlib
    """Draw the estimate and the true coefficient."""
    (simulation,) = simulations["fig6"]
    settings, t = simulation.truth.settings, simulation.truth.motion.t
    step = settings.hidden[0].friction_step
    factor = np.where(t < step.at_share * settings.duration_s, 1.0, 1.0 + step.change)
    return paper.draw_adaptation(make_course(simulation), settings.joints[0].viscous_nms_per_rad * factor)


FOURTH = 4
RETURN_BOUND = 1e-2


def check_7(simulations: Simulations) -> tuple[Claim, ...]:
    """Check what over-compensation does without and with the passivity controller."""
    (bare,), (guarded,) = simulations["fig7-unprotected"], simulations["fig7"]
    alone, course = make_course(bare), make_course(guarded)
    fallen, lowest = float(alone.energy_j.min() / alone.ends_j[0]), float(course.energy_j.min())
    tolerance = tolerance_j(guarded)
    acting = course.t[course.damping_nms_per_rad > 0.0]
    cycles = np.unique(np.searchsorted(course.ends_s, acting, side="right") + 1)
    return (
        Claim(
            "7a", "over-compensated without passivity controller, the energy falls below zero", "E_m < 0",
            f"down to {fallen:.2f} of what cycle 1 dissipated", fallen, fallen < 0.0,
        ),
        Claim(
            "7b", "with it, the energy never falls below zero", "E_m >= 0",
            f"lowest {lowest:.1e} J (tolerance {-tolerance:.1e} J)", lowest, lowest >= -tolerance,
            "a deficit is seen a tick late and paid within the next: the tolerance is the largest power of a tick, "
            "over the share of the inertia that is the hand's, on which the controller can draw",
        ),
        Claim(
            "7b", "the controller acts in the fourth cycle, and in no other", "fourth cycle",
            f"acts in cycle {', '.join(map(str, cycles))}", float(cycles[0]) if len(cycles) else np.nan,
            list(cycles) == [FOURTH],
            "cycles 2 and 3 inject what cycle 1 dissipated, all but exactly: a softer hand, which moves farther "
            "when it is aided, uses the reserve up just before cycle 3 ends",
        ),
        *_returns(guarded),
    )  # fmt: skip


def tolerance_j(simulation: Simulation) -> float:
    """Return what the energy can fall below zero by although the controller acts. [J]"""
    settings, motion = simulation.truth.settings, simulation.truth.motion
    hand, joint = settings.operator.inertia_kg_m2, settings.joints[0].inertia_kg_m2
    power = np.abs(motion.interaction_nm * motion.dq).max()
    return float(power / CONTROL_RATE_HZ * (hand + joint) / hand)


def _returns(guarded: Simulation) -> tuple[Claim, ...]:
    course, truth = make_course(guarded), guarded.truth
    highest, after = float(course.damping_nms_per_rad.max()), _applied(course, FOURTH)
    cap = truth.settings.compensator.max_damping_nms_per_rad
    taken = float(truth.compensators["dissipated_j"][-1, 0] / course.ends_j[0])
    return (
        Claim(
            "7c", "the adaptive damping is finite and dissipates what was injected too much", "shown, no number",
            f"up to {highest:.1f} N m s/rad, dissipates {taken:.2f} of what cycle 1 dissipated", highest,
            0.0 < highest <= cap and taken > 0.0,
            f"(22) divides by the squared velocity: none below 0.01 rad/s, and never above {cap:g} N m s/rad",
        ),
        within(
            "7c", "then the coefficient returns to the true one, from the energy that the controller took",
            "20 Ns/mm, (25)", f"{after:.5f} N m s/rad, * off",
            abs(after / truth.settings.joints[0].viscous_nms_per_rad - 1.0), RETURN_BOUND,
        ),
    )  # fmt: skip
