"""Ways in which files go wrong: of bytes in general, and of each container's own structure."""

import csv
import io
import sqlite3
import struct
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

Draw = np.random.Generator
Damage = Callable[[bytearray, Draw], bytearray]

EXTREMES = [
    struct.pack(form, value)
    for form, values in {
        "<I": (0, 1, 0x7FFFFFFF, 0xFFFFFFFF, 1 << 24),
        "<Q": (0, 1, 1 << 63, (1 << 64) - 1, 1 << 40),
        "<d": (float("nan"), float("inf"), 1e300, -1e6, 0.0, 1e9),
    }.items()
    for value in values
]
CELLS = ("", "abc", "1e308", "-", "1,5", "NaN", "inf", "-1e6", "0x10", '"', "1e-400", "9" * 400, "300")


def truncated(data: bytearray, draw: Draw) -> bytearray:
    """Cut the end off."""
    return data[: draw.integers(0, len(data))]


def _flipped(data: bytearray, draw: Draw, low: float, high: float) -> bytearray:
    for place in draw.integers(int(low * len(data)), max(int(high * len(data)), 1), size=draw.integers(1, 9)):
        data[min(place, len(data) - 1)] ^= 1 << draw.integers(8)
    return data


def flipped(data: bytearray, draw: Draw) -> bytearray:
    """Flip bits anywhere."""
    return _flipped(data, draw, 0.0, 1.0)


def flipped_head(data: bytearray, draw: Draw) -> bytearray:
    """Flip bits of the header."""
    return _flipped(data, draw, 0.0, 0.02)


def flipped_foot(data: bytearray, draw: Draw) -> bytearray:
    """Flip bits of the footer."""
    return _flipped(data, draw, 0.97, 1.0)


def extreme(data: bytearray, draw: Draw) -> bytearray:
    """Write an extreme number somewhere."""
    number = EXTREMES[draw.integers(len(EXTREMES))]
    place = draw.integers(0, max(len(data) - 8, 1))
    data[place : place + len(number)] = number
    return data


def _piece(data: bytearray, draw: Draw) -> tuple[int, int]:
    length = int(min(2 ** draw.uniform(0, 13), len(data)))
    start = int(draw.integers(0, len(data) - length + 1))
    return start, start + length


def zeroed(data: bytearray, draw: Draw) -> bytearray:
    """Set a block to zero, as a lost disk block is."""
    start, stop = _piece(data, draw)
    data[start:stop] = bytes(stop - start)
    return data


def lost(data: bytearray, draw: Draw) -> bytearray:
    """Lose a piece."""
    start, stop = _piece(data, draw)
    del data[start:stop]
    return data


def doubled(data: bytearray, draw: Draw) -> bytearray:
    """Write a piece twice."""
    start, stop = _piece(data, draw)
    data[start:start] = data[start:stop]
    return data


def moved(data: bytearray, draw: Draw) -> bytearray:
    """Write a piece elsewhere."""
    start, stop = _piece(data, draw)
    piece = data[start:stop]
    del data[start:stop]
    place = draw.integers(0, len(data) + 1)
    data[place:place] = piece
    return data


ANY: tuple[Damage, ...] = (truncated, flipped, flipped_head, flipped_foot, extreme, zeroed, lost, doubled, moved)


def csv_cell(data: bytearray, draw: Draw) -> bytearray:
    """Put something else into one to three cells."""
    rows = list(csv.reader(io.StringIO(data.decode())))
    for _ in range(draw.integers(1, 4)):
        row = rows[draw.integers(len(rows))]
        if row:
            row[draw.integers(len(row))] = CELLS[draw.integers(len(CELLS))]
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return bytearray(text.getvalue().encode())


def csv_line(data: bytearray, draw: Draw) -> bytearray:
    """Lose, double, cut or swap lines."""
    lines = bytes(data).split(b"\n")
    place, other = (int(i) for i in draw.integers(0, len(lines), size=2))
    kind = draw.integers(4)
    if kind == 0:
        del lines[place : place + int(draw.integers(1, 50))]
    elif kind == 1:
        lines[other:other] = lines[place : place + int(draw.integers(1, 50))]
    elif kind == 2:
        lines[place] = lines[place][: draw.integers(0, len(lines[place]) + 1)]
    else:
        lines[place], lines[other] = lines[other], lines[place]
    return bytearray(b"\n".join(lines))


