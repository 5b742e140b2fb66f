"""Bags for tests, written by rosbags' and mcap's own writers, and how they are read."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import Writer as McapWriter
from numpy.typing import NDArray
from rosbags.rosbag1 import Writer as Rosbag1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer as Rosbag2Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from friction_audit.io.readers import choose_reader
from friction_audit.io.readers.reader import ReadOptions
from friction_audit.io.recording import Recording
from friction_audit.io.writers.ros_messages import _blank
from friction_audit.joint_log import Finding

JOINT_STATE = "sensor_msgs/msg/JointState"
JOINTS = tuple(f"panda_joint{number}" for number in range(1, 8))
START_NS = 1_700_000_000_000_000_123
STEP_NS = 1_000_000
LOG_DELAY_NS = 200_000

Samples = dict[str, NDArray[np.float64]]


def samples(n: int, joints: int = 7, seed: int = 0) -> Samples:
    """Random q, dq and tau_J of shape (n, joints)."""
    rng = np.random.default_rng(seed)
    return {name: rng.normal(size=(n, joints)) for name in ("q", "dq", "tau_J")}


def read(path: Path, **options: Any) -> Recording:
    recording: Recording = choose_reader(path).loaded.read(path, ReadOptions(**options))
    return recording


def damage(recording: Recording) -> list[Finding]:
    return [finding for finding in recording.findings if finding.damaged]


def assert_read(recording: Recording, values: Samples) -> None:
    """The recording has these channels, to the bit, column by column."""
    assert list(recording.channels) == list(values)
    for name, array in values.items():
        np.testing.assert_array_equal(recording.channels[name], array)
        assert recording.channels[name].flags.f_contiguous


def ros1_store(*definitions: tuple[str, str], base: Stores = Stores.ROS1_NOETIC) -> Typestore:
    store = get_typestore(base)
    types: Any = {}
    for name, text in definitions:
        types.update(get_types_from_msg(text, name))
    store.register(types)
    return store


ros2_store = partial(ros1_store, base=Stores.ROS2_HUMBLE)


def stamp_ns(index: int) -> int:
    return START_NS + index * STEP_NS


def header(store: Typestore, index: int, frame: str = "") -> Any:
    times: Any = store.types["builtin_interfaces/msg/Time"]
    kind: Any = store.types["std_msgs/msg/Header"]
    extra = {"seq": index} if "seq" in kind.__dataclass_fields__ else {}
    return kind(stamp=times(*divmod(stamp_ns(index), 10**9)), frame_id=frame, **extra)


def joint_state(
    store: Typestore, index: int, values: Samples, *, names: Sequence[str] = JOINTS, empty: Sequence[str] = ()
) -> Any:
    """One JointState; the columns of the values follow JOINTS, whatever the order of the names."""
    kind: Any = store.types[JOINT_STATE]
    numbers = [
        np.array([own[index, JOINTS.index(name)] if name in JOINTS else 99.0 for name in names if channel not in empty])
        for channel, own in values.items()
    ]
    return kind(header(store, index), list(names), *numbers)


Stream = tuple[str, str, Sequence[tuple[int, Any]]]
"""Topic, message type, and (log time, message) of every message."""


def joint_states(
    store: Typestore, values: Samples, topic: str = "/joint_states", *, every: int = 1, **options: Any
) -> Stream:
    rows = range(0, len(values["q"]), every)
    return topic, JOINT_STATE, [(stamp_ns(i) + LOG_DELAY_NS, joint_state(store, i, values, **options)) for i in rows]


def fill(store: Typestore, typename: str, **fields: Any) -> Any:
    """Make a message with nothing in all fields but those given."""
    known = {name for name, _ in store.fielddefs[typename][1]}
    return replace(_blank(store, (2, typename)), **{name: value for name, value in fields.items() if name in known})


def franka_messages(store: Typestore, typename: str, values: Samples, names: Sequence[str] = JOINTS) -> Stream:
    """Messages of any generation of franka_msgs; their own time runs from 3 s on."""
    messages, flat = [], "q" in {name for name, _ in store.fielddefs[typename][1]}
    tau = values["tau_J"]
    for i in range(len(tau)):
        external = joint_state(store, i, {**values, "tau_J": 2 * tau}, names=names, empty=["q", "dq"])
        fields = {
            "header": header(store, i),
            "q": values["q"][i],
            "dq": values["dq"][i],
            **dict.fromkeys(("tau_j", "tau_J"), tau[i]),
            **dict.fromkeys(("tau_j_d", "tau_J_d"), -tau[i]),
            "tau_ext_hat_filtered": 2 * tau[i] if flat else external,
            "measured_joint_state": joint_state(store, i, values, names=names),
            "desired_joint_state": joint_state(store, i, {**values, "tau_J": -tau}, names=names),
            "time": 3.0 + i / 1000,
        }
        messages.append((stamp_ns(i), fill(store, typename, **fields)))
    return "/franka_state_controller/franka_states", typename, messages


def write(path: Path, content: Samples | Sequence[Stream], store: Typestore | None = None, **options: Any) -> Path:
    """Write joint states, or streams: a ROS 1 bag, an MCAP file (of ROS 2, or ``ros1``) or a folder of ROS 2."""
    ros1 = path.suffix == ".bag" or options.pop("ros1", False)
    store = store or (ros1_store() if ros1 else ros2_store())
    streams = [joint_states(store, content)] if isinstance(content, dict) else content
    serialise: Any = store.serialize_ros1 if ros1 else store.serialize_cdr
    if path.suffix == ".mcap":
        kinds = {kind: store.generate_msgdef(kind, ros_version=1 if ros1 else 2)[0].encode() for _, kind, _ in streams}
        encodings = ("ros1", "ros1msg") if ros1 else ("cdr", "ros2msg")
        payloads = [(topic, kind, [(t, bytes(serialise(m, kind))) for t, m in rows]) for topic, kind, rows in streams]
        return write_payloads(path, payloads, kinds, *encodings, **options)
    compression = options.pop("compression", None)
    writer: Any
    if ros1:
        writer = Rosbag1Writer(path)
        if compression:
            writer.set_compression(Rosbag1Writer.CompressionFormat[compression])
    else:
        writer = Rosbag2Writer(path, version=9, storage_plugin=StoragePlugin[options.pop("storage", "SQLITE3")])
        if compression:
            writer.set_compression(CompressionMode[compression], CompressionFormat.ZSTD)
    with writer:
        connections = [writer.add_connection(topic, kind, typestore=store) for topic, kind, _ in streams]
        for at, time, message in _in_order(streams):
            writer.write(connections[at], time, serialise(message, streams[at][1]))
    return path


def write_payloads(
    path: Path, streams: Sequence[Stream], schemas: dict[str, bytes], encoding: str, language: str, **options: Any
) -> Path:
    """Write messages that are serialised already, as an MCAP file; ``notes`` become its metadata."""
    notes = options.pop("notes", None)
    with path.open("wb") as file:
        writer: Any = McapWriter(file, **{"chunk_size": 64 * 1024, **options})
        writer.start(profile="")
        if notes:
            writer.add_metadata("robot", notes)
        channels = []
        for topic, kind, _ in streams:
            name = kind.replace("/msg/", "/") if encoding == "ros1" else kind
            schema = writer.register_schema(name, language, schemas[kind])
            channels.append(writer.register_channel(topic, encoding, schema))
        for at, time, payload in _in_order(streams):
            writer.add_message(channels[at], time, payload, time)
        writer.finish()
    return path


def _in_order(streams: Sequence[Stream]) -> list[tuple[int, int, Any]]:
    rows = [(at, time, message) for at, (_, _, messages) in enumerate(streams) for time, message in messages]
    return sorted(rows, key=lambda row: row[1])
