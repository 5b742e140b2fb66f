"""What all JSON documents share, their schemas, and the documents of convert, plot, simulate and its truth."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from importlib import import_module
from types import MappingProxyType
from typing import Any

from friction_audit.io.writers.tables import TidyTable
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.interaction import TorqueChoice
from friction_audit.reporting.notices import Notice, estimate_notices, left_out_notices, log_notices, text_of
from friction_audit.reporting.table import Column, Document, Record, to_json

# Kind of document -> module of this package that specifies it, under its name in capitals.
MODULES = {
    "estimate": "estimate", "info": "info", "plot": "documents", "replay": "replay", "diagnose": "diagnosis",
    "convert": "documents", "simulate": "documents", "truth": "documents", "reproduce": "compare", "compare": "compare",
    "batch": "drift", "report": "report", "export": "export", "diff": "diff", "plan": "plan",
}  # fmt: skip
KINDS = tuple(MODULES)
ENCODE = json.JSONEncoder(allow_nan=False).encode  # without indentation, it is compiled code
NO_OPTIONS: Mapping[str, object] = MappingProxyType({})
JOINED = Record(Column("path", str, "as given"), Column("sha256", str, "of the file"), Column("format", str, "reader"))


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
        Column("torque_unit", ("N m", "A", "mA"), "`A` or `mA` if the torque is a motor current", "source.torque_unit"),
        Column("joined", [JOINED], "further files of the log (`--join`)", "source.joined", optional=True),
    )


SOURCE: Column = Column("source", Record(*log_columns("joints")), "the log")
WARNING = Record(
    Column("code", str, "stable short name"),
    Column("joint", int, "number, or null", null=True),
    Column("message", str, "one sentence"),
)
WARNINGS: Column = Column("warnings", [WARNING], "what the user must know")
SETTINGS: Column = Column("settings", dict, "every setting, defaults included, and what the log chose")


def load_schema(kind: str) -> dict[str, Any]:
    """Return the JSON Schema of a kind of document, one of KINDS."""
    document: Document = getattr(import_module(f"friction_audit.reporting.{MODULES[kind]}"), kind.upper())
    return document.schema()


def write_document(document: Mapping[str, Any]) -> str:
    """Return the document as text in ASCII, so that any file name can be written, with a newline at its end."""
    return _text(document, "\n") + "\n"


def _text(value: Any, margin: str) -> str:  # noqa: ANN401 - what JSON knows
    """Return a value on indented lines; rows of a table, such as the cycles of a history, have a line each."""
    deeper = margin + "  "
    if isinstance(value, Mapping) and value:
        items = (f"{ENCODE(key)}: {_text(item, deeper)}" for key, item in value.items())
        return f"{{{deeper}{f',{deeper}'.join(items)}{margin}}}"
    if isinstance(value, list) and value:
        is_table = isinstance(value[0], Mapping) and not any(isinstance(one, Mapping) for one in value[0].values())
        items = (ENCODE(one) if is_table else _text(one, deeper) for one in value)
        return f"[{deeper}{f',{deeper}'.join(items)}{margin}]"
    return ENCODE(value)


def torque_choice(choice: TorqueChoice | None) -> dict[str, Any] | None:
    """Return how the torque was made, and why so in words; None where it was not."""
    return None if choice is None else to_json(choice) | {"reason": text_of(choice.reason)}


def settings_document(estimate: Estimate, reading: Mapping[str, object]) -> dict[str, Any]:
    """Return all settings, defaults included, and the choices that the log made where the user left them open."""
    settings: dict[str, Any] = to_json(estimate.settings)
    chosen = torque_choice(estimate.interaction.choice)
    points = estimate.settings.friction.cycles_per_point
    return {"reading": to_json(dict(reading)), **settings, "torque_chosen": chosen, "cycles_per_point": points}


class ResultDocument(Document):
    """A result that follows from the estimate of a log: its document, with keys that all have, and tables for files."""

    def __init__(
        self,
        name: str,
        title: str,
        *columns: Column,
        notices: Callable[[Any], Iterable[Notice]],
        settings: Callable[[Any], dict[str, Any]] = lambda _: {},
        files: Sequence[tuple[Record, Callable[[Any, Any], Any]]] = (),
    ) -> None:
        """Take kind and version, what it is, and its columns; what a result warns of, and its settings by step.

        ``files``: each table for files, and what gives its rows (or arrays) from a result and one of its ``joints``.
        """
        super().__init__(name, title, SOURCE, SETTINGS, WARNINGS, *(one.at("found") for one in columns))
        self.own: Record = Record(*columns)
        self.notices, self.settings, self.files = notices, settings, files

    def of(self, found: Any, reading: Mapping[str, object] = NO_OPTIONS) -> dict[str, Any]:  # noqa: ANN401
        """Return the document of a result of a log that was read with some options."""
        estimate: Estimate = getattr(found, "estimate", found)
        values = {"source": estimate.log, "warnings": self.notices(found), "found": found}
        values["settings"] = settings_document(estimate, reading) | self.settings(found)
        return self.json(values, estimate.log.source.torque_unit)

    def tables(self, found: Any) -> tuple[TidyTable, ...]:  # noqa: ANN401
        """Return the tables of a result for files."""
        unit = getattr(found, "estimate", found).log.source.torque_unit
        (joints,) = (one.value(found) for one in self.own.columns if one.name == "joints")
        return tuple(record.file(joints, partial(rows, found), unit) for record, rows in self.files)


OUTPUT = Record(
    Column("path", str, "where it was written"),
    Column("dialect", str, "name of the writer", "writer.name"),
    Column("joints", int, "number of joints", lambda out: len(out["log"].joint_names)),
    Column("samples", int, "number of samples", lambda out: len(out["log"].t)),
)
CONVERT = Document(
    "convert/1",
    "A log written in another format",
    SOURCE,
    Column("output", OUTPUT, "the new log"),
    WARNINGS._replace(get=lambda one: log_notices(one["source"]) + left_out_notices(one["output"])),
)
FIGURE = Record(
    Column("kind", str, "kind of figure", "0"),
    Column("joint", int, "number of the joint, null for a sheet of all", "1", null=True),
    Column("path", str, "where it was written", "2"),
)
PLOT = ResultDocument(
    "plot/1",
    "Figures of one log",
    Column("figures", [FIGURE], "what was drawn"),
    notices=lambda plot: estimate_notices(plot.estimate),
)
HIDDEN = Record(
    Column("joint", int, "number"),
    Column("name", str, "name of the effect"),
    Column("form", str, "its form, or null", null=True),
    Column("parameters", dict, "values by name"),
)
SCENARIO = (Column("scenario", str, "its name"), Column("seed", int, "the seed"))
EFFECTS = Column("effects", [HIDDEN], "hidden effects")
HIDDEN_SETTINGS = Column("settings", dict, "all settings but the hidden effects")
SIMULATED_OUTPUT = Record(
    *OUTPUT.columns,
    Column("sha256", str, "of the file as written"),
    Column("rate", float, "sampling rate", "log.rate_hz", unit="Hz"),
    Column("duration", float, "length", "log.duration_s", unit="s"),
)
SIMULATE = Document(
    "simulate/1",
    "A simulated log",
    *SCENARIO,
    Column("output", SIMULATED_OUTPUT, "the log"),
    Column("joint_names", [str], "names of the joints", "output.log.joint_names"),
    HIDDEN_SETTINGS,
    EFFECTS,
    WARNINGS._replace(get=lambda one: left_out_notices(one["output"])),
)
LOG_SHA256 = Column("log_sha256", str, "hash of the log", "output.sha256")
# Everything that was simulated, and the hash that tells which log it is.
TRUTH = Document("truth/1", "What was simulated in a log", *SCENARIO, LOG_SHA256, HIDDEN_SETTINGS, EFFECTS)
