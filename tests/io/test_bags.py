"""What is the same in all containers of messages: ROS 1 bags, ROS 2 bags and MCAP files."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import CompressionType, IndexType

from friction_audit.errors import InputError, UsageError
from friction_audit.io.readers import list_topics
from tests.io.bag_writing import (
    JOINT_STATE,
    JOINTS,
    STEP_NS,
    Stream,
    assert_read,
    header,
    joint_state,
    joint_states,
    read,
    ros1_store,
    ros2_store,
    samples,
    stamp_ns,
    write_mcap,
    write_rosbag1,
    write_rosbag2,
)

Write = Callable[[Path, Sequence[Stream]], Path]


def bag1(folder: Path, streams: Sequence[Stream], **options: Any) -> Path:
    return write_rosbag1(folder / "a.bag", ros1_store(), streams, **options)


def bag2(folder: Path, streams: Sequence[Stream], **options: Any) -> Path:
    return write_rosbag2(folder / "bag", ros2_store(), streams, **options)


def mcap(folder: Path, streams: Sequence[Stream], **options: Any) -> Path:
    return write_mcap(folder / "a.mcap", ros1_store() if options.get("ros1") else ros2_store(), streams, **options)


def store_of(write: Any) -> Any:
    is_ros1 = getattr(write, "func", write) is bag1 or "ros1" in getattr(write, "keywords", {})
    return ros1_store() if is_ros1 else ros2_store()


@pytest.mark.parametrize(
    "write",
    [
        *(partial(bag1, compression=compression) for compression in (None, "LZ4", "BZ2")),
        *(partial(bag2, compression=compression) for compression in (None, "MESSAGE", "FILE")),
        *(partial(bag2, storage="MCAP", compression=compression) for compression in (None, "FILE")),
        *(partial(mcap, compression=compression) for compression in CompressionType),
        partial(mcap, ros1=True),
        partial(mcap, use_chunking=False),
        partial(mcap, index_types=IndexType.NONE),
        partial(mcap, use_statistics=False, repeat_channels=False, repeat_schemas=False),
        partial(mcap, use_summary_offsets=False),
    ],
    ids=lambda write: f"{write.func.__name__} {' '.join(f'{k}={v}' for k, v in write.keywords.items())}",
)
def test_joint_states(tmp_path: Path, write: Write) -> None:
    values, store = samples(1500), store_of(write)
    text: Any = store.types["std_msgs/msg/String"]
    path = write(tmp_path, [joint_states(store, values), ("/note", "std_msgs/msg/String", [(stamp_ns(0), text("x"))])])
    recording = read(path)
    assert_read(recording, values)
    np.testing.assert_array_equal(recording.t, np.arange(1500) * STEP_NS / 1e9)
    assert recording.joint_names == JOINTS
    assert (recording.clock, recording.robot, recording.topic) == ("header_stamp", "panda", "/joint_states")
    assert recording.start_s == pytest.approx(1.7e9)
    assert recording.mapping == {"q": "position[{i}]", "dq": "velocity[{i}]", "tau_J": "effort[{i}]"}
    assert recording.findings == ()
    found = {(topic.name, topic.type, topic.messages, topic.readable) for topic in list_topics(path)[1]}
    assert found == {("/joint_states", JOINT_STATE, 1500, True), ("/note", "std_msgs/msg/String", 1, False)}
    with pytest.raises(InputError, match="/note of type std_msgs/msg/String holds no joint state"):
        read(path, topic="/note")


ANY = pytest.mark.parametrize("write", [bag1, bag2, mcap])


@ANY
def test_topics_that_alternate(tmp_path: Path, write: Write) -> None:
    values, store = samples(800), store_of(write)
    text: Any = store.types["std_msgs/msg/String"]
    notes = [(stamp_ns(i) + 7 * STEP_NS // 3, text("x" * (i % 13))) for i in range(700)]
    assert_read(read(write(tmp_path, [joint_states(store, values), ("/note", "std_msgs/msg/String", notes)])), values)


@ANY
def test_order_that_changes_between_messages(tmp_path: Path, write: Write) -> None:
    values, store = samples(5000), store_of(write)
    orders = (JOINTS, JOINTS[::-1], (*JOINTS[3:], *JOINTS[:3], "panda_finger_joint1"))
    at = (orders[i * i % 3 if i < 60 else i // 3000] for i in range(5000))  # each time, then once for good
    messages = [(stamp_ns(i), joint_state(store, i, values, names=names)) for i, names in enumerate(at)]
    assert_read(read(write(tmp_path, [("/joint_states", JOINT_STATE, messages)])), values)


@ANY
def test_scrambled_order_fingers_and_empty_names(tmp_path: Path, write: Write) -> None:
    values, store = samples(20), store_of(write)
    names = ["panda_finger_joint1", *JOINTS[::2], "panda_finger_joint2", *JOINTS[1::2]]
    recording = read(write(tmp_path, [joint_states(store, values, names=names)]))
    assert_read(recording, values)
    (said,) = [one.message for one in recording.findings if one.code == "joints_left_out"]
    assert said.endswith(": panda_finger_joint1, panda_finger_joint2")
    assert recording.joint_names == JOINTS
    kind: Any = store.types[JOINT_STATE]
    rows = ([values[c][i] for c in ("q", "dq", "tau_J")] for i in range(20))
    nameless = [(stamp_ns(i), kind(header(store, i), [], *row)) for i, row in enumerate(rows)]
    (tmp_path / "nameless").mkdir()
    recording = read(write(tmp_path / "nameless", [("/j", JOINT_STATE, nameless)]))
    assert_read(recording, values)
    assert recording.joint_names == tuple(f"joint{i}" for i in range(1, 8))
    assert recording.robot == "unknown"


@ANY
def test_two_arms_are_for_the_user_to_choose(tmp_path: Path, write: Write) -> None:
    streams = [joint_states(store_of(write), samples(20), f"/{arm}/joint_states") for arm in ("left", "right")]
    path = write(tmp_path, streams)
    with pytest.raises(UsageError, match=r"--topic '/right/joint_states' \(20 messages\)"):
        read(path)
    assert read(path, topic="right/joint_states").topic == "/right/joint_states"


@pytest.mark.parametrize("share", [0.3, 0.75, 0.98])
@pytest.mark.parametrize(
    "write",
    [
        *(partial(bag1, compression=compression) for compression in (None, "LZ4")),
        *(partial(mcap, **options) for options in ({}, {"use_chunking": False}, {"compression": CompressionType.NONE})),
    ],
)
def test_what_breaks_off_is_read_up_to_there(tmp_path: Path, write: Write, share: float) -> None:
    values = samples(9000)
    path = write(tmp_path, [joint_states(store_of(write), values)])
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    recording = read(path)
    saved = len(recording.t)
    assert max(1000, (share - 0.25) * 9000) < saved <= 9000
    assert_read(recording, {name: array[:saved] for name, array in values.items()})
    (finding,) = recording.findings
    assert (finding.code, finding.damaged) == ("truncated", True)
    assert f" of {int(share * len(whole))} " in finding.message
    assert f"the {saved} messages outside the damage were read" in finding.message
    assert (finding.amount or 0) <= share * len(whole)


SQLITE, MCAP_MAGIC, BAG = b"SQLite format 3\x00", b"\x89MCAP0\r\n", b"#ROSBAG V2.0\n"


@pytest.mark.parametrize(
    ("suffix", "content", "message"),
    [
        (".mcap", b"garbage" * 100, "does not begin as an MCAP file"),
        (".mcap", MCAP_MAGIC, "breaks off at byte 8 of 8 before the first whole chunk"),
        (".mcap", MCAP_MAGIC + b"\xfe" * 300, "breaks off at byte 8 of 308"),
        (".mcap", MCAP_MAGIC + bytes(300), "breaks off"),
        (".bag", b"\x01\x02garbage" * 100, "does not begin as a ROS 1 bag of version 2.0"),
        (".bag", b"#ROSBAG V1.2\n", "does not begin as a ROS 1 bag of version 2.0"),
        (".bag", BAG, "0 messages on any topic"),
        (".bag", BAG + b"\xff" * 200, "before the first whole message"),
        (".db3", b"garbage" * 100, "does not begin as an SQLite file"),
        (".db3", SQLITE + bytes(200), "cannot be read: |no table messages"),
        *((suffix, b"", "is empty") for suffix in (".mcap", ".bag", ".db3")),
    ],
)
def test_bad_files(tmp_path: Path, suffix: str, content: bytes, message: str) -> None:
    path = tmp_path / f"bad{suffix}"
    path.write_bytes(content)
    with pytest.raises(InputError, match=f"bad{suffix}: .*({message})"):
        read(path)
