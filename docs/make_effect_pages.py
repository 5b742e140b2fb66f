"""The generated parts of the pages of the effects: ``python docs/make_effect_pages.py [EFFECT...]``.

Title, summary, parameters and what separates an effect from others come from the effect and from the simulator, and so
does the table of all effects in ``effects/index.md``. The rest of a page is written by hand and stays.
"""  # noqa: INP001

import re
import sys
from pathlib import Path

from friction_audit.effects.effect import Effect
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.registry import NAMES, effect_of, effects
from friction_audit.simulation.effects import EFFECTS
from friction_audit.simulation.effects.effect import HiddenEffect

FOLDER = Path(__file__).parent / "effects"
HIDDEN = {effect.name: effect for effect in EFFECTS}
SKELETON = "# {name}\n\n\n\n## Equation\n\n## Parameters\n\n## In `diagnose`\n\nNot tested where\n"
BEGIN, END = "<!-- effects -->", "<!-- end of effects -->"


def page_of(text: str, name: str) -> str:
    """Return a page with its generated parts as they are to be."""
    effect, hidden = effect_of(name), HIDDEN[name]
    lines = text.splitlines()
    lines[0] = f"# {name}"
    lines[2] = f"*{hidden.summary[0].upper()}{hidden.summary[1:]}.*"
    text = "\n".join(lines) + "\n"
    condition = re.search(r"^Not tested where.*$", text, re.MULTILINE)
    text = _section(text, "Parameters", parameter_section(hidden))
    return _section(text, "In `diagnose`", "\n\n".join([condition[0] if condition else "", separation(effect)]))


def parameter_section(hidden: type[HiddenEffect]) -> str:
    """Return the parameters of the simulator with their usual values."""
    rows = (f"- `{one.name}`: {one.meaning}; {_number(one)}" for one in hidden.parameters())
    return "\n".join(rows)


def separation(effect: Effect) -> str:
    """Return what separates an effect from those that it names, and what in a recording does the same."""
    rows = [f"- [{name}]({name}.md): {effect.separate[name]}" for name in NAMES if name in effect.separate]
    lines = ["Separated from", "", *rows] if rows else []
    return "\n".join([*lines, "", f"{effect.recorder[:1].upper()}{effect.recorder[1:]}."] if effect.recorder else lines)


def index(text: str) -> str:
    """Return the page of all effects with its table as it is to be."""
    rows = [f"| [{one.name}]({one.name}.md) | {HIDDEN[one.name].summary} | {one.record} |" for one in effects()]
    table = "\n".join(["| effect | in a line | motion to record |", "| --- | --- | --- |", *rows])
    return re.sub(rf"(?s)({BEGIN}\n).*(?={END})", lambda found: f"{found[1]}\n{table}\n\n", text)


def _section(text: str, title: str, body: str) -> str:
    return re.sub(rf"(?ms)^## {title}\n.*?(?=^## |\Z)", lambda _: f"## {title}\n\n{body}\n\n", text).rstrip() + "\n"


def _number(parameter: Parameter) -> str:
    return f"{parameter.default:g}" + ("" if parameter.unit == "1" else f" {parameter.unit}")


def main() -> None:
    """Write the pages that are named, or all."""
    for name in sys.argv[1:] or NAMES:
        path = FOLDER / f"{name}.md"
        text = path.read_text() if path.exists() else SKELETON.format(name=name)
        path.write_text(page_of(text, name))
    path = FOLDER / "index.md"
    path.write_text(index(path.read_text()))


if __name__ == "__main__":
    main()
