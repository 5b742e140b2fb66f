"""What all JSON documents share, and the documents of convert, plot, simulate and its truth."""

import json
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

from friction_audit.joint_log import JointLog
from friction_audit.pipeline import Estimate
from friction_audit.reporting.notices import estimate_notices, left_out_notices, log_notices
from friction_audit.reporting.table import Column, Document, Record, to_json

NO_OPTIONS: Mapping[str, object] = MappingProxyType({})


JOINED = Record(
    (
        Column("path", str, "path as given"),
        Column("sha256", str, "of the file"),
        Column("format", str, "the reader"),
    )
)


def log_columns(count: str) -> tuple[Column, ...]:
    """Return the keys that tell which log it is; ``count`` names the number of its joints."""
    return (
        Column("path", str, "path as given", "source.path"),
        Column("sha256", str, "of the file", "source.sha256"),
        Column("format", str, "the reader", "source.format"),
        Column("robot", str, "a preset such as `panda`, or `unknown`", "source.robot"),
        Column("clock", str, "`robot_time`, `header_stamp`, `log_time` or `column`", "source.clock"),
        Column("topic", str, "topic or table that was read", "source.topic", null=True),
        Column("start", float, "Unix time of the first sample", "source.start_s", unit="s"),
        Column("channels", {"*": str}, "channel -> name in the file", "source.channels"),
        Column(count, int, "number of joints", lambda log: len(log.joint_names)),
        Column("samples", int, "number of samples", lambda log: log.samples),
        Column("rate", float, "median sampling rate", unit="Hz"),
        Column("duration", float, "from the first sample to the last", unit="s"),
        Column(
            "torque_unit", ("N m", "A", "mA"), "`A` or `mA` where the torque is a motor current", "source.torque_unit"
        ),
        Column("joined", [JOINED], "further files of the log (`--join`)", "source.joined", optional=True),
    )


SOURCE: Column = Column("source", Record(log_columns("joints")), "the log")
WARNING = Record(
    (
        Column("code", str, "stable short name"),
        Column("joint", int, "number, or null", null=True),
        Column("message", str, "one sentence"),
    )
)
WARNINGS: Column = Column("warnings", [WARNING], "what the user must know")
SETTINGS: Column = Column("settings", dict, "every setting, defaults included, and what the log chose")


def write_document(document: Mapping[str, Any]) -> str:
    """Return the document as text in ASCII, so that any file name can be written, with a newline at its end."""
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def settings_document(estimate: Estimate, reading: Mapping[str, object]) -> dict[str, Any]:
    """Return all settings, defaults included, and the choices that the log made where the user left them open.

    Args:
        estimate: The result.
        reading: How the log was read: options of the reader by name.
    """
    settings: dict[str, Any] = to_json(estimate.settings)
    chosen = to_json(estimate.interaction.choice)
    points = estimate.settings.friction.cycles_per_point
    return {"reading": to_json(dict(reading)), **settings, "torque_chosen": chosen, "cycles_per_point": points}


OUTPUT = Record(
    (
        Column("path", str, "where it was written"),
        Column("dialect", str, "name of the writer"),
        Column("joints", int, "number of joints", lambda out: len(out["log"].joint_names)),
        Column("samples", int, "number of samples", lambda out: len(out["log"].t)),
    )
)
CONVERT = Document(
    "convert", 1, "A log written in another format", Record((SOURCE, Column("output", OUTPUT, "the new log"), WARNINGS))
)


def convert_document(log: JointLog, path: str, dialect: str, left_out: Sequence[str] = ()) -> dict[str, Any]:
    """Return the document on a conversion.

    Args:
        log: The log as it was written.
        path: Where it was written.
        dialect: Name of the writer.
        left_out: Channels that the format has no place for.
    """
    warnings = log_notices(log) + left_out_notices(path, dialect, left_out)
    output = {"path": path, "dialect": dialect, "log": log}
    return CONVERT.json({"source": log, "output": output, "warnings": warnings})


