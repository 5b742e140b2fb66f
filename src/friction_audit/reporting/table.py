"""Specification of a result's tables: every column once, for documents, their schemas, files and people."""

import io
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from friction_audit import __version__
from friction_audit.friction.history import Coefficient
from friction_audit.io.writers.tables import JointRows, TidyTable
from friction_audit.reporting.words import MARK, NEWTON_METRES, NOTHING, format_coefficient, in_unit, joint_label

Form = Literal["j", "f", "t", "p", "n", "w"]
Tone = Literal["", "alert", "fine", "unsure", "off"]
Row = Any
Get = str | Callable[[Row], Any]
INTERVAL = "interval"  # kind of a pair of bounds, or of those of a Coefficient
PEOPLE, ALL = "tp", "jftp"
SUFFIXES = {
    "N m": "nm", "N m s/rad": "nms_per_rad", "N m/rad": "nm_per_rad", "N m/s": "nm_s", "kg m²": "kg_m2", "J": "j",
    "s": "s", "rad": "rad", "rad/s": "rad_s", "Hz": "hz", "°C": "c", "W": "w", "1/K": "per_k",
}  # fmt: skip
# Ends of the names of a coefficient's columns in files, and its fields.
ENDS = (("", "value"), ("_low", "low"), ("_high", "high"))
TYPES = {str: "string", int: "integer", float: "number", bool: "boolean", dict: "object"}


class Column(NamedTuple):
    """A column of a table, or a key of a document."""

    name: str  # its name without the unit
    # str, int, float, bool, Coefficient, INTERVAL, dict, a tuple of the words that it may hold, a Record, a list of
    # one kind (``[float]``) or a mapping of names to one kind (``{"*": Coefficient}``)
    kind: Any = float
    meaning: str = ""  # one line for people
    # path of attributes, keys and places from a row ("" is the row itself), or a function of it; the key if None
    get: Get | None = None
    unit: str = ""  # unit of the value; its suffix ends the key
    # head of the column for people, without the unit, the words of the name if empty; ``short`` that of the terminal
    title: str = ""
    short: str = ""
    # format of a number, or what gives the text of a value
    form: str | Callable[[Any], str] | Mapping[Any, str] = ".3g"
    sort: Get | None = None  # what the column is sorted by, like ``get``, if not by the value
    # forms in which the column appears, by letter: JSON document, file, terminal, page; a further table of the page
    on: str = "jf"
    null: bool = False  # whether the value may be missing in a document; an empty text is then null
    tone: Mapping[str, Tone] | None = None  # tone of the badge around a text, by the text
    code: bool = False  # whether it is the name of a file or the like, which may break anywhere
    words: bool = False  # whether it is a phrase for which the page leaves room
    optional: bool = False  # whether a document, or a table of arrays, has it only where there is something

    def key(self, torque_unit: str = NEWTON_METRES) -> str:
        """Return the name with its unit; in files that unit follows from that of the torque."""
        suffix = SUFFIXES.get(self.unit, "")
        if torque_unit != NEWTON_METRES:  # a motor current: a or ma
            suffix = ("nm_rad" if suffix == "j" else suffix).replace("nm", torque_unit.lower())
        return f"{self.name}_{suffix}" if suffix else self.name

    def head(self, torque_unit: str, *, narrow: bool = False) -> str:
        """Return the head of the column on a page, or the ``narrow`` one of the terminal."""
        unit, title = in_unit(self.unit, torque_unit), self.title or self.name.replace("_", " ")
        title = f"{self.short or title}\n" if narrow else f"{title} "
        return f"{title}[{unit}]" if unit else title[:-1]

    @property
    def number(self) -> bool:
        """Whether people read it as a number, set to the right."""
        return self.kind in (int, float, Coefficient)

    def value(self, row: Row) -> Any:  # noqa: ANN401 - any value of a result
        """Return the value in a row."""
        return _found(row, self.key() if self.get is None else self.get)

    def at(self, path: str, **changed: Any) -> "Column":  # noqa: ANN401 - fields of a column
        """Return this column for rows from which ``path`` leads to what has its values."""
        return self._replace(get=lambda row: self.value(_found(row, path)), **changed)

    def json(self, row: Row, torque_unit: str = NEWTON_METRES) -> Any:  # noqa: ANN401
        """Return the value in a row as a document has it."""
        value = self.value(row)
        return None if self.null and value == "" else _json(self.kind, value, torque_unit)

    def schema(self) -> dict[str, Any]:
        """Return the JSON Schema of the value."""
        found = _schema(self.kind)
        if self.null and isinstance(kind := found.get("type"), str):
            found["type"] = [kind, "null"]
        elif self.null and not {"type", "oneOf"} & found.keys():
            found = {"oneOf": [{"type": "null"}, found]}
        return found | ({"description": self.meaning} if self.meaning else {})

    def text(self, row: Row) -> str:
        """Return the value in a row for people, a dash for none."""
        value = self.value(row)
        if value is None or value == "" or (isinstance(value, float) and math.isnan(value)):
            return NOTHING
        if not isinstance(self.form, str):
            return (self.form[value] if isinstance(self.form, Mapping) else self.form(value)) or NOTHING
        if isinstance(value, Coefficient | bool):
            return format_coefficient(value) if isinstance(value, Coefficient) else "yes" if value else "no"
        return value if isinstance(value, str) else format(value, "d" if self.kind is int else self.form)

    def sort_key(self, row: Row) -> float | None:
        """Return the number that a row is sorted by, NaN for none; None if the column is sorted by its text."""
        if not self.number and self.sort is None:
            return None
        value = _found(row, self.sort) if self.sort is not None else self.value(row)
        value = value.value if isinstance(value, Coefficient) else value
        return math.nan if value is None else float(value)


