"""What messages hold, in ROS 1 bags and MCAP files: definitions, arms, encodings, and what is broken."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from google.protobuf.message_factory import GetMessages
from hypothesis import given, strategies as st
from mcap.writer import CompressionType

from friction_audit.errors import InputError, UsageError
from friction_audit.io.readers import list_topics, read_log
from friction_audit.io.readers.message_decoder import find_layout, franka_types
from friction_audit.io.readers.message_stream import Block, one_block
from friction_audit.io.readers.rosbag1 import Rosbag1Stream
from friction_audit.io.recording import Recording
from friction_audit.io.writers.mcap import _descriptors
from tests.io import bag_writing as bags
from tests.io.synthetic_recordings import refused

STORE, STORE2 = bags.ros1_store(), bags.ros2_store()
FRANKA_STATE = "franka_msgs/msg/FrankaState"


def codes(recording: Recording) -> set[str]:
    return {finding.code for finding in recording.findings}


def test_arm_and_gripper_taking_turns_on_one_topic(tmp_path: Path) -> None:
    values = bags.samples(50)
    arm = bags.joint_states(STORE, values)
    fingers = ["panda_finger_joint1", "panda_finger_joint2"]
    gripper = [(t + 10, bags.joint_state(STORE, i, values, names=fingers)) for i, (t, _) in enumerate(arm[2])]
    both = sorted([*arm[2], *gripper], key=lambda row: row[0])
    path = bags.write(tmp_path / "a.bag", [(arm[0], arm[1], both)])
    recording = bags.read(path)
    bags.assert_read(recording, values)
    assert codes(recording) == {"joints_left_out"}


def test_franka_state_next_to_republished_joint_states(tmp_path: Path) -> None:
    store = bags.ros1_store()
    store.register(franka_types(("Errors_41", "FrankaState_ros1"), FRANKA_STATE))
    values = bags.samples(90)
    topic = "/franka_state_controller/joint_states"
    twice = [bags.joint_states(STORE, values), bags.joint_states(STORE, values, topic, every=2)]
    own = bags.read(bags.write(tmp_path / "own.bag", twice))
    assert (own.topic, codes(own)) == (topic, {"topic_chosen"})
    streams = [
        bags.joint_states(store, values, every=30),
        bags.joint_states(store, values, topic, every=10),
        bags.joint_states(store, values, "/franka_state_controller/joint_states_desired", every=10),
        bags.franka_messages(store, FRANKA_STATE, values),
    ]
    recording = bags.read(bags.write(tmp_path / "a.bag", streams, store))
    assert recording.topic == "/franka_state_controller/franka_states"
    assert recording.clock == "robot_time"
    assert recording.joint_names == tuple(f"joint{i}" for i in range(1, 8))
    assert recording.robot == "panda"  # told by the joint names of the other topics
    tau = values["tau_J"]
    bags.assert_read(recording, {**values, "tau_J_d": -tau, "tau_ext_hat_filtered": 2 * tau})
    np.testing.assert_allclose(recording.t, np.arange(90) * 1e-3, atol=1e-12)
    (chosen,) = [finding for finding in recording.findings if finding.code == "topic_chosen"]
    assert "/joint_states (sensor_msgs/msg/JointState, 3 messages)" in chosen.message


def test_two_arms_in_one_message(tmp_path: Path) -> None:
    values = bags.samples(20, joints=6)
    names = [f"{side}_panda_joint{i}" for i in (1, 2, 3) for side in ("left", "right")]
    kind: Any = STORE.types[bags.JOINT_STATE]
    rows = zip(*values.values(), strict=True)
    messages = [(bags.stamp_ns(i), kind(bags.header(STORE, i), names, *row)) for i, row in enumerate(rows)]
    path = bags.write(tmp_path / "a.bag", [("/joint_states", bags.JOINT_STATE, messages)])
    with pytest.raises(UsageError, match="--topic '/joint_states#right_panda'"):
        bags.read(path)
    recording = bags.read(path, topic="/joint_states#right_panda")
    assert recording.joint_names == tuple(f"right_panda_joint{i}" for i in (1, 2, 3))
    np.testing.assert_array_equal(recording.channels["q"], values["q"][:, 1::2])
    refused("no arm 'middle'", bags.read, path, topic="/joint_states#middle")


def test_custom_definition_is_read_by_its_fields(tmp_path: Path) -> None:
    kind_name = "my_msgs/msg/ArmLog"
    store = bags.ros1_store((kind_name, "time stamp\nstring note\nfloat32[] q\nfloat32[] dq\nfloat64[] tau_j\n"))
    kind: Any = store.types[kind_name]
    times: Any = store.types["builtin_interfaces/msg/Time"]
    q = np.arange(24, dtype=np.float32).reshape(8, 3) / 7
    messages = [
        (bags.stamp_ns(i), kind(times(5, i * 10**6), "x" * (i % 2), q[i], 2 * q[i], q[i].astype(np.float64)))
        for i in range(8)
    ]
    recording = bags.read(bags.write(tmp_path / "a.bag", [("/log", kind_name, messages)], store))
    bags.assert_read(recording, {"q": q.astype(float), "dq": 2.0 * q, "tau_J": q.astype(float)})
    assert recording.joint_names == ("joint1", "joint2", "joint3")
    assert recording.mapping["tau_J"] == "tau_j[{i}]"
    assert recording.t[-1] == pytest.approx(7e-3)


def test_fields_mapped_by_the_user(tmp_path: Path) -> None:
    kind_name = "my_msgs/msg/ArmLog"
    store = bags.ros1_store((kind_name, "float64[2] alpha\nfloat64[2] rate\nfloat64[2] tau_J\nfloat64 clock\n"))
    kind: Any = store.types[kind_name]
    a = np.arange(8.0).reshape(4, 2)
    messages = [(bags.stamp_ns(i), kind(a[i], 2 * a[i], 3 * a[i], 0.5 * i)) for i in range(4)]
    path = bags.write(tmp_path / "a.bag", [("/log", kind_name, messages)], store)
    refused("no topic with measured joint states", bags.read, path)
    with pytest.raises(InputError, match=r"topic /log: no field spin in .*; its fields are alpha, rate, tau_J, clock"):
        bags.read(path, mapping={"dq": "spin"})
    mapping = {"q": "alpha[{i}]", "dq": "rate[{i}]", "tau_J": "tau_J[{i}]", "t": "clock"}
    recording = bags.read(path, mapping=mapping)
    bags.assert_read(recording, {"q": a, "dq": 2 * a, "tau_J": 3 * a})
    assert recording.t.tolist() == [0.0, 0.5, 1.0, 1.5]
    with pytest.raises(InputError, match=r"no field alhpa, spin .*did you mean alpha"):
        bags.read(path, topic="/log", mapping={"q": "alhpa", "dq": "spin"})
    beside = [("/log", kind_name, messages), bags.joint_states(store, bags.samples(9))]
    assert bags.read(bags.write(tmp_path / "b.bag", beside, store), mapping=mapping).topic == "/log"


def test_bag_that_was_never_closed_is_read_without_its_index(tmp_path: Path) -> None:
    values = bags.samples(4000)
    path = bags.write(tmp_path / "a.bag", values)
    content = bytearray(path.read_bytes())
    at = content.index(b"index_pos=") + len(b"index_pos=")
    index = int.from_bytes(content[at : at + 8], "little")
    content[at : at + 8] = bytes(8)
    path.write_bytes(content[:index])
    bags.assert_read(bags.read(path), values)


def test_bag_that_is_still_being_written(tmp_path: Path) -> None:
    """The last chunk's length is written when it is closed; until then it is 0."""
    values = bags.samples(300)
    path = bags.write(tmp_path / "a.bag", values)
    content = bytearray(path.read_bytes())
    (chunk,) = Rosbag1Stream(path)._chunks
    content[chunk.offset - 4 : chunk.offset] = bytes(4)
    path.write_bytes(content[: chunk.offset + chunk.size])
    recording = bags.read(path)
    bags.assert_read(recording, values)
    assert [finding.code for finding in recording.findings] == ["truncated"]


