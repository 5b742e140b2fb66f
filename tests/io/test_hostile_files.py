"""Whatever the bytes of a file are, reading it gives a log or an error in words, never anything else.

Bags made to take all memory, all time or the stack are refused, or read without what is hostile in them.
"""

import bz2
import io
import json
import struct
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import lz4.frame  # type: ignore[import-untyped]
import numpy as np
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings, strategies as st
from mcap.writer import CompressionType

from friction_audit.errors import FrictionAuditError
from friction_audit.io.readers import list_topics, read_log
from tests.io import bag_writing as bags
from tests.io.synthetic_recordings import motion, refused, tidy_frame
from tests.io.test_rosbag2 import edited, execute

BOMB_BYTES = 40 << 20  # in some kB
ZSTD_BOMB = zstandard.ZstdCompressor(level=1).compress(bytes(BOMB_BYTES))
LZ4_BOMB = lz4.frame.compress(bytes(BOMB_BYTES), store_size=False)
KIND = "foxglove.JointStates"


def mcap_chunk(path: Path, compression: bytes, packed: bytes, claimed: int) -> Path:
    """A sound file into which one chunk is put before the first, and whose summary is gone."""
    whole = bags.write(path, bags.samples(20)).read_bytes()
    head = struct.pack("<QQQI", 0, 0, claimed, 0) + struct.pack("<I", len(compression)) + compression
    content = head + struct.pack("<Q", len(packed)) + packed
    chunk = struct.pack("<BQ", 6, len(content)) + content
    begin = 8 + 9 + struct.unpack_from("<Q", whole, 9)[0]
    path.write_bytes(whole[:begin] + chunk + whole[begin:])
    return path


def bag_chunk(path: Path, compression: bytes, packed: bytes, claimed: int) -> Path:
    """A sound bag with one more chunk at its end."""
    whole = bags.write(path, bags.samples(20)).read_bytes()
    fields = (b"op=\x05", b"compression=" + compression, b"size=" + struct.pack("<I", claimed))
    header = b"".join(struct.pack("<I", len(field)) + field for field in fields)
    path.write_bytes(whole + struct.pack("<I", len(header)) + header + struct.pack("<I", len(packed)) + packed)
    return path


CHUNKS: dict[str, Callable[[Path], Path]] = {
    "mcap that claims 100 bytes": lambda f: mcap_chunk(f / "a.mcap", b"zstd", ZSTD_BOMB, 100),
    "mcap that tells the truth": lambda f: mcap_chunk(f / "a.mcap", b"zstd", ZSTD_BOMB, BOMB_BYTES),
    "mcap lz4": lambda f: mcap_chunk(f / "a.mcap", b"lz4", LZ4_BOMB, 1 << 60),
    "bag bz2": lambda f: bag_chunk(f / "a.bag", b"bz2", bz2.compress(bytes(24 << 20)), 24 << 20),
    "bag lz4": lambda f: bag_chunk(f / "a.bag", b"lz4", LZ4_BOMB, 1000),
}


@pytest.mark.parametrize("make", CHUNKS.values(), ids=CHUNKS.keys())
def test_chunk_that_is_a_bomb_is_left_out(tmp_path: Path, make: Callable[[Path], Path]) -> None:
    recording = bags.read(make(tmp_path))
    assert len(recording.t) == 20
    assert any("decompressed" in finding.message and finding.damaged for finding in recording.findings)


def test_message_that_is_a_bomb_is_left_out(tmp_path: Path) -> None:
    bag, _ = edited(tmp_path, 20, ("UPDATE messages SET data = ? WHERE id = 7", (ZSTD_BOMB,)))
    assert len(bags.read(bag).t) == 19


