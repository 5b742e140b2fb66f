"""Fig. 3: the net energy is kinetic energy and what friction dissipated."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.reporting.figures.paper import Course
from friction_audit.reproduce.course import make_course
from friction_audit.reproduce.reproduction import Claim, Reproduction, Simulations, relative

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CLOSURE_BOUND = 1e-5
MINIMA_BOUND = 1e-4


def check(simulations: Simulations) -> tuple[Claim, ...]:
    """Check (3), that dissipation never falls, and what the minima of the net energy rise by."""
    course, kinetic, dissipated = _energies(simulations)
    closure = float(np.abs(course.energy_j - kinetic - dissipated).max() / dissipated[-1])
    falls = float(np.diff(dissipated).min())
    rises, error = minima(course.energy_j, dissipated)
    return (
        Claim(
            figure="3",
            claim="net energy = kinetic + dissipated energy, at every sample",
            paper="(3), (6)",
            ours=f"differs by {relative(closure)} of what was dissipated (bound {relative(CLOSURE_BOUND)})",
            value=closure,
            holds=closure < CLOSURE_BOUND,
            note="the difference is that of the 1 ms sum (2) as trapezoids; the mechanics are finer",
        ),
        Claim(
            figure="3",
            claim="the dissipated energy never falls",
            paper="monotonically increasing",
            ours=f"smallest step {falls:.1e} J",
            value=falls,
            holds=falls >= 0.0,
        ),
        Claim(
            figure="3",
            claim="the minima of the net energy rise by what the cycle dissipated",
            paper="(7)",
            ours=f"{rises} cycles, worst {relative(error)} off (bound {relative(MINIMA_BOUND)})",
            value=error,
            holds=rises > 0 and error < MINIMA_BOUND,
        ),
    )


def _energies(simulations: Simulations) -> tuple[Course, Float, Float]:
    """Return the course and its kinetic and dissipated energy, shape (n,) each. [J]"""
    (simulation,) = simulations["fig3"]
    truth = simulation.truth
    inertia = truth.settings.joints[0].inertia_kg_m2
    kinetic = 0.5 * inertia * truth.motion.dq[:, 0] ** 2
    return make_course(simulation, zero_crossings=True), kinetic, truth.motion.dissipated_j[:, 0]


def minima(energy: Float, dissipated: Float) -> tuple[int, float]:
    """Return how many minima rise over the one before, the start included, and the largest relative difference."""
    inner = energy[1:-1]
    minima = np.flatnonzero((inner < energy[:-2]) & (inner <= energy[2:])) + 1
    places = np.concatenate([[0], minima])
    rise, lost = np.diff(energy[places]), np.diff(dissipated[places])
    return len(rise), float(np.abs(rise / lost - 1.0).max()) if len(rise) else np.inf


def draw(simulations: Simulations) -> "Figure":
    """Draw the three energies."""
    from friction_audit.reporting.figures.paper import draw_exchange

    return draw_exchange(*_energies(simulations))


FIGURE_3 = Reproduction(
    figure="3",
    title="Net energy, kinetic and dissipated energy of a joint with viscous friction",
    scenarios=("fig3",),
    most_seeds=1,
    check=check,
    draw=draw,
)
