"""A model of joints -> settings of a simulation: its inertia and friction, and its other terms as hidden effects.

The simulator has formulas of its own. Where one of them equals a term, it is used; a term without an equal is refused
by name, for a log made by another formula would not be one of the model's.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import atan2, hypot, inf, pi, sqrt
from typing import Any, TypeVar

from friction_audit.effects.joint_model import ArmModel, JointModel
from friction_audit.errors import UsageError
from friction_audit.simulation.effects import EFFECTS
from friction_audit.simulation.effects.load_dependent_friction import REFERENCE_NM
from friction_audit.simulation.settings import JointParameters

Settings = TypeVar("Settings", bound=Any)

ALIKE = 0.05
"""Numbers that differ by less than this share are taken for equal, for a fit never gives them exactly."""
SMALL_SPEED_RAD_S = 0.02
"""A friction that bends at a lower speed is a power of the speed."""
WIDE_RAD = 10.0
"""A wave under a bell of this width fills the whole range."""
SMALL_NM = 0.02
"""A spring that stiffens at a smaller torque is a linear one."""
SIMPLE = ("coulomb", "viscous")


@dataclass(frozen=True, kw_only=True, slots=True)
class Setting:
    """What a term's meaning depends on.

    Attributes:
        joint: Inertia and friction of the joint.
        start_rad: Where the joint is at the start; the simulator counts some positions from there. [rad]
        driven: True if the joint moves by itself.
        duration_s: Length of the recording. [s]
        outer_kg_m2: Inertia on the measured side; infinite where it is not one number, as of an arm. [kg m^2]
    """

    joint: JointParameters
    start_rad: float
    driven: bool
    duration_s: float
    outer_kg_m2: float = inf


class NoEqualError(Exception):
    """Why the simulator has no equal of a term."""


Values = Mapping[str, float]
Told = tuple[str, dict[str, float | str]]
"""Name of an effect and its parameters, the form among them."""


def with_model(settings: Settings, model: ArmModel) -> Settings:
    """Return the settings with the joints of a model.

    Args:
        settings: Of a scenario.
        model: A model for every joint; one that is None leaves the scenario's joint as it is.

    Raises:
        UsageError: If the numbers of joints differ, a joint has no inertia, or the simulator has no equal of a term.
    """
    if len(model.joints) != len(settings.joints):
        raise UsageError(
            f"the model has {len(model.joints)} joints, the scenario {len(settings.joints)}; expected as many; choose "
            "another scenario"
        )
    starts = getattr(settings, "pose_rad", (0.0,) * len(model.joints))
    joints, hidden = list(settings.joints), list(settings.hidden)
    for k, joint in enumerate(model.joints):
        if joint is not None:
            joints[k] = _simple(joint, f"the model's joint {k + 1}")
            setting = Setting(
                joint=joints[k],
                start_rad=starts[k],
                driven=bool(getattr(settings, "driven", False)),
                duration_s=settings.duration_s,
                outer_kg_m2=inf if hasattr(settings, "pose_rad") else settings.operator.inertia_kg_m2,
            )
            groups = _groups(joint, setting, f"the model's joint {k + 1}")
            hidden[k] = replace(hidden[k], **groups)
    return replace(settings, joints=tuple(joints), hidden=tuple(hidden))


def _simple(joint: JointModel, where: str) -> JointParameters:
    if joint.inertia_kg_m2 <= 0.0:
        raise UsageError(
            f"{where}: inertia_kg_m2 = {joint.inertia_kg_m2:g}: expected more than zero; it is of a torque from which "
            "a rigid-body model took the inertia out: give that of the joint"
        )
    coulomb, viscous = joint.values("coulomb"), joint.values("viscous")
    return JointParameters(
        inertia_kg_m2=joint.inertia_kg_m2,
        coulomb_nm=0.0 if coulomb is None else coulomb[0],
        viscous_nms_per_rad=0.0 if viscous is None else viscous[0],
    )


def _groups(joint: JointModel, setting: Setting, where: str) -> dict[str, Any]:
    """Return the groups of the hidden effects that a joint's other terms are, by name of the effect."""
    groups: dict[str, Any] = {}
    for term in joint.terms:
        if term.name in SIMPLE:
            continue
        values = {p.name: value for p, value in zip(term.effect.parameters, term.values, strict=True)}
        try:
            name, given = EQUALS.get(term.name, _no_equal)(values, setting)
        except NoEqualError as reason:
            raise UsageError(
                f"{where}: {term.name}: the simulator has no equal of it: {reason}; take the term out of the file, or "
                "hide a like effect by --effect"
            ) from None
        if name in groups:
            raise UsageError(f"{where}: {term.name}: another term is a {name} already; put them together in the file")
        groups[name] = _make(name, given, f"{where}: {term.name}")
    return groups


