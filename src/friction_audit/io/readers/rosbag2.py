"""ROS 2 bags -> Recording: a directory, or one sqlite3 storage file, with or without metadata.yaml."""

import re
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from friction_audit.errors import InputError
from friction_audit.io.files import METADATA, STORAGES, starts_with
from friction_audit.io.readers.mcap import MAGIC, McapStream
from friction_audit.io.readers.message_stream import MOST_TIMES_PACKED, Block, Damage, MessageStream, Window, bound_of
from friction_audit.io.readers.messages import read_messages, topics_of
from friction_audit.io.readers.rosbag2_sqlite import SQLITE_MAGIC, Sqlite3Stream, copy_of_cut

_COMPRESSED_SUFFIXES = (".zstd", ".zst")
_NUMBER = re.compile(r"_\d+$")
_BLANK = re.compile(r"\s")
_MOST_SHOWN = 8
_TOPICS = "topics_with_message_count:"
_COUNT_DIGITS = 19
_COPIED_BYTES = 1 << 20
_LARGEST_METADATA = 16 << 20  # recorders write some hundred bytes for each topic [byte]


class Rosbag2Stream(MessageStream):
    """The storage files of one bag, one after the other; connections are numbered through."""

    def __init__(self, path: Path, streams: Sequence[MessageStream], metadata: Sequence[str]) -> None:
        """Give each type the definition that any of the files has for it."""
        super().__init__(path)
        self._streams, self.stated, self.notes = streams, _stated_counts(metadata), _custom_data(metadata)
        own = [(stream, connection) for stream in streams for connection in stream.connections]
        known = {c.type: c for _, c in own if c.definition}
        self._places = [(stream, c.key) for stream, c in own]
        self.connections = tuple(
            replace(
                c,
                key=key,
                definition=known.get(c.type, c).definition,
                definition_format=known.get(c.type, c).definition_format,
            )
            for key, (_, c) in enumerate(own)
        )

    @property
    def damage(self) -> tuple[Damage, ...]:
        """What was found broken so far, in any of the files."""
        return tuple(damage for stream in self._streams for damage in stream.damage)

    def blocks(self, keys: Collection[int], window: Window | None = None) -> Iterator[Block]:
        """Yield the messages of some connections, file by file."""
        for stream in self._streams:
            numbers = {own: key for key, (place, own) in enumerate(self._places) if place is stream and key in keys}
            for block in stream.blocks(list(numbers), window) if numbers else ():
                yield replace(block, key=numbers[block.key])


@contextmanager
def _opened(path: Path) -> Iterator[MessageStream]:
    """Open all storage files of a bag; what had to be decompressed is kept as long."""
    with ExitStack() as stack:
        metadata, files = _metadata(path), _storage_files(path)
        compressed = [file for file in files if file.suffix in _COMPRESSED_SUFFIXES]
        folder = Path(stack.enter_context(TemporaryDirectory())) if compressed else None
        streams, is_lasting = list[MessageStream](), True
        for packed in files:  # by what it holds; by its name if it holds neither
            file = _decompress_file(packed, folder) if folder and packed in compressed else packed
            is_sqlite = starts_with(file, SQLITE_MAGIC)
            is_mcap = starts_with(file, MAGIC) or (file.suffix == ".mcap" and not is_sqlite)
            copy = None if is_mcap else copy_of_cut(file, stack)
            streams.append(McapStream(file) if is_mcap else Sqlite3Stream(file, copy))
            is_lasting &= file is packed and copy is None
        stream = Rosbag2Stream(path, streams, metadata)
        stream.is_lasting = is_lasting
        yield stream


def _storage_files(path: Path) -> list[Path]:
    """Find the storage files of a bag, in the order of their numbers."""
    if not path.is_dir():
        return [path]
    try:
        names = sorted((entry.name for entry in path.iterdir() if _is_storage(entry)), key=_by_number)
        stated = (line.strip()[1:].strip(" \t'\"") for line in _metadata(path) if line.lstrip().startswith("-"))
        listed = [Path(text).name for text in stated if text and not _BLANK.search(text) and _is_storage(Path(text))]
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; check its permissions") from error
    if not names:
        raise InputError(f"{path}: no storage file; expected *.db3 or *.mcap in the directory of a ROS 2 bag")
    if missing := [name for name in listed if name not in names]:
        raise InputError(
            f"{path}: metadata.yaml lists {', '.join(missing)}, not to be found; "
            f"copy the whole bag, or give one of its files alone ({', '.join(names)})"
        )
    if not listed:
        _refuse_several_recordings(path, names)
    return [path / name for name in names]


