"""Text tables -> Recording: libfranka's logToCSV, rostopic echo -p, bag exports, tidy and long tables."""

import csv
import dataclasses
import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.readers.channel_names import is_label, labels_of
from friction_audit.io.readers.columns import ColumnMap, map_columns
from friction_audit.io.readers.csv_dialect import Dialect, is_number, looks_like_csv, sniff_csv, split_line
from friction_audit.io.readers.long_table import LongColumns, find_long_columns, pivot_long
from friction_audit.io.readers.reader import Reader, ReadOptions, Recording, Topic, refuse_too_large
from friction_audit.io.readers.time_column import UNITS, Clock, TimeColumn, to_clock
from friction_audit.io.readers.to_recording import stated_arm, to_recording
from friction_audit.joint_log import Finding, Float, find_window

_BLOCK_BYTES = 8 << 20
_SHOWN_TEXT, _SHOWN_CELLS = 40, 3
_MOST_BAD = 0.01
"""Share of lines with a cell that is no number beyond which a column is not what its name says."""
_LOOK = 20
_LONG_INTEGER = 16
"""Digits from which a stamp no longer fits a float exactly."""
_EXCEPTION_LOG_ROWS = 60
_EXCEPTION_LOG_S = 0.1
_NA = ("-nan(ind)", "nan(ind)")


def read_csv(path: Path, options: ReadOptions) -> Recording:
    """Read a text table.

    Raises:
        InputError: If columns are missing, or a line does not hold what it should.
    """
    arm = stated_arm(path, options)
    dialect = sniff_csv(path)
    _refuse_headerless(path, dialect, options)
    names = dialect.names[: dialect.width]
    long = find_long_columns(names, path=str(path), mapping=options.mapping)
    if long is not None:
        return _read_long(path, dialect, long, arm, options)
    columns = map_columns(
        names,
        path=str(path),
        mapping=options.mapping,
        labels=labels_of(names, {names[cell]: text for cell, text in _label_cells(dialect).items()}),
        constant=_constant_columns(dialect),
        arm=arm,
    )
    recording = _read_wide(path, dialect, columns, options)
    return _vet_libfranka(recording, path, options) if _is_libfranka(dialect) else recording


def _read_wide(path: Path, dialect: Dialect, columns: ColumnMap, options: ReadOptions) -> Recording:
    cells = [cell for own in columns.channels.values() for cell in own]
    labels = _label_cells(dialect)
    table = _Table(path, dialect, columns.time, dict.fromkeys(cells, np.float64) | dict.fromkeys(labels, str), options)
    capacity = 0 if table.part else _count_lines(path, dialect)
    refuse_too_large(path, 8 * capacity * (len(cells) + 1), dialect.size)
    time: NDArray[Any] = np.empty(capacity, dtype=np.int64 if table.kind is str else table.kind)
    arrays = {c: np.empty((capacity, len(own)), order="F") for c, own in columns.channels.items()}
    rows = 0
    for line, block, stamps in table.blocks():
        stop = rows + len(block)
        if stop > len(time):  # of a part nobody knows how long it will be
            time = np.resize(time, 2 * stop)
            arrays = {c: _longer(array, 2 * stop) for c, array in arrays.items()}
        time[rows:stop] = stamps
        for channel, own in columns.channels.items():
            for joint, cell in enumerate(own):
                arrays[channel][rows:stop, joint] = block[cell].to_numpy()
        _refuse_moving_labels(path, block, labels, line)
        rows = stop
    clock, first_s = table.clock(time[:rows])
    channels = {c: array[:rows] for c, array in arrays.items()}
    return dataclasses.replace(to_recording(columns, clock, channels, findings=table.findings()), first_s=first_s)


def _longer(array: Float, rows: int) -> Float:
    longer = np.empty((rows, array.shape[1]), order="F")
    longer[: len(array)] = array
    return longer


def _read_long(path: Path, dialect: Dialect, long: LongColumns, arm: str, options: ReadOptions) -> Recording:
    """Read a table with one row per joint and time."""
    kinds: dict[int, Any] = dict.fromkeys(long.channels.values(), np.float64) | {long.joint: str}
    table = _Table(path, dialect, long.time, kinds, options, is_long=True)
    blocks: list[Any] = []
    times: list[NDArray[Any]] = []
    for _, block, stamps in table.blocks():
        blocks.append(block)
        times.append(stamps)
    clock, first_s = table.clock(np.concatenate(times) if times else np.empty(0))
    joint = np.concatenate([block[long.joint].to_numpy(dtype=object) for block in blocks])
    values = {c: np.concatenate([block[cell].to_numpy() for block in blocks]) for c, cell in long.channels.items()}
    recording = pivot_long(long, joint, clock, values, path=str(path), arm=arm, findings=table.findings())
    return dataclasses.replace(recording, first_s=first_s)


