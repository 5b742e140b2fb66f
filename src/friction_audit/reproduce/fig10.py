"""Fig. 10: one joint moved by a person, combined friction compensated from two cycles."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.reporting.figures.paper import Course
from friction_audit.reproduce.course import make_course
from friction_audit.reproduce.reproduction import MANY, Claim, Reproduction, Simulations, each, share, spread

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BAND = 0.25
"""Share of E_cyclic^2 that the net energy may leave it by at the later ends of cycles."""
SECOND = 1
"""Row of the second cycle."""


def check(simulations: Simulations) -> tuple[Claim, ...]:
    """Check that the energy rises for two cycles and then stays, also without a limit on how alike cycles may be."""
    courses = [make_course(simulation) for simulation in simulations["fig10"]]
    rises = np.array([np.diff(course.ends_j[: SECOND + 1], prepend=0.0).min() for course in courses])
    guarded = each(simulations["fig10"], lambda simulation: leaves_by(make_course(simulation)))
    printed = each(simulations["fig10-unguarded"], lambda simulation: leaves_by(make_course(simulation)))
    last_s = np.median([course.ends_s[-1] - course.ends_s[SECOND] for course in courses])
    return (
        Claim(
            figure="10b",
            claim="the net energy rises within the first two cycles",
            paper="initial two cycles",
            ours=f"in {share(rises > 0.0)}",
            value=float(rises.min()),
            holds=bool((rises > 0.0).all()),
        ),
        _band("thereafter it stays in the vicinity of E_cyclic^2", guarded, "", last_s),
        _band(
            "the same where every pair of cycles gives an estimate, however alike they are",
            printed,
            "(20) as printed divides by the difference of two cycles: two of the same speed determine nothing, and the "
            "estimate is that of the noise. Above a condition number of 200 the coefficients before are scaled",
            last_s,
        ),
    )


def leaves_by(course: Course) -> float:
    """Return how far the energy at later ends of cycles is from that of the second, over that."""
    second = course.ends_j[SECOND]
    return float(np.abs(course.ends_j[SECOND + 1 :] / second - 1.0).max())


def _band(claim: str, leaves: Float, note: str, last_s: float) -> Claim:
    inside = leaves < BAND
    return Claim(
        figure="10b",
        claim=claim,
        paper="vicinity of E_cyclic^2, no number",
        ours=f"within {BAND:.0%} over {last_s:.0f} s in {share(inside)}: {spread(leaves, 'of it')}",
        value=float(leaves.max()),
        holds=bool(inside.all()),
        note=note,
    )


def draw(simulations: Simulations) -> "Figure":
    """Draw velocity and torque, the net energy and the coefficients."""
    from friction_audit.reporting.figures.paper import draw_compensated

    return draw_compensated(make_course(simulations["fig10"][0]))


FIGURE_10 = Reproduction(
    figure="10",
    title="One joint moved by a person, combined friction compensated from two cycles",
    scenarios=("fig10", "fig10-unguarded"),
    most_seeds=MANY,
    check=check,
    draw=draw,
)
