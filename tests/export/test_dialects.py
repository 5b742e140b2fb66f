"""What the files look like to others: read with the formats' own libraries, not with the readers of this project."""

import json
import sqlite3
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory as ProtobufDecoder
from mcap_ros1.decoder import DecoderFactory as Ros1Decoder
from mcap_ros2.decoder import DecoderFactory as Ros2Decoder
from numpy.testing import assert_array_equal
from rosbags.highlevel import AnyReader

from friction_audit.io.writers.write_log import write_log
from friction_audit.joint_log import JointLog, Source

T = np.array([0.0, 0.001, 0.0025])
START_S = 1_700_000_000.5
JOINTS = tuple(f"panda_joint{number}" for number in range(1, 8))


@pytest.fixture
def log() -> JointLog:
    numbers = np.arange(21.0).reshape(3, 7)
    source = Source(path="made", sha256="", format="test", robot="panda", start_s=START_S)
    return JointLog(t=T, q=numbers, dq=numbers + 0.5, tau_J=-numbers, joint_names=JOINTS, source=source)


def decoded(path: Path, factory: Any) -> list[Any]:
    with path.open("rb") as stream:
        return list(make_reader(stream, decoder_factories=[factory]).iter_decoded_messages())


def test_csv_by_hand(log: JointLog, tmp_path: Path) -> None:
    write_log(log.take_joints([1]), tmp_path / "log.csv")
    expected = "time,q_1,dq_1,tau_J_1\n0,1,1.5,-1\n0.001,8,8.5,-8\n0.0025,15,15.5,-15\n"
    assert (tmp_path / "log.csv").read_text() == expected
    write_log(log.take_joints([1]), tmp_path / "log.csv", dialect="csv-rostopic", overwrite=True)
    header, _, second, _ = (tmp_path / "log.csv").read_text().splitlines()
    assert header.startswith("%time,field.header.seq,field.header.stamp,field.header.frame_id,field.name0,field.posi")
    assert second == "1700000000501000000,1,1700000000501000000,,panda_joint2,8,8.5,-8"


def test_libfranka_tables_of_both_ages(log: JointLog, tmp_path: Path) -> None:
    for dialect in ("csv-libfranka-0.9", "csv-libfranka"):
        write_log(replace(log, q=log.q + 1 / 3), tmp_path / f"{dialect}.csv", dialect=dialect)
    header, *old = (tmp_path / "csv-libfranka-0.9.csv").read_text().splitlines()
    assert header.startswith("duration, success rate, q[0], q[1], q[2], q[3], q[4], q[5], q[6],q_d[0], q_d[1]")
    names = header.split(",")
    assert (names[44], [name.strip() for name in names].count("q_d[0]")) == ("sent commands", 2)
    assert {len(line.split(",")) for line in (header, *old)} == {88}
    assert old[0].split(",")[44] == ""
    assert [line.split(",")[0] for line in old] == ["0", "1", "2"]
    header, *new = (tmp_path / "csv-libfranka.csv").read_text().splitlines()
    names = header.split(",")
    assert (names[:3], names[-1]) == (["time", "success_rate", "state.q[0]"], "cmd.tau_J_d[6]")
    assert len(names) == len(set(names)) == len(new[0].split(",")) == 87
    assert new[0].split(",")[2:4] == ["0.333333", "1.33333"]  # six digits


def test_parquet_keeps_the_names(log: JointLog, tmp_path: Path) -> None:
    write_log(log, tmp_path / "log.parquet")
    table = pq.read_table(tmp_path / "log.parquet")
    assert table.column_names[:3] == ["time", "q_1", "q_2"]
    notes = table.schema.metadata
    assert json.loads(notes[b"joint_names"]) == list(JOINTS)
    assert notes[b"robot"] == b"panda"
    assert float(notes[b"start_s"]) == START_S
    assert pq.ParquetFile(tmp_path / "log.parquet").metadata.row_group(0).column(1).compression == "ZSTD"


@pytest.mark.parametrize(
    ("name", "dialect", "torque"),
    [
        ("a.bag", "rosbag1-joint-state", "effort"),
        ("a.bag", "rosbag1-franka-state", "tau_J"),
        ("a", "rosbag2-sqlite3", "effort"),
        ("a", "rosbag2-mcap", "effort"),
    ],
)
def test_bags_are_what_rosbags_reads(name: str, dialect: str, torque: str, log: JointLog, tmp_path: Path) -> None:
    write_log(log, tmp_path / name, dialect=dialect)
    with AnyReader([tmp_path / name]) as reader:
        rows = [(stamp, reader.deserialize(raw, link.msgtype)) for link, stamp, raw in reader.messages()]
    assert [stamp for stamp, _ in rows] == [1_700_000_000_500_000_000 + k for k in (0, 1_000_000, 2_500_000)]
    message: Any = rows[1][1]
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1_700_000_000, 501_000_000)
    assert_array_equal(getattr(message, torque), -np.arange(7.0, 14.0))


