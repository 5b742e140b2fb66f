"""Elasticity: a spring between what is measured and what rubs."""

from collections.abc import Iterator, Sequence
from math import sqrt

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, values_of
from friction_audit.dynamics.transmission import HIGHEST_HZ, FarSide, far_side
from friction_audit.effects.excitation import reversals
from friction_audit.effects.joint_data import JointData, Nominal, grid_noise
from friction_audit.effects.terms.joint_elasticity import DAMPING_RATIO, TERM, springs
from friction_audit.effects.transmission import MOTION_BELOW_HZ, far_side_of, motions, no_inertia
from friction_audit.joint_log import Float

RINGING_HZ = np.append(np.geomspace(2.0, 40.0, 60), np.geomspace(50.0, HIGHEST_HZ, 5))
"""From a spring that a hand feels to one that nobody sees. Where ringing is seen a twentieth apart: it is a tenth wide,
twice its damping ratio."""
SOFTEST_NM_PER_RAD, STIFFEST_NM_PER_RAD = 10.0, 1e5
"""A rubber band, a steel shaft."""
USUAL_INERTIA_KG_M2 = 0.3
"""Of an arm's drive, where the torque tells none."""
SOFT_SHARES = (1.0, 2.5, 6.0)
"""Torque up to which a strain-wave gear stiffens as a share of the usual torque. One that stiffens hardly at all under
the torque there is would be a linear one again, and told half as soft as it is."""
SOUGHT_TIMES = 1.8
"""A spring that is fitted together with what is behind it is so many times softer or stiffer at most."""
SOUGHT_SOFT = 0.1, 10.0
"""Least and largest torque up to which it stiffens, as shares of the usual one."""
SOUGHT_DAMPINGS = (0.01, 0.5)
LARGEST_SHARE = 1.6
LEAST_SHARE = 0.5
"""Compliance found times the stiffness it was built for."""
MUCH_DAMPED = 0.1
"""Damping ratio of a far side that forgets noise of the position before it rings up on it. Undamped, it multiplies that
noise at its resonance by ten, and the ringing of friction's jumps drowns in it."""
FAR_SHARES = (0.8, 0.6)
"""Of the inertia that is behind the spring, where a rotor before it moves with the measured side, and its torque is
measured too."""
HIGHER = 2.0
"""How much higher a spring rings than its far side alone would on it, at most: its other end may be light."""
RINGING_SEEN_HZ = 25.0
"""Highest corner of the rows. A spring that rings faster shows by what it twists alone, which noise of the position
must leave to be seen."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """Springs whose ringing the rows can see, or whose twist stands out of the noise of the position."""
    stiffest = _stiffest_seen(data)
    return tuple(shape for shape in all_springs(data) if shape["spring_nm_per_rad"] <= stiffest)


def all_springs(data: JointData) -> tuple[Shape, ...]:
    """Linear springs of all stiffnesses, and of every second one springs that are soft at first.

    Those that ring where hardly more than noise moves the measured side are tried with a smooth motion too, more
    coarsely: it does not ring. Linear ones that ring where rows see it are tried with more damping too, and with less
    inertia behind them, more coarsely.
    """
    usual = _usual(data)
    every = _stiffnesses(data)
    fast, slow = every[every > _ringing_at(data, MOTION_BELOW_HZ)], every[every < _ringing_at(data, RINGING_SEEN_HZ)]
    smooth = {"motion_below_hz": MOTION_BELOW_HZ}
    soft = [{"soft_nm": share * usual} for share in SOFT_SHARES]
    tries: tuple[tuple[Float, dict[str, float]], ...] = (
        (every, {}),
        *((every[::2], one) for one in soft),
        (fast[::2], smooth),
        *((fast[::4], one | smooth) for one in soft),
        (slow[::4], {"damping_ratio": MUCH_DAMPED}),
        *(
            (slow[::2], {"far_share": share, "damping_ratio": damping})
            for share in FAR_SHARES
            for damping in (DAMPING_RATIO, MUCH_DAMPED)
        ),
    )
    return tuple({"spring_nm_per_rad": float(stiffness), **other} for tried, other in tries for stiffness in tried)


def _stiffest_seen(data: JointData) -> float:
    """Stiffness above which a spring neither rings below the rows' corner nor twists visibly at a reversal.

    Friction's jump, twice the Coulomb friction, must twist it by more than twice the noise of the position. [N m/rad]
    """
    noise = max(grid_noise(data.q, differences=4), np.finfo(float).tiny)
    return max(float(_ringing_at(data, RINGING_SEEN_HZ)), far_side(data.motion(data.torque)).coulomb_nm / noise)


def columns(data: JointData, baseline: Nominal, shape: Shape) -> Float:
    """What the spring adds to the torque per compliance, along the motion as measured or below a frequency."""
    ((_, column),) = together(data, baseline, (shape,))
    return column


def together(data: JointData, baseline: Nominal, shapes: Sequence[Shape]) -> Iterator[tuple[int, Float]]:
    """The same for many springs."""
    for place, added in twisted(data, [far_side_of(baseline)] * len(shapes), shapes):
        yield place, np.multiply(added, shapes[place]["spring_nm_per_rad"], out=added)


def twisted(data: JointData, far: Sequence[FarSide], shapes: Sequence[Shape]) -> Iterator[tuple[int, Float]]:
    """What many springs add to the torque, each with what is behind it."""
    for motion, places in motions(data, shapes):
        values = [values_of(TERM, shapes[place]) for place in places]
        for k, added in springs(motion, [far[place] for place in places], values):
            yield places[k], added[:, None]


def sought(data: JointData, shape: Shape) -> dict[str, tuple[float, float]]:
    """From where to where a spring is looked for together with what is behind it."""
    stiffness, usual = shape["spring_nm_per_rad"], _usual(data)
    least, most = SOUGHT_SOFT
    ranges = {
        "spring_nm_per_rad": (stiffness / SOUGHT_TIMES, stiffness * SOUGHT_TIMES),
        "damping_ratio": SOUGHT_DAMPINGS,
    }
    return ranges | ({"soft_nm": (least * usual, most * usual)} if "soft_nm" in shape else {})


def straight(shape: Shape) -> tuple[Shape, ...]:
    """The spring that is as stiff as one that is soft at first gets halfway."""
    if "soft_nm" not in shape:
        return ()
    others = {name: value for name, value in shape.items() if name != "soft_nm"}
    return ({**others, "spring_nm_per_rad": shape["spring_nm_per_rad"] / sqrt(2.0)},)


def _usual(data: JointData) -> float:
    return float(np.sqrt(np.mean(data.torque**2))) or 1.0


def _stiffnesses(data: JointData) -> Float:
    """The stiffest, and falling those on which the far side rings at all frequencies. [N m/rad]"""
    ringing = _ringing_at(data, RINGING_HZ)
    between = ringing[(ringing > SOFTEST_NM_PER_RAD) & (ringing < STIFFEST_NM_PER_RAD)]
    return np.append(STIFFEST_NM_PER_RAD, between[::-1])


def _ringing_at(data: JointData, frequency_hz: Float | float) -> Float:
    """Stiffness of a spring on which the inertia that the torque tells rings at a frequency. [N m/rad]"""
    inertia = far_side(data.motion(data.torque)).inertia_kg_m2 or USUAL_INERTIA_KG_M2
    return np.asarray(inertia * (2.0 * np.pi * np.asarray(frequency_hz)) ** 2)


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking: jumps of friction show it, at equally fast strokes too."""
    return reversals(data, baseline) or no_inertia(baseline)


def told_too_stiff(shape: Shape) -> dict[str, tuple[float, float]]:
    """How far off a spring along a smooth motion may be: its other end is held there, and rings along in truth.

    A spring between two ends rings higher than one whose other end is held, so that it is told stiffer than it is.
    """
    softer = {"spring_nm_per_rad": (HIGHER**-2, 1.0), "compliance_rad_per_nm": (1.0, HIGHER**2)}
    return softer if "motion_below_hz" in shape else {}


def admissible(factors: Float, shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(LEAST_SHARE < factors[0] * shape["spring_nm_per_rad"] <= LARGEST_SHARE)


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
    loose=told_too_stiff,
    noisy="spring_nm_per_rad",
    along_noise=("damping_ratio",),
    assumed=("damping_ratio", "far_share"),
    behind=twisted,
    sought=sought,
    plainer=straight,
)
