"""The generated parts of the pages of the effects: ``python docs/make_effect_pages.py [EFFECT...]``.

Title, summary, parameters and what separates an effect from others come from the effect and from the simulator. The
rest of a page is written by hand and stays.
"""  # noqa: INP001

import re
import sys
from math import inf
from pathlib import Path

from friction_audit.effects.effect import Effect
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.registry import NAMES, effect_of, effects
from friction_audit.simulation.effects import EFFECTS, HiddenEffect

FOLDER = Path(__file__).parent / "effects"
HIDDEN = {effect.name: effect for effect in EFFECTS}
SKELETON = "# {name}\n\n\n\n## Equation\n\n## Parameters\n\n## Separated by\n\n## In `diagnose`\n\n## Example\n"


def page_of(text: str, name: str) -> str:
    """Return a page with its generated parts as they are to be."""
    effect, hidden = effect_of(name), HIDDEN[name]
    lines = text.splitlines()
    lines[0] = f"# {name}"
    lines[2] = f"*{hidden.summary[0].upper()}{hidden.summary[1:]}.* Family: {effect.family}. Label: {effect.label}."
    text = "\n".join(lines) + "\n"
    text = _section(text, "Parameters", parameter_section(effect, hidden))
    return _section(text, "Separated by", separation(effect))


def parameter_section(effect: Effect, hidden: type[HiddenEffect]) -> str:
    """Return the table of parameters of the simulator, and the parameters of a joint model."""
    rows = ["| `--effect` | usual | unit | allowed | meaning |", "| --- | --- | --- | --- | --- |"]
    rows += [
        f"| `{one.name}` | {one.default:g} | {_unit(one)} | {_allowed(one)} | {one.meaning} |"
        for one in hidden.parameters()
    ]
    if hidden.forms:
        words = ", ".join(f"`{word}`" for word in hidden.forms)
        rows.append(f"| `form` | `{hidden.forms[0]}` | | {words} | functional form |")
    rows += ["", f"`{hidden.strength_name()}=0` changes nothing, to the bit."]
    if effect.parameters:
        listed = ", ".join(
            f"`{one.name}` ({', '.join(filter(None, (_unit(one), _allowed(one))))})" for one in effect.parameters
        )
        rows += ["", f"In a [joint model](../model.md): {listed}."]
    return "\n".join(rows)


def separation(effect: Effect) -> str:
    """Return the table of the effects that are easily confused with one, and the motion that separates them."""
    pairs = {**effect.separate, **{o.name: o.separate[effect.name] for o in effects() if effect.name in o.separate}}
    rows = [f"| [{other}]({other}.md) | {pairs[other]} |" for other in NAMES if other in pairs]
    best = f"To record: {effect.record}."
    return "\n".join([best, "", "| from | motion |", "| --- | --- |", *rows])


def _section(text: str, title: str, body: str) -> str:
    return re.sub(rf"(?ms)^## {title}\n.*?(?=^## )", lambda _: f"## {title}\n\n{body}\n\n", text)


def _unit(parameter: Parameter) -> str:
    return "" if parameter.unit == "1" else parameter.unit


def _allowed(parameter: Parameter) -> str:
    low, high = parameter.lower, parameter.upper
    if low == -inf:
        return "any" if high == inf else f"up to {high:g}"
    return f"from {low:g}" if high == inf else f"{low:g} to {high:g}"


def main() -> None:
    """Write the pages that are named, or all."""
    for name in sys.argv[1:] or NAMES:
        path = FOLDER / f"{name}.md"
        text = path.read_text() if path.exists() else SKELETON.format(name=name)
        path.write_text(page_of(text, name))


if __name__ == "__main__":
    main()
