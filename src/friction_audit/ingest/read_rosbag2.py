"""ROS 2 bags -> Recording: a directory, or one sqlite3 storage file, with or without metadata.yaml."""

import re
import sqlite3
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack, closing
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from friction_audit.errors import InputError
from friction_audit.ingest.first_bytes import starts_with
from friction_audit.ingest.message_stream import (
    Block,
    Connection,
    Damage,
    MessageStream,
    block_of_payloads,
    open_log,
)
from friction_audit.ingest.read_mcap import MAGIC, McapStream
from friction_audit.ingest.read_messages import read_messages, topics_of
from friction_audit.ingest.reader import Reader, ReadOptions, Recording, Topic
from friction_audit.ingest.stated_serial import serial_in

SQLITE_MAGIC = b"SQLite format 3\x00"
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
MESSAGES_PER_BLOCK = 1024  # larger ones wake the garbage collector, which doubles the time
DATABASE_ERRORS = (sqlite3.Error, UnicodeDecodeError)
"""What sqlite3 raises on a broken database; the second where the name of a broken thing is part of the message."""
STORAGE_SUFFIXES = (".db3", ".mcap")
COMPRESSED_SUFFIXES = (".zstd", ".zst")
_NUMBER = re.compile(r"_\d+$")
_MOST_SHOWN = 8
METADATA = "metadata.yaml"
_NOTE = re.compile(r"""^[ \t]+['"]?([\w -]+)['"]?:[ \t]*['"]?([^'"\n]+)""", re.MULTILINE)
_LISTED_FILE = re.compile(r"^\s*-\s*['\"]?(?:.*/)?([^/'\"\s]+\.(?:db3|mcap)(?:\.zstd?)?)['\"]?\s*$", re.MULTILINE)


class Sqlite3Stream:
    """The messages in one sqlite3 storage file."""

    def __init__(self, path: Path) -> None:
        """Read topics, definitions and message counts.

        Raises:
            InputError: If this is no sqlite3 storage of a ROS 2 bag, or it is broken.
        """
        self._path = path
        with open_log(path) as file:
            magic = file.read(len(SQLITE_MAGIC))
        if magic != SQLITE_MAGIC:
            raise InputError(
                f"{path}: {'does not begin as an SQLite file' if magic else 'is empty'}; expected the sqlite3 storage "
                "of a ROS 2 bag; check the file's type and that it was copied whole"
            )
        try:
            with closing(self._connect()) as database:
                self.connections = _read_connections(path, database)
        except DATABASE_ERRORS as error:
            raise self._broken(error) from error

    @property
    def damage(self) -> tuple[Damage, ...]:
        """Nothing: a broken database is refused as a whole, since its order is lost."""
        return ()

    def blocks(self, keys: Collection[int]) -> Iterator[Block]:
        """Yield the messages of some topics, one topic after the other."""
        try:
            with closing(self._connect()) as database:
                for key in keys:
                    cursor = database.execute("SELECT timestamp, data FROM messages WHERE topic_id = ?", (key,))
                    while rows := cursor.fetchmany(MESSAGES_PER_BLOCK):
                        yield self._block(key, rows)
        except DATABASE_ERRORS as error:
            raise self._broken(error) from error

    def _block(self, key: int, rows: Sequence[tuple[int, bytes]]) -> Block:
        try:
            payloads = self._decompressed([payload for _, payload in rows])
            return block_of_payloads(key, [log_time for log_time, _ in rows], payloads)
        except (TypeError, AttributeError, ValueError, OverflowError) as error:
            raise self._broken(f"a message is no pair of a time stamp and bytes ({error})") from error

    def _connect(self) -> sqlite3.Connection:
        """Open without writing anything beside the file, unless a journal of its own must be taken into account."""
        journal = self._path.with_name(f"{self._path.name}-wal")
        immutable = "" if journal.exists() and journal.stat().st_size else "&immutable=1"
        database = sqlite3.connect(f"{self._path.resolve().as_uri()}?mode=ro{immutable}", uri=True)
        database.text_factory = lambda text: text.decode(errors="replace")
        return database

    def _decompressed(self, payloads: Sequence[bytes]) -> Sequence[bytes]:
        """Undo compression by message; no CDR message begins with the four bytes that every zstd frame begins with."""
        if not payloads[0].startswith(ZSTD_MAGIC):
            return payloads
        import zstandard

        decompressor = zstandard.ZstdDecompressor()
        try:
            return [decompressor.decompress(payload) for payload in payloads]
        except zstandard.ZstdError as error:
            raise InputError(
                f"{self._path}: a compressed message is broken ({error}); record or copy it again"
            ) from error

    def _broken(self, error: Exception | str) -> InputError:
        return InputError(
            f"{self._path}: the sqlite3 database cannot be read: {error}; a bag that was cut off can often be saved "
            f"with `sqlite3 {self._path.name} .recover | sqlite3 recovered.db3`"
        )