def test_json_joint_states(tmp_path: Path) -> None:
    values = bags.samples(40)
    values["tau_J"][4, 2] = np.nan
    messages = []
    for i in range(40):
        stamp = dict(zip(("sec", "nanosec"), divmod(bags.stamp_ns(i), 10**9), strict=True))
        effort = [None if math.isnan(tau) else tau for tau in values["tau_J"][i]]
        fields = {"position": values["q"][i].tolist(), "velocity": values["dq"][i].tolist(), "effort": effort}
        messages.append((bags.stamp_ns(i) + 1000, {"header": {"stamp": stamp}, "name": list(bags.JOINTS), **fields}))
    streams = [("/j", "JointState", [(time, json.dumps(message).encode()) for time, message in messages])]
    path = bags.write_payloads(tmp_path / "a.mcap", streams, {"JointState": b"{}"}, "json", "jsonschema")
    recording = bags.read(path)
    bags.assert_read(recording, values)
    assert recording.clock == "header_stamp"
    np.testing.assert_array_equal(recording.t, np.arange(40) * bags.STEP_NS / 1e9)


def test_protobuf_joint_states_without_effort(tmp_path: Path) -> None:
    descriptors = _descriptors()
    kind: Any = GetMessages(descriptors.file)["foxglove.JointStates"]
    values = bags.samples(30)
    values["dq"][:, 0] = 0.0  # not on the wire, and still there
    payloads = []
    for i in range(30):
        message = kind()
        message.timestamp.FromNanoseconds(bags.stamp_ns(i))
        for name, q, dq in zip(bags.JOINTS, values["q"][i], values["dq"][i], strict=True):
            message.joints.add(name=name, position=q, velocity=dq)
        payloads.append((bags.stamp_ns(i) + 5, message.SerializeToString()))
    name = "foxglove.JointStates"
    schemas = {name: descriptors.SerializeToString()}
    file = bags.write_payloads(tmp_path / "a.mcap", [("/joints", name, payloads)], schemas, "protobuf", "protobuf")
    bag = bags.write(tmp_path / "a.bag", [bags.joint_states(STORE, values, empty=["tau_J"])])
    del values["tau_J"]
    for found in map(bags.read, (file, bag)):
        bags.assert_read(found, values)
        assert (found.clock, found.findings[0].code) == ("header_stamp", "channel_empty")
    refused("no torque .* holds no values in effort", read_log, bag)