def _make(name: str, given: Mapping[str, float | str], where: str) -> Any:  # noqa: ANN401 - every effect has its own
    effect = next(effect for effect in EFFECTS if effect.name == name)
    try:
        return effect.make({key: v if isinstance(v, str) else repr(float(v)) for key, v in given.items()})
    except UsageError as error:
        raise UsageError(f"{where}: {str(error).removeprefix(f'--effect {name}: ')}") from error


def _require(holds: bool, reason: str) -> None:
    if not holds:
        raise NoEqualError(reason)


def _alike(one: float, other: float) -> bool:
    return abs(one - other) <= ALIKE * max(abs(one), abs(other))


def _no_equal(_values: Values, _setting: Setting) -> Told:
    raise NoEqualError("its own formulas differ")


def _bias(values: Values, _setting: Setting) -> Told:
    return "torque_bias", {"torque_nm": next(iter(values.values()))}


def _stribeck(values: Values, _setting: Setting) -> Told:
    excess, speed, exponent = values.values()
    return "stribeck", {"excess_nm": excess, "speed_rad_s": speed, "exponent": exponent, "form": "exponential"}


def _nonlinear_viscous(values: Values, _setting: Setting) -> Told:
    torque, exponent, bend = list(values.values())[:3]
    _require(bend <= SMALL_SPEED_RAD_S, f"its friction that bends at {bend:g} rad/s is no power of the speed")
    return "nonlinear_viscous", {"torque_nm": torque, "exponent": exponent, "speed_rad_s": 1.0, "form": "power"}


def _asymmetric_coulomb(values: Values, _setting: Setting) -> Told:
    return "asymmetric_coulomb", {"half_difference_nm": values["coulomb_half_difference_nm"]}


def _asymmetric_viscous(values: Values, _setting: Setting) -> Told:
    return "asymmetric_viscous", {"half_difference_nms_per_rad": values["viscous_half_difference_nms_per_rad"]}


def _presliding(values: Values, setting: Setting) -> Told:
    bristles, reach, exponent, damping = values.values()
    _require(
        abs(bristles - setting.joint.coulomb_nm) <= 2 * ALIKE * bristles,
        "its bristles bear all of the Coulomb friction, no other share of it",
    )
    if exponent == 1.0:
        return "presliding", {"displacement_rad": reach, "damping_s": damping, "form": "lugre"}
    _require(damping == 0.0, "its bristles with damping have the exponent 1")
    return "presliding", {"displacement_rad": reach, "exponent": exponent, "form": "dahl"}


def _load_dependent_friction(values: Values, _setting: Setting) -> Told:
    share, by_power, exponent, directed, static = values.values()
    _require(round(static) == 0, "its load is all that goes through the gear, and not the weight alone")
    _require(by_power == 0.0 or round(directed) == 0, "its loss by the direction of the power is half of the mean")
    _require(_alike(exponent, 1.0) or _alike(exponent, 2.0), f"its exponents are 1 and 2, not {exponent:g}")
    linear = _alike(exponent, 1.0)
    return "load_dependent_friction", {
        "share": share if linear else share * REFERENCE_NM,
        "form": "linear" if linear else "quadratic",
    }


def _position_dependent_friction(values: Values, setting: Setting) -> Told:
    cosine, sine, order, centre, width = values.values()
    _require(width >= WIDE_RAD, "its wave fills the whole range")
    _require(setting.joint.coulomb_nm > 0.0, "its wave is a share of the Coulomb friction, which is none")
    return "position_dependent_friction", {
        "share": hypot(cosine, sine) / setting.joint.coulomb_nm,
        "cycles_per_rev": order,
        "phase_rad": _turn(atan2(cosine, sine) - order * centre),
        "form": "sinusoid",
    }


def _torque_ripple(values: Values, setting: Setting) -> Told:
    cosine, sine, order = values.values()
    size = hypot(cosine, sine)
    common: dict[str, float | str] = {"cycles_per_rev": order, "second_share": 0.0}
    if abs(cosine) <= ALIKE * size:
        _require(not setting.driven, "a motor that cogs beyond the sensor is not seen by it")
        return "torque_ripple", {"torque_nm": -sine, "form": "cogging", **common}
    _require(abs(sine) <= ALIKE * size, "its ripple has the phase of a sine or of a cosine")
    return "torque_ripple", {"torque_nm": cosine, "form": "reading", **common}


def _gravity_error(values: Values, setting: Setting) -> Told:
    cosine, sine = values["gravity_cos_nm"], values["gravity_sin_nm"]
    _require(round(values["gravity_error_source"]) == 0, "it errs in the joint's own angle")
    size = hypot(cosine, sine)
    return "gravity_error", {"torque_nm": -size if setting.driven else size, "phase_rad": _turn(atan2(cosine, sine))}


def _cable_spring(values: Values, setting: Setting) -> Told:
    stiffness, hardening, preload, centre, free = values.values()
    _require(abs(hardening) <= ALIKE * stiffness, "its cable that gets stiffer does so by a number of its own")
    _require(preload == 0.0 or (free == 0.0 and stiffness > 0.0), "its cable hangs loose where it does not pull")
    if free > 0.0:
        place = {"centre_rad": centre - setting.start_rad, "free_rad": free}
        return "cable_spring", {"stiffness_nm_per_rad": stiffness, **place, "form": "slack"}
    middle = centre - (preload / stiffness if preload else 0.0) - setting.start_rad
    return "cable_spring", {"stiffness_nm_per_rad": stiffness, "centre_rad": middle, "form": "linear"}