def test_message_that_an_expression_makes_is_refused(tmp_path: Path) -> None:
    rows = [("INSERT INTO messages VALUES (?, 1, ?)", (row, bags.stamp_ns(row))) for row in range(12)]
    commands = (
        "CREATE TABLE topics (id INTEGER PRIMARY KEY, name, type, serialization_format)",
        "INSERT INTO topics VALUES (1, '/joint_states', 'sensor_msgs/msg/JointState', 'cdr')",
        "CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id, timestamp, data BLOB AS (zeroblob(900000000)))",
    )
    refused("a.db3: ", bags.read, execute(tmp_path / "a.db3", *((one,) for one in commands), *rows))


def test_bag_that_is_a_bomb_is_refused_and_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_audit.io.readers.message_stream.MOST_TIMES_PACKED", 100)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "room"))
    (tmp_path / "room").mkdir()
    path = tmp_path / "a.db3.zstd"
    path.write_bytes(ZSTD_BOMB)
    refused("decompressed", bags.read, path)
    assert not list((tmp_path / "room").iterdir())


def states(joints: int = 2, **other: Any) -> dict[str, Any]:
    rows = [{"name": f"j{joint}", "position": 0.1, "velocity": 0.2, "effort": 0.3} for joint in range(joints)]
    return {"timestamp": {"sec": 1, "nsec": 0}, "joints": rows, **other}


def json_log(folder: Path, *bad: tuple[int, bytes], count: int = 40) -> Path:
    """JSON messages, some replaced."""
    good = [{**states(), "timestamp": {"sec": 1, "nsec": index * bags.STEP_NS}} for index in range(count)]
    payloads = [json.dumps(message).encode() for message in good]
    for index, payload in bad:
        payloads[index] = payload
    stream = [(bags.stamp_ns(index), payload) for index, payload in enumerate(payloads)]
    return bags.write_payloads(folder / "a.mcap", [("/joints", KIND, stream)], {KIND: b"{}"}, "json", "jsonschema")


@pytest.mark.parametrize("place", [0, 30])
@pytest.mark.parametrize(
    "payload",
    [
        b"[" * 5000,
        b"null",
        json.dumps(states()).replace("0.1", "1" + "0" * 400).encode(),
        json.dumps(states(timestamp={"sec": 10**25, "nsec": 0})).encode(),
        json.dumps(states(joints=5000)).encode(),
    ],
    ids=["deep", "null", "no float", "no stamp", "joints"],
)
def test_one_hostile_json_message_is_left_out(tmp_path: Path, payload: bytes, place: int) -> None:
    path = json_log(tmp_path, (place, payload))
    if place == 0 and b"j4999" in payload:
        refused("5000 joints", bags.read, path)
        return
    recording = bags.read(path)
    assert len(recording.t) == 39
    assert payload == b"null" or bags.damage(recording)


HEAD = "float64[] position\nfloat64[] velocity\nfloat64[] effort\n"
SEPARATOR = "=" * 80
SCHEMAS = {
    "contains itself": ("ros2msg", f"{HEAD}sensor_msgs/JointState next\n"),
    "endless arrays": (
        "ros2msg",
        f"{HEAD}p/A[1000] a\n{SEPARATOR}\nMSG: p/A\np/B[1000] b\n{SEPARATOR}\nMSG: p/B\nfloat64 x\n",
    ),
    "modules": ("ros2idl", "module a { " * 3000 + "};" * 3000),
    "parentheses": ("ros2idl", f"module a {{ const long X = {'(' * 3000}1{')' * 3000}; }};"),
}


@pytest.mark.parametrize(("language", "schema"), SCHEMAS.values(), ids=SCHEMAS.keys())
def test_definition_without_end_is_refused(tmp_path: Path, language: str, schema: str) -> None:
    stream = [("/joint_states", bags.JOINT_STATE, [(bags.stamp_ns(0), bytes(400))])]
    path = bags.write_payloads(tmp_path / "a.mcap", stream, {bags.JOINT_STATE: schema.encode()}, "cdr", language)
    refused("a.mcap: ", bags.read, path)
    refused("definition", bags.read, path, topic="/joint_states")