class _Table:
    """The blocks of a file as frames, what of them lies in the part asked for, and what is damaged."""

    def __init__(
        self,
        path: Path,
        dialect: Dialect,
        time: TimeColumn,
        kinds: Mapping[int, Any],
        options: ReadOptions,
        *,
        is_long: bool = False,
    ) -> None:
        self._path, self._dialect, self._time, self._options = path, dialect, time, options
        self.kind = _time_kind(dialect, time)
        self._stamp_kinds = dict.fromkeys(time.cells, self.kind)
        self._kinds = {**kinds, **self._stamp_kinds}
        self._is_long = is_long
        lengths = [sum(map(len, row)) + len(row) for row in dialect.rows]
        rows = dialect.size / (sum(lengths) / len(lengths))
        self.part = options.reads_part(8 * rows * len(self._kinds))
        self._unit = "ns" if len(time.cells) > 1 or self.kind is str else time.unit
        self._origin: float | None = None
        self._lowest, self._highest = np.inf, -np.inf
        self._lines = self._bad_lines = 0
        self._bad: list[str] = []
        self._cut: Finding | None = None

    def blocks(self) -> Iterator[tuple[int, Any, NDArray[Any]]]:
        """Yield the number of a block's first line, the block as a frame, and its stamps."""
        for line, block, is_last in _blocks(self._path, self._dialect):
            kept, self._cut = _without_cut_line(self._dialect, block, line, self._kinds) if is_last else (block, None)
            _check_widths(self._path, self._dialect, kept, line)
            if not kept.strip():
                continue
            rows = self._rows(kept, line) if self.part else None
            if rows is not None and self._lowest_of_block > self._stop and not self._is_long:
                return
            if rows is None or rows.any():
                frame = self._frame(kept, line, self._kinds)
                frame = frame if rows is None or len(rows) != len(frame) else frame[rows]
                yield line, *self._with_stamps(frame)

    def clock(self, stamps: NDArray[Any]) -> tuple[Clock, float | None]:
        """Return the clock of the rows that were read, and the log's first stamp on it where they are a part."""
        if not self.part:
            return to_clock(stamps, self._unit, path=str(self._path)), None
        assert self._origin is not None
        unit = UNITS[self._unit or "s"]
        first_s = (self._lowest - self._origin) / unit
        if len(stamps) == 0:
            ends = np.array([0.0, (self._highest - self._lowest) / unit * self._options.time_scale])
            find_window(ends, self._options.t_start_s, self._options.t_end_s, str(self._path))
        return to_clock(stamps, self._unit, path=str(self._path), origin=self._origin), first_s

    def findings(self) -> tuple[Finding, ...]:
        """Return what is damaged."""
        found = () if self._cut is None else (self._cut,)
        if not self._bad_lines:
            return found
        message = f"{self._bad_lines} lines hold what is no number ({'; '.join(self._bad)}); these are missing values"
        return (*found, Finding(code="no_numbers", message=message, amount=float(self._bad_lines), damaged=True))

    def _rows(self, block: bytes, line: int) -> NDArray[np.bool_]:
        """Return which rows of a block lie in the part."""
        _, stamps = self._with_stamps(self._frame(block, line, self._stamp_kinds))
        if self._origin is None:
            self._unit = to_clock(stamps.copy(), self._unit, path=str(self._path)).unit
            self._origin = stamps[np.isfinite(stamps).argmax()]
        start, stop = (edge * UNITS[self._unit or "s"] + self._origin for edge in self._options.window_of_clock())
        self._stop, self._lowest_of_block = stop, float(np.nanmin(stamps))
        self._lowest = min(self._lowest, self._lowest_of_block)
        self._highest = max(self._highest, float(np.nanmax(stamps)))
        rows: NDArray[np.bool_] = (stamps >= start) & (stamps < stop)
        return rows

    def _with_stamps(self, frame: Any) -> tuple[Any, NDArray[Any]]:  # noqa: ANN401
        """Return the rows that have a stamp, and the stamps."""
        column = frame[self._time.cells[0]]
        if self.kind is str:
            dates = _dates(column)
            lost = int(np.count_nonzero(np.isnat(dates)))
            if lost:
                text = column.iloc[int(np.isnat(dates).argmax())]
                self._complain(lost, f"column {self._time.name} holds neither a number nor an ISO 8601 date: {text!r}")
            return frame[~np.isnat(dates)], dates[~np.isnat(dates)].astype(np.int64)
        stamps = column.to_numpy()
        if len(self._time.cells) > 1:
            stamps = stamps * 1_000_000_000 + frame[self._time.cells[1]].to_numpy()
        return frame, stamps

    def _frame(self, block: bytes, line: int, kinds: Mapping[int, Any]) -> Any:  # noqa: ANN401
        """Parse whole lines; a few cells that are no number are missing values."""
        self._lines += block.count(b"\n") if kinds is self._kinds else 0
        try:
            return _frame(self._dialect, block, kinds)
        except (ValueError, OverflowError):  # pandas' ParserError is a ValueError
            mended, bad = _mend(self._dialect, block, line, kinds)
        if kinds is self._kinds:
            for complaint in bad:
                self._complain(1, complaint)
        try:
            return _frame(self._dialect, mended, kinds)
        except (ValueError, OverflowError) as error:
            raise InputError(f"{self._path}: lines from {line} on cannot be read as numbers: {error}") from error

    def _complain(self, lines: int, what: str) -> None:
        """Note lines with a cell that is none; refuse a table with many."""
        self._bad_lines += lines
        self._bad += [what] if len(self._bad) < _SHOWN_CELLS else []
        if self._bad_lines > _MOST_BAD * self._lines:
            raise InputError(
                f"{self._path}: {self._bad[0]}; expected a number in every line, and at least in "
                f"{1.0 - _MOST_BAD:.0%} of them; repair or remove the line"
            )


