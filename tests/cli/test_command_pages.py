"""Each command has a page that names all options that it does not share with ``estimate``, and only its own."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import pytest
import typer

from friction_audit.cli.app import NAMES, app, module_of

if TYPE_CHECKING:
    from types import ModuleType

NAME = dict(zip(map(module_of, NAMES), NAMES, strict=True))

PAGES = Path(__file__).parents[2] / "docs" / "commands"
SHORT = {"-q": "--quiet", "-v": "--verbose", "-o": "--output"}
CONSOLE = re.compile(r"^```console\n.*?^```$", re.MULTILINE | re.DOTALL)
OPTION = re.compile(r"(?<![\w-])(--[a-z][a-z-]+|-[a-z])(?![\w-])")


def options_of(name: str) -> set[str]:
    group = cast("Any", typer.main.get_command(app))
    found = [p for p in group.commands[name].params if p.param_type_name == "option"]
    return {name for p in found for name in (max(p.opts, key=len), *p.secondary_opts)}


@pytest.mark.parametrize("module", [*map(module_of, NAMES)], ids=NAMES)
def test_page_and_command_agree(module: "ModuleType") -> None:
    name = NAME[module]
    prose = CONSOLE.sub("", (PAGES / f"{name}.md").read_text())
    named = {SHORT.get(word, word) for word in OPTION.findall(prose)}
    shared = {"--help", "--help-all"} | (options_of("estimate") if name != "estimate" else set())
    assert options_of(name) - shared <= named
    assert named <= options_of(name)
