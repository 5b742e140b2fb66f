"""Text tables -> Recording: libfranka's logToCSV, rostopic echo -p, bag exports, tidy and long tables."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.readers.channel_names import is_label, labels_of
from friction_audit.io.readers.clocks import Stamps, TimeColumn
from friction_audit.io.readers.columns import ColumnMap
from friction_audit.io.readers.csv_lines import Dialect, is_row, recognises, sniff_csv, split_line, value_of
from friction_audit.io.readers.reader import ReadOptions, Topic, by_number
from friction_audit.io.readers.table import ROBOT_COLUMN, Cells, Part, Pieces, Table, read_table
from friction_audit.io.recording import Recording, Samples, WholeLogError
from friction_audit.joint_log import Finding, find_window
from friction_audit.parallel import ahead

_SHOWN_TEXT, _SHOWN_CELLS = 40, 3
_LIST = re.compile(r": [\"'](?:array)?[\[(]")  # in one cell, as pandas writes arrays
_MOST_BAD = 0.01  # of the lines with a cell that is no number; beyond, a column is not what its name says
_EXPECTED = f"numbers, in {1.0 - _MOST_BAD:.0%} of the lines; repair them"
_LONG_INTEGER = 16  # digits from which a stamp no longer fits a float exactly
_EXCEPTION_LOG_ROWS, _EXCEPTION_LOG_S = 60, 0.1
_COUNTED_BYTES = 256 << 20  # lines of a larger file are not counted where it is only listed: that takes seconds

__all__ = ["read", "recognises", "topics"]


def read(path: Path, options: ReadOptions) -> Recording:
    """Read a text table."""
    dialect = sniff_csv(path)
    if not dialect.has_header and not options.mapping:
        raise InputError(f"{path}: no header: line 1 holds {dialect.width} numbers; {by_number(dialect.width)}")
    table = CsvTable(dialect)
    recording = read_table(table, options)
    if not table.is_libfranka:
        return recording
    rows, duration_s = len(recording.t), float(recording.t[-1])
    if rows <= _EXCEPTION_LOG_ROWS and duration_s < _EXCEPTION_LOG_S and not options.allow_short:
        what = f"{rows} rows, {duration_s:.2f} s: looks like a libfranka exception log; expected several movements"
        raise InputError(f"{path}: {what}; log the state continuously, or read it with --allow-short")
    if recording.mapping["q"] == "q[{i}]" and recording.robot == "unknown":  # the header of libfranka <= 0.9.0
        recording = replace(recording, robot="panda")
    is_start = rows > 1 and recording.first_s is None
    if not is_start or not any(np.isnan(array[0]).any() for array in recording.channels.values()):
        return recording
    finding = Finding("first_row", "the first row holds no numbers yet; it is left out", amount=1.0)
    channels = {channel: array[1:] for channel, array in recording.channels.items()}
    return replace(recording, t=recording.t[1:], channels=channels).with_findings(finding)


class CsvTable(Table):
    """A text table, parsed by Arrow in blocks of whole lines, and line by line where a block has a fault."""

    slower = 4

    def __init__(self, dialect: Dialect) -> None:
        super().__init__(dialect.path, dialect.names[: dialect.width])
        self._dialect = dialect
        second = dialect.names[1].strip().lower() if len(dialect.names) > 1 else ""
        self.is_libfranka = second in ("success rate", "success_rate")
        first = zip(range(dialect.width), dialect.rows[0], strict=False)
        # rostopic echo -p writes the joints' names into every line
        self._labels = {cell: text.strip() for cell, text in first if text.strip() and is_label(dialect.names[cell])}
        self.labels = labels_of(self.names, {self.names[cell]: text for cell, text in self._labels.items()})
        whole = [row for row in dialect.rows if len(row) == dialect.width]
        said = ((cell, name) for cell, name in enumerate(self.names) if ROBOT_COLUMN.fullmatch(name))
        self.refuse_several_robots({name: [row[cell] for row in whole] for cell, name in said})
        if len(dialect.rows) >= 3:  # noqa: PLR2004  # a header stamp that stands still is no clock
            self.constant = frozenset(c for c in range(dialect.width) if len({row[c] for row in whole}) == 1)
        self._kinds: dict[int, Any] = {}
        self._lines = self._bad_lines = 0
        self._bad: list[str] = []
        self._cut: Finding | None = None

    def size(self, columns: ColumnMap) -> tuple[int, int, str | None]:
        words = [*self._labels] if columns.joint is None else [columns.joint]
        kind: Any = float  # of stamps; integers where a float would lose digits, text where they are dates
        texts = [row[c].strip() for row in self._dialect.rows for c in columns.time.cells if c < len(row)]
        whole = [text for text in texts if text.lstrip("-").isdigit()]
        is_split = len(columns.time.cells) > 1 and len(whole) == len(texts)
        if (
            texts
            and len(columns.time.cells) == 1
            and all(value_of(text, float, self._dialect.decimal) is None for text in texts)
        ):
            kind = str
        elif is_split or any(len(text) >= _LONG_INTEGER for text in whole):
            kind = np.int64
        self._kinds = dict.fromkeys(words, str) | dict.fromkeys(columns.cells, float)
        self._kinds |= dict.fromkeys(columns.time.cells, kind)
        lines, size = self._dialect.rows, self._dialect.size
        rows = size * len(lines) // sum(sum(map(len, line)) + len(line) for line in lines)
        return rows, size, "ns" if len(columns.time.cells) > 1 or kind is str else columns.time.unit

    def in_blocks(self, columns: ColumnMap) -> tuple[int, Pieces] | None:
        if self._kinds[columns.time.cells[0]] is str or self.is_libfranka:  # whose first row may hold no numbers
            return None
        rows = self._dialect.count_lines()
        return rows, partial(self._pieces, rows)

    def gather(self, columns: ColumnMap, stamps: Stamps, part: ReadOptions | None, rows: int) -> Part:
        first_s, last_s = np.inf, -np.inf
        path, words = str(self.path), [] if columns.joint is None else [columns.joint]
        samples = Samples(len(next(iter(columns.channels.values()))), columns.channels, rows if part is None else 0)
        for block in self._blocks(self._kinds, columns.time):
            t = stamps.since([block[cell] for cell in columns.time.cells])
            kept: Any = slice(None)
            if part is not None and np.isfinite(t).any():
                seconds, (start, stop) = t / stamps.unit_of(t), part.window_of_clock()
                first_s, last_s = min(first_s, np.nanmin(seconds)), max(last_s, np.nanmax(seconds))
                if np.nanmin(seconds) > stop and columns.joint is None:  # joints of a long table may follow each other
                    break
                kept = (seconds >= start) & (seconds < stop)
            times = dict(zip(("t", "joint"), (t[kept], *(block[cell][kept] for cell in words)), strict=False))
            samples.add(times, {c: [block[cell][kept] for cell in cells] for c, cells in columns.channels.items()})
        if part is not None and not samples.count:
            length = (last_s - first_s) * part.time_scale
            find_window(np.array([0.0, length]), part.t_start_s, part.t_end_s, path)
        samples.resize(samples.count)
        clock = stamps.clock(samples.times.get("t", np.empty(0)), path)
        return Part(clock, samples.channels, samples.times.get("joint"), None if part is None else float(first_s))

    def _pieces(self, rows: int, cells: Sequence[int]) -> Iterator[Cells]:
        """Yield columns of whole lines; WholeLogError if a line has a fault, or there are not so many."""
        for block in self._blocks({cell: self._kinds[cell] for cell in (*cells, *self._labels)}, None):
            rows -= len(block[cells[0]])
            yield block
        if rows:
            raise WholeLogError

    def findings(self) -> tuple[Finding, ...]:
        found = () if self._cut is None else (self._cut,)
        if not self._bad_lines:
            return found
        message = f"{self._bad_lines} lines hold what is no number ({'; '.join(self._bad)}); these are missing values"
        return (*found, Finding("no_numbers", message, amount=float(self._bad_lines), damaged=True))

    def _blocks(self, kinds: Mapping[int, Any], time: TimeColumn | None) -> Iterator[Cells]:
        """Yield columns of whole lines, dates in nanoseconds; without a clock WholeLogError if a line has a fault."""
        for lines, block, is_last in ahead(self._dialect.blocks()):
            kept, line = block, lines.start
            if is_last:
                kept, self._cut = self._dialect.without_cut_line(block, line, self._kinds)
            is_blank = not kept or kept.isspace()
            columns = None if is_blank else _parse(self._dialect, kept, kinds)
            if time is None and (columns is None or self._cut is not None):
                raise WholeLogError
            if is_blank:
                continue
            self._lines += len(lines)
            columns = columns or self._by_line(kept, line)
            for cell, label in self._labels.items():
                words = columns.get(cell, np.empty(0, object))
                if moved := [row for row in np.flatnonzero(words != label) if words[row].strip() != label]:
                    where = f"{self.path}: line {line + moved[0]}: joint {words[moved[0]]!r}"
                    what = f"where the first line has {label!r}; expected one order of the joints"
                    raise InputError(f"{where} {what}; sort the columns by joint")
            yield columns if time is None or kinds[time.cells[0]] is not str else self._dated(columns, time)

    def _by_line(self, block: bytes, line: int) -> Cells:
        """Read line by line; a few cells that are no number are missing values, or cost their line as a stamp."""
        dialect, found = self._dialect, {cell: list[Any]() for cell in self._kinds}
        for number, raw in enumerate(block.decode(errors="replace").split("\n"), start=line):
            text = raw.strip("\r")
            if "\r" in text:
                raise InputError(f"{self.path}: line {number} has a carriage return within; expected none; repair it")
            fields = split_line(text, dialect.separator) if is_row(text) else ()
            if fields and len(fields) != dialect.width:
                raise InputError(
                    f"{self.path}: line {number} has {len(fields)} fields; expected {dialect.width}; repair the line"
                )
            values = {c: value_of(fields[c], kind, dialect.decimal) for c, kind in self._kinds.items() if fields}
            wrong = [cell for cell, value in values.items() if value is None]
            if wrong:
                name, cell_text = dialect.names[wrong[0]].strip(), fields[wrong[0]].strip()[:_SHOWN_TEXT]
                self._complain(1, f"line {number}, column {name}: {cell_text!r} is not a number")
            if not any(self._kinds[cell] is np.int64 for cell in wrong):
                for cell, value in values.items():
                    found[cell].append(np.nan if value is None else value)
        return {cell: np.array(values, _DTYPES[self._kinds[cell]]) for cell, values in found.items()}

    def _complain(self, lines: int, what: str, expected: str = _EXPECTED) -> None:
        """Note lines with a cell that is no number; refuse a table with many."""
        self._bad_lines += lines
        self._bad += [what] if len(self._bad) < _SHOWN_CELLS else []
        if self._bad_lines > _MOST_BAD * self._lines:
            if _LIST.search(self._bad[0]):
                expected = "one column per joint; split the lists, or give them to log_from_frame as arrays"
            raise InputError(f"{self.path}: {self._bad[0]}; expected {expected}")

    def _dated(self, columns: Cells, time: TimeColumn) -> Cells:
        """Return the rows with dates, which become nanoseconds since 1970; not those beyond what these can hold."""
        import pandas as pd

        (cell,), words = time.cells, columns[time.cells[0]]
        day_first = r"^\s*(\d\d)\.(\d\d)\.(\d{4})"  # with slashes it could be the month
        texts = pd.Series(words, dtype=str).str.replace(",", ".").str.replace(day_first, r"\3-\2-\1", regex=True)
        dates = pd.to_datetime(texts, format="ISO8601", utc=True, errors="coerce")
        if dates.isna().all():  # a time of day
            dates = pd.Timestamp(0, tz="UTC") + pd.to_timedelta(texts, errors="coerce")
        dates = dates.where(dates.between(pd.Timestamp.min.tz_localize("UTC"), pd.Timestamp.max.tz_localize("UTC")))
        dated = dates.notna().to_numpy()
        if not dated.all():
            what = f"column {time.name} holds neither a number nor a date that is read: {words[~dated][0]!r}"
            expected = (
                "seconds, or dates such as 2024-05-01T12:00:00.001 or 01.05.2024 12:00:00.001; convert it, or name "
                "another clock with --map t=NAME"
            )
            self._complain(int(np.count_nonzero(~dated)), what, expected)
        stamps = dates[dated].dt.tz_convert(None).dt.as_unit("ns").to_numpy().astype(np.int64)
        return {own: array[dated] for own, array in columns.items()} | {cell: stamps}


_DTYPES: dict[Any, Any] = {str: object, float: np.float64, np.int64: np.int64}


def _parse(dialect: Dialect, block: bytes, kinds: Mapping[int, Any]) -> Cells | None:
    """Parse whole lines; None where Arrow refuses one of them."""
    import pyarrow as pa
    from pyarrow import compute, csv

    if b"\r" in block and block.count(b"\r") != block.count(b"\r\n"):  # within a line it would end it
        return None
    if dialect.separator == " ":
        block = b"\n".join(b" ".join(line.split()) for line in block.split(b"\n"))
    types = {str: pa.dictionary(pa.int32(), pa.string()), float: pa.float64(), np.int64: pa.int64()}
    columns = {f"f{cell}": types[kind] for cell, kind in kinds.items()}
    try:
        table = csv.read_csv(
            pa.BufferReader(block),
            read_options=csv.ReadOptions(autogenerate_column_names=True),
            parse_options=csv.ParseOptions(delimiter=dialect.separator),
            convert_options=csv.ConvertOptions(
                column_types=columns, include_columns=list(columns), decimal_point=dialect.decimal
            ),
        )
    except (pa.ArrowInvalid, pa.ArrowKeyError):
        return None
    found: Cells = {}
    for (cell, kind), column in zip(kinds.items(), table.combine_chunks().itercolumns(), strict=True):
        own = column.chunk(0) if column.num_chunks else pa.array([], column.type)
        if kind is str:
            found[cell] = np.array(own.dictionary.to_pylist(), object)[np.from_dlpack(own.indices)]
            continue
        if own.null_count and kind is np.int64:
            return None
        found[cell] = np.from_dlpack(compute.fill_null(own, np.nan) if own.null_count else own)
    return found if table.num_columns and table.num_rows else None


def topics(path: Path) -> tuple[Topic, ...]:
    """List the one table of a text file."""
    dialect = sniff_csv(path)
    rows = dialect.count_lines() if dialect.size <= _COUNTED_BYTES else None
    return (Topic(name=path.name, type=f"table of {dialect.width} columns", messages=rows, readable=True),)