def _mend(dialect: Dialect, block: bytes, line: int, kinds: Mapping[int, Any]) -> tuple[bytes, list[str]]:
    """Return the lines with cells that are no number left empty, without those that lack a stamp, and what is wrong."""
    lines, bad = [], []
    for number, raw in enumerate(block.decode(errors="replace").split("\n"), start=line):
        fields = list(split_line(raw.strip("\r"), dialect.separator)) if raw.strip() else []
        wrong = [c for c in kinds if c < len(fields) and not _fits(fields[c], kinds[c], dialect.decimal)]
        if wrong:
            name, text = dialect.names[wrong[0]].strip(), fields[wrong[0]].strip()[:_SHOWN_TEXT]
            bad.append(f"line {number}, column {name}: {text!r} is not a number")
            if any(kinds[c] is np.int64 for c in wrong):
                continue
            for cell in wrong:
                fields[cell] = "nan"
            stream = io.StringIO()
            csv.writer(stream, delimiter=dialect.separator, lineterminator="").writerow(fields)
        lines.append(stream.getvalue() if wrong else raw)
    return "\n".join(lines).encode(), bad


def _fits(field: str, kind: Any, decimal: str) -> bool:  # noqa: ANN401
    """Return True if a field is what its column holds; a stamp that is kept as an integer cannot be missing."""
    if kind is np.int64:
        return field.strip().lstrip("+-").isdigit()
    return kind is str or is_number(field, decimal)


def _frame(dialect: Dialect, block: bytes, kinds: Mapping[int, Any]) -> Any:  # noqa: ANN401
    import pandas as pd

    return pd.read_csv(
        io.BytesIO(block),
        header=None,
        names=range(dialect.width),
        usecols=sorted(kinds),
        dtype=dict(kinds),
        sep=r"\s+" if dialect.separator == " " else dialect.separator,
        decimal=dialect.decimal,
        skipinitialspace=True,
        na_values=list(_NA),
        **_exact_floats(pd.__version__),
        index_col=False,
        engine="c",
    )


def _exact_floats(version: str) -> dict[str, Any]:
    """Ask for correctly rounded numbers; since pandas 3.1 there is nothing else, and asking is deprecated."""
    major, minor = version.split(".")[:2]
    return {} if (int(major), int(minor)) >= (3, 1) else {"float_precision": "round_trip"}


