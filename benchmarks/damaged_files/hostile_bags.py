"""Hostile bags: bombs, claims, deep nesting in MCAP files, ROS 1 bags and ROS 2 bags."""

import bz2
import io
import json
import sqlite3
import struct
import zlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import lz4.frame  # type: ignore[import-untyped]
import zstandard

from benchmarks.damaged_files.case import REFUSED, Case, estimate, good, late, written
from benchmarks.damaged_files.watched import GIGABYTE

ZEROS = 6 * GIGABYTE


def _zstd_zeros(size: int, claim: int | None = None) -> bytes:
    out = io.BytesIO()
    compressor = zstandard.ZstdCompressor(level=3, write_content_size=False)
    with compressor.stream_writer(out, closefd=False) as stream:
        for _ in range(size >> 24):
            stream.write(bytes(1 << 24))
    del claim
    return out.getvalue()


def _mcap(records: Iterator[tuple[int, bytes]]) -> bytes:
    magic = b"\x89MCAP0\r\n"
    body = b"".join(struct.pack("<BQ", code, len(data)) + data for code, data in records)
    return magic + struct.pack("<BQ", 1, 8) + bytes(8) + body


def _text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()


def _mcap_chunk(packed: bytes, claim: int, compression: str) -> bytes:
    head = struct.pack("<QQQI", 0, 1, claim, 0) + _text(compression) + struct.pack("<Q", len(packed))
    return _mcap(iter([(6, head + packed)]))


def _mcap_messages(schema: str, encoding: str, definition: bytes, wire: str, messages: Sequence[bytes]) -> bytes:
    def records() -> Iterator[tuple[int, bytes]]:
        head = struct.pack("<H", 1) + _text(schema) + _text(encoding)
        yield 3, head + struct.pack("<I", len(definition)) + definition
        yield 4, struct.pack("<HH", 1, 1) + _text("/joint_states") + _text(wire) + struct.pack("<I", 0)
        for i, message in enumerate(messages):
            yield 5, struct.pack("<HIQQ", 1, i, i * 10_000_000, i * 10_000_000) + message

    return _mcap(records())


