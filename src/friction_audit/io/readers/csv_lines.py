"""Text tables before their numbers are parsed: decompressed, their dialect, their lines in blocks."""

import csv
import io
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import chain, pairwise
from pathlib import Path
from statistics import median_low
from typing import Any, NamedTuple

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.files import starts_with
from friction_audit.io.readers.reader import refuse_bomb
from friction_audit.joint_log import Finding

PACKED = {b"\x1f\x8b": "gzip", b"\x28\xb5\x2f\xfd": "zstd"}  # magic bytes -> codec of Arrow
# The longest head holds four lines of 100 000 columns; a file of one endless line is not split as a whole. [byte]
_HEAD_BYTES, _LONGEST_HEAD = 1 << 20, 1 << 23
_BLOCK_BYTES = 8 << 20


def open_table(path: Path) -> io.BufferedReader:
    """Open a text table, decompressed; reading raises InputError if a compressed one is damaged or a bomb."""
    codec = next((codec for magic, codec in PACKED.items() if starts_with(path, magic)), None)
    return io.BufferedReader(_Unpacked(path, codec) if codec else path.open("rb", buffering=0), _HEAD_BYTES)


class _Unpacked(io.RawIOBase):
    """A decompressed file."""

    def __init__(self, path: Path, codec: str) -> None:
        import pyarrow as pa

        self._path, self._codec, self._packed, self._size = path, codec, path.stat().st_size, 0
        self._stream = pa.CompressedInputStream(pa.OSFile(str(path)), codec)

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:  # noqa: ANN401 - what memory can be written to
        try:
            size = int(self._stream.readinto(buffer))
        except OSError as error:
            raise InputError(
                f"{self._path}: the {self._codec} stream breaks off or is damaged ({error}); expected a whole one; "
                f"copy it again, or read the part that there is: `{self._codec} -dc {self._path} > part.csv`"
            ) from error
        self._size += size
        refuse_bomb(self._path, self._size, self._packed)
        return size


_COMMENT = re.compile(r"#+|//+|%(?=[%\s])%*")  # %time begins the header of rostopic echo -p
_FEWEST_LINES = 4
_LOOK = 20
_UNIT = re.compile(r"[\[(]?\s*([a-zA-Z°µ%-][\w°µ%*/^.· -]{0,11}?)?\s*[\])]?")  # a cell of a line of units, or nothing
_USUAL_UNITS = {"", "-", "s", "sec", "rad", "rad/s", "nm", "n m", "n.m", "n*m", "n·m"}  # as if none were given
_PEEK_BYTES = 4096
_MISSING = {"", "na", "n/a", "null", "none", "nan", "-nan", "-nan(ind)", "nan(ind)", "#n/a", "<na>", "-1.#ind",
            "1.#qnan", "-1.#qnan", "1.#ind"}  # fmt: skip


class Dialect(NamedTuple):
    """A text table, and how it is written."""

    path: Path
    separator: str  # ",", ";", tab, or " " for any blanks
    decimal: str  # sign between units and tenths
    names: tuple[str, ...]  # names of the columns as they stand; #1, #2... where the file has no header
    has_header: bool  # True if the file names its columns
    width: int  # fields of a line of numbers
    offset: int  # byte at which the numbers begin
    line: int  # number of the line there, counted from 1
    size: int  # bytes of the file; what a logger appends later is not read
    rows: tuple[tuple[str, ...], ...]  # the fields of the first lines of numbers

    def blocks(self) -> Iterator[tuple[range, bytes, bool]]:
        """Yield (numbers of lines, the lines as a whole, is it the end of the file)."""
        line = self.line
        for block, following in pairwise(chain(self._chunks(), [b""])):
            lines = range(line, line + block.count(b"\n"))
            yield lines, block, not following
            line = lines.stop

    def _chunks(self) -> Iterator[bytes]:
        """Yield whole lines of the values, up to the size that the file had when it was first looked at."""
        with open_table(self.path) as stream:
            stream.read(self.offset)
            left = self.size - self.offset
            while chunk := stream.read(min(_BLOCK_BYTES, left)):
                chunk += stream.readline(left - len(chunk))
                left -= len(chunk)
                yield chunk

    def count_lines(self) -> int:
        """Return the number of rows, blank lines included."""
        count, chunk = 0, b""
        for chunk in self._chunks():
            count += int(np.count_nonzero(np.frombuffer(chunk, dtype=np.uint8) == ord("\n")))
        return count + (chunk[-1:] != b"\n")

    def without_cut_line(self, block: bytes, line: int, kinds: Mapping[int, Any]) -> tuple[bytes, Finding | None]:
        """Leave out a last line that was not finished; NUL bytes are what a power cut leaves."""
        text = block.rstrip(b"\0")
        body = text.rstrip(b"\r\n")
        before, newline, last = body.rpartition(b"\n")
        text_of_last = last.decode(errors="replace")
        fields = split_line(text_of_last, self.separator)
        is_short, found = True, f"{len(fields)} of {self.width} fields"
        if len(fields) == self.width:
            wrong = next((fields[c] for c in kinds if value_of(fields[c], kinds[c], self.decimal) is None), None)
            found = "" if wrong is None else f"{wrong!r} where a number belongs"
            if not found and body == text and newline and self.width - 1 in kinds:
                lines = before.decode(errors="replace").splitlines()[-_LOOK:]
                ends = [len(text.strip().rpartition(self.separator)[2]) for text in lines]
                is_short = len(fields[-1]) < min(ends, default=0)
                found = f"it has no line feed, and {fields[-1].strip()} may lack digits"
        if not found or not is_row(text_of_last):
            return body + b"\n", None
        number = line + before.count(b"\n") + len(newline)
        message = f"line {number}, the last one, {'is' if is_short else 'may be'} cut short ({found}); it is left out"
        return before + newline, Finding("truncated", message, amount=1.0, damaged=is_short)


