"""A spring and a gap between motor and link: what they add to the torque, the motion of the measured side given.

Both have a far side, which carries friction and most of the inertia, and are followed by the same integrator.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields
from math import sqrt
from typing import Any, ClassVar

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.transmission import (
    HIGHEST_HZ,
    MANY_SAMPLES,
    FrictionSide,
    Transmission,
    added_torques,
    contact_stiffness,
    fit_friction_side,
    simple_torque,
)
from friction_audit.effects.effect import LARGEST_SHARE, Each, Effect, Nonlinear, Points
from friction_audit.effects.joint_data import CORNER_HZ, JointData, Nominal, grid_noise, reversals, shares_of_span
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Caution

# Above, the noise of the position is amplified ten times and more; what people and motors mean to do is below 4 Hz.
MOTION_BELOW_HZ = 18.0
# Of the inertia, on the far side: a rotor may move with the measured side.
FAR_SHARES = (0.8, 0.6)

RATIO: dict[str, Any] = {"lower": 0.0, "upper": 2.0, "optional": True}  # bounds of a damping ratio
MEANING = "part of the inertia on the link side, the rest on the measured side"
FAR_SHARE = Parameter("far_share", "1", MEANING, lower=0.0, upper=1.0, optional=True, default=1.0)

LinkPoint = tuple[FrictionSide, float, Sequence[float]]  # far side, usual torque [N m], nonlinear parameters


class Link(Effect):
    """A spring or a gap: those of many parameters are followed side by side."""

    screened = 2
    needs_nominal = follows = transmits = True
    # Share of the coefficient that it follows from above which it is possible.
    least: ClassVar[float]

    def link(self, far: FrictionSide, usual_nm: float, values: Sequence[float]) -> Transmission:
        """Return the link of some values to a far side that usually takes so much torque (RMS)."""
        raise NotImplementedError

    def possible(self, coefficients: Float, at: Points) -> Each:
        share = coefficients[0] / self.coefficient_of(at)
        return (self.least < share) & (share <= LARGEST_SHARE)

    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield columns for many values; all have one far side."""
        torque, far = simple_torque(motion), fit_friction_side(motion)
        points = [(far, sqrt(torque @ torque / len(torque)), values) for values in many]
        for places, rows in self._follow(motion, points, np.transpose):
            yield from zip(places, rows[..., None], strict=True)

    def regressors_of(
        self, data: JointData, nominals: Sequence[Nominal], grid: Sequence[Nonlinear], seen: Callable[[Float], Float]
    ) -> Iterator[tuple[Sequence[int], Float]]:
        """Yield what the link adds to the torque, along the motion as measured or below a frequency."""
        # Negative inertia or friction of the nominal model counts as none.
        names = [one.name for one in fields(FrictionSide)]
        numbers = np.maximum([[getattr(one, name) for name in names] for one in nominals], 0.0)
        # Points with ``motion_below_hz`` go along the motion below that frequency, all others as measured.
        for below_hz in dict.fromkeys(at.get("motion_below_hz") for at in grid):
            own = [place for place, at in enumerate(grid) if at.get("motion_below_hz") == below_hz]
            motion = data.motion() if below_hz is None else data.motion_below(below_hz)
            every = max(len(motion.t) // MANY_SAMPLES, 1)
            simple = np.stack([motion.ddq[::every], motion.direction[::every], motion.dq[::every]])
            usual = np.sqrt(np.mean((numbers[own] @ simple) ** 2, axis=1)).tolist()
            far = [FrictionSide(**dict(zip(names, one, strict=True))) for one in numbers[own].tolist()]
            points = [*zip(far, usual, (self.values(grid[place]) for place in own), strict=True)]
            for places, rows in self._follow(motion, points, seen):
                yield [own[k] for k in places], rows

    def _follow(
        self, motion: Motion, points: Sequence[LinkPoint], seen: Callable[[Float], Float]
    ) -> Iterator[tuple[Sequence[int], Float]]:
        for places, added in added_torques(motion, [far for far, *_ in points], [self.link(*one) for one in points]):
            rows = seen(added.T)
            if self.forward == "spring":  # torque per compliance
                rows = rows * np.array([[points[place][-1][0]] for place in places])
            yield places, rows

    @staticmethod
    def requires(data: JointData, nominal: Nominal) -> Caution | None:
        """Jumps of friction, which show a link, and an inertia that rings."""
        return reversals(data, nominal) or (None if nominal.inertia_kg_m2 > 0.0 else Caution("no_inertia"))


# Strain-wave gears damp little: a few hundredths (T. D. Tuttle, W. P. Seering, IEEE Trans. Robot. Autom. 12, 1996).
DAMPING_RATIO = 0.05
# Frequencies of the ringing; a tenth apart where it is visible, for a resonance is a tenth wide.
RINGING_HZ = np.append(np.geomspace(2.0, 40.0, 30), np.geomspace(50.0, HIGHEST_HZ, 4))
SOFTEST_NM_PER_RAD, STIFFEST_NM_PER_RAD = 10.0, 1e5
USUAL_INERTIA_KG_M2 = 0.3  # of an arm's drive, where the torque shows none
# Torque up to which a strain-wave gear stiffens, as a share of the usual torque; far above it, it is a linear spring.
SOFT_SHARES = (1.0, 4.0)
# Damped so much, the far side does not ring up on noise of the position.
MUCH_DAMPED = 0.15


class JointElasticity(Link):
    """A spring between the measured side and the side of friction.

    The regressor is built for one stiffness and given per compliance: what the spring adds to the torque grows with the
    compliance as long as the joint rings faster than it is moved, and no longer does where it rings with the motion.
    """

    label = "a spring between motor and link"
    axis = "acceleration"
    coefficients = (Parameter("compliance_rad_per_nm", "rad/(N m)", "twist per torque", lower=0.0, upper=1.0),)
    nonlinear = (
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
            "damping_ratio", "1", "damping ratio of the ringing, the measured side held", default=DAMPING_RATIO, **RATIO
        ),
        FAR_SHARE,
    )
    forward = "spring"
    record = "repeat the motions at two or more clearly different speeds"
    separate = {
        "backlash": "reverse slowly with hardly any load: a gap gives no torque at all, a spring does",
        "inertia_error": "repeat the motions slowly and fast: what a spring adds grows with frequency",
    }
    least = 0.5

    def link(self, far: FrictionSide, usual_nm: float, values: Sequence[float]) -> Transmission:
        stiffness, soft_nm, damping_ratio, share = values
        return Transmission(
            stiffness_nm_per_rad=stiffness, soft_nm=soft_nm, damping_ratio=damping_ratio, far_share=share
        )

    def tries(self, data: JointData) -> list[Nonlinear]:
        """Return springs that ring below the regression's corner, or twist by more than the noise of the position."""
        far, usual = fit_friction_side(data.motion(data.torque)), float(np.sqrt(np.mean(data.torque**2))) or 1.0
        # Stiffnesses on which the inertia in the torque rings at all frequencies, from the stiffest. [N m/rad]
        inertia, hz = far.inertia_kg_m2 or USUAL_INERTIA_KG_M2, np.array([MOTION_BELOW_HZ, CORNER_HZ, *RINGING_HZ])
        smooth_at, corner, *_ = ringing = inertia * (2.0 * np.pi * hz) ** 2
        between = ringing[2:][(ringing[2:] > SOFTEST_NM_PER_RAD) & (ringing[2:] < STIFFEST_NM_PER_RAD)]
        every = np.append(STIFFEST_NM_PER_RAD, between[::-1])
        # Friction's jump, twice the Coulomb friction, must twist it by more than twice the noise of the position.
        stiffest = max(corner, far.coulomb_nm / max(grid_noise(data.q, differences=4), 1e-300))
        # Every second stiffness is tried for springs that are soft at first; the projection finds those between. Those
        # that ring where hardly more than noise moves the measured side are tried with a smooth motion too, those that
        # ring below the corner with more damping and with less inertia on the far side.
        fast, slow, smooth = every[every > smooth_at], every[every < corner], {"motion_below_hz": MOTION_BELOW_HZ}
        soft = [{"soft_nm": share * usual} for share in SOFT_SHARES]
        tries: tuple[tuple[Float, dict[str, float]], ...] = (
            (every, {"damping_ratio": DAMPING_RATIO}),
            *((every[::2], one | {"damping_ratio": DAMPING_RATIO}) for one in soft),
            (fast, smooth | {"damping_ratio": DAMPING_RATIO}),
            *((fast[::2], one | smooth) for one in soft),
            (slow[::2], {"damping_ratio": MUCH_DAMPED}),
            *((slow[::2], {"far_share": share, "damping_ratio": MUCH_DAMPED}) for share in FAR_SHARES),
        )
        seen = ((stiffness, other) for tried, other in tries for stiffness in tried.tolist() if stiffness <= stiffest)
        return [{"spring_nm_per_rad": stiffness, **other} for stiffness, other in seen]

    def coefficient_of(self, at: Points) -> Each:
        return 1.0 / at["spring_nm_per_rad"]