def joint_column(get: str = "", on: str = PEOPLE) -> Column:
    """Return the column that heads the rows of joints for people; ``get`` leads to what has ``joint`` and ``name``."""
    return Column("joint", str, get=get, form=lambda j: joint_label(j.joint, j.name), sort=f"{get}.joint", on=on)


JOINT, NAME = Column("joint", int, "number, from 1", on="j"), Column("name", str, "name in the log", on="j")
JOINTS = (JOINT, NAME, joint_column())  # what rows of joints begin with, for documents and for people


class Record:
    """Columns of one kind of row."""

    def __init__(self, *columns: Column, name: str = "", summary: str = "", over: str | None = None) -> None:
        """Take the columns in order, and what the table of files is called and what a row of it is.

        ``over``: key of the moment at which a row was known; a value of such a table is a joint's whole column.
        """
        self.columns = columns
        self.name, self.summary, self.over, self.arrays = name, summary, over, over is not None

    def on(self, form: Form) -> tuple[Column, ...]:
        """Return the columns of a form."""
        return tuple(column for column in self.columns if form in column.on)

    def json(self, row: Row, torque_unit: str = NEWTON_METRES) -> Any:  # noqa: ANN401 - an object, or a list of them
        """Return a row as an object, or the rows of a table of arrays as a list."""
        columns = self.on("j")
        if not self.arrays:
            there = (column for column in columns if not column.optional or column.value(row))
            return {column.key(): column.json(row, torque_unit) for column in there}
        values = (column.value(row) for column in columns)
        cells = zip(*(to_json(one if isinstance(one, np.ndarray) else [*one]) for one in values), strict=True)
        keys = [column.key() for column in columns]
        return [dict(zip(keys, own, strict=True)) for own in cells]

    def schema(self) -> dict[str, Any]:
        """Return the JSON Schema of a row."""
        columns = self.on("j")
        required = [column.key() for column in columns if not column.optional]
        properties = {column.key(): column.schema() for column in columns}
        return {"type": "object", "required": required, "properties": properties}

    def file(self, joints: Iterable[Any], get: Get, torque_unit: str = NEWTON_METRES) -> TidyTable:
        """Return the table for files, without optional columns that hold nothing; ``get``: rows (arrays) of a joint."""

        def cells(column: Column, rows: Any) -> Any:  # noqa: ANN401
            if self.arrays:
                return column.value(rows)
            values = [column.value(row) for row in rows]
            if column.kind is float:
                return np.array(values, dtype=np.float64)  # NaN for None
            return ["" if value is None and column.kind is str else value for value in values]

        every = ((one, _found(one, get)) for one in joints)
        found = [(one, rows) for one, rows in every if rows is not None and (self.arrays or rows)]
        lacking = [one for one in self.columns if one.optional and found and one.value(found[0][1]) is None]
        columns = {one.key(torque_unit): one for one in self.file_columns() if one not in lacking}
        return TidyTable(
            name=self.name,
            summary=self.summary,
            types={key: str if isinstance(column.kind, tuple) else column.kind for key, column in columns.items()},
            time=next((key for key, column in columns.items() if column.key() == self.over), None),
            rows=tuple(
                JointRows(joint=one.joint, name=one.name, columns={key: cells(c, rows) for key, c in columns.items()})
                for one, rows in found
            ),
        )

    def file_columns(self) -> list[Column]:
        """Return the columns of files: a coefficient is a value and the two ends of its interval."""

        def part(column: Column, end: str, field: str) -> Column:
            get = lambda row: getattr(column.value(row), field, None)  # noqa: E731
            return column._replace(name=column.name + end, kind=float, get=get)

        own = ([one] if one.kind is not Coefficient else [part(one, *end) for end in ENDS] for one in self.on("f"))
        return [column for columns in own for column in columns]

    def people(self, rows: Iterable[Row], form: Form = "p", **shown: Any) -> "Table":  # noqa: ANN401 - fields of Table
        """Return the table for people: on the terminal or on a page."""
        return Table(columns=self.on(form), rows=tuple(rows), **shown)


