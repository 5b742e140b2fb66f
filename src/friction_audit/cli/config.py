"""Options from a file, options written to one, and the command that was given."""

import json
import shlex
from collections.abc import Collection
from pathlib import Path
from typing import Any

import typer

from friction_audit.cli.choices import near_misses
from friction_audit.errors import printable, shortened
from friction_audit.io.files import read_toml

NOT_IN_FILES = ("config", "dump_config", "help", "help_all")
NOT_DUMPED = ("json", "overwrite", "quiet")  # of one call, and not of a set of settings
MOST_NAMED, LONGEST_KEY = 5, 40  # unknown keys that a message names, and characters of one


def command_line(context: typer.Context, *, leave_out: Collection[str]) -> str:
    """Return the command that was given, as it is typed, without some of its parameters."""
    words: list[str] = []
    for parameter in context.command.params:
        name = str(parameter.name)
        source = context.get_parameter_source(name)
        if name not in leave_out and source is not None and source.name != "DEFAULT":
            option = max(parameter.opts, key=len) if parameter.param_type_name == "option" else ""
            words += _words(option, context.params[name])
    return shlex.join(["friction-audit", str(context.command.name), *words])


def _words(option: str, value: object) -> list[str]:
    """Return an option, or an argument if it has no name, as it is typed."""
    if isinstance(value, bool):
        return [option] if value else []
    values = value if isinstance(value, list | tuple) else [value]
    return [word for item in values for word in ([option, str(item)] if option else [str(item)])]


def load_config(context: typer.Context, path: Path | None) -> Path | None:
    """Make the file's values the defaults of the command's options; called before any other option is read."""
    if path is not None and not context.resilient_parsing:
        context.default_map = _translate(_read(path), path, _options(context))
    return path


def dump_config(context: typer.Context) -> str:
    """Return the options in force as TOML; those without a value as comments."""
    options = _options(context)
    lines = [
        _line(key, context.params.get(parameter.name)) for key, parameter in options.items() if key not in NOT_DUMPED
    ]
    return "".join(f"{line}\n" for line in lines)


def _options(context: typer.Context) -> dict[str, Any]:
    options = [p for p in context.command.params if p.param_type_name == "option" and p.name not in NOT_IN_FILES]
    return {max(option.opts, key=len).removeprefix("--"): option for option in options}


def _read(path: Path) -> dict[str, Any]:
    try:
        return read_toml(path)
    except OSError as error:
        raise typer.BadParameter(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise typer.BadParameter(f"{path}: not TOML with options: {printable(str(error))}") from error


def _translate(values: dict[str, Any], path: Path, options: dict[str, Any]) -> dict[str, Any]:
    named = {key.replace("_", "-"): value for key, value in values.items()}
    unknown = [shortened(printable(key), LONGEST_KEY) for key in named if key not in options]
    if unknown:
        few = [f"{key}{near_misses(key, tuple(options))}" for key in unknown[:MOST_NAMED]]
        more = f" and {len(unknown) - len(few)} more" if len(unknown) > len(few) else ""
        listed = "" if "?" in "".join(few) else f" (options of this command: {', '.join(options)})"
        raise typer.BadParameter(f"{path}: no option {', '.join(few)}{more}{listed}")
    return {options[key].name: _as_given(value, repeatable=options[key].multiple) for key, value in named.items()}


def _as_given(value: Any, *, repeatable: bool) -> Any:  # noqa: ANN401 - any TOML value
    if isinstance(value, dict):
        value = [f"{key}={item}" for key, item in value.items()]
    if repeatable:
        return [str(item) for item in (value if isinstance(value, list) else [value])]
    if isinstance(value, list):
        return ",".join(map(str, value))
    return value if isinstance(value, bool) else str(value)


def _line(key: str, value: Any) -> str:  # noqa: ANN401 - any value of an option
    if value is None or value in ([], ()):
        return f"# {key} ="
    if isinstance(value, bool):
        return f"{key} = {str(value).lower()}"
    if isinstance(value, int | float):
        return f"{key} = {value!r}"
    if isinstance(value, list | tuple):
        return f"{key} = {json.dumps([str(item) for item in value], ensure_ascii=False)}"
    return f"{key} = {json.dumps(str(value), ensure_ascii=False)}"
