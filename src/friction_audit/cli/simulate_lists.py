"""What ``friction-audit simulate`` can be asked for, as tables for people and for ``cut``."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from friction_audit.simulation.assign import Setting
    from friction_audit.simulation.effects import HiddenEffect
    from friction_audit.simulation.scenarios import Scenario

SEVERAL_JOINTS = "; takes several joints"


def scenario_lines() -> list[str]:
    """Return a line per scenario: name, joints, what it is."""
    from friction_audit.simulation.scenarios import SCENARIOS

    width = max(len(scenario.name) for scenario in SCENARIOS)
    return [f"{scenario.name:<{width}}  {_about(scenario)}" for scenario in SCENARIOS]


def setting_lines(scenario: "Scenario") -> list[str]:
    """Return what a scenario is, and a line per setting with its value, as ``--set`` takes them."""
    from friction_audit.simulation.assign import paths

    values = {path: _value(value) for path, value in paths(scenario.settings).items()}
    width = max(map(len, values))
    return [f"{scenario.name}: {_about(scenario)}", *(f"  {path:<{width}}  {value}" for path, value in values.items())]


def effect_lines() -> list[str]:
    """Return the effects by family: each with its parameters, their usual values and their meaning."""
    from friction_audit.simulation.effects import EFFECTS

    families = dict.fromkeys(effect.family() for effect in EFFECTS)
    return [
        line
        for family in families
        for line in (family, *_indented(line for e in EFFECTS if e.family() == family for line in _effect(e)))
    ]


def _value(value: "Setting") -> str:
    from friction_audit.simulation.assign import Kind, write_value

    others = f"  (or {', '.join(value.others)})" if isinstance(value, Kind) and value.others else ""
    return write_value(value) + others


def _about(scenario: "Scenario") -> str:
    figure = f" ({scenario.figure})" if scenario.figure else ""
    return f"{scenario.summary}{figure}"


def _effect(effect: "type[HiddenEffect]") -> list[str]:
    from friction_audit.simulation.effects.effect import described

    rows = [(parameter.name, f"{parameter.default:g}", described(parameter)) for parameter in effect.parameters()]
    if effect.forms:
        rows.append(("form", effect.forms[0], f"one of {', '.join(effect.forms)}"))
    widths = [max(len(row[column]) for row in rows) for column in (0, 1)]
    table = [f"{name:<{widths[0]}}  {usual:<{widths[1]}}  {meaning}" for name, usual, meaning in rows]
    needs = SEVERAL_JOINTS if effect.needs_neighbours else ""
    return [f"{effect.name}: {effect.summary}{needs}", *_indented(table)]


def _indented(lines: Iterable[str]) -> Iterable[str]:
    return (f"  {line}" for line in lines)