def test_encoding_that_is_not_read(tmp_path: Path) -> None:
    payloads = [("/j", "foxglove.JointStates", [(bags.stamp_ns(0), b"\x00\x01")])]
    path = bags.write_payloads(tmp_path / "a.mcap", payloads, {"foxglove.JointStates": b""}, "flatbuffer", "flatbuffer")
    refused(r"no topic with measured joint states.*/j \(foxglove.JointStates, 1 messages\)", bags.read, path)


@pytest.mark.parametrize("compression", list(CompressionType))
def test_chunk_with_a_flipped_bit_is_left_out(tmp_path: Path, compression: CompressionType) -> None:
    values = bags.samples(2000)
    path = bags.write(tmp_path / "a.mcap", values, compression=compression)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0x10
    path.write_bytes(content)
    recording = bags.read(path)
    damage, missing = recording.findings
    assert (damage.code, damage.damaged) == ("truncated", True)
    assert (missing.code, missing.amount) == ("missing_messages", 2000.0 - len(recording.t))
    kept = np.isin(values["q"][:, 0], recording.channels["q"][:, 0])
    assert 1000 < kept.sum() == len(recording.t) < 2000
    np.testing.assert_array_equal(recording.channels["tau_J"], values["tau_J"][kept])


def test_broken_definition_matters_only_on_the_topic_asked_for(tmp_path: Path) -> None:
    values = bags.samples(5)
    good = [
        (bags.stamp_ns(i), bytes(STORE2.serialize_cdr(bags.joint_state(STORE2, i, values), bags.JOINT_STATE)))
        for i in range(5)
    ]
    schemas = {
        bags.JOINT_STATE: STORE2.generate_msgdef(bags.JOINT_STATE, ros_version=2)[0].encode(),
        "a/msg/Bad": b"this is ! no definition",
        "a/msg/Half": b"b/Unknown q",
    }
    streams = [("/j", bags.JOINT_STATE, good), ("/bad", "a/msg/Bad", good), ("/half", "a/msg/Half", good)]
    path = bags.write_payloads(tmp_path / "a.mcap", streams, schemas, "cdr", "ros2msg")
    bags.assert_read(bags.read(path), values)
    assert [topic.readable for topic in list_topics(path)[1]] == [True, False, False]
    refused(r"a.mcap: topic /bad of type a/msg/Bad cannot be read", bags.read, path, topic="/bad")
    refused(r"topic /half .* does not say what 'b/msg/Unknown' is", bags.read, path, topic="/half")


