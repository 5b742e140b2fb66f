"""Fig. 11: interaction torque over velocity, combined friction compensated."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.reporting.figures.paper import Course
from friction_audit.reproduce.course import make_course
from friction_audit.reproduce.fig8 import peak_nm
from friction_audit.reproduce.fig10 import SECOND
from friction_audit.reproduce.reproduction import MANY, Claim, Reproduction, Simulations, share, spread

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PEAK_NM = 0.5
FAST = 0.3
"""Speed above which friction is sliding and all of the compensation acts. [rad/s]"""
REMAINS = 0.15
"""Share of the friction that may be left of an ellipse."""


def check(simulations: Simulations) -> tuple[Claim, ...]:
    """Check the peak torque and that little of friction is left in the curve."""
    before = [make_course(simulation) for simulation in simulations["fig8"]]
    after = [compensated(make_course(simulation)) for simulation in simulations["fig10"]]
    peaks = np.array([peak_nm(course) for course in after])
    left = np.array([abs(against_nm(a)) / against_nm(b) for a, b in zip(after, before, strict=True)])
    joint = simulations["fig10"][0].truth.settings.joints[0]
    return (
        Claim(
            figure="11",
            claim="the peak interaction torque falls to below 0.5 N m",
            paper="below 0.5 N m",
            ours=f"{spread(peaks, 'N m')}; below {PEAK_NM:g} N m in {share(peaks < PEAK_NM)}",
            value=float(peaks.max()),
            holds=bool((peaks < PEAK_NM).all()),
            note=f"low-passed at 10 Hz, from the end of cycle 2 on; {joint.coulomb_nm:g} N m of it break the joint "
            "away, which no compensator lowers that acts on the velocity",
        ),
        Claim(
            figure="11",
            claim="the curve is elliptical: what is left is inertia",
            paper="elliptical profile",
            ours=f"mean torque along the motion, of that without: {spread(left, '')}",
            value=float(left.max()),
            holds=bool((left < REMAINS).all()),
            note=f"above {FAST:g} rad/s; bound {REMAINS:g}; inertia has no part in it",
        ),
    )


def compensated(course: Course) -> Course:
    """Return the part from the end of the second cycle on."""
    kept = course.t >= course.ends_s[SECOND]
    later = course.ends_s > course.ends_s[SECOND]
    return Course(
        t=course.t[kept],
        dq=course.dq[kept],
        interaction_nm=course.interaction_nm[kept],
        energy_j=course.energy_j[kept],
        ends_s=course.ends_s[later],
        ends_j=course.ends_j[later],
        coulomb_nm=course.coulomb_nm[kept],
        viscous_nms_per_rad=course.viscous_nms_per_rad[kept],
        damping_nms_per_rad=course.damping_nms_per_rad[kept],
    )


def against_nm(course: Course) -> float:
    """Return the mean of F_m sgn(dq) where the joint slides: friction, as acceleration and braking cancel. [N m]"""
    fast = np.abs(course.dq) > FAST
    return float((course.interaction_nm[fast] * np.sign(course.dq[fast])).mean())


def draw(simulations: Simulations) -> "Figure":
    """Draw the curve from the end of the second cycle on."""
    from friction_audit.reporting.figures.paper import draw_compensated_loop

    without, with_ = make_course(simulations["fig8"][0]), compensated(make_course(simulations["fig10"][0]))
    return draw_compensated_loop(with_, without)


FIGURE_11 = Reproduction(
    figure="11",
    title="Interaction torque over velocity, combined friction compensated",
    scenarios=("fig8", "fig10"),
    most_seeds=MANY,
    check=check,
    draw=draw,
)