def is_row(line: str) -> bool:
    """Return True for a line that is neither blank nor a comment, which may also stand between rows and at the end."""
    return bool(line.strip()) and not _COMMENT.match(line)


def value_of(field: str, kind: Any, decimal: str) -> Any:  # noqa: ANN401
    """Return what a field holds, None if it is not what its column holds; NaN where it says that there is no number."""
    text = field.strip()
    if kind is str:
        return text
    if kind is np.int64:
        return int(text) if text.lstrip("+-").isdigit() and abs(int(text)) < 1 << 63 else None
    if text.lower() in _MISSING:
        return math.nan
    try:
        return None if "_" in text else float(text.replace(",", ".") if decimal == "," else text)
    except ValueError:
        return None


def split_line(line: str, separator: str) -> tuple[str, ...]:
    """Split one line into its fields, quotes respected."""
    is_blank = separator == " "
    line = " ".join(line.split()) if is_blank else line.replace("\r", " ")
    try:
        return tuple(next(csv.reader([line], delimiter=separator, skipinitialspace=not is_blank), []))
    except csv.Error:  # a field beyond the module's limit: no quotes are respected there
        return tuple(line.split(separator))


def sniff_csv(path: Path) -> Dialect:
    """Find out how a text table is written, from its first lines; InputError if it holds no line of numbers."""
    skipped, begin, last = 0, 0, b""
    with open_table(path) as stream:
        _refuse_no_text(path, stream.peek(_HEAD_BYTES))
        # The last of the comments and blank lines at the start: numpy.savetxt writes its header as a comment.
        while (line := stream.readline(_HEAD_BYTES)) and not is_row(_decoded(line)):
            skipped, begin, last = skipped + bool(last), begin + len(last), line
        head = last + line + stream.read(_HEAD_BYTES)
        while head.count(b"\n") < _FEWEST_LINES and len(head) < _LONGEST_HEAD and (more := stream.read(_HEAD_BYTES)):
            head += more
        size = path.stat().st_size
        if isinstance(stream.raw, _Unpacked):
            size = begin + len(head) + sum(map(len, iter(partial(stream.read, _BLOCK_BYTES), b"")))
    lines = head.splitlines(keepends=True)
    if begin + len(head) < size and len(lines) > 1:
        del lines[-1]  # which may end in the middle
    texts = [_decoded(line).strip("\r\n") for line in lines]
    start = next((i for i, text in enumerate(texts) if is_row(text)), None)
    if start is None:
        raise InputError(f"{path}: all lines are blank or comments; expected a table with a header")
    start = _below_prologue(texts, start)
    separator = separator_of(texts[start])
    names, has_header, first = _names_and_first(texts, start, separator)
    rows = tuple(split_line(text, separator) for text in texts[first : first + _LOOK] if is_row(text))
    if not rows:
        raise InputError(f"{path}: 0 samples: a header of {len(names)} columns and no rows; record the arm in motion")
    commas = (value_of(field, float, ",") for row in rows for field in row if "," in field and separator != ",")
    return Dialect(
        path=path,
        separator=separator,
        decimal="," if any(number is not None for number in commas) else ".",
        names=names,
        has_header=has_header,
        width=_width(path, names, rows, skipped + first + 1),
        offset=begin + sum(map(len, lines[:first])),
        line=skipped + first + 1,
        size=size,
        rows=rows,
    )


def _decoded(line: bytes) -> str:
    try:
        return line.decode("utf-8-sig")
    except UnicodeDecodeError:  # a degree sign, as older programs write it
        return line.decode("latin-1")