FIGURE = Record(
    (
        Column("kind", str, "kind of figure"),
        Column("joint", int, "number of the joint, null for a sheet of all", null=True),
        Column("path", str, "where it was written"),
    )
)
PLOT = Document(
    "plot", 1, "Figures of one log", Record((SOURCE, SETTINGS, WARNINGS, Column("figures", [FIGURE], "what was drawn")))
)


def plot_document(
    estimate: Estimate, figures: Iterable[tuple[str, int | None, str]], reading: Mapping[str, object] = NO_OPTIONS
) -> dict[str, Any]:
    """Return the document on figures.

    Args:
        estimate: The result that was drawn.
        figures: Kind, joint number (None for a sheet of all) and path of every figure.
        reading: How the log was read: options of the reader by name.
    """
    return PLOT.json(
        {
            "source": estimate.log,
            "settings": settings_document(estimate, reading),
            "warnings": estimate_notices(estimate),
            "figures": [{"kind": kind, "joint": joint, "path": path} for kind, joint, path in figures],
        }
    )


class SimulatedLog(NamedTuple):
    """What was simulated, with everything that makes it again.

    Attributes:
        scenario: Name of the scenario.
        seed: The seed.
        settings: All settings but the hidden effects, nested, units in the keys.
        effects: Hidden effects: ``joint``, ``name``, ``form`` (or None) and ``parameters``.
        sha256: Hash of the log as it was written.
    """

    scenario: str
    seed: int
    settings: Mapping[str, object]
    effects: Sequence[Mapping[str, object]]
    sha256: str


HIDDEN = Record(
    (
        Column("joint", int, "number"),
        Column("name", str, "name of the effect"),
        Column("form", str, "its form, or null", null=True),
        Column("parameters", dict, "values by name"),
    )
)
SCENARIO = (Column("scenario", str, "its name"), Column("seed", int, "the seed"))
EFFECTS = Column("effects", [HIDDEN], "hidden effects")
HIDDEN_SETTINGS = Column("settings", dict, "all settings but the hidden effects")
SIMULATE = Document(
    "simulate",
    1,
    "A simulated log",
    Record(
        (
            *SCENARIO,
            Column(
                "output",
                Record(
                    (
                        OUTPUT.columns[0],
                        Column("sha256", str, "of the file as written"),
                        *OUTPUT.columns[1:],
                        Column("rate", float, "sampling rate", "log.rate_hz", unit="Hz"),
                        Column("duration", float, "length", "log.duration_s", unit="s"),
                    )
                ),
                "the log",
            ),
            Column("joint_names", [str], "names of the joints"),
            HIDDEN_SETTINGS,
            EFFECTS,
            WARNINGS,
        )
    ),
)
TRUTH = Document(
    "truth",
    1,
    "What was simulated in a log",
    Record((*SCENARIO, Column("log_sha256", str, "hash of the log", "sha256"), HIDDEN_SETTINGS, EFFECTS)),
)


def simulate_document(
    simulated: SimulatedLog, log: JointLog, path: str, dialect: str, left_out: Sequence[str] = ()
) -> dict[str, Any]:
    """Return the document on a simulation.

    Args:
        simulated: What was simulated.
        log: The log.
        path: Where it was written.
        dialect: Name of the writer.
        left_out: Channels that the format has no place for.
    """
    output = {"path": path, "sha256": simulated.sha256, "dialect": dialect, "log": log}
    warnings = left_out_notices(path, dialect, left_out)
    own = {"output": output, "joint_names": log.joint_names, "warnings": warnings}
    return SIMULATE.json(simulated._asdict() | own)


def truth_document(simulated: SimulatedLog) -> dict[str, Any]:
    """Return the truth of a log: everything that was simulated, and the hash that tells which log it is."""
    return TRUTH.json(simulated._asdict())
