"""Friction step: from a moment on, friction is another than before."""

import math
from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.simulation.effects.effect import Given, HiddenEffect, Setting, Values, must, number, strength

ABRUPT, RAMP, SETTLING = range(3)


@dataclass(frozen=True, kw_only=True, slots=True)
class FrictionStep(HiddenEffect):
    """A change of friction once in a recording."""

    summary = "friction changes once, at a moment of the recording"
    forms = ("abrupt", "ramp", "settling")

    change: float = strength(0.5, "change of Coulomb friction, as a share of it", lower=-0.95)
    viscous_ratio: float = number(1.0, "change of viscous friction, as a share of that", upper=1.0)
    at_share: float = number(0.5, "when, as a share of the recording", upper=1.0)
    length_s: float = number(5.0, "length of the ramp, time constant of settling", "s", lower=0.001)
    form: int = ABRUPT

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        coulomb, viscous, moment, length = values.values()
        joint = setting.joint
        must(coulomb != 0.0 and joint.coulomb_nm > 0.0, "its step is a share of the Coulomb friction")
        change = coulomb / joint.coulomb_nm
        by_viscous = viscous / joint.viscous_nms_per_rad if joint.viscous_nms_per_rad > 0.0 else 0.0
        given: Given = {"change": change, "viscous_ratio": by_viscous / change}
        if length == 0.0:
            return {**given, "at_share": moment / setting.duration_s, "form": "abrupt"}
        begin = (moment - 0.5 * length) / setting.duration_s
        return {**given, "at_share": begin, "length_s": length, "form": "ramp"}


@compiled()
def progress(group: Record, t: float, duration: float) -> float:
    """Return the share of the change that is done at time t: 0 before the step, 1 at its end."""
    since = t - group.at_share * duration
    if since < 0.0:
        return 0.0
    if group.form == RAMP:
        return float(min(1.0, since / group.length_s))
    if group.form == SETTLING:
        return float(-math.expm1(-since / group.length_s))
    return 1.0


@compiled()
def coulomb_factor(group: Record, t: float, duration: float) -> float:
    """Return the Coulomb friction over that before the step, above 0."""
    return float(1.0 + group.change * progress(group, t, duration))


@compiled()
def viscous_factor(group: Record, t: float, duration: float) -> float:
    """Return the viscous friction over that before the step, above 0."""
    return float(1.0 + group.change * group.viscous_ratio * progress(group, t, duration))
