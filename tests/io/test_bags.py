"""What is the same in all containers of messages: ROS 1 bags, ROS 2 bags and MCAP files."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import CompressionType, IndexType
from rosbags.typesys.store import Typestore

from friction_audit.errors import UsageError
from friction_audit.io.readers import list_topics
from tests.each_case import thorough
from tests.io import bag_writing as bags
from tests.io.synthetic_recordings import refused


@dataclass
class Form:
    """A container, and how its writer is asked to write it."""

    name: str
    options: dict[str, Any]

    @property
    def store(self) -> Typestore:
        return bags.ros1_store() if self.name == "a.bag" or "ros1" in self.options else bags.ros2_store()

    def write(self, folder: Path, content: Any) -> Path:
        return bags.write(folder / self.name, content, **self.options)

    def __str__(self) -> str:
        return f"{self.name} {' '.join(f'{name}={value}' for name, value in self.options.items())}"


def forms(name: str, *options: dict[str, Any]) -> list[Form]:
    return [Form(name, one) for one in options]


@pytest.mark.parametrize(
    "form",
    [
        *forms("a.bag", *({"compression": one} for one in (None, "LZ4", "BZ2"))),
        *forms("bag", *({"compression": one} for one in (None, "MESSAGE", "FILE"))),
        *forms("bag", *({"storage": "MCAP", "compression": one} for one in (None, "MESSAGE", "FILE"))),
        *forms("a.mcap", *({"compression": one} for one in CompressionType)),
        *forms("a.mcap", {"ros1": True}, {"use_chunking": False}, {"index_types": IndexType.NONE}),
        *forms("a.mcap", {"use_statistics": False, "repeat_channels": False, "repeat_schemas": False}),
        *forms("a.mcap", {"use_summary_offsets": False}),
    ],
    ids=str,
)
def test_joint_states(tmp_path: Path, form: Form) -> None:
    values, store = bags.samples(500), form.store
    text: Any = store.types["std_msgs/msg/String"]
    note = ("/note", "std_msgs/msg/String", [(bags.stamp_ns(0), text("x"))])
    path = form.write(tmp_path, [bags.joint_states(store, values), note])
    recording = bags.read(path)
    bags.assert_read(recording, values)
    np.testing.assert_array_equal(recording.t, np.arange(500) * bags.STEP_NS / 1e9)
    assert recording.joint_names == bags.JOINTS
    assert (recording.clock, recording.robot, recording.topic) == ("header_stamp", "panda", "/joint_states")
    assert recording.start_s == pytest.approx(1.7e9)
    assert recording.mapping == {"q": "position[{i}]", "dq": "velocity[{i}]", "tau_J": "effort[{i}]"}
    assert recording.findings == ()
    found = {(topic.name, topic.type, topic.messages, topic.readable) for topic in list_topics(path)[1]}
    assert found == {("/joint_states", bags.JOINT_STATE, 500, True), ("/note", "std_msgs/msg/String", 1, False)}
    refused("/note of type std_msgs/msg/String holds no joint state", bags.read, path, topic="/note")


ANY = pytest.mark.parametrize("form", [Form(name, {}) for name in ("a.bag", "bag", "a.mcap")], ids=str)


@ANY
def test_topics_that_alternate(tmp_path: Path, form: Form) -> None:
    values, store = bags.samples(800), form.store
    text: Any = store.types["std_msgs/msg/String"]
    notes = [(bags.stamp_ns(i) + 7 * bags.STEP_NS // 3, text("x" * (i % 13))) for i in range(700)]
    streams = [bags.joint_states(store, values), ("/note", "std_msgs/msg/String", notes)]
    bags.assert_read(bags.read(form.write(tmp_path, streams)), values)


@ANY
def test_order_that_changes_between_messages(tmp_path: Path, form: Form) -> None:
    values, store = bags.samples(2400), form.store
    orders = (bags.JOINTS, bags.JOINTS[::-1], (*bags.JOINTS[3:], *bags.JOINTS[:3], "panda_finger_joint1"))
    at = (orders[i * i % 3 if i < 60 else i // 1400] for i in range(2400))  # each time, then once for good
    messages = [(bags.stamp_ns(i), bags.joint_state(store, i, values, names=names)) for i, names in enumerate(at)]
    bags.assert_read(bags.read(form.write(tmp_path, [("/joint_states", bags.JOINT_STATE, messages)])), values)


@ANY
def test_scrambled_order_fingers_and_empty_names(tmp_path: Path, form: Form) -> None:
    values, store = bags.samples(20), form.store
    names = ["panda_finger_joint1", *bags.JOINTS[::2], "panda_finger_joint2", *bags.JOINTS[1::2]]
    recording = bags.read(form.write(tmp_path, [bags.joint_states(store, values, names=names)]))
    bags.assert_read(recording, values)
    (said,) = [one.message for one in recording.findings if one.code == "joints_left_out"]
    assert said.endswith(": panda_finger_joint1, panda_finger_joint2")
    assert recording.joint_names == bags.JOINTS
    kind: Any = store.types[bags.JOINT_STATE]
    rows = ([values[c][i] for c in ("q", "dq", "tau_J")] for i in range(20))
    nameless = [(bags.stamp_ns(i), kind(bags.header(store, i), [], *row)) for i, row in enumerate(rows)]
    (tmp_path / "nameless").mkdir()
    recording = bags.read(form.write(tmp_path / "nameless", [("/j", bags.JOINT_STATE, nameless)]))
    bags.assert_read(recording, values)
    assert recording.joint_names == tuple(f"joint{i}" for i in range(1, 8))
    assert recording.robot == "unknown"


@ANY
def test_two_arms_are_for_the_user_to_choose(tmp_path: Path, form: Form) -> None:
    streams = [bags.joint_states(form.store, bags.samples(20), f"/{arm}/joint_states") for arm in ("left", "right")]
    path = form.write(tmp_path, streams)
    with pytest.raises(UsageError, match=r"--topic '/right/joint_states' \(20 messages\)"):
        bags.read(path)
    assert bags.read(path, topic="right/joint_states").topic == "/right/joint_states"


@pytest.mark.parametrize(
    "form",
    [
        *forms("a.bag", {"compression": "LZ4"}),
        *forms("a.mcap", {}, {"use_chunking": False}, {"chunk_size": 1 << 30}),
        *thorough(forms("a.bag", {"compression": None})),
        *thorough(forms("a.mcap", *({"compression": one} for one in (CompressionType.NONE, CompressionType.LZ4)))),
        *thorough(forms("a.mcap", *({"chunk_size": 1 << 30, "compression": one} for one in CompressionType))),
    ],
    ids=str,
)
def test_what_breaks_off_is_read_up_to_there(tmp_path: Path, form: Form) -> None:
    count = 5000
    values = bags.samples(count)
    path = form.write(tmp_path, values)
    whole = path.read_bytes()
    for share in (0.3, 0.75, 0.98):
        path.write_bytes(whole[: int(share * len(whole))])
        recording = bags.read(path)
        saved = len(recording.t)
        assert max(0.1, share - 0.25) * count < saved <= count
        bags.assert_read(recording, {name: array[:saved] for name, array in values.items()})
        (finding,) = recording.findings
        assert (finding.code, finding.damaged) == ("truncated", True)
        assert f" of {int(share * len(whole))} " in finding.message
        assert f"the {saved} messages outside the damage were read" in finding.message
        assert (finding.amount or 0) <= share * len(whole)


SQLITE, MCAP_MAGIC, BAG = b"SQLite format 3\x00", b"\x89MCAP0\r\n", b"#ROSBAG V2.0\n"


@pytest.mark.parametrize(
    ("suffix", "content", "message"),
    [
        (".mcap", MCAP_MAGIC, "breaks off at byte 8 of 8 before the first whole chunk"),
        (".mcap", MCAP_MAGIC + b"\xfe" * 300, "breaks off at byte 8 of 308"),
        (".mcap", MCAP_MAGIC + bytes(300), "breaks off"),
        (".bag", b"#ROSBAG V1.2\n", "does not begin as a ROS 1 bag of version 2.0"),
        (".bag", BAG, "0 messages on any topic"),
        (".bag", BAG + b"\xff" * 200, "before the first whole message"),
        (".db3", SQLITE + bytes(200), "cannot be read: |no table messages"),
    ],
)
def test_bad_files(tmp_path: Path, suffix: str, content: bytes, message: str) -> None:
    path = tmp_path / f"bad{suffix}"
    path.write_bytes(content)
    refused(f"bad{suffix}: .*({message})", bags.read, path)
