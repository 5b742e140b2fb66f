"""Unlogged compensation: a friction compensator was active, and the log does not say so."""

import math
from dataclasses import dataclass
from typing import Any

from friction_audit.compiled import compiled
from friction_audit.simulation.effects.effect import Effect, Parameter

SMOOTH, DEAD_BAND, SIGMOID = range(3)

SKEW = 0.2


@dataclass(frozen=True, kw_only=True, slots=True)
class UnloggedCompensation:
    """A torque of the motor that helps the motion.

    Attributes:
        share: Of the friction below that is compensated.
        coulomb_nm: Coulomb friction that the compensator believes in. [N m]
        viscous_nms_per_rad: Viscous coefficient that it believes in; the sigmoid form has none. [N m s/rad]
        width_rad_s: Speed up to which it holds back. [rad/s]
        form: Index into the forms of the effect.
    """

    share: float = 0.0
    coulomb_nm: float = 0.2
    viscous_nms_per_rad: float = 0.05
    width_rad_s: float = 0.05
    form: int = SMOOTH


@compiled()
def torque_nm(group: Any, velocity: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the torque that helps the motion, of the sign of the velocity. [N m]

    Not passive by its nature: it feeds the joint, and above the joint's own friction it drives it.
    """
    if group.form == SIGMOID:
        return float(group.share * sigmoid_nm(group, velocity))
    if group.form == DEAD_BAND:
        if abs(velocity) <= group.width_rad_s:
            return 0.0
        coulomb = math.copysign(group.coulomb_nm, velocity)
    else:
        coulomb = group.coulomb_nm * math.tanh(velocity / group.width_rad_s)
    return float(group.share * (coulomb + group.viscous_nms_per_rad * velocity))


@compiled()
def sigmoid_nm(group: Any, velocity: float) -> float:  # noqa: ANN401 - a record of numbers
    """Return the friction of a Panda joint after Gaz et al. (2019): a sigmoid shifted through the origin. [N m]

    phi1 is twice the Coulomb friction, phi2 one over the width; phi2 phi3 is that of the published joint 1, so that the
    two plateaus differ by a fifth. A logistic function is written as tanh, which does not overflow.
    """
    shifted = math.tanh(0.5 * (velocity / group.width_rad_s + SKEW))
    return float(group.coulomb_nm * (shifted - math.tanh(0.5 * SKEW)))


EFFECT = Effect(
    name="unlogged_compensation",
    family="slow and events",
    summary="a friction compensator was active that the log does not contain",
    group=UnloggedCompensation,
    strength="share",
    parameters=(
        Parameter(name="share", usual=0.7, meaning="share of the friction compensated", high=1.2),
        Parameter(name="coulomb_nm", usual=0.2, meaning="Coulomb friction it believes in [N m]"),
        Parameter(name="viscous_nms_per_rad", usual=0.05, meaning="viscous coefficient it believes in [N m s/rad]"),
        Parameter(name="width_rad_s", usual=0.05, meaning="speed up to which it holds back [rad/s]", low=1e-4),
    ),
    forms=("smooth", "dead_band", "sigmoid"),
)