def test_ros1_franka_state_is_the_vendor_s(log: JointLog, tmp_path: Path) -> None:
    write_log(log, tmp_path / "a.bag", dialect="rosbag1-franka-state")
    with AnyReader([tmp_path / "a.bag"]) as reader:
        (connection,) = reader.connections
        (*_, (_, _, raw)) = reader.messages()
        message: Any = reader.deserialize(raw, connection.msgtype)
    assert connection.digest == "431567d5df6caf4e4dd7385f25cb71ee"
    assert len(raw) == 2491
    assert message.time == 0.0025
    assert np.isnan(message.tau_ext_hat_filtered).all()


def test_humble_storage_carries_no_definitions(log: JointLog, tmp_path: Path) -> None:
    write_log(log, tmp_path / "a.db3", dialect="rosbag2-db3-franka-state")
    with closing(sqlite3.connect(tmp_path / "a.db3")) as database:
        tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
        assert "message_definitions" not in tables
        assert database.execute("SELECT type FROM topics").fetchall() == [("franka_msgs/msg/FrankaState",)]
        assert database.execute("SELECT count(*) FROM messages").fetchone() == (3,)
    assert [item.name for item in tmp_path.iterdir()] == ["a.db3"]


def _flat(content: Any) -> tuple[object, bool]:
    return content.tau_j, hasattr(content, "o_ddp_o")


TORQUE = (-np.arange(7.0, 14.0)).tolist()
MCAP: dict[str, tuple[Any, str, str, Callable[[Any], object], object]] = {
    "mcap": (Ros2Decoder, "sensor_msgs/msg/JointState", "cdr", lambda c: (c.name, c.effort), (JOINTS, TORQUE)),
    "mcap-ros1": (Ros1Decoder, "sensor_msgs/JointState", "ros1", lambda c: (c.name, c.effort), (JOINTS, TORQUE)),
    "mcap-franka-robot-state": (
        Ros2Decoder, "franka_msgs/msg/FrankaRobotState", "cdr",
        lambda c: (c.measured_joint_state.name, c.measured_joint_state.effort, c.tau_ext_hat_filtered.effort),
        (JOINTS, TORQUE, ()),
    ),
    "mcap-franka-robot-state-flat": (Ros2Decoder, "franka_msgs/msg/FrankaRobotState", "cdr", _flat, (TORQUE, False)),
    "mcap-franka-state": (Ros2Decoder, "franka_msgs/msg/FrankaState", "cdr", _flat, (TORQUE, True)),
    "mcap-protobuf": (
        ProtobufDecoder, "foxglove.JointStates", "protobuf",
        lambda c: ([j.name for j in c.joints], [j.effort for j in c.joints], c.joints[0].HasField("acceleration")),
        (JOINTS, TORQUE, False),
    ),
}  # fmt: skip


@pytest.mark.parametrize("dialect", MCAP)
def test_mcap(dialect: str, log: JointLog, tmp_path: Path) -> None:
    decoder, name, encoding, of, expected = MCAP[dialect]
    write_log(log, tmp_path / "a.mcap", dialect=dialect)
    schema, channel, message, content = decoded(tmp_path / "a.mcap", decoder())[1]
    assert (schema.name, channel.message_encoding, message.log_time) == (name, encoding, 1_700_000_000_501_000_000)
    assert json.loads(json.dumps(of(content), default=list)) == json.loads(json.dumps(expected))


def test_mcap_json(log: JointLog, tmp_path: Path) -> None:
    write_log(log.take_joints([1]), tmp_path / "a.mcap", dialect="mcap-json")
    with (tmp_path / "a.mcap").open("rb") as stream:
        messages: list[Any] = list(make_reader(stream).iter_messages())
    schema, channel, message = messages[1]
    assert (schema.name, schema.encoding, channel.message_encoding) == ("foxglove.JointStates", "jsonschema", "json")
    assert json.loads(message.data) == {
        "timestamp": {"sec": 1_700_000_000, "nsec": 501_000_000},
        "joints": [{"name": "panda_joint2", "position": 8.0, "velocity": 8.5, "effort": -8.0}],
    }


def test_stamps_are_never_zero(log: JointLog, tmp_path: Path) -> None:
    write_log(replace(log, source=Source(path="x", sha256="", format="x")), tmp_path / "a.mcap")
    assert decoded(tmp_path / "a.mcap", Ros2Decoder())[0][3].header.stamp.sec == 1
