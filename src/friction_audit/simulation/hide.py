"""``NAME[:parameter=value,...][@2,5]`` -> hidden effects in the settings of a simulation."""

import difflib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from friction_audit.errors import UsageError
from friction_audit.joint_numbers import require_joints, split_joints, write_joint_numbers
from friction_audit.simulation.assign import as_nested
from friction_audit.simulation.effects import EFFECTS, HiddenEffect
from friction_audit.simulation.effects.effect import FORM
from friction_audit.simulation.scenarios import SCENARIOS

Settings = TypeVar("Settings", bound=Any)


@dataclass(frozen=True, kw_only=True, slots=True)
class HiddenInJoint:
    """An effect that works in a joint."""

    joint: int  # number of the joint, 1..n
    name: str  # name of the effect
    form: str | None  # its functional form, or None where there is only one
    parameters: dict[str, float]  # its numbers by name, the unit as suffix


def hide(settings: Settings, entries: Iterable[str]) -> Settings:
    """Return the settings with effects hidden in their joints.

    Args:
        settings: Of a scenario; ``hidden`` holds one record per joint, with one group per effect.
        entries: ``"stribeck"``, ``"stribeck:excess_nm=0.2,form=lorentzian"``, ``"stribeck@2,5"``; without @ all
            joints that move.

    Raises:
        UsageError: If an effect, a parameter or a joint is not there, or an effect comes twice in one joint.
    """
    hidden, taken = list(settings.hidden), set[tuple[str, int]]()
    for entry in entries:
        where = f"--effect {entry}"
        effect, given, joints = _parse(entry, where)
        if effect.needs_neighbours and len(hidden) == 1:
            raise UsageError(f"{where}: takes an arm of several joints; {_scenarios_with_neighbours()}")
        meant = settings.moving if joints is None else joints
        require_joints(meant, len(hidden), where)
        again = [joint for joint in meant if (effect.name, joint) in taken]
        if again:
            raise UsageError(f"{where}: joint {write_joint_numbers(again)} has {effect.name} already; give it once")
        taken.update((effect.name, joint) for joint in meant)
        group = effect.make(given)
        for joint in meant:
            hidden[joint - 1] = hidden[joint - 1].holding(group)
    return replace(settings, hidden=tuple(hidden))


def hidden_effects(settings: Any) -> tuple[HiddenInJoint, ...]:  # noqa: ANN401 - settings of any scenario
    """Return the effects that do anything, joint by joint."""
    found = []
    for joint, groups in enumerate(settings.hidden, start=1):
        for group in groups.each():
            if group.hidden:
                values = group.values()
                form = values.pop(FORM, None)
                numbers = {name: float(value) for name, value in values.items()}
                text = None if form is None else str(form)
                found.append(HiddenInJoint(joint=joint, name=group.name, form=text, parameters=numbers))
    return tuple(found)


def settings_in_sight(settings: Any) -> dict[str, Any]:  # noqa: ANN401 - settings of any scenario
    """Return all settings but the hidden effects, nested as they are."""
    return {name: value for name, value in as_nested(settings).items() if name != "hidden"}


def _parse(entry: str, where: str) -> tuple[type[HiddenEffect], dict[str, str], tuple[int, ...] | None]:
    described, joints = split_joints(entry, where)
    name, colon, parameters = described.partition(":")
    return _find(name.strip(), where), _parameters(parameters, where) if colon else {}, joints


def _find(name: str, where: str) -> type[HiddenEffect]:
    found = next((effect for effect in EFFECTS if effect.name == name), None)
    if found is None:
        near = difflib.get_close_matches(name, [effect.name for effect in EFFECTS], n=2)
        hint = f"did you mean {' or '.join(near)}?" if near else "--list-effects names all of them"
        raise UsageError(f"{where}: no effect {name or 'without a name'}; {hint}")
    return found


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


def _scenarios_with_neighbours() -> str:
    names = [scenario.name for scenario in SCENARIOS if len(scenario.settings.hidden) > 1]
    return f"choose another scenario: {', '.join(names)}"
