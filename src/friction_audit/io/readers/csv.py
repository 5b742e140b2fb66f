"""Text tables -> Recording: libfranka's logToCSV, rostopic echo -p, bag exports, tidy and long tables."""

import csv
import io
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.readers.channel_names import is_label, labels_of
from friction_audit.io.readers.columns import ColumnMap
from friction_audit.io.readers.csv_lines import (
    PEEK_BYTES,
    Dialect,
    blocks_of_lines,
    check_widths,
    count_lines,
    fits,
    is_number,
    open_table,
    separator_of,
    sniff_csv,
    split_line,
    without_cut_line,
)
from friction_audit.io.readers.reader import ReadOptions, Topic, refuse_too_large
from friction_audit.io.readers.table import Part, Table, read_table
from friction_audit.io.readers.time_column import UNITS, Clock, TimeColumn, to_clock
from friction_audit.io.recording import Recording
from friction_audit.joint_log import Finding, find_window

if TYPE_CHECKING:
    import pandas as pd

_SHOWN_TEXT, _SHOWN_CELLS = 40, 3
_MOST_BAD = 0.01  # of the lines with a cell that is no number; beyond, a column is not what its name says
_LONG_INTEGER = 16  # digits from which a stamp no longer fits a float exactly
_EXCEPTION_LOG_ROWS, _EXCEPTION_LOG_S = 60, 0.1
_NA = ("-nan(ind)", "nan(ind)")
_NANOSECONDS = 1_000_000_000
_COUNTED_BYTES = 256 << 20  # lines of a larger file are not counted where it is only listed: that takes seconds


def recognises(path: Path) -> bool:
    """Return True if the file is text whose first line has at least two fields; never raises."""
    try:
        with open_table(path) as stream:
            head = stream.read(PEEK_BYTES)
    except OSError:
        return False
    except InputError:  # compressed, and damaged: reading it says so
        return True
    text = head.decode("utf-8-sig", errors="ignore")
    line = next((line for line in text.splitlines() if line.strip()), "")
    printable = b"\0" not in head and len(text.encode()) > 0.95 * len(head) - 3
    return printable and not line.lstrip().startswith(("{", "<")) and len(split_line(line, separator_of(line))) > 1


def read(path: Path, options: ReadOptions) -> Recording:
    """Read a text table."""
    dialect = sniff_csv(path)
    if not dialect.has_header and not options.mapping:
        raise InputError(
            f"{path}: no header: line 1 holds {dialect.width} numbers; expected names of columns; say which column is "
            "what by its number, e.g. --map t=#1 --map q=#2-#8 --map dq=#9-#15 --map tau_J=#16-#22"
        )
    recording = read_table(CsvTable(path, dialect), options)
    second = dialect.names[1].strip().lower() if len(dialect.names) > 1 else ""
    is_libfranka = second in ("success rate", "success_rate")
    return _check_libfranka(recording, path, options) if is_libfranka else recording


