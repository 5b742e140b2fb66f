# ruff: noqa: PLC0415  # what a method imports counts as its cost
"""How fast joint states are read from bags, next to the libraries that people use.

    python -m benchmarks.bench_bags [--messages 200000] [--repeat 3]

The files are written by the libraries' own writers into a temporary folder. Every method reads them in a process of its
own, which includes its imports, of modules that are compiled as after an installation; all must find the values that
were written, bit for bit.
"""

import argparse
import hashlib
import json
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.processes import INSTALLED, MEGABYTE

JOINTS = 7
NAMES = [f"panda_joint{number}" for number in range(1, JOINTS + 1)]
FIELDS = ("position", "velocity", "effort")
START_NS = 1_700_000_000_000_000_000
STEP_NS = 1_000_000

Samples = NDArray[np.float64]


def truth(messages: int) -> Samples:
    """Make the values to be written, shape (3, n, j)."""
    return np.random.default_rng(1).normal(size=(3, messages, JOINTS))


def digest(q: Samples, dq: Samples, tau: Samples) -> str:
    """Hash all values, so that they need not be sent between processes."""
    parts = (np.ascontiguousarray(array).tobytes() for array in (q, dq, tau))
    total = hashlib.sha256()
    for part in parts:
        total.update(part)
    return total.hexdigest()


def serialised(messages: int, encoding: str) -> Iterator[tuple[int, bytes]]:
    """Yield log time [ns] and payload of every message, serialised by rosbags."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if encoding == "ros1" else Stores.ROS2_HUMBLE)
    serialise = store.serialize_ros1 if encoding == "ros1" else store.serialize_cdr
    message: Any = store.types["sensor_msgs/msg/JointState"]
    header: Any = store.types["std_msgs/msg/Header"]
    stamp: Any = store.types["builtin_interfaces/msg/Time"]
    extra = {"seq": 0} if encoding == "ros1" else {}
    for index, (q, dq, tau) in enumerate(truth(messages).transpose(1, 0, 2)):
        time_ns = START_NS + index * STEP_NS
        head = header(stamp=stamp(sec=time_ns // 10**9, nanosec=time_ns % 10**9), frame_id="", **extra)
        value = message(header=head, name=NAMES, position=q, velocity=dq, effort=tau)
        yield time_ns + 150_000, bytes(serialise(value, "sensor_msgs/msg/JointState"))


def write_rosbag1(path: Path, messages: int) -> None:
    """Write a ROS 1 bag with rosbags."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    with Writer(path) as writer:
        store = get_typestore(Stores.ROS1_NOETIC)
        connection = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        for log_time, payload in serialised(messages, "ros1"):
            writer.write(connection, log_time, payload)


def write_sqlite3(path: Path, messages: int) -> None:
    """Write a ROS 2 bag, sqlite3 storage, with rosbags."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    with Writer(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        store = get_typestore(Stores.ROS2_HUMBLE)
        connection = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        for log_time, payload in serialised(messages, "cdr"):
            writer.write(connection, log_time, payload)


def write_mcap(path: Path, messages: int) -> None:
    """Write an MCAP file with the mcap library's defaults: chunks of 1 MB, zstd."""
    from mcap.writer import Writer
    from rosbags.typesys import Stores, get_typestore

    text, _ = get_typestore(Stores.ROS2_HUMBLE).generate_msgdef("sensor_msgs/msg/JointState", ros_version=2)
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        schema = writer.register_schema("sensor_msgs/msg/JointState", "ros2msg", text.encode())
        channel = writer.register_channel("/joint_states", "cdr", schema)
        for log_time, payload in serialised(messages, "cdr"):
            writer.add_message(channel, log_time, payload, log_time)
        writer.finish()  # type: ignore[no-untyped-call]


def read_ours(path: Path, messages: int) -> tuple[Samples, ...]:
    """Read with friction-audit."""
    from friction_audit.io.readers import choose_reader
    from friction_audit.io.readers.reader import ReadOptions

    recording = choose_reader(path).loaded.read(path, ReadOptions())
    assert len(recording.t) == messages
    assert recording.joint_names == tuple(NAMES)
    return tuple(recording.channels[name] for name in ("q", "dq", "tau_J"))


def collected(messages: int, decoded: Iterator[Any]) -> tuple[Samples, ...]:
    """Put messages that were decoded one by one into arrays."""
    arrays = tuple(np.empty((messages, JOINTS)) for _ in FIELDS)
    for index, message in enumerate(decoded):
        for array, field in zip(arrays, FIELDS, strict=True):
            array[index] = getattr(message, field)
    return arrays