def _read_connections(path: Path, database: sqlite3.Connection) -> tuple[Connection, ...]:
    tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if missing := {"topics", "messages"} - tables:
        raise InputError(
            f"{path}: no table {' and no table '.join(sorted(missing))}; expected the sqlite3 storage of a ROS 2 bag; "
            f"tables are {', '.join(sorted(tables)) or 'none'}"
        )
    definitions: dict[str, tuple[str, str]] = {}
    if "message_definitions" in tables:
        query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        definitions = {name: (language, text) for name, language, text in database.execute(query)}
    topics = database.execute("SELECT id, name, type, serialization_format FROM topics ORDER BY id").fetchall()
    counts = _count_messages(database, [key for key, *_ in topics])
    connections = []
    for key, topic, typename, encoding in topics:
        language, text = definitions.get(typename, ("", ""))
        connections.append(
            Connection(
                key=key,
                topic=str(topic),
                type=str(typename),
                encoding=str(encoding),
                definition=str(text).encode(),
                definition_format=str(language),
                messages=counts.get(key, 0),
            )
        )
    return tuple(connections)


def _count_messages(database: sqlite3.Connection, keys: Sequence[int]) -> dict[int, int]:
    """Count the messages of each topic; of a single one by the index of time stamps, without reading the messages."""
    if len(keys) == 1:
        return {keys[0]: database.execute("SELECT COUNT(*) FROM messages").fetchone()[0]}
    return dict(database.execute("SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id").fetchall())


class SeveralFiles:
    """The storage files of one bag, one after the other; connections are numbered through."""

    def __init__(self, streams: Sequence[MessageStream]) -> None:
        """Number the connections through and give each type the definition that any of the files has for it."""
        self._streams = streams
        known = {c.type: c for stream in streams for c in stream.connections if c.definition}
        self._place: list[tuple[int, int]] = []
        connections = []
        for index, stream in enumerate(streams):
            for connection in stream.connections:
                source = known.get(connection.type, connection)
                connections.append(
                    replace(
                        connection,
                        key=len(self._place),
                        definition=source.definition,
                        definition_format=source.definition_format,
                    )
                )
                self._place.append((index, connection.key))
        self.connections = tuple(connections)

    @property
    def damage(self) -> tuple[Damage, ...]:
        """What was found broken so far, in any of the files."""
        return tuple(damage for stream in self._streams for damage in stream.damage)

    def blocks(self, keys: Collection[int]) -> Iterator[Block]:
        """Yield the messages of some connections, file by file."""
        for index, stream in enumerate(self._streams):
            numbers = {own: key for key, (file, own) in enumerate(self._place) if file == index and key in keys}
            for block in stream.blocks(list(numbers)) if numbers else ():
                yield Block(numbers[block.key], block.log_time, block.buffer, block.start, block.size)


