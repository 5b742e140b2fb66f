"""Load-dependent friction: the gear rubs harder the more torque it transmits."""

from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.simulation.effects.effect import Given, HiddenEffect, Setting, Values, alike, must, strength

LINEAR, QUADRATIC, BACKDRIVE = range(3)

REFERENCE_NM = 10.0  # load at which the quadratic form equals the linear one. [N m]

# Share by which the loss exceeds its mean when the link drives the motor, and falls short of it otherwise.
BACKDRIVE_EXCESS = 0.5


@dataclass(frozen=True, kw_only=True, slots=True)
class LoadDependentFriction(HiddenEffect):
    """Friction that grows with the transmitted torque."""

    summary = "friction grows with the torque that the gear transmits"
    forms = ("linear", "quadratic", "backdrive")

    share: float = strength(0.06, "share of the transmitted torque that is lost", upper=1.0)
    form: int = LINEAR

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        share, by_power, exponent, directed, static = values.values()
        must(round(static) == 0, "its load is all that goes through the gear, and not the weight alone")
        must(by_power == 0.0 or round(directed) == 0, "its loss by the direction of the power is half of the mean")
        must(alike(exponent, 1.0) or alike(exponent, 2.0), f"its exponents are 1 and 2, not {exponent:g}")
        if alike(exponent, 1.0):
            return {"share": share, "form": "linear"}
        return {"share": share * REFERENCE_NM, "form": "quadratic"}


@compiled()
def extra_nm(group: Record, load_nm: float, power_w: float) -> float:
    """Return the friction that the load adds to the Coulomb level (not negative, so passive). [N m]

    Linear after Bittencourt and Gunnarsson, Static friction in a robot joint (2012); quadratic after Duclusaud et al.,
    Extended friction models for the physics simulation of servo actuators (2025); backdrive after Wang and Kim,
    Directional efficiency in geared transmissions (2015): the teeth lose more where the link drives the motor.
    The power through the sensor into the motor's side is above 0 where the link drives the motor.
    """
    load = abs(load_nm)
    if group.form == QUADRATIC:
        return float(group.share * load * load / REFERENCE_NM)
    if group.form == BACKDRIVE and power_w > 0.0:
        return float(group.share * load * (1.0 + BACKDRIVE_EXCESS))
    if group.form == BACKDRIVE and power_w < 0.0:
        return float(group.share * load * (1.0 - BACKDRIVE_EXCESS))
    return float(group.share * load)
