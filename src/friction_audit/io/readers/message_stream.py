"""Which message fields are which channel: the table of joint state messages.

A definition is matched by its fields, not by its type's name: any message that has the fields of a row is readable.
Field names are compared without regard to case, since ROS 2 forced lower case on libfranka's names.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import BinaryIO, Protocol

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.joint_log import Finding, Float


@dataclass(frozen=True, kw_only=True, slots=True)
class MessageKind:
    """One family of joint state messages.

    Attributes:
        rank: Preference when a file holds several; the smallest wins.
        fields: Channel -> dotted path of its array.
        required: Channels of which a definition must have all.
        names: Path of the joint names, if the message carries them.
        robot_time: Path of the robot's own clock. [s]
        stamps: Paths of the source's time stamp, the first one present is taken.
        elements: Path of a list with one entry per joint; the other paths then lie within an entry.
    """

    rank: int
    fields: Mapping[str, str]
    required: tuple[str, ...]
    names: str | None = None
    robot_time: str | None = None
    stamps: tuple[str, ...] = ("header.stamp",)
    elements: str | None = None


KINDS: tuple[MessageKind, ...] = (
    # nested FrankaRobotState
    MessageKind(
        rank=0,
        fields={
            "q": "measured_joint_state.position",
            "dq": "measured_joint_state.velocity",
            "tau_J": "measured_joint_state.effort",
            "tau_J_d": "desired_joint_state.effort",
            "tau_ext_hat_filtered": "tau_ext_hat_filtered.effort",
        },
        required=("q", "dq", "tau_J"),
        names="measured_joint_state.name",
        robot_time="time",
    ),
    # FrankaState
    MessageKind(
        rank=0,
        fields={
            "q": "q",
            "dq": "dq",
            "tau_J": "tau_J",
            "tau_J_d": "tau_J_d",
            "tau_ext_hat_filtered": "tau_ext_hat_filtered",
            "gravity": "gravity",
            "tau_interaction": "tau_interaction",
            "tau_compensation": "tau_compensation",
            "tau_passivity": "tau_passivity",
            "temperature": "temperature",
        },
        required=("q", "dq"),
        names="name",
        robot_time="time",
        stamps=("header.stamp", "stamp"),
    ),
    # JointState
    MessageKind(
        rank=1,
        fields={"q": "position", "dq": "velocity", "tau_J": "effort"},
        required=("q", "dq", "tau_J"),
        names="name",
        stamps=("header.stamp", "timestamp", "stamp"),
    ),
    # foxglove JointStates
    MessageKind(
        rank=1,
        fields={"q": "position", "dq": "velocity", "tau_J": "effort"},
        required=(),
        names="name",
        stamps=("timestamp",),
        elements="joints",
    ),
)
"""In the order in which a definition is tried."""


def match_kind(paths: Iterable[str]) -> MessageKind | None:
    """Find the kind that a message with these fields belongs to, its paths spelled as the message spells them.

    Args:
        paths: Dotted paths of all fields of the message, lists of entries included.
    """
    spelled = {path.lower(): path for path in paths}
    for kind in KINDS:
        wanted = (kind.elements,) if kind.elements else tuple(kind.fields[channel] for channel in kind.required)
        if all(path.lower() in spelled for path in wanted):
            return kind if kind.elements else _spell(kind, spelled)
    return None


def _spell(kind: MessageKind, spelled: Mapping[str, str]) -> MessageKind:
    fields = {channel: spelled[path.lower()] for channel, path in kind.fields.items() if path.lower() in spelled}
    return replace(
        kind,
        fields=fields,
        names=spelled.get((kind.names or "").lower()),
        robot_time=spelled.get((kind.robot_time or "").lower()),
        stamps=tuple(spelled[path] for path in kind.stamps if path in spelled),
    )


Int = NDArray[np.int64]

SHORTEST_RUN = 16
"""A run of equally long messages shorter than this means that topics alternate: no more runs are looked for."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Connection:
    """One publisher's stream in a file; several connections may share a topic.

    Attributes:
        key: What the container calls it, unique in the stream.
        topic: Topic name, with its leading slash if the file has one.
        type: Message type, ``package/msg/Name`` for ROS.
        encoding: How payloads are serialised: ``"ros1"``, ``"cdr"``, ``"json"``, ``"protobuf"`` or something else.
        definition: The message definition that the file carries, empty if it carries none.
        definition_format: Language of the definition, e.g. ``"ros2msg"``, ``"ros2idl"``, ``"protobuf"``.
        messages: Number of messages, or None when the file does not tell.
    """

    key: int
    topic: str
    type: str
    encoding: str
    definition: bytes = b""
    definition_format: str = ""
    messages: int | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Block:
    """Consecutive messages of one connection: payloads as ranges of one buffer.

    Attributes:
        key: Key of the connection.
        log_time: Time at which each message was recorded, shape (n,). [ns]
        buffer: Bytes that hold all payloads.
        start: Offset of each payload in the buffer, shape (n,).
        size: Length of each payload, shape (n,). [byte]
    """

    key: int
    log_time: Int
    buffer: bytes
    start: Int
    size: Int

    def __len__(self) -> int:
        """Return the number of messages."""
        return len(self.log_time)

    def payload(self, index: int) -> bytes:
        """Return one payload."""
        first = int(self.start[index])
        return self.buffer[first : first + int(self.size[index])]