def _below_prologue(texts: Sequence[str], start: int) -> int:
    """Return the line of the header below lines about the recording: the first that is as wide as the last lines."""
    last = [text for text in texts[start:] if is_row(text)][-_LOOK:]
    is_blank = separator_of(texts[start]) == " " and len(last[-1].split()) > 1  # then a comma is the decimal sign
    separator = " " if is_blank else separator_of(last[-1])
    width = median_low(len(split_line(text, separator)) for text in last)
    wide = next((i for i in range(start, len(texts)) if len(split_line(texts[i], separator)) >= width - 1), start)
    is_header = any(value_of(field, float, ",") is None for field in split_line(texts[wide], separator))
    return wide if is_header else start


def _names_and_first(texts: Sequence[str], start: int, separator: str) -> tuple[tuple[str, ...], bool, int]:
    """Return names of the columns, whether they are known, and which is the first line of numbers.

    ``ros2 topic echo --csv`` prints a JointState without a header: stamp, frame, names of joints, three arrays. Units
    that stand in the line below the names are put into these.
    """
    fields = split_line(texts[start], separator)
    words = [value_of(field, float, "." if separator == "," else ",") is None for field in fields]
    joints = words[3:].index(False) if False in words[3:] else 0
    if joints and len(fields) == 3 + 4 * joints and fields[0].isdigit() and fields[1].isdigit():
        arrays = (f"{name}.{joint}" for name in ("name", "position", "velocity", "effort") for joint in range(joints))
        return ("header.stamp.sec", "header.stamp.nanosec", "header.frame_id", *arrays), True, start
    two = (texts[start - 1] if start else "", texts[start])
    above, own = (split_line(t[m.end() :] if (m := _COMMENT.match(t)) else t, separator) for t in two)
    # A comment that names as many columns is the header of a line with numbers, also where that begins with a date.
    is_above = len(above) == len(fields) and not all(words)
    has_header, first = is_above or any(words), start + (any(words) and not is_above)
    names = above if is_above else own if has_header else tuple(f"#{column}" for column in range(1, len(fields) + 1))
    below = [field.strip() for line in texts[first : first + has_header] for field in split_line(line, separator)]
    units = [_UNIT.fullmatch(field) for field in below]
    is_number = any(field and value_of(field, float, ".") is not None for field in below)
    if len(below) != len(names) or is_number or not all(units) or not any(one and one[1] for one in units):
        return names, has_header, first
    named = zip(names, ((one[1] if one else None) or "" for one in units), strict=True)
    names = tuple(name if unit.lower() in _USUAL_UNITS else f"{name.strip()} [{unit}]" for name, unit in named)
    return names, has_header, first + 1


def recognises(path: Path) -> bool:
    """Return True if the file is text whose first line has at least two fields; never raises."""
    try:
        with open_table(path) as stream:
            head = stream.read(_PEEK_BYTES)
    except OSError:
        return False
    except InputError:  # compressed, and damaged: reading it says so
        return True
    text = head.decode("utf-8-sig", errors="ignore")
    line = next((line for line in text.splitlines() if line.strip()), "")
    printable = b"\0" not in head and len(text.encode()) > 0.95 * len(head) - 3
    return printable and not line.lstrip().startswith(("{", "<")) and len(split_line(line, separator_of(line))) > 1


def _refuse_no_text(path: Path, head: bytes) -> None:
    """Refuse other files than text in UTF-8 or a kin of ASCII, with lines that end as everywhere."""
    kinds = {
        "text in UTF-32": head.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")),
        "text in UTF-16": head.startswith((b"\xff\xfe", b"\xfe\xff")),
        "nothing but zero bytes": head and not head.strip(b"\0"),
        # At the end they are what a power cut leaves.
        f"no text (it begins with the bytes {head[:8].hex(' ')})": b"\0" in head.rstrip(b"\0")[:_PEEK_BYTES],
        "text whose lines end in a carriage return alone": b"\r" in head and b"\n" not in head,
    }
    if found := next((kind for kind, is_so in kinds.items() if is_so), ""):
        raise InputError(f"{path}: {found}; expected a table in UTF-8 with lines that end in a line feed; save it so")


def separator_of(line: str) -> str:
    """Return what separates the fields of a line."""
    counts = {separator: line.count(separator) for separator in ("\t", ";", ",")}
    if counts[";"] and counts[";"] >= counts["\t"]:
        return ";"  # before the comma, which then is the decimal sign
    if counts["\t"] and counts["\t"] + 1 >= counts[","]:
        return "\t"  # likewise
    return "," if counts[","] else " "


def _width(path: Path, names: tuple[str, ...], rows: tuple[tuple[str, ...], ...], line: int) -> int:
    """Return the fields per line; a separator at the end of every line, but not of the header, is forgiven."""
    width = len(rows[0])
    trailing = rows[0][-1].strip() == "" if width == len(names) + 1 else names[-1].strip() == ""
    if width != len(names) and not (abs(width - len(names)) == 1 and trailing) and len(rows) > 1:
        raise InputError(f"{path}: line {line} has {width} fields; expected {len(names)} as in the header; repair it")
    return width if len(rows) > 1 else len(names)