STORES = {"ros1": STORE, "cdr": STORE2}
CODECS: dict[str, tuple[Any, Any]] = {
    "ros1": (STORE.serialize_ros1, STORE.deserialize_ros1),
    "cdr": (STORE2.serialize_cdr, STORE2.deserialize_cdr),
}
NUMBERS = ("header.stamp.sec", "header.stamp.nanosec", "position", "velocity", "effort")
any_name = st.text(st.characters(codec="utf-8", exclude_characters="\x00"), max_size=12)


@st.composite
def same_layout(draw: st.DrawFn) -> tuple[str, list[Any]]:
    """Messages with the same names and array lengths, other values."""
    encoding = draw(st.sampled_from(sorted(STORES)))
    names, frame = draw(st.lists(any_name, max_size=5)), draw(any_name)
    lengths = [draw(st.integers(0, 5)) for _ in range(3)]
    numbers = [st.lists(st.floats(width=64, allow_nan=True), min_size=k, max_size=k) for k in lengths]
    kind: Any = STORES[encoding].types[bags.JOINT_STATE]
    return encoding, [
        kind(bags.header(STORES[encoding], index, frame), names, *(np.array(draw(one), np.float64) for one in numbers))
        for index in range(draw(st.integers(1, 6)))
    ]


@given(same_layout(), st.data())
def test_equals_the_librarys_decoder_bit_for_bit(case: tuple[str, list[Any]], data: st.DataObject) -> None:
    encoding, messages = case
    serialise, deserialise = CODECS[encoding]
    payloads = [bytes(serialise(message, bags.JOINT_STATE)) for message in messages]
    layout = find_layout(payloads[0], bags.JOINT_STATE, STORES[encoding].fielddefs, encoding=encoding)
    gaps = data.draw(st.sampled_from([(0,), (5,), (3, 11, 0)]))  # between the payloads: none, even, uneven
    buffer, start = b"", []
    for number, payload in enumerate(payloads):
        start.append(len(buffer))
        buffer += payload + b"\xff" * gaps[number % len(gaps)]
    size = np.full(len(payloads), len(payloads[0]), np.int64)
    records = layout.records(Block(0, np.arange(len(payloads)), buffer, np.array(start, np.int64), size), NUMBERS)
    assert records is not None
    for record, payload in zip(records, payloads, strict=True):
        reference = deserialise(payload, bags.JOINT_STATE)
        assert list(layout.strings["name"]) == reference.name
        assert layout.strings["header.frame_id"] == (reference.header.frame_id,)
        assert record["header.stamp.nanosec"][0] == reference.header.stamp.nanosec
        for field in ("position", "velocity", "effort"):
            assert record[field].tobytes() == getattr(reference, field).tobytes()
    changed = list(map(bytearray, payloads))  # any other string or length is refused
    place = data.draw(st.sampled_from(np.flatnonzero(layout.fixed).tolist()))
    data.draw(st.sampled_from(changed))[place] ^= data.draw(st.integers(1, 255))
    assert layout.records(one_block(0, range(len(changed)), list(map(bytes, changed))), NUMBERS) is None
