"""Options with a choice of names, and values that several options share."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from functools import partial
from importlib import import_module
from math import inf
from typing import Any, TypeVar, dataclass_transform

import typer

from friction_audit.effects import registry
from friction_audit.errors import UsageError, near_misses, printable
from friction_audit.joint_numbers import parse_joint_numbers
from friction_audit.reporting.figures import style as figure_style
from friction_audit.reporting.figures.registry import figures_of

FIGURES, REPLAY_FIGURES, DIAGNOSIS_FIGURES, BATCH_FIGURES, DIFF_FIGURES = (
    tuple(figure.name for figure in figures_of(result))
    for result in ("estimate", "replay", "diagnosis", "drift", "diff")
)
PLOTTED = (*FIGURES, *REPLAY_FIGURES, *DIAGNOSIS_FIGURES)
ALL = "all"
Group = TypeVar("Group")
OPTION = "option"  # key of a field's metadata
EFFECTS, IMAGE_FORMATS = registry.NAMES, figure_style.FORMATS
EXPORTS = ("mcap", "csv", "parquet")


def names_in(module: str, registry: str) -> list[str]:
    """Return the names in a registry whose module loads numerics, asked for when a shell completes them."""
    return [one.name for one in getattr(import_module(f"friction_audit.{module}"), registry)]


scenarios = partial(names_in, "simulation.scenarios", "SCENARIOS")
dialects = partial(names_in, "io.writers.write_log", "WRITERS")


def completed_by(names: Callable[[], Sequence[str]], *, several: bool = False) -> Callable[[str], list[str]]:
    """Return what a shell completes an option with: one of the names, or of several another one after a comma."""

    def offer(incomplete: str) -> list[str]:
        chosen, comma, begun = incomplete.rpartition(",") if several else ("", "", incomplete)
        left = (name for name in names() if name not in chosen.split(","))
        return [f"{chosen}{comma}{name}" for name in left if name.startswith(begun)]

    return offer


@dataclass_transform(kw_only_default=True, frozen_default=True)
def group(heading: str) -> Callable[[type[Group]], type[Group]]:
    """Return what makes a class a group of options under a heading of the help, but those with another one."""

    def make(of: type[Group]) -> type[Group]:
        made = dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)(of)
        for one in fields(made):  # type: ignore[arg-type] # it is a dataclass by now
            info = one.metadata.get(OPTION)
            if info and info.rich_help_panel is None:
                info.rich_help_panel = heading
        return made

    return make


def option(text: str, *names: str, default: object = None, **settings: Any) -> Any:  # noqa: ANN401
    """Return an option as the default of a parameter of a command, or of a field of a group; see ``described``."""
    return field(default=default, metadata={OPTION: described(text, *names, **settings)})


def flag(text: str, *names: str, **settings: Any) -> Any:  # noqa: ANN401
    """Return an option without a value, by its names: of a single one Typer would make two, with and without no-."""
    return option(text, *names, default=False, **settings)


def positive(text: str, **settings: Any) -> Any:  # noqa: ANN401
    """Return an option for a number above zero, a bound that click has not."""

    def check(value: float | None) -> float | None:
        if value is not None and not value > 0.0:
            raise typer.BadParameter(f"{value:g}: expected a number above zero")
        return value

    return option(text, callback=check, **settings)


def described(
    text: str,
    *names: str,
    panel: str | None = None,
    one_of: Sequence[str] = (),
    some_of: Sequence[str] = (),
    **settings: Any,  # noqa: ANN401 - of typer.Option
) -> Any:  # noqa: ANN401 - of Typer
    """Return an option for ``Annotated``; ``one_of`` its values, or ``some_of`` them, repeated or between commas."""
    if known := tuple(one_of or some_of):
        shown = f"{'|'.join(known)}{',...' if some_of else ''}"
        offer = completed_by(lambda: known, several=bool(some_of))
        settings = {"metavar": shown, "callback": check_known(known), "autocompletion": offer, **settings}
    return typer.Option(*names, help=text, rich_help_panel=panel, **settings)


def check_known(names: Sequence[str]) -> Callable[[Any], Any]:
    """Return what refuses a value that is, or holds, none of the names, and leaves repetitions out."""

    def check(value: Any) -> Any:  # noqa: ANN401 - a name, several of them, or None
        several = isinstance(value, list | tuple)
        chosen = [name.strip() for one in value for name in one.split(",")] if several else [value]
        for name in chosen:
            if name is not None and name not in names:
                near = near_misses(name, names)
                raise typer.BadParameter(f"{printable(name)}: expected one of {', '.join(names)}{near}")
        return list(dict.fromkeys(chosen)) if several else value

    return check


def style(name: str) -> str:
    """Draw the figures of this command in a style."""
    figure_style.STYLE.set(figure_style.load_style(name))
    return name


def parse_joints(text: str | None) -> tuple[int, ...] | None:
    """Return the joints of ``"1,3-5"``, in order and each once, or None for all."""
    return None if text is None else parse_joint_numbers(text, f"--joints {text}")


def parse_numbers(option: str, text: str, names: tuple[str, ...]) -> tuple[float, ...]:
    """Return the numbers of ``"0.2,0.05"``, one per name."""
    try:
        numbers = tuple(map(float, text.split(",")))
    except ValueError as error:
        raise UsageError(f"{option} {text}: expected numbers {','.join(names)}") from error
    if len(numbers) != len(names):
        found = f"{len(numbers)} number{'s' * (len(numbers) > 1)}"
        raise UsageError(f"{option} {text}: {found}; expected {len(names)}: {','.join(names)}")
    return numbers


def parse_range(option: str, text: str | None, unit: str, least: float = -inf) -> tuple[float, float] | None:
    """Return the ends of ``"0.01,1"``; None where there is no text."""
    if text is None:
        return None
    low, high = parse_numbers(option, text, ("LOW", "HIGH"))
    if not least <= low < high < inf:
        bound = "0 <= " if least == 0.0 else ""
        raise UsageError(f"{option} {text}: expected {bound}LOW < HIGH [{unit}]")
    return low, high


def parse_mapping(entries: list[str] | None) -> dict[str, str]:
    """Return the mapping of ``["dq=vel_{i}", ...]``: channel -> name in the file."""
    mapping: dict[str, str] = {}
    for entry in entries or []:
        channel, equals, name = entry.partition("=")
        if not equals or not channel or not name:
            raise UsageError(f"--map {entry}: expected CHANNEL=NAME, e.g. --map dq=velocity_{{i}}")
        if channel in mapping:
            raise UsageError(f"--map {entry}: {channel} is mapped twice; give its names separated by commas")
        mapping[channel] = name
    return mapping