def _time_delay(values: Values, _setting: Setting) -> Told:
    delay = values["delay_s"]
    return "time_delay", {"delay_s": abs(delay), "form": "torque_late" if delay >= 0.0 else "velocity_late"}


def _torque_crosstalk(values: Values, _setting: Setting) -> Told:
    before, after, side = values.values()
    before, after = before * (side <= 0), after * (side >= 0)
    if before == 0.0 or after == 0.0:
        return "torque_crosstalk", {"share": before + after, "form": "next" if before == 0.0 else "previous"}
    _require(_alike(before, after), "its sensors feel both neighbours alike")
    return "torque_crosstalk", {"share": 0.5 * (before + after), "form": "both"}


def _joint_elasticity(values: Values, setting: Setting) -> Told:
    _require(values["soft_nm"] <= SMALL_NM, "its spring stiffens as a hyperbolic tangent, not evenly up to a torque")
    _require(values["far_share"] >= 1.0 - ALIKE, "all inertia is on the link side of its spring")
    return "joint_elasticity", {
        "compliance_rad_per_nm": values["compliance_rad_per_nm"],
        "damping_ratio": _of_both_sides(values["damping_ratio"], setting),
        "form": "linear",
    }


def _backlash(values: Values, setting: Setting) -> Told:
    share, gap, contact_hz, damping_ratio, far_share = values.values()
    _require(abs(share - 1.0) <= 2 * ALIKE, "all inertia and friction are on the link side of its backlash")
    _require(far_share >= 1.0 - ALIKE, "all inertia is on the link side of its backlash")
    stiffness = setting.joint.inertia_kg_m2 * (2.0 * pi * contact_hz) ** 2
    return "backlash", {
        "gap_rad": gap,
        "contact_compliance_rad_per_nm": 1.0 / stiffness,
        "contact_damping_ratio": _of_both_sides(damping_ratio, setting),
    }


def _of_both_sides(damping_ratio: float, setting: Setting) -> float:
    """The damping ratio with both sides free that is this one with the measured side held."""
    return damping_ratio * sqrt(1.0 + setting.joint.inertia_kg_m2 / setting.outer_kg_m2)


def _inertia_error(values: Values, _setting: Setting) -> Told:
    return "inertia_error", {"extra_kg_m2": values["extra_inertia_kg_m2"]}


def _friction_step(values: Values, setting: Setting) -> Told:
    coulomb, viscous, moment, length = values.values()
    joint = setting.joint
    _require(coulomb != 0.0 and joint.coulomb_nm > 0.0, "its step is a share of the Coulomb friction")
    change = coulomb / joint.coulomb_nm
    by_viscous = viscous / joint.viscous_nms_per_rad if joint.viscous_nms_per_rad > 0.0 else 0.0
    given: dict[str, float | str] = {"change": change, "viscous_ratio": by_viscous / change}
    if length == 0.0:
        return "friction_step", {**given, "at_share": moment / setting.duration_s, "form": "abrupt"}
    begin = (moment - 0.5 * length) / setting.duration_s
    return "friction_step", {**given, "at_share": begin, "length_s": length, "form": "ramp"}


def _unlogged_compensation(values: Values, _setting: Setting) -> Told:
    torque, width, skew, form = values.values()
    _require(skew == 0.0, "its sigmoid has one shift")
    return "unlogged_compensation", {
        "share": 1.0,
        "coulomb_nm": torque,
        "viscous_nms_per_rad": 0.0,
        "width_rad_s": width,
        "form": "dead_band" if round(form) else "smooth",
    }


def _turn(angle: float) -> float:
    """Return an angle within half a turn."""
    return (angle + pi) % (2.0 * pi) - pi


EQUALS: Mapping[str, Callable[[Values, Setting], Told]] = {
    "offset": _bias,
    "torque_bias": _bias,
    "stribeck": _stribeck,
    "nonlinear_viscous": _nonlinear_viscous,
    "asymmetric_coulomb": _asymmetric_coulomb,
    "asymmetric_viscous": _asymmetric_viscous,
    "presliding": _presliding,
    "load_dependent_friction": _load_dependent_friction,
    "position_dependent_friction": _position_dependent_friction,
    "torque_ripple": _torque_ripple,
    "gravity_error": _gravity_error,
    "cable_spring": _cable_spring,
    "time_delay": _time_delay,
    "torque_crosstalk": _torque_crosstalk,
    "joint_elasticity": _joint_elasticity,
    "backlash": _backlash,
    "inertia_error": _inertia_error,
    "friction_step": _friction_step,
    "unlogged_compensation": _unlogged_compensation,
}
"""What of the simulator a term equals, by name of the term."""
