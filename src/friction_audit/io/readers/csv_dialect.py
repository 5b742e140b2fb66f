"""How a text table is written: separator, decimal sign, header, first line of numbers."""

import csv
import os
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from friction_audit.errors import InputError
from friction_audit.io.readers.packed import open_table

# The longest head holds four lines of 100 000 columns; a file of one endless line is not split as a whole. [byte]
_HEAD_BYTES, _LONGEST_HEAD = 1 << 20, 1 << 23
_FEWEST_LINES = 4
_LOOK = 20
PEEK_BYTES = 4096
_MISSING = {"", "na", "n/a", "null", "none", "nan", "-nan", "-nan(ind)", "nan(ind)", "#n/a", "<na>", "-1.#ind",
            "1.#qnan", "-1.#qnan", "1.#ind", "inf", "-inf", "+inf", "infinity", "-infinity", "+infinity"}  # fmt: skip


@dataclass(frozen=True, kw_only=True, slots=True)
class Dialect:
    """How a text table is written."""

    separator: str  # ",", ";", tab, or " " for any blanks
    decimal: str  # sign between units and tenths
    names: tuple[str, ...]  # names of the columns as they stand; #1, #2... where the file has no header
    has_header: bool  # True if the file names its columns
    width: int  # fields of a line of numbers
    offset: int  # byte at which the numbers begin
    line: int  # number of the line there, counted from 1
    size: int  # bytes of the file; what a logger appends later is not read
    rows: tuple[tuple[str, ...], ...]  # the fields of the first lines of numbers


def is_number(text: str, decimal: str = ".") -> bool:
    """Return True if a field is a number or one of the usual ways to write that there is none."""
    stripped = text.strip()
    if stripped.lower() in _MISSING:
        return True
    try:
        float(stripped.replace(",", ".") if decimal == "," else stripped)
    except ValueError:
        return False
    return "_" not in stripped


def split_line(line: str, separator: str) -> tuple[str, ...]:
    """Split one line into its fields, quotes respected."""
    if separator == " ":
        return tuple(line.split())
    try:
        return tuple(next(csv.reader([line.replace("\r", " ")], delimiter=separator), []))
    except csv.Error:  # a field beyond the module's limit: no quotes are respected there
        return tuple(line.split(separator))


def sniff_csv(path: Path) -> Dialect:
    """Find out how a text table is written, from its first lines.

    Raises:
        InputError: If it holds no line of numbers.
    """
    with open_table(path) as stream:
        _refuse_no_text(path, stream.read(_HEAD_BYTES))
        skipped, begin = _skip_comments(stream)
        head = stream.read(_HEAD_BYTES)
        while head.count(b"\n") < _FEWEST_LINES and len(head) < _LONGEST_HEAD and (more := stream.read(_HEAD_BYTES)):
            head += more
        place, size = stream.tell(), stream.seek(0, os.SEEK_END)
    lines = head.splitlines(keepends=True)
    del lines[len(lines) - (place < size and len(lines) > 1) :]  # which may end in the middle
    texts = [line.decode("utf-8-sig", errors="replace").strip("\r\n") for line in lines]
    start = next((i for i, text in enumerate(texts) if text.strip() and not text.startswith("#")), None)
    if start is None:
        raise InputError(f"{path}: all lines are blank or comments; expected a table with a header")
    separator = separator_of(texts[start])
    fields = split_line(texts[start], separator)
    if all(is_number(field, "," if separator == ";" else ".") for field in fields):
        first = start  # numpy.savetxt writes its header as a comment
        names = (
            split_line(texts[start - 1].lstrip("#"), separator) if texts[start - 1].startswith("#") and start else ()
        )
        has_header = len(names) == len(fields)
        names = names if has_header else tuple(f"#{column}" for column in range(1, len(fields) + 1))
    else:
        first, has_header, names = start + 1, True, split_line(texts[start].lstrip("#"), separator)
    rows = tuple(split_line(text, separator) for text in texts[first : first + _LOOK] if text.strip())
    if not rows:
        raise InputError(
            f"{path}: 0 samples; the table has a header ({len(names)} columns) and no rows; record the arm while it "
            "moves"
        )
    return Dialect(
        separator=separator,
        decimal="," if separator == ";" and any("," in field for row in rows for field in row) else ".",
        names=names,
        has_header=has_header,
        width=_width(path, names, rows, skipped + first + 1),
        offset=begin + sum(map(len, lines[:first])),
        line=skipped + first + 1,
        size=size,
        rows=rows,
    )


def _refuse_no_text(path: Path, head: bytes) -> None:
    """Refuse other files than text in UTF-8 or a kin of ASCII, with lines that end as everywhere."""
    found = ""
    if head.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")):
        found = "text in UTF-32"
    elif head.startswith((b"\xff\xfe", b"\xfe\xff")):
        found = "text in UTF-16"
    elif head and not head.strip(b"\0"):
        found = "nothing but zero bytes"
    elif b"\0" in head.rstrip(b"\0")[:PEEK_BYTES]:  # at the end they are what a power cut leaves
        found = f"no text (it begins with the bytes {head[:8].hex(' ')})"
    elif b"\r" in head and b"\n" not in head:
        found = "text whose lines end in a carriage return alone"
    if found:
        raise InputError(f"{path}: {found}; expected a table in UTF-8 with lines that end in a line feed; save it so")


def _skip_comments(stream: BinaryIO) -> tuple[int, int]:
    """Go to the last of the comments and blank lines at the start; return how many are before it, and its place."""
    stream.seek(0)
    count, begin, place = -1, 0, 0
    for line in iter(lambda: stream.readline(_HEAD_BYTES), b""):
        if line.strip() and not line.startswith(b"#"):
            break
        count, begin, place = count + 1, place, place + len(line)
    stream.seek(begin)
    return max(count, 0), begin


def separator_of(line: str) -> str:
    """Return what separates the fields of a line."""
    counts = {separator: line.count(separator) for separator in ("\t", ";", ",")}
    if counts[";"] and counts[";"] >= counts["\t"]:
        return ";"  # before the comma, which then is the decimal sign
    best = max(counts, key=lambda separator: counts[separator])
    return best if counts[best] else " "


def _width(path: Path, names: tuple[str, ...], rows: tuple[tuple[str, ...], ...], line: int) -> int:
    """Return the fields per line; a separator at the end of every line, but not of the header, is forgiven."""
    width = len(rows[0])
    trailing = rows[0][-1].strip() == "" if width == len(names) + 1 else names[-1].strip() == ""
    if width != len(names) and not (abs(width - len(names)) == 1 and trailing) and len(rows) > 1:
        raise InputError(
            f"{path}: line {line} has {width} fields, the header has {len(names)}; expected the same number "
            "in every line; repair the header"
        )
    return width if len(rows) > 1 else len(names)
