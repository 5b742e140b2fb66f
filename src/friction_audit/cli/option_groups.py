"""Options in groups: a parameter that is a dataclass stands for one option per field, or for groups in its fields."""

import inspect
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any


def with_option_groups(command: Callable[..., None]) -> Callable[..., None]:
    """Return the command as Typer wants it: every dataclass parameter replaced by its fields.

    A field carries its option as ``Annotated[type, typer.Option(...)]`` and its default as the field's default; a field
    that is a dataclass itself is a group within the group.
    """
    parameters = inspect.signature(command).parameters.values()
    groups = {p.name: p.annotation for p in parameters if is_dataclass(p.annotation)}
    flat = [one for p in parameters for one in (_fields(p.annotation) if p.name in groups else [_keyword(p)])]

    def run(**values: Any) -> None:  # noqa: ANN401 - whatever the options hold
        filled = {name: _fill(group, values) for name, group in groups.items()}
        command(**filled, **values)

    run.__name__, run.__doc__ = command.__name__, command.__doc__
    run.__annotations__ = {p.name: p.annotation for p in flat}
    run.__signature__ = inspect.Signature(flat)  # type: ignore[attr-defined]
    return run


def _fields(group: Any) -> list[inspect.Parameter]:  # noqa: ANN401 - a dataclass
    found: list[inspect.Parameter] = []
    for f in fields(group):
        one = inspect.Parameter(f.name, inspect.Parameter.KEYWORD_ONLY, default=f.default, annotation=f.type)
        found += _fields(f.type) if is_dataclass(f.type) else [one]
    return found


def _keyword(parameter: inspect.Parameter) -> inspect.Parameter:
    return parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY)


def _fill(group: Any, values: dict[str, Any]) -> Any:  # noqa: ANN401 - a dataclass
    """Take the group's fields out of the values."""
    taken = {f.name: _fill(f.type, values) if is_dataclass(f.type) else values.pop(f.name) for f in fields(group)}
    return group(**taken)
