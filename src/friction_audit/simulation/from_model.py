"""A model of joints -> settings of a simulation: its inertia and friction, and its other terms as hidden effects.

The simulator has formulas of its own. Where one of them equals a term, it is used (``HiddenEffect.from_parameters``); a
term without an equal is refused by name, for a log made by another formula would not be one of the model's.
"""

from dataclasses import fields, replace
from math import inf
from typing import TYPE_CHECKING, Any, TypeVar

from friction_audit.errors import UsageError
from friction_audit.simulation.effects import EFFECTS, HiddenEffect
from friction_audit.simulation.effects.effect import FORM, Given, NoEqualError, Setting
from friction_audit.simulation.settings import JointParameters

if TYPE_CHECKING:
    from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel

Settings = TypeVar("Settings", bound=Any)

NOMINAL = ("coulomb", "viscous")  # terms that are settings of the joint itself
EQUALS: dict[str, type[HiddenEffect]] = {
    name: effect for effect in EFFECTS for name in (effect.name, *effect.stands_for)
}


def with_model(settings: Settings, model: "ArmModel") -> Settings:
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


def _simple(joint: "JointModel", where: str) -> JointParameters:
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


def _groups(joint: "JointModel", setting: Setting, where: str) -> dict[str, HiddenEffect]:
    groups: dict[str, HiddenEffect] = {}
    for term in joint.terms:
        if term.name in NOMINAL:
            continue
        found = _equal(term, setting, f"{where}: {term.name}")
        if found.name in groups:
            raise UsageError(
                f"{where}: {term.name}: another term is a {found.name} already; put them together in the file"
            )
        groups[found.name] = found
    return groups


def equal_of(term: "FittedTerm", setting: Setting) -> HiddenEffect:
    """Return the hidden effect that equals a term.

    Raises:
        NoEqualError: If the simulator has none.
        UsageError: If it does not take the numbers.
    """
    effect = EQUALS[term.name]
    return _made(effect, effect.from_parameters(_values_of(term), setting))


def near_of(term: "FittedTerm") -> HiddenEffect:
    """Return the hidden effect next to a term: numbers that mean the same are taken over, the others are as usual."""
    effect, values = EQUALS[term.name], _values_of(term)
    likes = {one.name: values.get(one.metadata["like"]) for one in fields(effect) if one.name != FORM}
    near: Given = {
        own.name: min(max(value, own.lower), own.upper)
        for own in effect.parameters()
        if (value := likes[own.name]) is not None and (value or own.name != effect.strength_name())
    }
    return _made(effect, near)


def _values_of(term: "FittedTerm") -> dict[str, float]:
    return {p.name: value for p, value in zip(term.effect.parameters, term.values, strict=True)}


def _made(effect: type[HiddenEffect], given: Given) -> HiddenEffect:
    return effect.make({key: v if isinstance(v, str) else repr(float(v)) for key, v in given.items()})


def _equal(term: "FittedTerm", setting: Setting, where: str) -> HiddenEffect:
    try:
        return equal_of(term, setting)
    except NoEqualError as reason:
        raise UsageError(
            f"{where}: the simulator has no equal of it: {reason}; take the term out of the file, or hide a like "
            "effect by --effect"
        ) from None
    except UsageError as error:
        raise UsageError(f"{where}: {str(error).removeprefix(f'--effect {EQUALS[term.name].name}: ')}") from error
