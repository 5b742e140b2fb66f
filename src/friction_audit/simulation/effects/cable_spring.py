"""Cable spring: a cable or hose along the arm pulls the joint back."""

from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.simulation.effects.effect import ALIKE, Given, HiddenEffect, Setting, Values, must, number, strength

LINEAR, HARDENING, SLACK, TETHER = range(4)

# Distance from the centre at which the hardening form is twice as strong as the linear one. [rad]
HARDENING_RAD = 1.0


@dataclass(frozen=True, kw_only=True, slots=True)
class CableSpring(HiddenEffect):
    """A spring from the arm to the joint, behind the sensor."""

    summary = "a cable or hose pulls the joint back"
    forms = ("linear", "hardening", "slack", "tether")

    stiffness_nm_per_rad: float = strength(0.4, "stiffness where it pulls", "N m/rad", upper=2000.0)
    centre_rad: float = number(0.0, "position where it does not pull", like="cable_centre_rad")
    free_rad: float = number(0.3, "free play of a slack cable or a tether", like="cable_free_rad")
    form: int = LINEAR

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        stiffness, hardening, preload, centre, free = values.values()
        must(abs(hardening) <= ALIKE * stiffness, "its cable that gets stiffer does so by a number of its own")
        must(preload == 0.0 or (free == 0.0 and stiffness > 0.0), "its cable hangs loose where it does not pull")
        if free > 0.0:
            place: Given = {"centre_rad": centre - setting.start_rad, "free_rad": free}
            return {"stiffness_nm_per_rad": stiffness, **place, "form": "slack"}
        middle = centre - (preload / stiffness if preload else 0.0) - setting.start_rad
        return {"stiffness_nm_per_rad": stiffness, "centre_rad": middle, "form": "linear"}


@compiled()
def torque_nm(group: Record, q: float) -> float:
    """Return the torque towards the centre, on the motor's side of the sensor. [N m]

    Conservative in every form. A slack cable pulls beyond its free play on both sides, a tether on the upper side only.
    """
    stretch = q - group.centre_rad
    if group.form == HARDENING:
        stretch *= 1.0 + (stretch / HARDENING_RAD) ** 2
    elif group.form == SLACK:
        stretch -= min(max(stretch, -group.free_rad), group.free_rad)
    elif group.form == TETHER:
        stretch = max(0.0, stretch - group.free_rad)
    return float(-group.stiffness_nm_per_rad * stretch)