def read_rosbags(path: Path, messages: int) -> tuple[Samples, ...]:
    """Read with rosbags, decoding every message."""
    from rosbags.highlevel import AnyReader

    with AnyReader([path]) as reader:
        decoded = (reader.deserialize(raw, connection.msgtype) for connection, _, raw in reader.messages())
        return collected(messages, decoded)


def read_mcap_ros2(path: Path, messages: int) -> tuple[Samples, ...]:
    """Read with mcap and mcap-ros2-support."""
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        return collected(messages, (decoded for _, _, _, decoded in reader.iter_decoded_messages()))


METHODS: dict[str, Callable[[Path, int], tuple[Samples, ...]]] = {
    "friction-audit": read_ours,
    "rosbags AnyReader.deserialize": read_rosbags,
    "mcap + mcap-ros2-support": read_mcap_ros2,
}


@dataclass(frozen=True)
class Container:
    """A file to read: its name, who writes it, who else reads it, and the ratio to reach."""

    name: str
    file: str
    write: Callable[[Path, int], None]
    rivals: tuple[tuple[str, float], ...]


CONTAINERS = (
    Container("rosbag1", "joints.bag", write_rosbag1, (("rosbags AnyReader.deserialize", 20.0),)),
    Container("sqlite3", "joints_sqlite3", write_sqlite3, (("rosbags AnyReader.deserialize", 12.0),)),
    Container(
        "MCAP (zstd)",
        "joints.mcap",
        write_mcap,
        (("mcap + mcap-ros2-support", 10.0), ("rosbags AnyReader.deserialize", 15.0)),
    ),
)


def peak_memory_mb() -> float:
    """Return the peak resident memory of this process since it began; getrusage would count its parent's in."""
    found = re.search(r"VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text(encoding="ascii"))
    assert found
    return int(found[1]) * 1024 / MEGABYTE


def measure(method: str, path: Path, messages: int) -> dict[str, Any]:
    """Read a file in this process; returns what was measured."""
    before = peak_memory_mb()
    begin = time.perf_counter()
    arrays = METHODS[method](path, messages)
    seconds = time.perf_counter() - begin
    peak = peak_memory_mb()
    kept = sum(array.nbytes for array in arrays)
    return {
        "seconds": seconds,
        "peak_mb": peak,
        "start_mb": before,
        "kept_mb": kept / MEGABYTE,
        "digest": digest(*arrays),
    }


def measure_apart(method: str, path: Path, messages: int, repeat: int) -> dict[str, Any]:
    """Read a file in fresh processes; returns the run of median time."""
    command = [sys.executable, "-m", "benchmarks.bench_bags", "--child", method, "--path", str(path)]
    command += ["--messages", str(messages)]
    turns = range(repeat + 1)  # the first one compiles the modules
    outputs = [subprocess.run(command, check=True, capture_output=True, env=INSTALLED).stdout for _ in turns]
    runs: list[dict[str, Any]] = [json.loads(output) for output in outputs[1:]]
    return sorted(runs, key=lambda run: run["seconds"])[repeat // 2]


def compare(container: Container, folder: Path, messages: int, repeat: int) -> Iterator[str]:
    """Write one container, read it with every method, and yield rows of the table."""
    path = folder / container.file
    container.write(path, messages)
    expected = digest(*truth(messages))
    ours = measure_apart("friction-audit", path, messages, repeat)
    results = [("friction-audit", ours, "")]
    for name, goal in container.rivals:
        rival = measure_apart(name, path, messages, repeat)
        results.append((name, rival, f"{rival['seconds'] / ours['seconds']:.1f} (goal {goal:g})"))
    for name, run, ratio in results:
        if run["digest"] != expected:
            raise SystemExit(f"{container.name}, {name}: other numbers than were written")
        rate = f"{messages / run['seconds'] / 1e3:.0f} k"
        yield f"| {container.name} | {name} | {rate} | {ratio} | {run['peak_mb']:.0f} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--messages", type=int, default=200_000)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--child", choices=METHODS, help=argparse.SUPPRESS)
    parser.add_argument("--path", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.child:
        print(json.dumps(measure(arguments.child, arguments.path, arguments.messages)))
        return
    print(f"{arguments.messages} JointState messages of {JOINTS} joints, median of {arguments.repeat} runs\n")
    print("| container | method | messages/s | friction-audit is faster by | peak [MB] |")
    print("|---|---|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        for container in CONTAINERS:
            for row in compare(container, Path(folder), arguments.messages, arguments.repeat):
                print(row, flush=True)


if __name__ == "__main__":
    main()