def _refuse_several_recordings(path: Path, names: Sequence[str]) -> None:
    """Without metadata.yaml, files are one recording if their names differ in the number at the end alone."""
    stems = {_NUMBER.sub("", name.partition(".")[0]) for name in names}
    numbered = all(_NUMBER.search(name.partition(".")[0]) for name in names)
    if len(names) == 1 or (len(stems) == 1 and numbered):
        return
    more = f" and {len(names) - _MOST_SHOWN} more" if len(names) > _MOST_SHOWN else ""
    shown = ", ".join(names[:_MOST_SHOWN]) + more
    raise InputError(
        f"{path}: {len(names)} storage files that are not parts of one recording ({shown}); expected metadata.yaml or "
        "names such as run_0.db3, run_1.db3; give one of the files"
    )


def _is_storage(path: Path) -> bool:
    name = path.name
    for suffix in _COMPRESSED_SUFFIXES:
        name = name.removesuffix(suffix)
    return name.endswith(STORAGES)


def _by_number(name: str) -> list[tuple[int, str]]:
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", name)]


def _decompress_file(path: Path, folder: Path) -> Path:
    import zstandard

    target = folder / path.stem
    left = bound_of(path.stat().st_size)
    try:
        with (
            path.open("rb") as packed,
            target.open("wb") as file,
            zstandard.ZstdDecompressor().stream_reader(packed, read_across_frames=True) as stream,
        ):
            while block := stream.read(_COPIED_BYTES):
                left -= file.write(block)
                if left < 0:
                    raise InputError(
                        f"{path}: holds more than {file.tell()} bytes when decompressed; expected at most "
                        f"{MOST_TIMES_PACKED} times its size, which no recording exceeds; record it again"
                    )
    except (zstandard.ZstdError, OSError) as error:
        raise InputError(
            f"{path}: cannot be decompressed into {folder} ({error}); copy or record it again, or, if there is no "
            "room, set TMPDIR to a larger place"
        ) from error
    return target


def recognises(path: Path) -> bool:
    """Return True for a database, a compressed storage file, or a folder with one."""
    if not path.is_dir():
        return starts_with(path, SQLITE_MAGIC) or (path.suffix in _COMPRESSED_SUFFIXES and _is_storage(path))
    try:
        return any(_is_storage(entry) for entry in path.iterdir())
    except OSError:
        return False


read, topics = partial(read_messages, _opened), partial(topics_of, _opened)


def _metadata(folder: Path) -> list[str]:
    """Return the lines of metadata.yaml; none where there is none."""
    path = folder / METADATA
    if not path.is_file():
        return []
    if path.stat().st_size > _LARGEST_METADATA:
        raise InputError(f"{path}: holds more than {_LARGEST_METADATA} bytes; remove it to read without")
    try:
        return path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not text ({error.reason}); remove it to read without") from error


def _stated_counts(lines: Sequence[str]) -> dict[str, int]:
    """Return the number of messages of each topic that metadata.yaml states; recorders differ in the order of keys."""
    begin = next((place for place, line in enumerate(lines, 1) if line.strip() == _TOPICS), len(lines))
    counts: dict[str, int] = {}
    item: dict[str, str] = {}
    depth: int | None = None
    for line in lines[begin:]:
        text, indent = line.strip(), len(line) - len(line.lstrip(" "))
        depth = indent if depth is None else depth
        if indent < depth or (indent == depth and not text.startswith("-")):
            break
        item = {} if indent == depth else item
        name, _, value = text.lstrip("- ").partition(":")
        item.setdefault(name, value.strip(" \t'\""))
        count = item.get("message_count", "")
        if "name" in item and count.isdecimal() and len(count) < _COUNT_DIGITS:
            counts[item["name"]] = int(count)
    return counts


def _custom_data(lines: Sequence[str]) -> dict[str, str]:
    """Return the notes that metadata.yaml carries of its own (``ros2 bag record --custom-data``)."""
    begin = next((number for number, line in enumerate(lines, 1) if "custom_data:" in line), len(lines))
    notes = (line.partition(":") for line in lines[begin:] if line[:1] in (" ", "\t"))
    return {name.strip(" \t'\""): value.strip(" \t'\"") for name, _, value in notes}
