"""The lines of a text table: in blocks of whole lines, of equal width, without a last one that is cut."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.readers.csv_dialect import Dialect, is_number, split_line
from friction_audit.io.readers.packed import open_table
from friction_audit.joint_log import Finding

_BLOCK_BYTES = 8 << 20
_LOOK = 20


def blocks_of_lines(path: Path, dialect: Dialect) -> Iterator[tuple[int, bytes, bool]]:
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
    with open_table(path) as stream:
        stream.seek(dialect.offset)
        while chunk := stream.read(min(_BLOCK_BYTES, dialect.size - stream.tell())):
            yield chunk


def count_lines(path: Path, dialect: Dialect) -> int:
    """Return the number of rows, blank lines included."""
    count, chunk = 0, b""
    for chunk in _chunks(path, dialect):
        count += int(np.count_nonzero(np.frombuffer(chunk, dtype=np.uint8) == ord("\n")))
    return count + (chunk[-1:] != b"\n")


def fits(field: str, kind: Any, decimal: str) -> bool:  # noqa: ANN401
    """Return True if a field is what its column holds; a stamp that is kept as an integer cannot be missing."""
    if kind is np.int64:
        return field.strip().lstrip("+-").isdigit()
    return kind is str or is_number(field, decimal)


def without_cut_line(
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
        wrong = next((fields[c] for c in kinds if not fits(fields[c], kinds[c], dialect.decimal)), None)
        found = "" if wrong is None else f"{wrong!r} where a number belongs"
        if not found and body == text and newline and dialect.width - 1 in kinds:
            lines = before.decode(errors="replace").splitlines()[-_LOOK:]
            ends = [len(text.strip().rpartition(dialect.separator)[2]) for text in lines]
            is_short = len(fields[-1]) < min(ends, default=0)
            found = f"it has no line feed, and {fields[-1].strip()} may lack digits"
    if not found or not last.strip():
        return body + b"\n", None
    number = line + before.count(b"\n") + len(newline)
    message = f"line {number}, the last one, {'is' if is_short else 'may be'} cut short ({found}); it is left out"
    return before + newline, Finding(code="truncated", message=message, amount=1.0, damaged=is_short)


def check_widths(path: Path, dialect: Dialect, block: bytes, line: int) -> None:
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