class Table(NamedTuple):
    """A table for people."""

    columns: Sequence[Column]  # its columns; the first heads the row
    rows: Sequence[Row]  # its rows
    caption: str = ""  # what it shows
    folded: bool = False  # whether a page shows it only when asked for
    unit: str = NEWTON_METRES  # unit of the torque

    def text(self, column: Column, row: Row) -> str:
        """Return the text of a cell."""
        return in_unit(column.text(row), self.unit)

    def filled(self, *, without: str = "") -> "Table":
        """Return the table without the columns that hold nothing in any row, and without those of a name."""
        named = (column for column in self.columns if column.name != without)
        return self._replace(columns=[one for one in named if any(one.text(row) != NOTHING for row in self.rows)])

    def lines(self, marked: Collection[int] = ()) -> list[str]:
        """Return it as text as wide as the terminal, and wider where numbers would be cut; ``marked`` rows get a mark.

        A terminal breaks long lines, and half a number is worse. Columns of phrases give way.
        """
        from rich.box import SIMPLE_HEAD
        from rich.console import Console
        from rich.table import Table as RichTable
        from rich.text import Text

        drawn = RichTable(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False, collapse_padding=True)
        for column in self.columns:
            head = Text(column.head(self.unit, narrow=True))
            drawn.add_column(head, justify="right" if column.number else "left", no_wrap=not column.words)
        for number, row in enumerate(self.rows):
            first, *others = (column.text(row) for column in self.columns)
            drawn.add_row(*map(Text, (f"{first} {MARK}" if number in marked else first, *others)))
        stream = io.StringIO()
        console = Console(file=stream, highlight=False, markup=False, color_system=None)
        roomy = console.options.update(max_width=1000)
        for part in (one for one in drawn.columns if one.no_wrap):
            part.min_width = max(console.measure(cell, options=roomy).maximum for cell in (part.header, *part.cells))
        console.width = max(console.width, console.measure(drawn, options=roomy).minimum)
        console.print(drawn)
        return [line.rstrip() for line in stream.getvalue().splitlines()]


