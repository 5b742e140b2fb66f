"""Unlogged compensation: a friction compensator was active, and the log does not say so."""

import math
from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.simulation.effects.effect import Given, HiddenEffect, Setting, Values, must, number, strength

SMOOTH, DEAD_BAND, SIGMOID = range(3)

SKEW = 0.2


@dataclass(frozen=True, kw_only=True, slots=True)
class UnloggedCompensation(HiddenEffect):
    """A torque of the motor that helps the motion."""

    summary = "a friction compensator was active that the log does not contain"
    forms = ("smooth", "dead_band", "sigmoid")

    share: float = strength(0.7, "share of the friction compensated", upper=1.2)
    coulomb_nm: float = number(0.2, "Coulomb friction it believes in", "N m")
    viscous_nms_per_rad: float = number(0.05, "viscous coefficient it believes in", "N m s/rad")
    width_rad_s: float = number(0.05, "speed up to which it holds back", like="unlogged_width_rad_s")
    form: int = SMOOTH

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        torque, width, skew, form = values.values()
        must(skew == 0.0, "its sigmoid has one shift")
        friction: Given = {"share": 1.0, "coulomb_nm": torque, "viscous_nms_per_rad": 0.0, "width_rad_s": width}
        return {**friction, "form": "dead_band" if round(form) else "smooth"}


@compiled()
def torque_nm(group: Record, velocity: float) -> float:
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
def sigmoid_nm(group: Record, velocity: float) -> float:
    """Return the friction of a Panda joint after Gaz et al. (2019): a sigmoid shifted through the origin. [N m]

    phi1 is twice the Coulomb friction, phi2 one over the width; phi2 phi3 is that of the published joint 1, so that the
    two plateaus differ by a fifth. A logistic function is written as tanh, which does not overflow.
    """
    shifted = math.tanh(0.5 * (velocity / group.width_rad_s + SKEW))
    return float(group.coulomb_nm * (shifted - math.tanh(0.5 * SKEW)))