def npz_member(data: bytearray, draw: Draw) -> bytearray:
    """Damage one array inside of the archive, its check sum made right."""
    with zipfile.ZipFile(io.BytesIO(bytes(data))) as archive:
        entries = {name: bytearray(archive.read(name)) for name in archive.namelist()}
    name = sorted(entries)[draw.integers(len(entries))]
    entry = entries[name]
    kind = draw.integers(5)
    if kind == 0:
        del entries[name]
    elif kind == 1:
        entries[name] = _flipped(entry, draw, 0.0, min(128 / len(entry), 1.0))
    elif kind == 2:
        entries[name] = _flipped(entry, draw, 0.0, 1.0)
    elif kind == 3:
        shape = (b"(2147483648,)", b"(0,)", b"(-1,)", b"(3, 3, 3)", b"(9999999, 9999)")[draw.integers(5)]
        begin, end = entry.index(b"("), entry.index(b")")
        entries[name] = entry[:begin] + shape.ljust(end + 1 - begin) + entry[end + 1 :]
    else:
        entries[name] = truncated(entry, draw)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for key, value in entries.items():
            archive.writestr(key, bytes(value))
    return bytearray(out.getvalue())


def _mcap_records(data: bytes) -> Iterator[tuple[int, int]]:
    place = 8
    while place + 9 <= len(data):
        length = struct.unpack_from("<Q", data, place + 1)[0]
        yield place, place + 9 + length
        place += 9 + length


def mcap_record(data: bytearray, draw: Draw) -> bytearray:
    """Damage the opcode, the length or the order of records."""
    records = [(start, stop) for start, stop in _mcap_records(bytes(data)) if stop <= len(data)]
    if not records:
        return flipped(data, draw)
    start, stop = records[draw.integers(len(records))]
    kind = draw.integers(4)
    if kind == 0:
        data[start] = int(draw.integers(0, 256))
    elif kind == 1:
        data[start + 1 : start + 9] = struct.pack("<Q", int(2 ** draw.uniform(0, 63)))
    elif kind == 2:
        del data[start:stop]
    else:
        other = records[draw.integers(len(records))][0]
        data[other:other] = data[start:stop]
    return data


def rosbag1_record(data: bytearray, draw: Draw) -> bytearray:
    """Damage the claimed length of a header or of a record's data."""
    places, place = [], 13
    while place + 4 <= len(data):
        head = struct.unpack_from("<I", data, place)[0]
        if place + 8 + head > len(data):
            break
        body = struct.unpack_from("<I", data, place + 4 + head)[0]
        places += [place, place + 4 + head]
        place += 8 + head + body
    where = places[draw.integers(len(places))] if places else 13
    data[where : where + 4] = struct.pack("<I", int(2 ** draw.uniform(0, 32)) & 0xFFFFFFFF)
    return data


def sqlite_rows(path: Path, draw: Draw) -> None:
    """Change, shorten or delete messages, times and tables of a bag."""
    with sqlite3.connect(path) as base:
        count = base.execute("SELECT count(*) FROM messages").fetchone()[0]
        first = int(draw.integers(1, max(count, 2)))
        last = first + int(draw.integers(1, 50))
        commands = (
            "DELETE FROM messages WHERE id BETWEEN ? AND ?",
            "UPDATE messages SET data = x'' WHERE id BETWEEN ? AND ?",
            "UPDATE messages SET data = 'text' WHERE id BETWEEN ? AND ?",
            "UPDATE messages SET data = substr(data, 1, length(data) / 2) WHERE id BETWEEN ? AND ?",
            "UPDATE messages SET data = zeroblob(length(data)) WHERE id BETWEEN ? AND ?",
            "UPDATE messages SET timestamp = 'soon' WHERE id BETWEEN ? AND ?",
            "UPDATE messages SET timestamp = timestamp + 1000000000000 WHERE id BETWEEN ? AND ?",
            "UPDATE messages SET topic_id = 99 WHERE id BETWEEN ? AND ?",
        )
        base.execute(commands[draw.integers(len(commands))], (first, last))
    base.close()


OWN: dict[str, tuple[Damage, ...]] = {
    "csv": (csv_cell, csv_line),
    "npz": (npz_member,),
    "mcap": (mcap_record,),
    "bag": (rosbag1_record,),
}
"""Container -> damages of its own structure; those of sqlite3 bags work on the file."""


def damage(path: Path, draw: Draw) -> str:
    """Damage a file in place; return the name of what was done."""
    kind = path.suffix[1:]
    own = OWN.get(kind, ())
    if kind == "db3" and draw.random() < 0.3:
        sqlite_rows(path, draw)
        return sqlite_rows.__name__
    # A third of the damages are those that only this container can have.
    choice = own if own and draw.random() < 0.33 else ANY
    chosen = choice[draw.integers(len(choice))]
    path.write_bytes(bytes(chosen(bytearray(path.read_bytes()), draw)))
    return chosen.__name__
