"""Elasticity: a spring between what is measured and what rubs."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import reversals
from friction_audit.discrepancy.candidates.inertia_behind import inertia_behind
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.mean_sign import mean_sign
from friction_audit.joint_log import Float
from friction_audit.model.term import Motion
from friction_audit.model.terms.joint_elasticity import TERM
from friction_audit.model.transmission import HIGHEST_HZ, far_side

RINGING_HZ = np.append(np.geomspace(2.0, 40.0, 60), np.geomspace(50.0, HIGHEST_HZ, 5))
"""From a spring that a hand feels to one that nobody sees. Where ringing is seen a twentieth apart: it is a tenth wide,
twice its damping ratio."""
SOFTEST_NM_PER_RAD, STIFFEST_NM_PER_RAD = 10.0, 1e5
"""A rubber band, a steel shaft."""
USUAL_INERTIA_KG_M2 = 0.3
"""Of an arm's drive, where the torque tells none."""
MOTION_BELOW_HZ = 18.0
"""A spring that rings faster amplifies the noise of the position, ten times and more, and what people and motors mean
to do is below 4 Hz; unless the measured side rings with the far one, it is better taken as smooth."""
FILTER_S = 0.2
"""Reach of the low-pass to either side."""
SOFT_SHARES = (1e-3, 0.3, 1.0)
"""Torque up to which a strain-wave gear is soft, as a share of the usual torque; the first is a linear spring. One that
is soft for all the torque there is would be a linear one again, and told half as soft as it is."""
LARGEST_SHARE = 1.6
FEWEST_REVERSALS = 20
LEAST_SHARE = 0.5
"""Compliance found times the stiffness it was built for; a stiffer spring than the stiffest looks just like it."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """Linear springs of all stiffnesses, and of every fourth one springs that are soft at first.

    Those that ring where hardly more than noise moves the measured side are tried with a smooth motion too, more
    coarsely: it does not ring.
    """
    usual = float(np.sqrt(np.mean(data.torque**2))) or 1.0
    every, fast = _stiffnesses(data, 0.0), _stiffnesses(data, MOTION_BELOW_HZ)
    tries: tuple[tuple[Float, dict[str, float]], ...] = (
        (every, {}),
        (fast[::2], {"motion_below_hz": MOTION_BELOW_HZ}),
    )
    return tuple(
        {"spring_nm_per_rad": float(stiffness), "soft_nm": share * usual, **motion}
        for tried, motion in tries
        for k, share in enumerate(SOFT_SHARES)
        for stiffness in tried[:: 4 if k else 1]
    )


def columns(data: JointData, baseline: Baseline, shape: Shape) -> Float:
    """What the spring adds to the torque per compliance, along the motion as measured or below a frequency."""
    ((_, column),) = together(data, baseline, (shape,))
    return column


def together(data: JointData, baseline: Baseline, shapes: Sequence[Shape]) -> Iterator[tuple[int, Float]]:
    """The same for many springs, all along one motion or smooth ones."""
    places: dict[float | None, list[int]] = {}
    for place, shape in enumerate(shapes):
        places.setdefault(shape.get("motion_below_hz"), []).append(place)
    for below_hz, alike in places.items():
        values = [tuple(shapes[place][parameter.name] for parameter in TERM.shape) for place in alike]
        for k, column in TERM.regressors(_motion(data, baseline, below_hz), values):
            yield alike[k], column


def _motion(data: JointData, baseline: Baseline, below_hz: float | None) -> Motion:
    if below_hz is None:
        return data.motion(baseline.torque)
    if below_hz not in data.smooth:
        data.smooth[below_hz] = _smooth(data, below_hz)
    motion = data.smooth[below_hz]
    rest = baseline.inertia_kg_m2 * motion.ddq + baseline.coulomb_nm * motion.direction
    return replace(motion, rest=rest + baseline.viscous_nms_per_rad * motion.dq)


def _smooth(data: JointData, below_hz: float) -> Motion:
    q, dq, ddq = (_low_passed(signal, below_hz, data.step_s) for signal in (data.q, data.dq, data.ddq))
    return replace(data.motion(), q=q, dq=dq, ddq=ddq, way=mean_sign(data.t, dq, ddq))


def _low_passed(signal: Float, below_hz: float, step_s: float) -> Float:
    """A signal filtered symmetrically, its ends held; half of the amplitude passes at the frequency."""
    from scipy.signal import firwin, oaconvolve

    half = round(FILTER_S / step_s)
    kernel = firwin(2 * half + 1, below_hz, fs=1.0 / step_s)
    return np.asarray(oaconvolve(np.pad(signal, half, mode="edge"), kernel, "valid"))


def _stiffnesses(data: JointData, above_hz: float) -> Float:
    """The stiffest, and falling those on which the inertia that the torque tells rings above a frequency. [N m/rad]"""
    inertia = far_side(data.motion(data.torque)).inertia_kg_m2 or USUAL_INERTIA_KG_M2
    ringing = inertia * (2.0 * np.pi * RINGING_HZ[above_hz < RINGING_HZ]) ** 2
    between = ringing[(ringing > SOFTEST_NM_PER_RAD) & (ringing < STIFFEST_NM_PER_RAD)]
    return np.append(STIFFEST_NM_PER_RAD, between[::-1])


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking: jumps of friction show it, at equally fast strokes too."""
    return reversals(data, baseline, FEWEST_REVERSALS) or inertia_behind(baseline)


def admissible(factors: Float, shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    share = factors[0] * shape["spring_nm_per_rad"]
    least = 0.0 if shape["spring_nm_per_rad"] >= STIFFEST_NM_PER_RAD else LEAST_SHARE
    return bool(least < share <= LARGEST_SHARE)


CANDIDATE = Candidate(
    name="joint_elasticity",
    label="a spring between motor and link",
    shapes=shapes,
    columns=columns,
    together=together,
    column_units=("rad_per_nm",),
    untestable=untestable,
    admissible=admissible,
    axis="acceleration",
    term=TERM,
    leans_on_model=True,
)
