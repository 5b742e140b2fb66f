"""Fig. 9: over the velocity, combined friction draws two plateaus; perfectly compensated, inertia leaves an ellipse."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.reporting.figures.paper import Course
from friction_audit.reproduce.course import make_course
from friction_audit.reproduce.reproduction import Claim, Reproduction, Simulations, relative
from friction_audit.simulation.settings import CONTROL_RATE_HZ
from friction_audit.simulation.simulation import Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NEAR_ZERO = 0.05
"""Share of the peak speed that counts as near zero."""
PLATEAU_BOUND = 0.02


def check(simulations: Simulations) -> tuple[Claim, ...]:
    """Check the plateaus, and what is left of them after compensation."""
    (raw,), (aided,) = simulations["fig9-friction"], simulations["fig9-compensated"]
    return (_plateaus(raw), *_ellipse(raw, aided))


def last_period(simulation: Simulation) -> Course:
    """Return the last period of the sinusoid, without what the start from rest leaves."""
    course = make_course(simulation, zero_crossings=True)
    kept = course.t >= course.t[-1] - simulation.truth.settings.operator.motion.period_s
    return Course(
        t=course.t[kept],
        dq=course.dq[kept],
        interaction_nm=course.interaction_nm[kept],
        energy_j=course.energy_j[kept],
        ends_s=course.ends_s,
        ends_j=course.ends_j,
        coulomb_nm=course.coulomb_nm[kept],
        viscous_nms_per_rad=course.viscous_nms_per_rad[kept],
        damping_nms_per_rad=course.damping_nms_per_rad[kept],
    )


def plateau_nm(course: Course) -> float:
    """Return half the distance of the plateaus at velocity zero: inertia has the same sign on both and cancels."""
    slow = np.abs(course.dq) < NEAR_ZERO * np.abs(course.dq).max()
    forth, back = slow & (course.dq > 0.0), slow & (course.dq < 0.0)
    return float(0.5 * (course.interaction_nm[forth].mean() - course.interaction_nm[back].mean()))


def _plateaus(raw: Simulation) -> Claim:
    joint, course = raw.truth.settings.joints[0], last_period(raw)
    slow = np.abs(course.dq[np.abs(course.dq) < NEAR_ZERO * np.abs(course.dq).max()])
    expected = joint.coulomb_nm + joint.viscous_nms_per_rad * float(slow.mean())
    plateau = plateau_nm(course)
    error = abs(plateau / expected - 1.0)
    return Claim(
        figure="9",
        claim="with combined friction, a pair of plateaus at plus and minus the Coulomb friction",
        paper="dashed line, no number",
        ours=f"+-{plateau:.4f} N m about velocity zero, {relative(error)} off (bound {relative(PLATEAU_BOUND)})",
        value=error,
        holds=error < PLATEAU_BOUND,
    )


def _ellipse(raw: Simulation, aided: Simulation) -> tuple[Claim, ...]:
    before, after = last_period(raw), last_period(aided)
    left = abs(plateau_nm(after)) / plateau_nm(before)
    roundness, bound = off_ellipse(after), one_tick_of_silence(aided)
    cost = float((after.energy_j[-1] - after.energy_j[0]) / (before.energy_j[-1] - before.energy_j[0]))
    return (
        Claim(
            figure="9",
            claim="perfectly compensated, no plateau is left",
            paper="solid line, no number",
            ours=f"{relative(left)} of it (bound {relative(PLATEAU_BOUND)}); "
            f"a period costs {relative(abs(cost))} of the energy",
            value=left,
            holds=left < PLATEAU_BOUND,
        ),
        Claim(
            figure="9",
            claim="and the curve is an ellipse",
            paper="elliptical profile",
            ours=f"within {relative(roundness)} of one with these half axes (bound {relative(bound)})",
            value=roundness,
            holds=roundness < bound,
            note="at each turn the joint rests for a tick, in which the sign of its velocity is zero and the "
            "compensator silent; the bound is what the hand's damper makes of that, b dt / (m + B)",
        ),
    )


def off_ellipse(course: Course) -> float:
    """Return the largest distance of the moving joint from the ellipse with the same half axes, over these."""
    direction = np.sign(course.dq)
    moving = (direction != 0.0) & (np.diff(direction, prepend=direction[0]) == 0.0)
    dq, torque = course.dq[moving], course.interaction_nm[moving]
    dq, torque = dq / np.abs(dq).max(), torque / np.abs(torque).max()
    return float(np.abs(np.hypot(dq, torque) - 1.0).max())


def one_tick_of_silence(simulation: Simulation) -> float:
    """Return the torque of a joint that lags by one tick of its acceleration, over that of its inertia.

    While the compensator is silent, friction holds the joint. It then moves slower than intended by a dt, to which the
    hand's damper b adds b a dt, of which the share B / (m + B) passes the sensor; the inertia's own torque is B a.
    """
    settings = simulation.truth.settings
    moved = settings.operator.inertia_kg_m2 + settings.joints[0].inertia_kg_m2
    return float(settings.operator.damping_nms_per_rad / CONTROL_RATE_HZ / moved)


def draw(simulations: Simulations) -> "Figure":
    """Draw both curves."""
    from friction_audit.reporting.figures.paper import draw_plateaus

    (raw,), (aided,) = simulations["fig9-friction"], simulations["fig9-compensated"]
    return draw_plateaus(last_period(raw), last_period(aided))


FIGURE_9 = Reproduction(
    figure="9",
    title="Interaction torque over velocity: combined friction, and the same perfectly compensated",
    scenarios=("fig9-friction", "fig9-compensated"),
    most_seeds=1,
    check=check,
    draw=draw,
)
