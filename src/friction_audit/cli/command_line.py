"""The command that was given, for a result that says how it is made again."""

import shlex
from collections.abc import Collection

import typer


def command_line(context: typer.Context, *, leave_out: Collection[str]) -> str:
    """Return the command that was given, as it is typed.

    Args:
        context: Of the command.
        leave_out: Names of parameters that only concern how it was watched.
    """
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