class CsvTable(Table):
    """A text table, read in blocks of whole lines; lines outside the part asked for are parsed for their stamps."""

    def __init__(self, path: Path, dialect: Dialect) -> None:
        super().__init__(path, dialect.names[: dialect.width])
        self._dialect = dialect
        first = zip(range(dialect.width), dialect.rows[0], strict=False)
        # rostopic echo -p writes the joints' names into every line
        self._labels = {cell: text.strip() for cell, text in first if text.strip() and is_label(dialect.names[cell])}
        self.labels = labels_of(self.names, {self.names[cell]: text for cell, text in self._labels.items()})
        if len(dialect.rows) >= 3:  # noqa: PLR2004  # a header stamp that stands still is no clock
            whole = [row for row in dialect.rows if len(row) == dialect.width]
            self.constant = frozenset(c for c in range(dialect.width) if len({row[c] for row in whole}) == 1)
        self._origin: float | None = None  # the first stamp, where a part is read
        self._lowest, self._highest, self._block_lowest = np.inf, -np.inf, np.inf
        self._lines = self._bad_lines = 0
        self._bad: list[str] = []
        self._cut: Finding | None = None

    def read(self, columns: ColumnMap, options: ReadOptions) -> Part:
        """Read the columns; of a large table the part asked for alone."""
        dialect, cells = self._dialect, [cell for own in columns.channels.values() for cell in own]
        self._time, self._options, self._kind = columns.time, options, _time_kind(dialect, columns.time)
        self._unit = "ns" if len(columns.time.cells) > 1 or self._kind is str else columns.time.unit
        self._stamp_kinds: dict[int, Any] = dict.fromkeys(columns.time.cells, self._kind)
        texts = [*self._labels] if columns.joint is None else [columns.joint]
        self._kinds = dict.fromkeys(texts, str) | dict.fromkeys(cells, np.float64) | self._stamp_kinds
        lengths = [sum(map(len, row)) + len(row) for row in dialect.rows]
        self._is_part = options.reads_part(8 * dialect.size / (sum(lengths) / len(lengths)) * len(self._kinds))
        capacity = 0 if self._is_part else count_lines(self.path, dialect)
        refuse_too_large(self.path, 8 * capacity * (len(cells) + 1), dialect.size)
        time, channels, joints = self._gather(columns, capacity)
        clock, first_s = self._clock(time)
        joint = None if columns.joint is None else np.concatenate(joints)
        return Part(clock=clock, channels=channels, joint=joint, first_s=first_s)

    def _gather(
        self, columns: ColumnMap, capacity: int
    ) -> tuple[NDArray[Any], dict[str, NDArray[np.float64]], list[NDArray[Any]]]:
        """Return stamps and channels, and of a long table the joints, block by block."""
        time: NDArray[Any] = np.empty(capacity, dtype=np.int64 if self._kind is str else self._kind)
        channels = {c: np.empty((capacity, len(own)), order="F") for c, own in columns.channels.items()}
        joints: list[NDArray[Any]] = []
        count = 0
        for line, block, stamps in self._blocks(in_order=columns.joint is None):
            stop = count + len(block)
            if stop > len(time):  # the length of a part is not known in advance
                time = np.resize(time, 2 * stop)
                channels = {c: _longer(array, 2 * stop) for c, array in channels.items()}
            time[count:stop] = stamps
            for channel, own in columns.channels.items():
                for joint, cell in enumerate(own):
                    channels[channel][count:stop, joint] = block[cell].to_numpy()
            if columns.joint is None:
                self._refuse_moving_labels(block, line)
            else:
                joints.append(block[columns.joint].to_numpy(dtype=object))
            count = stop
        return time[:count], {c: array[:count] for c, array in channels.items()}, joints

    def findings(self) -> tuple[Finding, ...]:
        """Return what is damaged."""
        found = () if self._cut is None else (self._cut,)
        if not self._bad_lines:
            return found
        message = f"{self._bad_lines} lines hold what is no number ({'; '.join(self._bad)}); these are missing values"
        return (*found, Finding(code="no_numbers", message=message, amount=float(self._bad_lines), damaged=True))

    def _blocks(self, *, in_order: bool) -> Iterator[tuple[int, "pd.DataFrame", NDArray[Any]]]:
        """Yield the number of a block's first line, the block as a frame, and its stamps."""
        for line, block, is_last in blocks_of_lines(self.path, self._dialect):
            kept = block
            if is_last:
                kept, self._cut = without_cut_line(self._dialect, block, line, self._kinds)
            check_widths(self.path, self._dialect, kept, line)
            if not kept.strip():
                continue
            rows = self._rows_in_part(kept, line) if self._is_part else None
            if rows is not None and in_order and self._block_lowest > self._stop:
                return
            if rows is None or rows.any():
                frame = self._frame(kept, line, self._kinds)
                frame = frame if rows is None or len(rows) != len(frame) else frame[rows]
                yield line, *self._with_stamps(frame)

    def _rows_in_part(self, block: bytes, line: int) -> NDArray[np.bool_]:
        _, stamps = self._with_stamps(self._frame(block, line, self._stamp_kinds))
        if self._origin is None:
            self._unit = to_clock(stamps.copy(), self._unit, path=str(self.path)).unit
            self._origin = stamps[np.isfinite(stamps).argmax()]
        start, self._stop = (e * UNITS[self._unit or "s"] + self._origin for e in self._options.window_of_clock())
        self._block_lowest = float(np.nanmin(stamps))
        self._lowest = min(self._lowest, self._block_lowest)
        self._highest = max(self._highest, float(np.nanmax(stamps)))
        rows: NDArray[np.bool_] = (stamps >= start) & (stamps < self._stop)
        return rows

    def _clock(self, stamps: NDArray[Any]) -> tuple[Clock, float | None]:
        """Return the clock of the rows that were read, and the log's first stamp on it where they are a part."""
        if not self._is_part:
            return to_clock(stamps, self._unit, path=str(self.path)), None
        assert self._origin is not None
        unit = UNITS[self._unit or "s"]
        if len(stamps) == 0:
            ends = np.array([0.0, (self._highest - self._lowest) / unit * self._options.time_scale])
            find_window(ends, self._options.t_start_s, self._options.t_end_s, str(self.path))
        clock = to_clock(stamps, self._unit, path=str(self.path), origin=self._origin)
        return clock, (self._lowest - self._origin) / unit

    def _with_stamps(self, frame: "pd.DataFrame") -> tuple["pd.DataFrame", NDArray[Any]]:
        """Return the rows that have a stamp, and the stamps."""
        column = frame[self._time.cells[0]]
        if self._kind is str:
            dates = _dates(column)
            lost = np.isnat(dates)
            if lost.any():
                text = column.iloc[int(lost.argmax())]
                what = f"column {self._time.name} holds neither a number nor an ISO 8601 date: {text!r}"
                self._complain(int(np.count_nonzero(lost)), what)
            return frame[~lost], dates[~lost].astype(np.int64)
        stamps = column.to_numpy()
        if len(self._time.cells) > 1:
            stamps = stamps * _NANOSECONDS + frame[self._time.cells[1]].to_numpy()
        return frame, stamps

    def _frame(self, block: bytes, line: int, kinds: Mapping[int, Any]) -> "pd.DataFrame":
        """Parse whole lines; a few cells that are no number are missing values."""
        is_whole = kinds is self._kinds
        self._lines += block.count(b"\n") if is_whole else 0
        try:
            return _frame(self._dialect, block, kinds)
        except (ValueError, OverflowError):  # pandas' ParserError is a ValueError
            mended, bad = _mend(self._dialect, block, line, kinds)
        for complaint in bad if is_whole else ():
            self._complain(1, complaint)
        try:
            return _frame(self._dialect, mended, kinds)
        except (ValueError, OverflowError) as error:
            raise InputError(f"{self.path}: lines from {line} on cannot be read as numbers: {error}") from error

    def _complain(self, lines: int, what: str) -> None:
        """Note lines with a cell that is no number; refuse a table with many."""
        self._bad_lines += lines
        self._bad += [what] if len(self._bad) < _SHOWN_CELLS else []
        if self._bad_lines > _MOST_BAD * self._lines:
            raise InputError(
                f"{self.path}: {self._bad[0]}; expected a number in every line, and at least in "
                f"{1.0 - _MOST_BAD:.0%} of them; repair or remove the line"
            )

    def _refuse_moving_labels(self, block: "pd.DataFrame", line: int) -> None:
        for cell, label in self._labels.items():
            other = block[cell].str.strip() != label
            if other.any():
                raise InputError(
                    f"{self.path}: line {line + other.index[other][0]}: joint {block[cell][other].iloc[0]!r} where the "
                    f"first line has {label!r}; the order of the joints changes; expected one order in the whole "
                    "table; sort the columns by joint"
                )


