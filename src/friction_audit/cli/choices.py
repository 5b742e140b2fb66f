"""Names that options accept, written down again so that ``--help`` loads no numerics.

A test holds them equal to the tuples of the steps, figures and formats that they belong to.
"""

import difflib
from collections.abc import Callable, Sequence
from typing import Any

import typer

from friction_audit.effects.registry import NAMES
from friction_audit.errors import UsageError, printable
from friction_audit.joint_numbers import parse_joint_numbers
from friction_audit.reporting.figures.registry import figure_names

TORQUES = ("auto", "interaction", "tau_ext", "tau_J")
GRAVITIES = ("auto", "logged", "model", "none")
INERTIAS = ("auto", "model", "none")
DRIVES = ("auto", "hand", "robot")
ROBOTS = ("auto", "panda", "fr3", "none")
CYCLES_FROM = ("joint", "hand")
ESTIMATORS = ("weighted", "paper")
MODELS = ("combined", "coulomb", "viscous")
ASSUMPTIONS = ("same-motion", "same-torque", "same-operator")
COMPENSATORS = ("energy", "fixed", "sigmoid", "lugre", "disturbance_observer", "torque_regulation", "model")
FIGURES, REPLAY_FIGURES = figure_names("estimate"), figure_names("replay")
DIAGNOSIS_FIGURES, BATCH_FIGURES = figure_names("diagnosis"), figure_names("drift")
PLOTTED = figure_names("estimate", "replay", "diagnosis")
ALL = "all"
IMAGE_FORMATS = ("png", "svg", "pdf")
REPORT_FORMATS = {"html": ".html", "pdf": ".pdf", "markdown": ".md", "json": ".json"}
"""Formats of a report and the endings of their files."""
EXPORTS = ("mcap", "csv", "parquet")
ESTIMATE_TABLES = ("coefficients", "coefficient_history", "cycles", "interaction")
REPLAY_TABLES = ("replay_joints", "replay_cycles", "replay_signals")
DIAGNOSE_TABLES = (
    "verdicts",
    "effects",
    "negligible_effects",
    "effect_parameters",
    "residual_checks",
    "gap_ladder",
    "residual_profiles",
    "residual",
    "simulated_motion",
)
REPORT_TABLES = (*ESTIMATE_TABLES, *REPLAY_TABLES, *DIAGNOSE_TABLES)
"""Tables of each command's result."""
EFFECTS = NAMES
SCENARIOS = (
    "joint",
    "joint-sine",
    "joint-slow",
    "joint-loaded",
    "joint-driven",
    "panda-joint",
    "panda",
    "panda-driven",
    "fig3",
    "fig6",
    "fig7-unprotected",
    "fig7",
    "fig8",
    "fig9-friction",
    "fig9-compensated",
    "fig10",
    "fig10-published",
    "fig12",
    "fig13",
)
DIALECTS = (
    "parquet",
    "parquet-lists",
    "csv",
    "csv-long",
    "csv-rostopic",
    "csv-bag",
    "csv-libfranka",
    "csv-libfranka-0.9",
    "npz",
    "rosbag1-joint-state",
    "rosbag1-franka-state",
    "rosbag2-sqlite3",
    "rosbag2-mcap",
    "rosbag2-db3",
    "rosbag2-db3-franka-state",
    "mcap",
    "mcap-franka-robot-state",
    "mcap-franka-robot-state-flat",
    "mcap-franka-state",
    "mcap-ros1",
    "mcap-json",
    "mcap-protobuf",
)


def option(
    panel: str,
    text: str,
    *names: str,
    one_of: Sequence[str] = (),
    some_of: Sequence[str] = (),
    **settings: Any,  # noqa: ANN401 - of typer.Option
) -> object:
    """Return an option under a heading of the help text.

    Args:
        panel: The heading.
        text: Its help.
        names: As typed; made from the parameter's name if there are none.
        one_of: The values it accepts.
        some_of: The values it accepts, repeated or separated by commas, each once.
        settings: Of ``typer.Option``.
    """
    known = tuple(one_of or some_of)
    if known:
        check, offer = (_one, offer_one) if one_of else (_some, _offer_some)
        settings = {"metavar": "|".join(known), "callback": check(known), "autocompletion": offer(known), **settings}
    return typer.Option(*names, help=text, rich_help_panel=panel, **settings)


def offer_one(names: Sequence[str]) -> Callable[[str], list[str]]:
    """Return what a shell completes an option of one name with."""
    return lambda incomplete: [name for name in names if name.startswith(incomplete)]


def _offer_some(names: Sequence[str]) -> Callable[[str], list[str]]:
    """Offer the names that do not stand before the last comma."""

    def offer(incomplete: str) -> list[str]:
        chosen, comma, begun = incomplete.rpartition(",")
        left = (name for name in names if name not in chosen.split(","))
        return [f"{chosen}{comma}{name}" for name in left if name.startswith(begun)]

    return offer


def _one(names: Sequence[str]) -> Callable[[str | None], str | None]:
    def check(value: str | None) -> str | None:
        if value is not None:
            _check(value, names)
        return value

    return check


def _some(names: Sequence[str]) -> Callable[[list[str]], list[str]]:
    def check(values: list[str]) -> list[str]:
        chosen = [name.strip() for value in values for name in value.split(",")]
        for name in chosen:
            _check(name, names)
        return list(dict.fromkeys(chosen))

    return check


def some_figures(wanted: Sequence[str], names: Sequence[str]) -> tuple[str, ...]:
    """Return the figures of ``--figures``, in their order."""
    return tuple(name for name in names if name in wanted or ALL in wanted)


def near_misses(word: str, names: Sequence[str]) -> str:
    """Return ``"; did you mean ...?"`` for a misspelt name, or nothing."""
    near = difflib.get_close_matches(word, names, n=2)
    return f"; did you mean {' or '.join(near)}?" if near else ""


def _check(value: str, names: Sequence[str]) -> None:
    if value not in names:
        raise typer.BadParameter(f"{printable(value)}: expected one of {', '.join(names)}{near_misses(value, names)}")


def parse_joints(text: str | None) -> tuple[int, ...] | None:
    """Return the joints of ``"1,3-5"``, in order and each once, or None for all."""
    return None if text is None else parse_joint_numbers(text, f"--joints {text}")


def parse_numbers(option: str, text: str, names: tuple[str, ...]) -> tuple[float, ...]:
    """Return the numbers of ``"0.2,0.05"``, one per name."""
    parts = text.split(",")
    try:
        numbers = tuple(float(part) for part in parts)
    except ValueError as error:
        raise UsageError(f"{option} {text}: expected numbers {','.join(names)}") from error
    if len(numbers) != len(names):
        raise UsageError(f"{option} {text}: {len(numbers)} numbers; expected {len(names)}: {','.join(names)}")
    return numbers


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
