"""Fig. 8: one joint moved by a person, without compensation."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.reporting.figures.panels import smooth
from friction_audit.reporting.figures.paper import Course
from friction_audit.reproduce.course import make_course
from friction_audit.reproduce.reproduction import MANY, Claim, Reproduction, Simulations, each, share, spread

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PEAK_NM = (1.3, 1.7)
"""What still is approximately 1.5 N m."""


def check(simulations: Simulations) -> tuple[Claim, ...]:
    """Check that every cycle takes energy, and the peak torque."""
    courses = [make_course(simulation) for simulation in simulations["fig8"]]
    rises = np.array([np.diff(course.ends_j, prepend=0.0).min() for course in courses])
    factors = np.array([course.ends_j[-1] / course.ends_j[1] for course in courses])
    peaks = each(simulations["fig8"], lambda simulation: peak_nm(make_course(simulation)))
    near = (peaks > PEAK_NM[0]) & (peaks < PEAK_NM[1])
    return (
        Claim(
            figure="8b",
            claim="without compensation the net energy oscillates but increases",
            paper="shown, no number",
            ours=f"every cycle adds to it in {share(rises > 0.0)}; "
            f"at the end {np.median(factors):.1f} times that of cycle 2",
            value=float(rises.min()),
            holds=bool((rises > 0.0).all()),
        ),
        Claim(
            figure="8c",
            claim="the peak interaction torque is approximately 1.5 N m",
            paper="approximately 1.5 N m",
            ours=f"{spread(peaks, 'N m')}; 1.3 to 1.7 N m in {share(near)}",
            value=float(np.median(peaks)),
            holds=bool(near.all()),
            note="friction and person are chosen for it, see fig8; of the torque low-passed at 10 Hz",
        ),
    )


def peak_nm(course: Course, *, from_s: float = 0.0) -> float:
    """Return the largest interaction torque from a time on, low-passed as it is drawn. [N m]"""
    filtered = smooth(course.t, course.interaction_nm)
    return float(np.abs(filtered[course.t >= from_s]).max())


def draw(simulations: Simulations) -> "Figure":
    """Draw velocity and torque, the net energy, and the torque over the velocity."""
    from friction_audit.reporting.figures.paper import draw_uncompensated

    return draw_uncompensated(make_course(simulations["fig8"][0]))


FIGURE_8 = Reproduction(
    figure="8",
    title="One joint moved by a person, without compensation",
    scenarios=("fig8",),
    most_seeds=MANY,
    check=check,
    draw=draw,
)