def _longer(array: NDArray[np.float64], rows: int) -> NDArray[np.float64]:
    longer = np.empty((rows, array.shape[1]), order="F")
    longer[: len(array)] = array
    return longer


def _mend(dialect: Dialect, block: bytes, line: int, kinds: Mapping[int, Any]) -> tuple[bytes, list[str]]:
    """Return the lines with cells that are no number left empty, without those that lack a stamp, and what is wrong."""
    lines, bad = [], []
    for number, raw in enumerate(block.decode(errors="replace").split("\n"), start=line):
        fields = list(split_line(raw.strip("\r"), dialect.separator)) if raw.strip() else []
        wrong = [c for c in kinds if c < len(fields) and not fits(fields[c], kinds[c], dialect.decimal)]
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


def _frame(dialect: Dialect, block: bytes, kinds: Mapping[int, Any]) -> "pd.DataFrame":
    import pandas as pd

    # Since pandas 3.1 numbers always are rounded correctly, and asking for it is deprecated.
    rounds = tuple(map(int, pd.__version__.split(".")[:2])) >= (3, 1)
    exact: dict[str, Any] = {} if rounds else {"float_precision": "round_trip"}
    frame: pd.DataFrame = pd.read_csv(
        io.BytesIO(block),
        header=None,
        names=range(dialect.width),
        usecols=sorted(kinds),
        dtype=dict(kinds),
        sep=r"\s+" if dialect.separator == " " else dialect.separator,
        decimal=dialect.decimal,
        skipinitialspace=True,
        na_values=list(_NA),
        index_col=False,
        engine="c",
        **exact,
    )
    return frame