def _storage_files(path: Path) -> list[Path]:
    """Find the storage files of a bag, in the order of their numbers.

    Raises:
        InputError: If there are none, or metadata.yaml lists files that are not there.
    """
    if not path.is_dir():
        return [path]
    try:
        names = sorted((entry.name for entry in path.iterdir() if _is_storage(entry)), key=_by_number)
        metadata = path / METADATA
        listed = _LISTED_FILE.findall(metadata.read_text(encoding="utf-8")) if metadata.is_file() else []
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; check its permissions") from error
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path / 'metadata.yaml'}: is not text ({error.reason}); remove it to read without"
        ) from error
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
    shown = ", ".join(names[:_MOST_SHOWN]) + (
        f" and {len(names) - _MOST_SHOWN} more" if len(names) > _MOST_SHOWN else ""
    )
    raise InputError(
        f"{path}: {len(names)} storage files that are not parts of one recording ({shown}); expected metadata.yaml or "
        "names such as run_0.db3, run_1.db3; give one of the files"
    )


def _is_storage(path: Path) -> bool:
    name = path.name
    for suffix in COMPRESSED_SUFFIXES:
        name = name.removesuffix(suffix)
    return name.endswith(STORAGE_SUFFIXES)


def _by_number(name: str) -> list[tuple[int, str]]:
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", name)]


def _open(path: Path, stack: ExitStack) -> MessageStream:
    """Open all storage files of a bag; what had to be decompressed is kept until the stack is closed."""
    files = _storage_files(path)
    compressed = [file for file in files if file.suffix in COMPRESSED_SUFFIXES]
    folder = Path(stack.enter_context(TemporaryDirectory())) if compressed else None
    streams = [_open_file(_decompress_file(file, folder) if folder and file in compressed else file) for file in files]
    return streams[0] if len(streams) == 1 else SeveralFiles(streams)


def _open_file(path: Path) -> MessageStream:
    """Open a storage file by what it holds; by its name if it holds neither."""
    is_sqlite = starts_with(path, SQLITE_MAGIC)
    is_mcap = starts_with(path, MAGIC) or (path.suffix == ".mcap" and not is_sqlite)
    return McapStream(path) if is_mcap else Sqlite3Stream(path)


def _decompress_file(path: Path, folder: Path) -> Path:
    import zstandard

    target = folder / path.stem
    try:
        with open_log(path) as packed, target.open("wb") as file:
            zstandard.ZstdDecompressor().copy_stream(packed, file)
    except zstandard.ZstdError as error:
        raise InputError(f"{path}: cannot be decompressed ({error}); copy or record it again") from error
    return target


def _recognises(path: Path) -> bool:
    if not path.is_dir():
        return starts_with(path, SQLITE_MAGIC) or (path.suffix in COMPRESSED_SUFFIXES and _is_storage(path))
    try:
        return any(_is_storage(entry) for entry in path.iterdir())
    except OSError:
        return False


def _read(path: Path, options: ReadOptions) -> Recording:
    with ExitStack() as stack:
        recording = read_messages(path, _open(path, stack), options)
    return replace(recording, serial=serial_in(_custom_data(path / METADATA)))


def _custom_data(metadata: Path) -> dict[str, str]:
    """Return the notes that metadata.yaml carries of its own (``ros2 bag record --custom-data``)."""
    if not metadata.is_file():
        return {}
    _, _, below = metadata.read_text(encoding="utf-8").partition("custom_data:")
    return dict(_NOTE.findall(below))


def _topics(path: Path) -> tuple[Topic, ...]:
    with ExitStack() as stack:
        return topics_of(path, _open(path, stack))


ROSBAG2 = Reader(
    name="rosbag2",
    suffixes=(".db3", ".zstd", ".zst"),
    recognises=_recognises,
    read=_read,
    topics=_topics,
    summary="ROS 2 bag, sqlite3 or MCAP: its directory or one .db3 file, with or without metadata.yaml.",
)