@dataclass(slots=True)
class Window:
    """A part of a log by the time of recording, and what was left out on either side of it.

    Attributes:
        first: Log time of its start. [ns]
        last: Log time of its end. [ns]
        before: True if messages before it were left out.
        after: True if messages after it were left out.
        latest: Latest log time of the messages left out before it. [ns]
    """

    first: float
    last: float
    before: bool = False
    after: bool = False
    latest: float = -inf

    def leaves_out(self, times: tuple[int, int]) -> bool:
        """Return True if messages from one log time to another lie outside; times that run back are not trusted."""
        first, last = times
        earlier, later = first <= last < self.first, last >= first > self.last
        self.after |= later
        if earlier:
            self.before, self.latest = True, max(self.latest, last)
        return earlier or later

    def part_of(self, block: "Block") -> "Block":
        """Return the messages of a block that lie inside."""
        earlier, later = block.log_time < self.first, block.log_time > self.last
        self.after |= bool(later.any())
        if earlier.any():
            self.before, self.latest = True, max(self.latest, float(block.log_time[earlier].max()))
        kept = ~(earlier | later)
        return Block(block.key, block.log_time[kept], block.buffer, block.start[kept], block.size[kept])


@dataclass(frozen=True, slots=True)
class Damage:
    """Where a file is broken.

    Attributes:
        byte: Offset in the file up to which everything was sound, or None where that is not known.
        file_bytes: Length of the file.
        reason: What is wrong there.
    """

    byte: int | None
    file_bytes: int
    reason: str


class MessageStream(Protocol):
    """What every container offers; ``damage`` is complete once all blocks have been read."""

    @property
    def connections(self) -> tuple[Connection, ...]:
        """Connections in the file."""

    @property
    def damage(self) -> tuple[Damage, ...]:
        """What was found broken so far."""

    def blocks(self, keys: Collection[int], window: Window | None = None) -> Iterator[Block]:
        """Yield the messages of some connections, in the order of the file; the window may be exceeded."""


def block_of_ranges(key: int, buffer: bytes, ranges: Sequence[tuple[int, int, int]]) -> Block:
    """Make a block of the offset, length and time of each payload in a buffer."""
    start, size, log_time = np.array(ranges, np.int64).T
    return Block(key, log_time, buffer, start, size)


def block_of_payloads(key: int, log_time: Sequence[int], payloads: Sequence[bytes]) -> Block:
    """Join separate payloads into one block."""
    size = np.fromiter(map(len, payloads), np.int64, len(payloads))
    start = np.concatenate(([0], np.cumsum(size)[:-1])).astype(np.int64)
    return Block(key, np.array(log_time, np.int64), b"".join(payloads), start, size)


@contextmanager
def open_log(path: Path) -> Iterator[BinaryIO]:
    """Open a log for reading.

    Raises:
        InputError: If the file cannot be opened or read.
    """
    try:
        with path.open("rb") as file:
            yield file
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; check the path and its permissions") from error