@pytest.mark.parametrize("text", ["\n" * 400_000, "custom_data:\n" + " " * 1_000_000, "- " + "a/" * 400_000])
def test_long_metadata_takes_no_time(tmp_path: Path, text: str) -> None:
    bag = bags.write(tmp_path / "bag", bags.samples(20))
    with (bag / "metadata.yaml").open("a") as file:
        file.write(text)
    begin = time.perf_counter()
    assert len(bags.read(bag).t) == 20
    assert time.perf_counter() - begin < 2.0


@pytest.mark.parametrize("chunked", [True, False])
def test_messages_that_the_statistics_count_are_missed(tmp_path: Path, chunked: bool) -> None:
    store = bags.ros2_store()
    plain: dict[str, Any] = {"compression": CompressionType.NONE, "enable_crcs": False}
    path = bags.write(tmp_path / "a.mcap", bags.samples(60), use_chunking=chunked, **plain)
    content = bytearray(path.read_bytes())
    record = struct.pack(
        "<BQ", 5, 22 + len(store.serialize_cdr(bags.joint_states(store, bags.samples(1))[2][0][1], bags.JOINT_STATE))
    )
    at = content.find(record, content.find(record) + 1)
    content[at] = 0x85
    path.write_bytes(content)
    log = read_log(path)
    assert len(log.t) == 59
    assert [(f.code, f.amount) for f in log.source.findings if f.damaged] == [("missing_messages", 1.0)]


def test_messages_that_the_index_of_a_bag_counts_are_missed(tmp_path: Path) -> None:
    store = bags.ros1_store()
    path = bags.write(
        tmp_path / "a.bag", [bags.joint_states(store, bags.samples(60), topic) for topic in ("/joint_states", "/other")]
    )
    content = path.read_bytes()
    first = content.find(b"conn=\x00\x00\x00\x00", content.find(b"op=\x02") - 40)
    path.write_bytes(content[:first] + b"conn=\x01\x00\x00\x00" + content[first + 9 :])
    recording = bags.read(path, topic="/joint_states")
    assert len(recording.t) == 59
    assert [(f.code, f.amount) for f in bags.damage(recording)] == [("missing_messages", 1.0)]


SAMPLES = 50


def npz() -> bytes:
    np.savez_compressed(stream := io.BytesIO(), **motion(SAMPLES))  # type: ignore[arg-type]
    return stream.getvalue()


def bag(name: str, **options: Any) -> bytes:
    with TemporaryDirectory() as folder:
        path = bags.write(Path(folder) / name, bags.samples(20), **options)
        return (next(path.glob("*.db3")) if path.is_dir() else path).read_bytes()


FILES: dict[str, Callable[[], bytes]] = {
    "run.csv": lambda: tidy_frame(SAMPLES).to_csv(index=False).encode(),
    "run.parquet": lambda: tidy_frame(SAMPLES).to_parquet(),
    "run.npz": npz,
    "run.bag": lambda: bag("run.bag"),
    "chunks.mcap": lambda: bag("run.mcap", enable_crcs=False, chunk_size=2048),
    "loose.mcap": lambda: bag("run.mcap", use_chunking=False),
    "run.db3": lambda: bag("bag"),
}
whole = cache(lambda name: FILES[name]())


@pytest.mark.parametrize("name", FILES)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damage_is_an_error_in_words(tmp_path: Path, name: str, data: st.DataObject) -> None:
    content = bytearray(whole(name))
    place = data.draw(st.integers(0, len(content) - 1))
    damage = data.draw(st.one_of(st.just(None), st.binary(min_size=1, max_size=50)))
    if damage is None:
        del content[place:]
    else:
        content[place : place + len(damage)] = damage
    (tmp_path / name).write_bytes(content)
    with suppress(FrictionAuditError):
        assert len(read_log(tmp_path / name).t) <= SAMPLES
    with suppress(FrictionAuditError):
        list_topics(tmp_path / name)
