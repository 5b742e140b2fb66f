"""Joint elasticity: a spring between the measured side and the side of friction.

The regressor is built for one stiffness and given per compliance: what the spring adds to the torque grows with the
compliance as long as the joint rings faster than it is moved, and no longer does where it rings with the motion.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.transmission import HIGHEST_HZ, FarSide, Transmission, added_torques, far_side
from friction_audit.effects.effect import Nonlinear, Trait
from friction_audit.effects.joint_data import CORNER_HZ, JointData, Nominal, grid_noise
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.transmission import FAR_SHARE, MOTION_BELOW_HZ, Link, far_side_of, motions
from friction_audit.joint_log import Float

# Strain-wave gears damp little: a few hundredths (T. D. Tuttle, W. P. Seering, IEEE Trans. Robot. Autom. 12, 1996).
DAMPING_RATIO = 0.05
# Frequencies of the ringing; a tenth apart where it is visible, for a resonance is a tenth wide.
RINGING_HZ = np.append(np.geomspace(2.0, 40.0, 30), np.geomspace(50.0, HIGHEST_HZ, 4))
SOFTEST_NM_PER_RAD, STIFFEST_NM_PER_RAD = 10.0, 1e5
USUAL_INERTIA_KG_M2 = 0.3  # of an arm's drive, where the torque shows none
# Torque up to which a strain-wave gear stiffens, as a share of the usual torque; far above it, it is a linear spring.
SOFT_SHARES = (1.0, 4.0)
LARGEST_SHARE = 1.6
LEAST_SHARE = 0.5  # compliance found times the stiffness it was built for
# Damped so much, the far side does not ring up on noise of the position.
MUCH_DAMPED = 0.15
# Of the inertia, on the far side: a rotor may move with the measured side.
FAR_SHARES = (0.8, 0.6)


class JointElasticity(Link):
    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield columns, per compliance, for many values; all have one far side."""
        yield from springs(motion, [far_side(motion)] * len(many), many)

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """Springs that ring below the corner of the regression, or twist by more than the noise of the position."""
        stiffest = _stiffest_seen(data)
        return tuple(at for at in all_springs(data) if at["spring_nm_per_rad"] <= stiffest)

    def regressors_of(
        self, data: JointData, nominals: Sequence[Nominal], grid: Sequence[Nonlinear]
    ) -> Iterator[tuple[int, Float]]:
        for motion, places in motions(data, grid):
            values = [self.values(grid[place]) for place in places]
            for k, column in springs(motion, [far_side_of(nominals[place]) for place in places], values):
                yield places[k], column

    def coefficient_of(self, at: Nonlinear) -> float:
        return 1.0 / at["spring_nm_per_rad"]

    def admissible(self, coefficients: Float, at: Nonlinear) -> bool:
        return bool(LEAST_SHARE < coefficients[0] * at["spring_nm_per_rad"] <= LARGEST_SHARE)


def all_springs(data: JointData) -> tuple[Nonlinear, ...]:
    """Linear springs, and of every second stiffness springs that are soft at first; the projection finds those between.

    Springs that ring where hardly more than noise moves the measured side are tried with a smooth motion too, those
    that ring below the corner with more damping and with less inertia on the far side.
    """
    usual, every = float(np.sqrt(np.mean(data.torque**2))) or 1.0, _stiffnesses(data)
    fast, slow = every[every > _ringing_at(data, MOTION_BELOW_HZ)], every[every < _ringing_at(data, CORNER_HZ)]
    smooth = {"motion_below_hz": MOTION_BELOW_HZ}
    soft = [{"soft_nm": share * usual} for share in SOFT_SHARES]
    tries: tuple[tuple[Float, dict[str, float]], ...] = (
        (every, {"damping_ratio": DAMPING_RATIO}),
        *((every[::2], one | {"damping_ratio": DAMPING_RATIO}) for one in soft),
        (fast, smooth | {"damping_ratio": DAMPING_RATIO}),
        *((fast[::2], one | smooth) for one in soft),
        (slow[::2], {"damping_ratio": MUCH_DAMPED}),
        *((slow[::2], {"far_share": share, "damping_ratio": MUCH_DAMPED}) for share in FAR_SHARES),
    )
    return tuple({"spring_nm_per_rad": float(stiffness), **other} for tried, other in tries for stiffness in tried)


def _stiffest_seen(data: JointData) -> float:
    """Stiffness above which a spring neither rings below the regression's corner nor twists visibly at a reversal.

    Friction's jump, twice the Coulomb friction, must twist it by more than twice the noise of the position. [N m/rad]
    """
    noise = max(grid_noise(data.q, differences=4), np.finfo(float).tiny)
    return max(float(_ringing_at(data, CORNER_HZ)), far_side(data.motion(data.torque)).coulomb_nm / noise)


def _stiffnesses(data: JointData) -> Float:
    """The stiffest, and falling those on which the far side rings at all frequencies. [N m/rad]"""
    ringing = _ringing_at(data, RINGING_HZ)
    between = ringing[(ringing > SOFTEST_NM_PER_RAD) & (ringing < STIFFEST_NM_PER_RAD)]
    return np.append(STIFFEST_NM_PER_RAD, between[::-1])


def _ringing_at(data: JointData, frequency_hz: Float | float) -> Float:
    """Stiffness of a spring on which the inertia in the torque rings at a frequency. [N m/rad]"""
    inertia = far_side(data.motion(data.torque)).inertia_kg_m2 or USUAL_INERTIA_KG_M2
    return np.asarray(inertia * (2.0 * np.pi * np.asarray(frequency_hz)) ** 2)


def springs(motion: Motion, far: Sequence[FarSide], many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
    """Yield what springs add to the torque per compliance, each with its own far side, shape (n, 1)."""
    links = [
        Transmission(stiffness_nm_per_rad=stiffness, damping_ratio=damping_ratio, soft_nm=soft, far_share=share)
        for stiffness, soft, damping_ratio, share in many
    ]
    for place, added in added_torques(motion, far, links):
        yield place, np.multiply(added, many[place][0], out=added)[:, None]


EFFECT = JointElasticity(
    name="joint_elasticity",
    label="a spring between motor and link",
    family="structure",
    axis="acceleration",
    coefficients=(Parameter("compliance_rad_per_nm", "rad/(N m)", "twist per torque", lower=0.0, upper=1.0),),
    nonlinear=(
        Parameter("spring_nm_per_rad", "N m/rad", "stiffness of the assumed resonance", lower=1.0, upper=1e6),
        Parameter(
            "soft_nm",
            "N m",
            "torque up to which the gear stiffens, from half the stiffness at zero",
            lower=0.0,
            upper=1e3,
            optional=True,
        ),
        Parameter(
            "damping_ratio",
            "1",
            "damping ratio of the ringing, the measured side held",
            lower=0.0,
            upper=2.0,
            optional=True,
            default=DAMPING_RATIO,
        ),
        FAR_SHARE,
    ),
    traits=Trait.NEEDS_NOMINAL,
    forward="spring",
    record="repeat the motions at two or more clearly different speeds",
    separate={
        "backlash": "reverse slowly with hardly any load: a gap gives no torque at all, a spring does",
        "inertia_error": "repeat the motions slowly and fast: what a spring adds grows with frequency",
    },
)