def _blocks(path: Path, dialect: Dialect) -> Iterator[tuple[int, bytes, bool]]:
    """Yield (number of the first line, whole lines, is it the end of the file)."""
    line, rest = dialect.line, b""
    chunks = _chunks(path, dialect)
    chunk = next(chunks, b"")
    while chunk:
        following = next(chunks, b"")
        block, newline, tail = (rest + chunk).rpartition(b"\n") if following else (rest + chunk, b"", b"")
        yield line, block + newline, not following
        line, rest, chunk = line + block.count(b"\n") + len(newline), tail, following


def _chunks(path: Path, dialect: Dialect) -> Iterator[bytes]:
    """Yield the bytes of the values, up to the size that the file had when it was first looked at."""
    with path.open("rb") as stream:
        stream.seek(dialect.offset)
        while chunk := stream.read(min(_BLOCK_BYTES, dialect.size - stream.tell())):
            yield chunk


def _without_cut_line(
    dialect: Dialect, block: bytes, line: int, kinds: Mapping[int, Any]
) -> tuple[bytes, Finding | None]:
    """Leave out a last line that a killed logger did not finish; NUL bytes are what a power cut leaves.

    A last line without a line feed may lack digits even where its fields are complete.
    """
    text = block.rstrip(b"\0")
    body = text.rstrip(b"\r\n")
    before, newline, last = body.rpartition(b"\n")
    fields = split_line(last.decode(errors="replace"), dialect.separator)
    is_short, found = True, f"{len(fields)} of {dialect.width} fields"
    if len(fields) == dialect.width:
        wrong = next((fields[c] for c in kinds if not _fits(fields[c], kinds[c], dialect.decimal)), None)
        found = "" if wrong is None else f"{wrong!r} where a number belongs"
        if not found and body == text and newline and dialect.width - 1 in kinds:
            is_short = len(fields[-1]) < _shortest_end(dialect, before)
            found = f"it has no line feed, and {fields[-1].strip()} may lack digits"
    if not found or not last.strip():
        return body + b"\n", None
    number = line + before.count(b"\n") + len(newline)
    message = f"line {number}, the last one, {'is' if is_short else 'may be'} cut short ({found}); it is left out"
    return before + newline, Finding(code="truncated", message=message, amount=1.0, damaged=is_short)


def _shortest_end(dialect: Dialect, block: bytes) -> int:
    """Return how many signs the last field of a line has at least, among the last lines of a block."""
    lines = block.decode(errors="replace").splitlines()[-_LOOK:]
    ends = [line.strip().rpartition(dialect.separator)[2] for line in lines]
    return min(map(len, ends), default=0)


def _check_widths(path: Path, dialect: Dialect, block: bytes, line: int) -> None:
    """Every line has the same number of fields; a count of separators proves it, lines are looked at if it fails.

    A carriage return within a line would end it for the parser, and leave the count of separators as it is.
    """
    codes = np.frombuffer(block, dtype=np.uint8)
    if dialect.separator != " " and block.count(b"\r") == block.count(b"\r\n"):
        separators = np.count_nonzero(codes == ord(dialect.separator))
        if separators == (dialect.width - 1) * np.count_nonzero(codes == ord("\n")):
            return
    for number, raw in enumerate(block.decode(errors="replace").split("\n"), start=line):
        if "\r" in raw.strip("\r"):
            raise InputError(
                f"{path}: line {number} has a carriage return within it; expected one at its end or none; "
                "repair or remove the line"
            )
        fields = split_line(raw.strip("\r"), dialect.separator) if raw.strip() else ()
        if fields and len(fields) != dialect.width:
            raise InputError(
                f"{path}: line {number} has {len(fields)} fields; expected {dialect.width} as in the lines before; "
                "repair or remove the line"
            )


def _count_lines(path: Path, dialect: Dialect) -> int:
    """Return the number of rows, blank lines included."""
    count, chunk = 0, b""
    for chunk in _chunks(path, dialect):
        count += int(np.count_nonzero(np.frombuffer(chunk, dtype=np.uint8) == ord("\n")))
    return count + (chunk[-1:] != b"\n")


def _time_kind(dialect: Dialect, time: TimeColumn) -> type:
    """Return how stamps are read: as integers where a float would lose digits, as text where they are dates."""
    texts = [row[cell].strip() for row in dialect.rows for cell in time.cells if cell < len(row)]
    if texts and not any(is_number(text, dialect.decimal) for text in texts):
        return str
    exact = len(time.cells) > 1 or any(text.lstrip("-").isdigit() and len(text) >= _LONG_INTEGER for text in texts)
    return np.int64 if exact else np.float64