NANOSECONDS = 1e9
FIRST_UNIX_TIME_S = 1e9  # September 2001: below it, a clock counts from something else than 1970
DISAGREEMENT_SD_S = 5e-3
DISAGREEMENT_STEPS = 2.0
DISAGREEMENT_DRIFT = 2e-4
ROBOT_TIME_UNITS = ((1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds"))
UNIT_TOLERANCE = 0.2
CLOCK_TITLES = {"robot_time": "the robot's own time", "header_stamp": "the header stamp", "log_time": "the log time"}


@dataclass(frozen=True, eq=False, slots=True)
class MessageClock:
    """The clock chosen: name, t from its smallest value [s], Unix time of t = 0 or None, what was noticed."""

    name: str
    t: Float
    start_s: float | None
    findings: tuple[Finding, ...]


def choose_clock(log_time: Int, stamp: Int | None, robot_time: Float | None) -> MessageClock:
    """Choose the best clock that runs.

    Args:
        log_time: Time of recording, shape (n,). [ns]
        stamp: Time stamp of the source, if there is one. [ns]
        robot_time: The robot's own clock, if there is one. [s]
    """
    robot_time, units = (None, []) if robot_time is None else _in_seconds(robot_time, log_time)
    # Differences are taken in integers: 1.7e18 ns has no room for nanoseconds in a float64.
    offered = {
        "robot_time": None if robot_time is None else robot_time - np.min(robot_time),
        "header_stamp": None if stamp is None else (stamp - stamp.min()) / NANOSECONDS,
        "log_time": (log_time - log_time.min()) / NANOSECONDS,
    }
    clocks = {name: t for name, t in offered.items() if t is not None}
    stopped = [name for name, t in clocks.items() if not _runs(t)]
    chosen = next((name for name in clocks if name not in stopped), "log_time")
    findings = units + [_stopped_finding(name, chosen) for name in stopped if name != chosen]
    if chosen != "log_time":
        findings += _disagreement(clocks[chosen], clocks["log_time"], chosen)
    return MessageClock(chosen, clocks[chosen], _start(chosen, log_time, stamp), tuple(findings))


def _in_seconds(robot_time: Float, log_time: Int) -> tuple[Float, list[Finding]]:
    """Recognise a robot's clock that counts in milli-, micro- or nanoseconds: by that factor faster than the log."""
    logged_s = float(np.ptp(log_time)) / NANOSECONDS
    ratio = float(np.ptp(robot_time)) / logged_s if logged_s > 0.0 else 1.0
    for factor, unit in ROBOT_TIME_UNITS:
        if abs(ratio / factor - 1.0) < UNIT_TOLERANCE:
            message = (
                f"the robot's own time counts in {unit}, by comparison with the log time; it was divided by {factor:g}"
            )
            return robot_time / factor, [Finding(code="robot_time_unit", message=message, amount=factor)]
    return robot_time, []


def _runs(t: Float) -> bool:
    """Return True if a clock is finite and does not stand still; a single message cannot tell."""
    return bool(np.isfinite(t).all()) and (len(t) == 1 or bool(t.max() > 0.0))


def _stopped_finding(name: str, chosen: str) -> Finding:
    return Finding(
        code="clock_stopped",
        message=f"{CLOCK_TITLES[name]} is the same (or not a number) in all messages; {CLOCK_TITLES[chosen]} was used",
    )


def _start(chosen: str, log_time: Int, stamp: Int | None) -> float | None:
    """Return the Unix time of t = 0; the robot's clock counts from its start, so the log time stands in for it."""
    source = stamp if chosen == "header_stamp" and stamp is not None else log_time
    start_s = float(source.min()) / NANOSECONDS
    return start_s if start_s > FIRST_UNIX_TIME_S else None


def _disagreement(t: Float, log_t: Float, chosen: str) -> list[Finding]:
    """Compare the clock chosen with the log time: a drift, and what is left after it."""
    if len(t) < 3 or not log_t.max() > 0.0:  # noqa: PLR2004
        return []
    difference = log_t - t
    centred = t - t.mean()
    drift = float(centred @ difference / (centred @ centred))
    sd_s = float(np.std(difference - drift * centred))
    limit_s = max(DISAGREEMENT_SD_S, DISAGREEMENT_STEPS * float(t.max()) / (len(t) - 1))
    findings = []
    if sd_s > limit_s:
        text = f"{CLOCK_TITLES[chosen]} and the log time differ irregularly, standard deviation {sd_s * 1e3:.3g} ms"
        findings.append(Finding(code="clock_disagreement", amount=sd_s, message=f"{text}; {chosen} was used"))
    if abs(drift) > DISAGREEMENT_DRIFT and abs(drift) * t.max() > limit_s:
        text = f"the log time runs {drift * 100:+.3g} % against {CLOCK_TITLES[chosen]}"
        findings.append(Finding(code="clock_disagreement", amount=drift, message=f"{text}; {chosen} was used"))
    return findings
