"""What holds for every command: examples in its help that parse, near misses, ``--config`` of what it dumps."""

import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import pytest
import typer

from friction_audit.cli.app import NAMES, app, module_of
from tests.cli.conftest import Run

if TYPE_CHECKING:
    from types import ModuleType

NAME = dict(zip(map(module_of, NAMES), NAMES, strict=True))

GROUP = cast("Any", typer.main.get_command(app))
EACH = pytest.mark.parametrize("module", [*map(module_of, NAMES)], ids=NAMES)
SHORTEST = 4
"""Letters of an option from which on a slip still tells what was meant."""
READ_AT_ONCE = (".urdf", "panda.xml", "model.toml", "sessions.csv")
"""Files of the examples that must be there."""
EAGER = {"--list-dialects"}
"""Options that answer before any other is looked at."""


def examples(module: "ModuleType") -> list[list[str]]:
    """Return the words of each example of a command, without what it is piped into."""
    lines = module.EXAMPLES.splitlines()[1:]
    return [shlex.split(line.partition(" | ")[0]) for line in lines if line.strip()]


def options(name: str) -> list[str]:
    return [max(p.opts, key=len) for p in GROUP.commands[name].params if p.param_type_name == "option"]


def slip(word: str) -> str:
    """Return a word with its last two letters the other way round, or the last one doubled if they are the same."""
    return word[:-2] + word[-1] + word[-2] if word[-1] != word[-2] else word + word[-1]


@EACH
def test_help_shows_examples_that_are_the_command_s(module: "ModuleType", run: Run) -> None:
    name, shown = NAME[module], run(NAME[module], "--help").out
    assert len(examples(module)) > 1
    for line in module.EXAMPLES.splitlines():
        assert line in shown
    for words in examples(module):
        assert words[:2] == ["friction-audit", name]
        named = {word.partition("=")[0] for word in words if re.match(r"--[a-z]", word)}
        assert named <= set(options(name))


@EACH
def test_a_misspelt_command_suggests_the_near_one(module: "ModuleType", run: Run) -> None:
    answer = run(slip(NAME[module]))
    assert answer.code == 2
    assert f"'{NAME[module]}'" in answer.err.partition("Did you mean")[2]


@EACH
def test_a_misspelt_option_suggests_the_near_one(module: "ModuleType") -> None:
    command = GROUP.commands[NAME[module]]
    for option in options(NAME[module]):
        if len(option) < SHORTEST + len("--"):
            continue
        with pytest.raises(Exception, match="No such option") as refused:
            command.make_context(NAME[module], [slip(option)])
        assert option in refused.value.possibilities, option  # type: ignore[attr-defined]


@EACH
def test_what_is_dumped_can_be_read_back(module: "ModuleType", run: Run, tmp_path: Path) -> None:
    """Every example of the command's help, with the options in a file instead."""
    for number, words in enumerate(examples(module)):
        if EAGER & set(words):
            continue
        (tmp_path / "model.toml").write_text("")
        given = [_there(word, tmp_path) for word in words[1:]]
        first = run(*given, "--dump-config")
        assert first.code == 0, first.err
        path = tmp_path / f"{number}.toml"
        path.write_text(first.out, encoding="utf-8")
        again = run(*_without_options(module, given), "--config", path, "--dump-config")
        assert again.out == first.out


def _there(word: str, folder: Path) -> str:
    """Return the word, of a file that must be there a file that is."""
    return str(folder / "model.toml") if word.endswith(READ_AT_ONCE) else word


def _without_options(module: "ModuleType", words: list[str]) -> list[str]:
    """Return the command and its arguments."""
    context = GROUP.commands[words[0]].make_context(NAME[module], words[1:])
    arguments = [p.name for p in context.command.params if p.param_type_name == "argument"]
    values = [context.params[name] for name in arguments if context.params[name] is not None]
    return [
        words[0],
        *(str(one) for value in values for one in (value if isinstance(value, list | tuple) else [value])),
    ]
