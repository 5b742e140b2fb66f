"""JointLog -> MCAP with foxglove.JointStates, as JSON or as protobuf."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from friction_audit.io.writers.mcap import Channel, write_mcap
from friction_audit.io.writers.tables import NANOSECONDS, stamps_ns
from friction_audit.io.writers.writer import Writer
from friction_audit.joint_log import JointLog

if TYPE_CHECKING:
    from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet
    from google.protobuf.message import Message

TOPIC = "/joint_states"
SCHEMA = "foxglove.JointStates"
HOLDS = ("q", "dq", "tau_J")

_NUMBER = {"type": "number"}
_TIME = {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}
_JOINT = {
    "name": {"type": "string"},
    "position": _NUMBER,
    "velocity": _NUMBER,
    "acceleration": _NUMBER,
    "effort": _NUMBER,
}
JSON_SCHEMA = {
    "title": SCHEMA,
    "description": "The state of joints",
    "type": "object",
    "properties": {
        "timestamp": {"title": "time", **_TIME},
        "joints": {"type": "array", "items": {"type": "object", "properties": _JOINT}},
    },
}

PROTOBUF_NUMBERS = {"position": 2, "velocity": 3, "acceleration": 4, "effort": 5}
"""Optional numbers of a foxglove.JointState and their field numbers; 1 is the name."""


def write_json(log: JointLog, path: Path) -> None:
    """Write JSON messages; numbers in the shortest form that reads back to the bit."""
    channel = Channel(
        topic=TOPIC,
        schema=SCHEMA,
        schema_encoding="jsonschema",
        schema_data=json.dumps(JSON_SCHEMA).encode(),
        encoding="json",
    )
    write_mcap(path, channel, _json_messages(log))


def _json_messages(log: JointLog) -> Iterator[tuple[int, bytes]]:
    for stamp, joints in _samples(log):
        time = {"sec": stamp // NANOSECONDS, "nsec": stamp % NANOSECONDS}
        yield stamp, json.dumps({"timestamp": time, "joints": joints}, separators=(",", ":")).encode()


def write_protobuf(log: JointLog, path: Path) -> None:
    """Write protobuf messages with their descriptors."""
    descriptors = _descriptors()
    channel = Channel(
        topic=TOPIC,
        schema=SCHEMA,
        schema_encoding="protobuf",
        schema_data=descriptors.SerializeToString(),
        encoding="protobuf",
    )
    write_mcap(path, channel, _protobuf_messages(log, descriptors))


def _protobuf_messages(log: JointLog, descriptors: "FileDescriptorSet") -> Iterator[tuple[int, bytes]]:
    from google.protobuf.message_factory import GetMessages

    joint_states: Any = GetMessages(descriptors.file)[SCHEMA]
    for stamp, joints in _samples(log):
        message: Message = joint_states(
            timestamp={"seconds": stamp // NANOSECONDS, "nanos": stamp % NANOSECONDS}, joints=joints
        )
        yield stamp, message.SerializeToString()


def _samples(log: JointLog) -> Iterator[tuple[int, list[dict[str, str | float]]]]:
    """Yield (time [ns], joints) for every sample."""
    channels = log.channels()
    rows = zip(stamps_ns(log).tolist(), *(channels[name] for name in HOLDS), strict=True)
    for stamp, q, dq, effort in rows:
        numbers = zip(log.joint_names, q.tolist(), dq.tolist(), effort.tolist(), strict=True)
        yield stamp, [{"name": n, "position": p, "velocity": v, "effort": e} for n, p, v, e in numbers]


def _descriptors() -> "FileDescriptorSet":
    """Return the descriptors of foxglove.JointStates and all that it contains."""
    from google.protobuf import timestamp_pb2
    from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet

    timestamp = FileDescriptorProto()
    timestamp_pb2.DESCRIPTOR.CopyToProto(timestamp)
    return FileDescriptorSet(file=[timestamp, _joint_state_file(), _joint_states_file(timestamp.name)])


def _joint_state_file() -> "FileDescriptorProto":
    from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto

    file = FileDescriptorProto(name="foxglove/JointState.proto", package="foxglove", syntax="proto3")
    message = file.message_type.add(name="JointState")
    optional = FieldDescriptorProto.LABEL_OPTIONAL
    message.field.add(name="name", number=1, type=FieldDescriptorProto.TYPE_STRING, label=optional)
    for index, (name, number) in enumerate(PROTOBUF_NUMBERS.items()):
        message.field.add(
            name=name,
            number=number,
            type=FieldDescriptorProto.TYPE_DOUBLE,
            label=optional,
            proto3_optional=True,
            oneof_index=index,
        )
        message.oneof_decl.add(name=f"_{name}")
    return file


def _joint_states_file(timestamp_file: str) -> "FileDescriptorProto":
    from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto

    file = FileDescriptorProto(
        name="foxglove/JointStates.proto",
        package="foxglove",
        syntax="proto3",
        dependency=[timestamp_file, "foxglove/JointState.proto"],
    )
    message = file.message_type.add(name="JointStates")
    kind = FieldDescriptorProto.TYPE_MESSAGE
    message.field.add(
        name="timestamp",
        number=1,
        type=kind,
        type_name=".google.protobuf.Timestamp",
        label=FieldDescriptorProto.LABEL_OPTIONAL,
    )
    message.field.add(
        name="joints", number=2, type=kind, type_name=".foxglove.JointState", label=FieldDescriptorProto.LABEL_REPEATED
    )
    return file


MCAP_JSON = Writer(
    name="mcap-json",
    suffix=".mcap",
    write=write_json,
    summary="MCAP of foxglove.JointStates as JSON",
    holds=HOLDS,
    needs=("tau_J",),
)
MCAP_PROTOBUF = Writer(
    name="mcap-protobuf",
    suffix=".mcap",
    write=write_protobuf,
    summary="MCAP of foxglove.JointStates as protobuf",
    holds=HOLDS,
    needs=("tau_J",),
)
