"""ROS 2 bags -> Recording: a directory, or one sqlite3 storage file, with or without metadata.yaml."""

import re
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from friction_audit.errors import InputError
from friction_audit.io.files import COMPRESSED, METADATA, STORAGE_NAMES, starts_with
from friction_audit.io.readers.mcap import McapStream
from friction_audit.io.readers.message_stream import MOST_TIMES_PACKED, Block, MessageStream, Window, bound_of
from friction_audit.io.readers.messages import read_messages, topics_of
from friction_audit.io.readers.rosbag2_sqlite import Sqlite3Stream

_ITEM = re.compile(r"^[ \t]*-[ \t]*['\"]?([^\s'\"]+)['\"]?[ \t]*$", re.MULTILINE)  # of a list, without blanks
_TOPICS = "topics_with_message_count:\n"
_NAME = re.compile(r"^[- ]*name: *['\"]?([^'\"\s]+)", re.MULTILINE)
_COUNT = re.compile(r"^[- ]*message_count: *(\d{1,18}) *$", re.MULTILINE)
_COPIED_BYTES = 1 << 20
_LARGEST_METADATA = 16 << 20  # recorders write some hundred bytes for each topic [byte]


class Rosbag2Stream(MessageStream):
    """The storage files of one bag, one after the other; connections are numbered through."""

    def __init__(self, path: Path, streams: Sequence[MessageStream], metadata: str) -> None:
        """Give each type the definition that any of the files has for it."""
        super().__init__(path)
        listed = metadata.partition(_TOPICS)[2]
        indent = len(listed) - len(listed.lstrip(" "))
        items = re.split(rf"^ {{{indent}}}- ", listed, flags=re.MULTILINE)
        found = ((_NAME.search(item), _COUNT.search(item)) for item in items)  # recorders differ in the order of keys
        self.stated = {name[1]: int(count[1]) for name, count in found if name and count}
        lines = metadata.partition("custom_data:")[2].splitlines()[1:]  # notes of ros2 bag record --custom-data
        pairs = (line.partition(":") for line in lines if line[:1] in (" ", "\t"))
        self.notes = {name.strip(" \t'\""): value.strip(" \t'\"") for name, _, value in pairs}
        self._streams = streams
        for stream in streams:
            self.damage |= stream.damage
            stream.damage = self.damage
        own = [(stream, connection) for stream in streams for connection in stream.connections]
        self._places = [(stream, c.key) for stream, c in own]
        known = {c.type: c.definition for _, c in own if c.definition[1]}
        self.connections = tuple(
            replace(c, key=key, definition=known.get(c.type, c.definition)) for key, (_, c) in enumerate(own)
        )

    def blocks(self, keys: Collection[int], window: Window | None = None) -> Iterator[Block]:
        for stream in self._streams:
            numbers = {own: key for key, (place, own) in enumerate(self._places) if place is stream and key in keys}
            for block in stream.blocks(list(numbers), window) if numbers else ():
                yield replace(block, key=numbers[block.key])


@contextmanager
def _opened(path: Path) -> Iterator[MessageStream]:
    """Open all storage files of a bag; what had to be decompressed is kept as long."""
    with ExitStack() as stack:
        metadata, listed = "", path / METADATA
        if listed.is_file():
            with listed.open("rb") as stated:
                metadata = stated.read(_LARGEST_METADATA).decode(errors="replace")
        files = _storage_files(path, metadata) if path.is_dir() else [path]
        is_packed = any(file.suffix in COMPRESSED for file in files)
        folder = Path(stack.enter_context(TemporaryDirectory()) if is_packed else path)
        streams = list[MessageStream]()
        try:
            for packed in files:  # by what it holds; by its name if it holds neither
                file = _decompress_file(packed, folder) if packed.suffix in COMPRESSED else packed
                is_sqlite = starts_with(file, Sqlite3Stream.magic)
                is_mcap = starts_with(file, McapStream.magic) or (file.suffix == ".mcap" and not is_sqlite)
                streams.append(McapStream(file) if is_mcap else Sqlite3Stream(file))
            stream = Rosbag2Stream(path, streams, metadata)
            stream.is_lasting = not is_packed
            yield stream
        except InputError as error:  # of a decompressed file the name that the user knows
            own = path if path.is_dir() else path.parent
            raise InputError(str(error).replace(f"{folder}/", f"{own}/")) from error


def _storage_files(path: Path, metadata: str) -> list[Path]:
    """Find the storage files of a bag, in the order of their numbers."""
    names = [file.name for file in path.iterdir() if file.name.endswith(STORAGE_NAMES)]
    names.sort(key=lambda one: [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", one)])
    listed = [Path(text).name for text in _ITEM.findall(metadata) if text.endswith(STORAGE_NAMES)]
    if missing := [name for name in listed if name not in names]:
        there = f"copy the whole bag, or give one of its files alone ({', '.join(names)})"
        raise InputError(f"{path}: metadata.yaml lists {', '.join(missing)}, not to be found; {there}")
    return [path / name for name in names]


def _decompress_file(path: Path, folder: Path) -> Path:
    """Decompress a storage file, one that is cut off as far as it goes."""
    import zstandard

    target, left = folder / path.stem, bound_of(path.stat().st_size)
    try:
        with (
            path.open("rb") as packed,
            target.open("wb") as file,
            zstandard.ZstdDecompressor().stream_reader(packed, read_across_frames=True) as stream,
        ):
            while block := stream.read(_COPIED_BYTES):
                left -= file.write(block)
                if left < 0:
                    what = f"decompressed to {file.tell()} bytes; expected at most {MOST_TIMES_PACKED} times its size"
                    raise InputError(f"{path}: {what}; record it again")
    except (zstandard.ZstdError, OSError) as error:
        raise InputError(
            f"{path}: cannot be decompressed into {folder} ({error}); copy it again, or set TMPDIR to a larger place"
        ) from error
    return target


def recognises(path: Path) -> bool:
    """Return True for a database, a compressed storage file, or a folder with one."""
    if not path.is_dir():
        is_packed = path.suffix in COMPRESSED and path.name.endswith(STORAGE_NAMES)
        return is_packed or starts_with(path, Sqlite3Stream.magic)
    return any(entry.name.endswith(STORAGE_NAMES) for entry in path.iterdir())


read, topics = partial(read_messages, _opened), partial(topics_of, _opened)