def _mcap_json(*messages: str) -> Callable[[Path], Sequence[str]]:
    good = [
        json.dumps({
            "timestamp": {"sec": i // 100, "nsec": i % 100 * 10_000_000},
            "joints": [{"name": "a", "position": 0.1, "velocity": 0.2, "effort": 0.3}],
        })
        for i in range(400)
    ]  # fmt: skip
    data = [text.encode() for text in (*messages, *good)]
    return written("json.mcap", _mcap_messages("foxglove.JointStates", "jsonschema", b"{}", "json", data))


def _mcap_schema(encoding: str, definition: str) -> Callable[[Path], Sequence[str]]:
    wire = {"ros1msg": "ros1"}.get(encoding, "cdr")
    data = _mcap_messages("sensor_msgs/msg/JointState", encoding, definition.encode(), wire, [bytes(64)] * 400)
    return written("schema.mcap", data)


def _bag_record(header: dict[str, bytes], data: bytes) -> bytes:
    fields = b"".join(struct.pack("<I", len(k) + 1 + len(v)) + k.encode() + b"=" + v for k, v in header.items())
    return struct.pack("<I", len(fields)) + fields + struct.pack("<I", len(data)) + data


def _bag_chunk(packed: bytes, claim: int, compression: str) -> bytes:
    head = {"op": b"\x03", "index_pos": bytes(8), "conn_count": bytes(4), "chunk_count": bytes(4)}
    chunk = {"op": b"\x05", "compression": compression.encode(), "size": struct.pack("<I", claim & 0xFFFFFFFF)}
    return b"#ROSBAG V2.0\n" + _bag_record(head, b" " * 4027) + _bag_record(chunk, packed)


def _bz2_zeros() -> bytes:
    compressor = bz2.BZ2Compressor(9)
    return b"".join([*(compressor.compress(bytes(1 << 24)) for _ in range(ZEROS >> 24)), compressor.flush()])


def _lz4_zeros() -> bytes:
    compressor = lz4.frame.LZ4FrameCompressor()
    parts = [compressor.begin(), *(compressor.compress(bytes(1 << 24)) for _ in range(ZEROS >> 24)), compressor.flush()]
    return b"".join(parts)


def _base(folder: Path, change: Callable[[sqlite3.Connection], object], name: str = "log.db3") -> Sequence[str]:
    sound_log = good(folder, "rosbag2-db3", ".db3")
    path = folder / name
    sound_log.rename(path)
    base = sqlite3.connect(path)
    with base:
        change(base)
    base.close()
    return estimate(path)


def _generated(base: sqlite3.Connection) -> None:
    base.execute("ALTER TABLE messages RENAME TO old")
    base.execute(
        "CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
        "data BLOB AS (zeroblob(900000000)))"
    )
    base.execute("INSERT INTO messages (topic_id, timestamp) SELECT topic_id, timestamp FROM old LIMIT 12")
    base.execute("DROP TABLE old")


def _metadata(text: str) -> Callable[[Path], Sequence[str]]:
    def make(folder: Path) -> Sequence[str]:
        bag = good(folder, "rosbag2-sqlite3", "")
        file = bag / "metadata.yaml"
        file.write_text(file.read_text() + text)
        return estimate(bag)

    return make


def _zstd_file(folder: Path) -> Sequence[str]:
    path = folder / "log.db3.zstd"
    path.write_bytes(_zstd_zeros(ZEROS))
    return estimate(path)


def cases() -> Iterator[Case]:
    """Yield the hostile bags."""
    yield Case(
        "MCAP zstd bomb that claims 100 bytes", late("b.mcap", lambda: _mcap_chunk(_zstd_zeros(ZEROS), 100, "zstd"))
    )
    yield Case(
        "MCAP zstd bomb that claims its size", late("b.mcap", lambda: _mcap_chunk(_zstd_zeros(ZEROS), ZEROS, "zstd"))
    )
    yield Case("MCAP lz4 bomb", late("b.mcap", lambda: _mcap_chunk(_lz4_zeros(), ZEROS, "lz4")))
    yield Case("MCAP claim of 2^62 bytes", written("c.mcap", _mcap_chunk(zlib.compress(b""), 1 << 62, "zstd")))
    for name, text in {
        "deep": "[" * 5000, "huge number": '{"joints": [{"name": "a", "position": 1' + "0" * 400 + "}]}",
        "huge time": '{"timestamp": {"sec": 1' + "0" * 25 + '}, "joints": []}', "null": "null", "5000 digits":
        '{"joints": [{"name": "a", "position": ' + "7" * 5000 + "}]}", "no text": "\xed\xa0\x80",
    }.items():  # fmt: skip
        yield Case(f"MCAP JSON: {name}", _mcap_json(text))
    many = json.dumps(
        {"joints": [{"name": f"j{i}", "position": 1.0, "velocity": 1.0, "effort": 1.0} for i in range(100_000)]}
    )
    yield Case("MCAP JSON of 1e5 joints", _mcap_json(*[many] * 20))
    own = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"
    self = own + "sensor_msgs/JointState again\n" + "=" * 80 + "\nMSG: sensor_msgs/JointState\n" + own
    yield Case("MCAP schema that holds itself", _mcap_schema("ros2msg", self + "sensor_msgs/JointState again\n"))
    yield Case("MCAP ros1 schema that holds itself", _mcap_schema("ros1msg", self + "sensor_msgs/JointState again\n"))
    yield Case("MCAP IDL 3000 modules deep", _mcap_schema("ros2idl", "module a { " * 3000 + "};" * 3000))
    yield Case(
        "MCAP IDL of parentheses", _mcap_schema("ros2idl", "const long a = " + "(" * 3000 + "1" + ")" * 3000 + ";")
    )
    yield Case("ROS 1 bz2 bomb", late("b.bag", lambda: _bag_chunk(_bz2_zeros(), ZEROS, "bz2")))
    yield Case("ROS 1 bz2 bomb that claims 100 bytes", late("b.bag", lambda: _bag_chunk(_bz2_zeros(), 100, "bz2")))
    yield Case("ROS 1 lz4 bomb", late("b.bag", lambda: _bag_chunk(_lz4_zeros(), ZEROS, "lz4")))
    yield Case(
        "ROS 1 header of 4 GB",
        written("h.bag", b"#ROSBAG V2.0\n" + struct.pack("<I", 0xFFFFFFFF) + bytes(99)),
        REFUSED,
    )
    tiny = _bag_record({"op": b"\x09"}, b"")
    yield Case(
        "ROS 1 bag of 1e6 tiny records",
        late("tiny.bag", lambda: _bag_chunk(b"", 0, "none") + tiny * 1_000_000),
    )
    yield Case(
        "sqlite3 message that is a zstd bomb",
        lambda f: _base(f, lambda b: b.execute("UPDATE messages SET data = ? WHERE id = 5", (_zstd_zeros(ZEROS),))),
    )
    yield Case("sqlite3 generated column", lambda f: _base(f, _generated))
    yield Case(
        "sqlite3 view in place of a table",
        lambda f: _base(
            f,
            lambda b: b.executescript(
                "ALTER TABLE messages RENAME TO old; CREATE VIEW messages AS "
                "WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n) "
                "SELECT id, 1 AS topic_id, id AS timestamp, zeroblob(100) AS data FROM n"
            ),
        ),
    )
    yield Case("zstd file of 6 GB of zeros", _zstd_file, REFUSED)
    yield Case("metadata.yaml: 400 000 blank lines", _metadata("\n" * 400_000))
    yield Case("metadata.yaml: 1 MB of blanks", _metadata("  custom_data:\n" + " " * 1_000_000 + "\n"))
    yield Case("metadata.yaml: 1 MB of dashes", _metadata("- " * 500_000))
