"""MCAP files: ROS 2, ROS 1, JSON and protobuf messages, whole and broken."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from google.protobuf.message_factory import GetMessages
from mcap.writer import CompressionType

from friction_audit.errors import InputError
from friction_audit.io.readers import list_topics
from friction_audit.io.writers.mcap import _descriptors
from tests.io.bag_writing import (
    JOINTS,
    STEP_NS,
    assert_read,
    joint_state,
    joint_states,
    read,
    ros2_store,
    samples,
    stamp_ns,
    write_json_mcap,
    write_mcap,
    write_mcap_payloads,
)

STORE = ros2_store()


def test_json_joint_states(tmp_path: Path) -> None:
    values = samples(40)
    values["tau_J"][4, 2] = np.nan
    messages = []
    for i in range(40):
        stamp = dict(zip(("sec", "nanosec"), divmod(stamp_ns(i), 10**9), strict=True))
        effort = [None if math.isnan(tau) else tau for tau in values["tau_J"][i]]
        fields = {"position": values["q"][i].tolist(), "velocity": values["dq"][i].tolist(), "effort": effort}
        messages.append((stamp_ns(i) + 1000, {"header": {"stamp": stamp}, "name": list(JOINTS), **fields}))
    recording = read(write_json_mcap(tmp_path / "a.mcap", "/j", "JointState", messages))
    assert_read(recording, values)
    assert recording.clock == "header_stamp"
    np.testing.assert_array_equal(recording.t, np.arange(40) * STEP_NS / 1e9)


def test_protobuf_joint_states_without_effort(tmp_path: Path) -> None:
    descriptors = _descriptors()
    kind: Any = GetMessages(descriptors.file)["foxglove.JointStates"]
    values = samples(30)
    values["dq"][:, 0] = 0.0  # not on the wire, and still there
    payloads = []
    for i in range(30):
        message = kind()
        message.timestamp.FromNanoseconds(stamp_ns(i))
        for name, q, dq in zip(JOINTS, values["q"][i], values["dq"][i], strict=True):
            message.joints.add(name=name, position=q, velocity=dq)
        payloads.append((stamp_ns(i) + 5, message.SerializeToString()))
    name = "foxglove.JointStates"
    schemas = {name: descriptors.SerializeToString()}
    recording = read(
        write_mcap_payloads(tmp_path / "a.mcap", [("/joints", name, payloads)], schemas, "protobuf", "protobuf")
    )
    del values["tau_J"]
    assert_read(recording, values)
    assert (recording.clock, recording.findings[0].code) == ("header_stamp", "channel_empty")


def test_encoding_that_is_not_read(tmp_path: Path) -> None:
    payloads = [("/j", "foxglove.JointStates", [(stamp_ns(0), b"\x00\x01")])]
    path = write_mcap_payloads(tmp_path / "a.mcap", payloads, {"foxglove.JointStates": b""}, "flatbuffer", "flatbuffer")
    with pytest.raises(
        InputError, match=r"no topic with measured joint states.*/j \(foxglove.JointStates, 1 messages\)"
    ):
        read(path)


def test_file_without_its_closing_magic_is_read_whole(tmp_path: Path) -> None:
    values = samples(100)
    path = write_mcap(tmp_path / "a.mcap", STORE, [joint_states(STORE, values)])
    path.write_bytes(path.read_bytes()[:-4])
    assert_read(read(path), values)


@pytest.mark.parametrize("compression", list(CompressionType))
def test_chunk_with_a_flipped_bit_is_left_out(tmp_path: Path, compression: CompressionType) -> None:
    values = samples(2000)
    path = write_mcap(tmp_path / "a.mcap", STORE, [joint_states(STORE, values)], compression=compression)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0x10
    path.write_bytes(content)
    recording = read(path)
    damage, missing = recording.findings
    assert (damage.code, damage.damaged) == ("truncated", True)
    assert (missing.code, missing.amount) == ("missing_messages", 2000.0 - len(recording.t))
    kept = np.isin(values["q"][:, 0], recording.channels["q"][:, 0])
    assert 1000 < kept.sum() == len(recording.t) < 2000
    np.testing.assert_array_equal(recording.channels["tau_J"], values["tau_J"][kept])


def test_broken_definition_matters_only_on_the_topic_asked_for(tmp_path: Path) -> None:
    values = samples(5)
    kind = "sensor_msgs/msg/JointState"
    good = [(stamp_ns(i), bytes(STORE.serialize_cdr(joint_state(STORE, i, values), kind))) for i in range(5)]
    schemas = {
        kind: STORE.generate_msgdef(kind, ros_version=2)[0].encode(),
        "a/msg/Bad": b"this is ! no definition",
        "a/msg/Half": b"b/Unknown q",
    }
    streams = [("/j", kind, good), ("/bad", "a/msg/Bad", good), ("/half", "a/msg/Half", good)]
    path = write_mcap_payloads(tmp_path / "a.mcap", streams, schemas, "cdr", "ros2msg")
    assert_read(read(path), values)
    assert [topic.readable for topic in list_topics(path)[1]] == [True, False, False]
    with pytest.raises(InputError, match=r"a.mcap: topic /bad of type a/msg/Bad cannot be read"):
        read(path, topic="/bad")
    with pytest.raises(InputError, match=r"topic /half .* does not say what 'b/msg/Unknown' is"):
        read(path, topic="/half")
