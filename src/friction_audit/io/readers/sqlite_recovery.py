"""SQLite files that are cut off: a copy that SQLite opens, with the tree of the messages' table made anew.

For the layout of pages and records see https://www.sqlite.org/fileformat2.html.
"""

import re
import shutil
import struct
from contextlib import ExitStack
from functools import reduce
from io import SEEK_END
from itertools import count, pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import BinaryIO

from friction_audit.errors import InputError
from friction_audit.io.readers.message_stream import open_log

SQLITE_MAGIC = b"SQLite format 3\x00"
HEADER_BYTES, LARGEST_PAGE = 100, 65_536
_PAGES = slice(28, 32)
_LOCK_BYTE = 1 << 30  # its page is never used
_VARINT = rb"[\x80-\xff]{0,7}[\0-\x7f]"
# Length and id of a message, length of its header, type of the id, of topic_id and timestamp, and of the data.
_MESSAGE = re.compile(_VARINT + b"(" + _VARINT + rb")[\x05-\x0c]\0[\1-\6\x08\x09]{2}" + _VARINT, re.DOTALL)


def stated_bytes(header: bytes) -> int:
    """Return how long an SQLite file is by its header, 0 if the header does not say."""
    page = int.from_bytes(header[16:18], "big")
    stated = len(header) == HEADER_BYTES and header[24:28] == header[92:96]
    return (LARGEST_PAGE if page == 1 else page) * int.from_bytes(header[_PAGES], "big") if stated else 0


def copy_of_cut(path: Path, stack: ExitStack) -> Path | None:
    """Return a copy of a database that is cut off, its header corrected; None if whole.

    SQLite refuses a file that is shorter than its header says. In the copy it refuses the pages that are missing, and
    reads the others.
    """
    with open_log(path) as file:
        header = file.read(HEADER_BYTES)
    size, stated = path.stat().st_size, stated_bytes(header)
    if not header.startswith(SQLITE_MAGIC) or size >= stated:
        return None
    page = stated // int.from_bytes(header[_PAGES], "big")
    copy = Path(stack.enter_context(TemporaryDirectory())) / path.name
    try:
        shutil.copyfile(path, copy)
        with copy.open("r+b") as file:
            file.truncate(size // page * page)
            file.seek(_PAGES.start)
            file.write(bytes(4))  # SQLite then goes by the size of the file
    except OSError as error:
        raise InputError(
            f"{path}: is cut off, and there is no room in {copy.parent} for the copy from which it is saved "
            f"({error.strerror}); set TMPDIR to a larger place"
        ) from error
    return copy


def rebuild_tree(file: BinaryIO, header: bytes, root: int) -> None:
    """Write the interior pages of the table of messages anew, over those of its leaf pages that are there.

    SQLite begins an interior page when there are hundreds of leaf pages already, so that it may lie after the cut.
    """
    size = stated_bytes(header) // int.from_bytes(header[_PAGES], "big")
    pages = file.seek(0, SEEK_END) // size
    usable = size - header[20]
    most = (usable - 12) // (12 + 2)  # a header, and for each cell its place of two bytes
    level = _leaves(file, size, pages, root, int.from_bytes(header[32:36], "big"))
    spare = (number for number in count(pages + 1) if number != _LOCK_BYTE // size + 1)
    while len(level) > 1:
        groups, parents = -(-len(level) // most), []
        for begin, end in pairwise([len(level) * group // groups for group in range(groups + 1)]):
            *left, (last, right) = level[begin:end]
            keys = ([key >> shift & 0x7F | (shift > 0) << 7 for shift in range(49, -1, -7)] for key, _ in left)
            cells = b"".join(struct.pack(">I8B", child, *key) for (_, child), key in zip(left, keys, strict=True))
            start = usable - len(cells)
            head = struct.pack(f">BHHHBI{len(left)}H", 5, 0, len(left), start, 0, right, *range(start, usable, 12))
            parents.append((last, root if groups == 1 else next(spare)))
            file.seek((parents[-1][1] - 1) * size)
            file.write((head.ljust(start, b"\0") + cells).ljust(size, b"\0"))
        level = parents


def _leaves(file: BinaryIO, size: int, pages: int, root: int, trunk: int) -> list[tuple[int, int]]:
    """Return the last id and the number of each leaf page of the table of messages, unless the root is one."""

    def page(number: int) -> bytes:
        file.seek((number - 1) * size)
        return file.read(size)

    if not 1 < root <= pages or _ids_on(page(root)):
        return []
    free: set[int] = set()
    while 0 < trunk <= pages and trunk not in free:  # the list of free pages, which may hold deleted messages
        free.add(trunk)
        trunk, listed, *numbers = struct.unpack(f">{size // 4}I", page(trunk))
        free.update(number for number in numbers[:listed] if number <= pages)
    found = ((*ids, number) for number in range(1, pages + 1) if number not in free and (ids := _ids_on(page(number))))
    leaves = [(-1, 0)]
    for last, first, number in sorted(found):  # by their last id, so that a page with wrong ids displaces one at most
        if first > leaves[-1][0]:
            leaves.append((last, number))
    return leaves[1:]


def _ids_on(page: bytes) -> tuple[int, int] | None:
    """Return the last and the first id on a leaf page of messages; None if it is another, or a cell is no message."""
    places = page[8 : 8 + 2 * int.from_bytes(page[3:5], "big")] if page.startswith(b"\x0d") else b""
    cells = [_MESSAGE.match(page, place) for (place,) in struct.iter_unpack(">H", places)]
    ids = [reduce(lambda number, byte: number << 7 | byte & 0x7F, cell[1], 0) for cell in cells if cell]
    sound = 0 < len(ids) == len(cells) and all(first < second for first, second in pairwise(ids))
    return (ids[-1], ids[0]) if sound else None
