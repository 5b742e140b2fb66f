"""Text tables -> Recording: libfranka's logToCSV, rostopic echo -p, bag exports, tidy and long tables."""

import dataclasses
import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.ingest.columns import ColumnMap, map_columns
from friction_audit.ingest.foreign_names import is_label, labels_of
from friction_audit.ingest.long_table import LongColumns, find_long_columns, pivot_long
from friction_audit.ingest.reader import Reader, ReadOptions, Recording, Topic
from friction_audit.ingest.sniff_csv import Dialect, is_number, looks_like_csv, sniff_csv, split_line
from friction_audit.ingest.time_column import TimeColumn, to_clock
from friction_audit.ingest.to_recording import stated_arm, to_recording
from friction_audit.joint_log import Finding

_BLOCK_BYTES = 8 << 20
_SHOWN_TEXT = 40
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
        return _read_long(path, dialect, long, arm)
    columns = map_columns(
        names,
        path=str(path),
        mapping=options.mapping,
        labels=labels_of(names, {names[cell]: text for cell, text in _label_cells(dialect).items()}),
        constant=_constant_columns(dialect),
        arm=arm,
    )
    recording = _read_wide(path, dialect, columns)
    return _vet_libfranka(recording, path, options) if _is_libfranka(dialect) else recording


def _read_wide(path: Path, dialect: Dialect, columns: ColumnMap) -> Recording:
    capacity = _count_lines(path, dialect)
    kind = _time_kind(dialect, columns.time)
    time: NDArray[Any] = np.empty(capacity, dtype=np.int64 if kind is str else kind)
    arrays = {c: np.empty((capacity, len(cells)), order="F") for c, cells in columns.channels.items()}
    labels = _label_cells(dialect)
    kinds: dict[int, Any] = {cell: np.float64 for cells in columns.channels.values() for cell in cells}
    kinds |= dict.fromkeys(columns.time.cells, kind) | dict.fromkeys(labels, str)
    rows, cut = 0, None
    for block in _parse(path, dialect, kinds):
        if isinstance(block, Finding):
            cut = block
            continue
        stop = rows + len(block)
        time[rows:stop] = _stamps(block, columns.time, path)
        for channel, cells in columns.channels.items():
            for joint, cell in enumerate(cells):
                arrays[channel][rows:stop, joint] = block[cell].to_numpy()
        _refuse_moving_labels(path, block, labels, rows + dialect.line)
        rows = stop
    findings = () if cut is None else (cut,)
    clock = to_clock(time[:rows], _time_unit(columns.time, kind), path=str(path))
    return to_recording(columns, clock, {c: array[:rows] for c, array in arrays.items()}, findings=findings)


def _read_long(path: Path, dialect: Dialect, long: LongColumns, arm: str) -> Recording:
    """Read a table with one row per joint and time."""
    kinds: dict[int, Any] = dict.fromkeys(long.channels.values(), np.float64) | {long.joint: str}
    kind = _time_kind(dialect, long.time)
    kinds |= dict.fromkeys(long.time.cells, kind)
    blocks: list[Any] = []
    findings: list[Finding] = []
    for block in _parse(path, dialect, kinds):
        if isinstance(block, Finding):
            findings.append(block)
        else:
            blocks.append(block)
    if not blocks:
        raise InputError(f"{path}: 0 samples; the table has a header and no whole row")
    joint = np.concatenate([block[long.joint].to_numpy(dtype=object) for block in blocks])
    time = np.concatenate([_stamps(block, long.time, path) for block in blocks])
    values = {c: np.concatenate([block[cell].to_numpy() for block in blocks]) for c, cell in long.channels.items()}
    unit = _time_unit(long.time, kind)
    return pivot_long(long, joint, time, values, path=str(path), arm=arm, unit=unit, findings=tuple(findings))