class Document(Record):
    """A JSON document: ``schema`` and ``version``, then its columns."""

    def __init__(self, name: str, title: str, *columns: Column) -> None:
        """Take kind and version (``estimate/1``), what it is, and its keys."""
        super().__init__(*columns, name=f"friction-audit/{name}", summary=title)

    def json(self, row: Row, torque_unit: str = NEWTON_METRES) -> dict[str, Any]:
        """Return the document of values by name."""
        return {"schema": self.name, "version": __version__, **super().json(row, torque_unit)}

    def schema(self) -> dict[str, Any]:
        """Return the JSON Schema of the document."""
        head, body = {"schema": {"const": self.name}, "version": {"type": "string"}}, super().schema()
        return {
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": self.summary,
            "description": "Numbers carry their unit in the key; null where there is no number.",
            "type": "object",
            "required": [*head, *body["required"]],
            "properties": head | body["properties"],
        }


def to_json(value: Any) -> Any:  # noqa: ANN401, PLR0911 - any value of a result or of settings
    """Return the value as JSON knows it: NaN and infinity as null, arrays and tuples as lists, paths as text."""
    if is_dataclass(value) and not isinstance(value, type):
        return to_json(asdict(value))
    match value:
        case Mapping():
            return {str(key): to_json(item) for key, item in value.items()}
        case np.ndarray() if value.dtype.kind == "f":  # at once: a day has 200 000 cycles
            cells = value.astype(object)
            cells[~np.isfinite(value)] = None
            return cells.tolist()
        case np.ndarray() | np.generic():
            return to_json(value.tolist())
        case list() | tuple():
            return [to_json(item) for item in value]
        case float():
            return value if math.isfinite(value) else None
        case Path():
            return str(value)
    return value


def _found(row: Row, get: Get) -> Any:  # noqa: ANN401
    """Return what a path leads to, None where a part of it is None."""
    if not isinstance(get, str):
        return get(row)
    for name in filter(None, get.split(".")):
        if row is None:
            return None
        key = int(name) if name.isdigit() else name
        row = row[key] if isinstance(row, Mapping) or key != name else getattr(row, name)
    return row


def _json(kind: Any, value: Any, torque_unit: str) -> Any:  # noqa: ANN401
    match kind:
        case Record():
            return ([] if kind.arrays else None) if value is None else kind.json(value, torque_unit)
        case list() if value is not None:
            return [_json(kind[0], item, torque_unit) for item in value]
        case dict() if value is not None:
            return {name: _json(kind["*"], item, torque_unit) for name, item in value.items()}
    if isinstance(value, Coefficient):
        number, interval = to_json(value.value), to_json([value.low, value.high])
        if kind in (float, INTERVAL):
            return number if kind is float else interval
        return None if number is None else {"value": number, "ci95": interval}
    return in_unit(value, torque_unit) if kind is str and value is not None else to_json(value)


def _schema(kind: Any) -> dict[str, Any]:  # noqa: ANN401, PLR0911 - a return per kind
    interval = {"type": "array", "items": {"type": ["number", "null"]}, "minItems": 2, "maxItems": 2}
    match kind:
        case Record():
            return {"type": "array", "items": kind.schema()} if kind.arrays else kind.schema()
        case tuple():
            return {"enum": list(kind)}
        case list():
            return {"type": "array", "items": _schema(kind[0])}
        case dict():
            return {"type": "object", "additionalProperties": _schema(kind["*"])}
    if kind is Coefficient:
        properties = {"value": {"type": "number"}, "ci95": interval}
        found = {"type": "object", "required": ["value", "ci95"], "properties": properties}
        return {"oneOf": [{"type": "null"}, found]}
    if kind is INTERVAL:
        return interval
    return {"type": ["number", "null"] if kind is float else TYPES[kind]}
