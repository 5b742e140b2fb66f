"""Backlash: a gap between the measured side and the side of friction.

Where the torque changes sign the far side flies free, friction alone on it, until the measured side has crossed the
gap and strikes it on the other flank.
"""

from collections.abc import Iterator, Sequence
from math import sqrt

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.transmission import (
    MANY_SAMPLES,
    FarSide,
    Transmission,
    added_torques,
    far_side,
    flank_stiffness,
    part_of,
    simple_torque,
)
from friction_audit.effects.effect import Nonlinear, Trait
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.transmission import FAR_SHARE, MOTION_BELOW_HZ, Link, far_side_of, motions
from friction_audit.joint_log import Float

CONTACT_DAMPING_RATIO = 0.2  # of metal on lubricated metal: half of the speed is left after an impact
SPAN_SHARES = np.geomspace(3e-5, 0.02, 24)  # widths of the gap as shares of the span of the motion
# Flanks by frequency and damping. Noise of the position shifts impacts after a bounce: damped flanks suit those better.
SOFT, MIDDLE, RINGING, HARD = (
    {"contact_hz": hz, "flank_damping_ratio": damping}
    for hz, damping in ((18.0, 0.7), (25.0, 0.7), (30.0, 0.25), (50.0, 0.25))
)
# Of the inertia, on the far side: a rotor may move with the measured side.
FAR_SHARES = (0.8, 0.6)
# The coefficient is 1 but for the errors of a nominal model that was fitted without the gap.
LEAST_SHARE, LARGEST_SHARE = 0.4, 1.6


class Backlash(Link):
    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield columns for many values; all have one far side."""
        far, torque = far_side(motion), simple_torque(motion)
        usual = sqrt(torque @ torque / len(torque))
        yield from plays(motion, [far] * len(many), [usual] * len(many), many)

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """All widths on soft flanks, and on harder ones that a smooth motion strikes; some with less inertia.

        The projection finds frequency and damping in between.
        """
        widths = (SPAN_SHARES * (float(np.ptp(data.q)) or 1.0)).tolist()
        calm = {"motion_below_hz": MOTION_BELOW_HZ}
        kinds: tuple[dict[str, float], ...] = (SOFT, RINGING, MIDDLE | calm, HARD | calm)
        return (
            *({"gap_rad": width, **kind} for kind in kinds for width in widths),
            *({"gap_rad": width, **SOFT, "far_share": share} for share in FAR_SHARES for width in widths[::2]),
        )

    def regressors_of(
        self, data: JointData, nominals: Sequence[Nominal], grid: Sequence[Nonlinear]
    ) -> Iterator[tuple[int, Float]]:
        far = [far_side_of(nominal) for nominal in nominals]
        numbers = np.array([(own.inertia_kg_m2, own.coulomb_nm, own.viscous_nms_per_rad) for own in far])
        for motion, places in motions(data, grid):
            every = max(len(motion.t) // MANY_SAMPLES, 1)
            simple = np.stack([motion.ddq[::every], motion.direction[::every], motion.dq[::every]])
            usual = np.sqrt(np.mean((numbers[places] @ simple) ** 2, axis=1)).tolist()
            values = [self.values(grid[place]) for place in places]
            for k, column in plays(motion, [far[place] for place in places], usual, values):
                yield places[k], column

    def coefficient_of(self, at: Nonlinear) -> float:
        return 1.0

    def admissible(self, coefficients: Float, at: Nonlinear) -> bool:
        return bool(LEAST_SHARE <= coefficients[0] <= LARGEST_SHARE)


def plays(
    motion: Motion, far: Sequence[FarSide], usual_nm: Sequence[float], many: Sequence[Sequence[float]]
) -> Iterator[tuple[int, Float]]:
    """Yield columns for many values, each with its own far side and the usual torque of that."""
    flanks = [
        flank(part_of(own, values[-1]).inertia_kg_m2, usual, values)
        for own, usual, values in zip(far, usual_nm, many, strict=True)
    ]
    for place, added in added_torques(motion, far, flanks):
        yield place, added[:, None]


def flank(inertia_kg_m2: float, usual_nm: float, values: Sequence[float]) -> Transmission:
    """Return the transmission of a gap.

    Args:
        inertia_kg_m2: Inertia on the far side.
        usual_nm: Root mean square of the torque that it transmits.
        values: Nonlinear parameters, in order.
    """
    gap, contact_hz, damping_ratio, share = values
    return Transmission(
        stiffness_nm_per_rad=flank_stiffness(inertia_kg_m2, contact_hz, gap, usual_nm),
        damping_ratio=damping_ratio,
        gap_rad=gap,
        far_share=share,
    )


EFFECT = Backlash(
    name="backlash",
    label="free play at a reversal",
    family="structure",
    axis="displacement",
    coefficients=(
        Parameter("backlash_share", "1", "share of inertia and friction on the link side", lower=0.0, upper=1.5),
    ),
    nonlinear=(
        Parameter("gap_rad", "rad", "full width of the gap", lower=1e-7, upper=1.0),
        Parameter("contact_hz", "Hz", "frequency in contact", lower=1.0, upper=1e3),
        Parameter(
            "flank_damping_ratio",
            "1",
            "damping ratio in contact",
            lower=0.0,
            upper=2.0,
            optional=True,
            default=CONTACT_DAMPING_RATIO,
        ),
        FAR_SHARE,
    ),
    traits=Trait.NEEDS_NOMINAL,
    forward="gap",
    record="reverse slowly at least 20 times with hardly any load",
    separate={"contact_event": "reverse again at the same places: a gap opens at every reversal"},
)