CONTACT_DAMPING_RATIO = 0.2  # of metal on lubricated metal: half of the speed is left after an impact
SPAN_SHARES = np.geomspace(3e-5, 0.02, 24)  # widths of the gap as shares of the span of the motion
# Flanks by frequency and damping. Noise of the position shifts impacts after a bounce: damped flanks suit those better.
SOFT, MIDDLE, RINGING, HARD = (
    {"contact_hz": hz, "flank_damping_ratio": damping}
    for hz, damping in ((18.0, 0.7), (25.0, 0.7), (30.0, 0.25), (50.0, 0.25))
)


class Backlash(Link):
    """A gap between the measured side and the side of friction.

    Where the torque changes sign the far side flies free, friction alone on it, until the measured side has crossed the
    gap and strikes it on the other flank.
    """

    label = "free play at a reversal"
    axis = "displacement"
    coefficients = (
        Parameter("backlash_share", "1", "share of inertia and friction on the link side", lower=0.0, upper=1.5),
    )
    nonlinear = (
        Parameter("gap_rad", "rad", "full width of the gap", lower=1e-7, upper=1.0),
        Parameter("contact_hz", "Hz", "frequency in contact", lower=1.0, upper=1e3),
        Parameter("flank_damping_ratio", "1", "damping ratio in contact", default=CONTACT_DAMPING_RATIO, **RATIO),
        FAR_SHARE,
    )
    forward = "gap"
    record = "reverse slowly at least 20 times with hardly any load"
    separate = {"contact_event": "reverse again at the same places: a gap opens at every reversal"}
    least = 0.4

    def link(self, far: FrictionSide, usual_nm: float, values: Sequence[float]) -> Transmission:
        gap, contact_hz, damping_ratio, share = values
        return Transmission(
            stiffness_nm_per_rad=contact_stiffness(share * far.inertia_kg_m2, contact_hz, gap, usual_nm),
            damping_ratio=damping_ratio,
            gap_rad=gap,
            far_share=share,
        )

    def tries(self, data: JointData) -> list[Nonlinear]:
        """Return all widths on soft flanks, and on harder ones that a smooth motion strikes; some with less inertia."""
        widths = shares_of_span(data, SPAN_SHARES)
        calm = {"motion_below_hz": MOTION_BELOW_HZ}
        kinds: tuple[dict[str, float], ...] = (SOFT, RINGING, MIDDLE | calm, HARD | calm)
        return [
            *({"gap_rad": width, **kind} for kind in kinds for width in widths),
            *({"gap_rad": width, **SOFT, "far_share": share} for share in FAR_SHARES for width in widths[::2]),
        ]