def _time_kind(dialect: Dialect, time: TimeColumn) -> type:
    """Return how stamps are read: as integers where a float would lose digits, as text where they are dates."""
    texts = [row[cell].strip() for row in dialect.rows for cell in time.cells if cell < len(row)]
    if texts and not any(is_number(text, dialect.decimal) for text in texts):
        return str
    exact = len(time.cells) > 1 or any(text.lstrip("-").isdigit() and len(text) >= _LONG_INTEGER for text in texts)
    return np.int64 if exact else np.float64


def _dates(column: "pd.Series[str]") -> NDArray[np.datetime64]:
    """Return dates in nanoseconds since 1970; what is no date, or beyond what these can hold, is missing."""
    import pandas as pd

    dates = pd.to_datetime(column, format="ISO8601", utc=True, errors="coerce")
    dates = dates.where(dates.between(pd.Timestamp.min.tz_localize("UTC"), pd.Timestamp.max.tz_localize("UTC")))
    stamps: NDArray[np.datetime64] = dates.dt.tz_convert(None).dt.as_unit("ns").to_numpy()
    return stamps


def _check_libfranka(recording: Recording, path: Path, options: ReadOptions) -> Recording:
    """Apply what is known of libfranka's logToCSV: its ring buffer, its first row, the robot of the old header."""
    rows, duration_s = len(recording.t), float(recording.t[-1])
    if rows <= _EXCEPTION_LOG_ROWS and duration_s < _EXCEPTION_LOG_S and not options.allow_short:
        raise InputError(
            f"{path}: {rows} rows, {duration_s:.2f} s: looks like a libfranka exception log (its ring buffer holds "
            "50 rows and is written when a motion fails); expected a recording of several movements; "
            "log the robot state continuously, or read it all the same with --allow-short"
        )
    if recording.mapping["q"] == "q[{i}]" and recording.robot == "unknown":  # the header of libfranka <= 0.9.0
        recording = replace(recording, robot="panda")
    is_start = rows > 1 and recording.first_s is None
    if not is_start or not any(np.isnan(array[0]).any() for array in recording.channels.values()):
        return recording
    finding = Finding(code="first_row", message="the first row holds no numbers yet; it is left out", amount=1.0)
    return replace(
        recording,
        t=recording.t[1:],
        channels={channel: array[1:] for channel, array in recording.channels.items()},
        findings=(*recording.findings, finding),
    )


def topics(path: Path) -> tuple[Topic, ...]:
    """List the one table of a text file."""
    dialect = sniff_csv(path)
    rows = count_lines(path, dialect) if dialect.size <= _COUNTED_BYTES else None
    return (Topic(name=path.name, type=f"table of {dialect.width} columns", messages=rows, readable=True),)
