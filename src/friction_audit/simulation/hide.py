"""Hidden effects in the settings of a simulation: from ``NAME[:parameter=value,...][@2,5]``, or from a joint model.

A term of a model that no formula of the simulator equals is refused: a log of another one would not be the model's.
"""

from collections.abc import Iterable
from dataclasses import fields, replace
from math import inf
from typing import Any, TypeVar

from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel
from friction_audit.errors import UsageError, near_misses
from friction_audit.joint_numbers import parse_joint_numbers, require_joints, write_joint_numbers
from friction_audit.simulation.effects import EFFECTS
from friction_audit.simulation.effects.effect import FORM, Given, HiddenEffect, NoEqualError, Setting
from friction_audit.simulation.scenarios import SCENARIOS
from friction_audit.simulation.settings import JointParameters

Settings = TypeVar("Settings", bound=Any)

BY_NAME = {effect.name: effect for effect in EFFECTS}
EQUALS = BY_NAME | {name: effect for effect in EFFECTS for name in effect.stands_for}  # of the terms of a model
NOMINAL = ("coulomb", "viscous")  # terms that are settings of the joint itself


def hide(settings: Settings, entries: Iterable[str]) -> Settings:
    """Return settings with effects such as ``"stribeck:excess_nm=0.2@2,5"`` in joints; without @ in all that move."""
    hidden, taken = list(settings.hidden), set[tuple[str, int]]()
    for entry in entries:
        where = f"--effect {entry}"
        described, at, numbers = entry.partition("@")
        joints = parse_joint_numbers(numbers, where) if at else None
        name, colon, parameters = described.partition(":")
        if name.strip() not in BY_NAME:
            hint = near_misses(name, BY_NAME) or "; --list-effects names all of them"
            raise UsageError(f"{where}: no effect {name or 'without a name'}{hint}")
        effect = BY_NAME[name.strip()]
        if effect.needs_neighbours and len(hidden) == 1:
            several = ", ".join(scenario.name for scenario in SCENARIOS if len(scenario.settings.hidden) > 1)
            raise UsageError(f"{where}: takes an arm of several joints; choose another scenario: {several}")
        meant = settings.moving if joints is None else joints
        require_joints(meant, len(hidden), where)
        again = [joint for joint in meant if (effect.name, joint) in taken]
        if again:
            raise UsageError(f"{where}: joint {write_joint_numbers(again)} has {effect.name} already; give it once")
        taken.update((effect.name, joint) for joint in meant)
        group = effect.make(_parameters(parameters, where) if colon else {})
        for joint in meant:
            hidden[joint - 1] = hidden[joint - 1].holding(group)
    return replace(settings, hidden=tuple(hidden))


def hidden_effects(settings: Any) -> list[dict[str, Any]]:  # noqa: ANN401 - settings of any scenario
    """Return the effects that do anything, joint by joint, as documents show them; the form None where there is one."""
    return [
        {"joint": joint, "name": group.name, "form": values.pop(FORM, None), "parameters": values}
        for joint, groups in enumerate(settings.hidden, start=1)
        for group in groups.present()
        for values in [group.values()]
    ]


def _parameters(text: str, where: str) -> dict[str, str]:
    given: dict[str, str] = {}
    for part in text.split(","):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or not name or not value:
            raise UsageError(f"{where}: {part.strip()!r}: expected NAME:PARAMETER=VALUE,...")
        if name in given:
            raise UsageError(f"{where}: {name} is given twice")
        given[name] = value
    return given


def with_model(settings: Settings, model: ArmModel) -> Settings:
    """Return the settings with the joints of a model, where the simulator has an equal of each term."""
    if len(model.joints) != len(settings.joints):
        found = f"the model has {len(model.joints)} joints, the scenario {len(settings.joints)}"
        raise UsageError(f"{found}; expected as many; choose another scenario")
    starts = getattr(settings, "pose_rad", (0.0,) * len(model.joints))
    joints, hidden = list(settings.joints), list(settings.hidden)
    outer = inf if hasattr(settings, "pose_rad") else settings.operator.inertia_kg_m2
    for k, joint in ((k, joint) for k, joint in enumerate(model.joints) if joint is not None):
        where, inertia = f"the model's joint {k + 1}", joint.inertia_kg_m2
        if inertia <= 0.0:
            raise UsageError(
                f"{where}: inertia_kg_m2 = {inertia:g}: expected more than zero; it is of a torque from which a "
                "rigid-body model took the inertia out: give that of the joint"
            )
        (coulomb,), (viscous,) = (joint.values(name) or (0.0,) for name in NOMINAL)
        joints[k] = JointParameters(inertia_kg_m2=inertia, coulomb_nm=coulomb, viscous_nms_per_rad=viscous)
        setting = Setting(joints[k], starts[k], settings.driven, settings.duration_s, outer)
        hidden[k] = replace(hidden[k], **_groups(joint, setting, where))
    return replace(settings, joints=tuple(joints), hidden=tuple(hidden))


def _groups(joint: JointModel, setting: Setting, where: str) -> dict[str, HiddenEffect]:
    groups: dict[str, HiddenEffect] = {}
    for term in joint.terms:
        if term.name in NOMINAL:
            continue
        about, effect = f"{where}: {term.name}", EQUALS[term.name]
        try:
            found = effect.make(effect.from_parameters(term.numbers, setting))
        except NoEqualError as reason:
            why = f"the simulator has no equal of it: {reason}"
            todo = "take the term out of the file, or hide a like effect by --effect"
            raise UsageError(f"{about}: {why}; {todo}") from None
        except UsageError as error:
            wrong = str(error).removeprefix(f"--effect {effect.name}: ")
            raise UsageError(f"{about}: {wrong}") from error
        if found.name in groups:
            raise UsageError(f"{about}: another term is a {found.name} already; put them together in the file")
        groups[found.name] = found
    return groups


def near_of(term: FittedTerm) -> HiddenEffect:
    """Return the hidden effect next to a term: numbers that mean the same are taken over, the others are as usual."""
    effect, values = EQUALS[term.name], term.numbers
    likes = {one.name: values.get(one.metadata["like"]) for one in fields(effect)[1:]}
    near: Given = {
        own.name: min(max(value, own.lower), own.upper)
        for own in effect.parameters()
        if (value := likes[own.name]) is not None and (value or own.name != effect.strength_name)
    }
    return effect.make(near)