def _dates(column: Any) -> NDArray[np.datetime64]:  # noqa: ANN401
    """Return dates in nanoseconds since 1970; what is no date, or beyond what these can hold, is missing."""
    import pandas as pd

    dates = pd.to_datetime(column, format="ISO8601", utc=True, errors="coerce")
    dates = dates.where(dates.between(pd.Timestamp.min.tz_localize("UTC"), pd.Timestamp.max.tz_localize("UTC")))
    stamps: NDArray[np.datetime64] = dates.dt.tz_convert(None).dt.as_unit("ns").to_numpy()
    return stamps


def _constant_columns(dialect: Dialect) -> frozenset[int]:
    """Return columns that stand still in the first lines: a header stamp that nobody set is no clock."""
    if len(dialect.rows) < 3:  # noqa: PLR2004
        return frozenset()
    whole = [row for row in dialect.rows if len(row) == dialect.width]
    return frozenset(c for c in range(dialect.width) if len({row[c] for row in whole}) == 1)


def _label_cells(dialect: Dialect) -> dict[int, str]:
    """Return the fields of the first row that hold a joint's name, as ``rostopic echo -p`` writes them."""
    first = zip(range(dialect.width), dialect.rows[0], strict=False)
    return {cell: text.strip() for cell, text in first if text.strip() and is_label(dialect.names[cell])}


def _refuse_moving_labels(path: Path, block: Any, labels: Mapping[int, str], line: int) -> None:  # noqa: ANN401
    for cell, label in labels.items():
        other = block[cell].str.strip() != label.strip()
        if other.any():
            raise InputError(
                f"{path}: line {line + other.index[other][0]}: joint {block[cell][other].iloc[0]!r} where the "
                f"first line has {label.strip()!r}; the order of the joints changes; expected one order in the whole "
                "table; sort the columns by joint"
            )


def _refuse_headerless(path: Path, dialect: Dialect, options: ReadOptions) -> None:
    if dialect.has_header or options.mapping:
        return
    raise InputError(
        f"{path}: no header: line 1 holds {dialect.width} numbers; expected names of columns; say which column is what "
        "by its number, e.g. --map t=#1 --map q=#2-#8 --map dq=#9-#15 --map tau_J=#16-#22"
    )


def _is_libfranka(dialect: Dialect) -> bool:
    second = dialect.names[1].strip().lower() if len(dialect.names) > 1 else ""
    return second in ("success rate", "success_rate")


def _vet_libfranka(recording: Recording, path: Path, options: ReadOptions) -> Recording:
    """Apply what is known of libfranka's logToCSV: its ring buffer, its first row, the robot of the old header."""
    rows, duration_s = len(recording.t), float(recording.t[-1])
    if rows <= _EXCEPTION_LOG_ROWS and duration_s < _EXCEPTION_LOG_S and not options.allow_short:
        raise InputError(
            f"{path}: {rows} rows, {duration_s:.2f} s: looks like a libfranka exception log (its ring buffer holds "
            "50 rows and is written when a motion fails); expected a recording of several movements; "
            "log the robot state continuously, or read it all the same with --allow-short"
        )
    old_header = recording.mapping["q"] == "q[{i}]" and recording.robot == "unknown"
    recording = dataclasses.replace(recording, robot="panda") if old_header else recording  # libfranka <= 0.9.0
    begins = rows > 1 and recording.first_s is None
    if begins and any(np.isnan(array[0]).any() for array in recording.channels.values()):
        return _without_first_row(recording)
    return recording


def _without_first_row(recording: Recording) -> Recording:
    finding = Finding(code="first_row", message="the first row holds no numbers yet; it is left out", amount=1.0)
    return dataclasses.replace(
        recording,
        t=recording.t[1:],
        channels={channel: array[1:] for channel, array in recording.channels.items()},
        findings=(*recording.findings, finding),
    )


def _tables(path: Path) -> tuple[Topic, ...]:
    dialect = sniff_csv(path)
    return (
        Topic(
            name=path.name,
            type=f"table of {dialect.width} columns",
            messages=_count_lines(path, dialect),
            readable=True,
        ),
    )


CSV = Reader(
    name="csv",
    suffixes=(".csv", ".tsv", ".txt", ".dat"),
    recognises=looks_like_csv,
    read=read_csv,
    topics=_tables,
    summary="text tables: libfranka logToCSV, rostopic echo -p, bag exports, tidy and long tables",
)