def _parse(path: Path, dialect: Dialect, kinds: Mapping[int, Any]) -> Iterator[Any]:
    """Yield the blocks of the file as frames; at the end a Finding if its last line is cut."""
    for line, block, is_last in _blocks(path, dialect):
        kept, finding = _without_cut_line(dialect, block, line, kinds) if is_last else (block, None)
        _check_widths(path, dialect, kept, line)
        if kept.strip():
            yield _frame(path, dialect, kept, line, kinds)
        if finding is not None:
            yield finding


def _frame(path: Path, dialect: Dialect, block: bytes, line: int, kinds: Mapping[int, Any]) -> Any:  # noqa: ANN401
    import pandas as pd

    try:
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
    except (ValueError, OverflowError) as error:  # pandas' ParserError is a ValueError
        raise _bad_text(path, dialect, block, line, kinds, error) from error


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
    """Leave out a last line that a killed logger did not finish; NUL bytes are what a power cut leaves."""
    body = block.rstrip(b"\0").rstrip(b"\r\n")
    before, newline, last = body.rpartition(b"\n")
    fields = split_line(last.decode(errors="replace"), dialect.separator)
    found = f"{len(fields)} of {dialect.width} fields"
    if len(fields) == dialect.width:
        numbers = (fields[c] for c in kinds if kinds[c] is not str)
        wrong = next((field for field in numbers if not is_number(field, dialect.decimal)), None)
        found = "" if wrong is None else f"{wrong!r} where a number belongs"
    if not found or not last.strip():
        return body + b"\n", None
    number = line + before.count(b"\n") + len(newline)
    return before + newline, Finding(
        code="truncated",
        message=f"line {number}, the last one, is cut short ({found}); it is left out",
        amount=1.0,
        damaged=True,
    )


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


def _bad_text(
    path: Path, dialect: Dialect, block: bytes, line: int, kinds: Mapping[int, Any], error: Exception
) -> InputError:
    """Find the field that is no number."""
    for number, raw in enumerate(block.decode(errors="replace").split("\n"), start=line):
        fields = split_line(raw.strip("\r"), dialect.separator) if raw.strip() else ()
        for cell in sorted(kinds) if len(fields) == dialect.width else ():
            if kinds[cell] is not str and not is_number(fields[cell], dialect.decimal):
                name, text = dialect.names[cell].strip(), fields[cell].strip()[:_SHOWN_TEXT]
                return InputError(
                    f"{path}: line {number}, column {name}: {text!r} is not a number; repair or remove the line"
                )
    return InputError(f"{path}: lines from {line} on cannot be read as numbers: {error}")


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


def _time_unit(time: TimeColumn, kind: type) -> str | None:
    return "ns" if len(time.cells) > 1 or kind is str else time.unit


def _stamps(block: Any, time: TimeColumn, path: Path) -> NDArray[Any]:  # noqa: ANN401
    column = block[time.cells[0]]
    if column.dtype.kind not in "iuf":
        return _dates(column, time, path)
    stamps: NDArray[Any] = column.to_numpy()
    if len(time.cells) > 1:
        stamps = stamps * 1_000_000_000 + block[time.cells[1]].to_numpy()
    return stamps


def _dates(column: Any, time: TimeColumn, path: Path) -> NDArray[np.int64]:  # noqa: ANN401
    """Turn dates into nanoseconds since 1970."""
    import pandas as pd

    try:
        dates = pd.to_datetime(column, format="ISO8601", utc=True)
    except ValueError as error:
        raise InputError(f"{path}: column {time.name} holds neither numbers nor ISO 8601 dates: {error}") from error
    if dates.isna().any():
        raise InputError(f"{path}: column {time.name} lacks {int(dates.isna().sum())} dates; remove those lines")
    nanoseconds: NDArray[np.int64] = dates.dt.tz_convert(None).dt.as_unit("ns").to_numpy().astype(np.int64)
    return nanoseconds


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
                f"{path}: line {line + int(other.to_numpy().argmax())}: joint {block[cell][other].iloc[0]!r} where the "
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
    if rows > 1 and any(np.isnan(array[0]).any() for array in recording.channels.values()):
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
