"""Which topic, and which arm on it, to read: chosen if there is no doubt, otherwise left to the user."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

from friction_audit.errors import InputError
from friction_audit.io.readers.joint_names import DRIVER_NODES, UNNAMED_ARM, arm_name, arms_in, namespace
from friction_audit.io.readers.message_decoder import MessageDecoder
from friction_audit.io.readers.message_kinds import MessageKind, Row
from friction_audit.io.readers.reader import SeveralLogsError, Topic
from friction_audit.joint_log import TORQUE_CHANNELS, Finding

_NOT_MEASURED = re.compile(r"desired|command|target|goal|motor_state|external")


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Candidate:
    """A topic whose messages can be read as joint states."""

    topic: str  # its name
    type: str  # its message type
    messages: int | None  # number of messages, or None when the file does not say
    kind: MessageKind  # which fields are which channel
    decoders: Mapping[int, MessageDecoder]  # key of each connection -> its decoder
    rows: Sequence[Row] = field(default=())  # the first messages, decoded

    @property
    def arms(self) -> dict[str, tuple[str, ...]]:
        """Prefix of each arm in the messages -> its joints."""
        return arms_in([name for row in self.rows for name in row.names])

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels that have content in the first messages, in the order of the kind's table."""
        return tuple(name for name in self.kind.fields if any(name in row.channels for row in self.rows))


def choose_topic(
    path: Path, candidates: Sequence[Candidate], topics: Sequence[Topic], wanted: str | None
) -> tuple[Candidate, tuple[str, ...], tuple[Finding, ...]]:
    """Return the topic to read, the joints of the arm to read, and what to say about the choice.

    SeveralLogsError if the file holds several arms and the user named none.
    """
    if wanted is not None:
        name, _, arm = wanted.partition("#")
        candidate = _named(path, candidates, topics, name)
        return candidate, _arm_joints(path, candidate, arm), ()
    measured = [c for c in candidates if c.arms and not _NOT_MEASURED.search(c.topic.rsplit("/", 1)[-1])]
    if not measured:
        raise InputError(_nothing_to_read(path, candidates, topics))
    namespaces = {namespace(candidate.topic) for candidate in measured} - {""}
    prefixes = {arm for candidate in measured for arm in candidate.arms} - {""}
    if len(namespaces) > 1 or len(prefixes) > 1:
        message = f"{path}: several arms in one log; choose one with {_choices(measured)}"
        raise SeveralLogsError(message, _best_of_each_arm(measured))
    best = min(measured, key=_preference)
    return best, _arm_joints(path, best, ""), _others_finding(best, [c for c in measured if c is not best])


def _preference(candidate: Candidate) -> tuple[bool, int, bool, int]:
    """Torque before none, libfranka's own messages before others, first hand before republished, then the rate."""
    first_hand = bool(DRIVER_NODES & set(candidate.topic.split("/")))
    torque = any(name in candidate.channels for name in TORQUE_CHANNELS)
    return not torque, candidate.kind.rank, not first_hand, -(candidate.messages or 0)


def _best_of_each_arm(candidates: Sequence[Candidate]) -> list[str]:
    """Return the best topic for each arm, arms distinguished by the names of their joints, else by namespace."""
    found: dict[str, str] = {}
    for candidate in sorted(candidates, key=_preference):
        for arm in candidate.arms:
            found.setdefault(arm_name(arm) or namespace(candidate.topic), _topic(candidate, arm))
    return [found[arm] for arm in sorted(found)]


def _topic(candidate: Candidate, arm: str) -> str:
    return f"{candidate.topic}#{arm or UNNAMED_ARM}" if len(candidate.arms) > 1 else candidate.topic


def _choices(candidates: Sequence[Candidate]) -> str:
    lines = []
    for candidate in candidates:
        count = "" if candidate.messages is None else f" ({candidate.messages} messages)"
        lines += [f"--topic '{_topic(candidate, arm)}'{count}" for arm in candidate.arms]
    return " or ".join(lines)


def _arm_joints(path: Path, candidate: Candidate, wanted: str) -> tuple[str, ...]:
    arms = {arm or UNNAMED_ARM: joints for arm, joints in candidate.arms.items()}
    if not arms:
        raise InputError(f"{path}: topic {candidate.topic} has no joints in its messages; choose another with --topic")
    if wanted in arms:
        return arms[wanted]
    if wanted:
        raise InputError(
            f"{path}: no arm {wanted!r} on topic {candidate.topic}; it has {', '.join(arms)}; "
            f"choose with {_choices([candidate])}"
        )
    if len(arms) > 1:
        message = f"{path}: several arms on topic {candidate.topic}; choose one with {_choices([candidate])}"
        raise SeveralLogsError(message, _best_of_each_arm([candidate]))
    return next(iter(arms.values()))


def _named(path: Path, candidates: Sequence[Candidate], topics: Sequence[Topic], wanted: str) -> Candidate:
    for candidate in candidates:
        if candidate.topic.strip("/") == wanted.strip("/"):
            return candidate
    there = next((topic for topic in topics if topic.name.strip("/") == wanted.strip("/")), None)
    if there is not None and there.messages == 0:
        raise InputError(f"{path}: topic {there.name} has no messages; {_listed(topics)}")
    if there is not None:
        raise InputError(
            f"{path}: topic {there.name} of type {there.type} holds no joint state that can be read; expected fields "
            f"q, dq and tau_J, or position, velocity and effort; {_listed(topics)}"
        )
    near = get_close_matches(wanted, [topic.name for topic in topics], cutoff=0.5)
    hint = f"did you mean {' or '.join(near)}? " if near else ""
    raise InputError(f"{path}: no topic {wanted}; {hint}{_listed(topics)}; choose one with --topic")


def _nothing_to_read(path: Path, candidates: Sequence[Candidate], topics: Sequence[Topic]) -> str:
    if not topics:
        return f"{path}: no messages at all; expected a topic with joint states; check that the recording was running"
    if candidates and not any(topic.messages for topic in topics if topic.name in {c.topic for c in candidates}):
        names = ", ".join(dict.fromkeys(candidate.topic for candidate in candidates))
        return (
            f"{path}: 0 messages on {names}; expected joint states; {_listed(topics)}; check that the robot was "
            "running, and record again"
        )
    if broken := next((candidate for candidate in candidates if not candidate.rows), None):
        return (
            f"{path}: the first messages on topic {broken.topic} of type {broken.type} do not fit their definition; "
            f"{_listed(topics)}; choose another one with --topic, or record again"
        )
    return (
        f"{path}: no topic with measured joint states; expected fields q, dq and tau_J, or position, velocity and "
        f"effort; {_listed(topics)}; name the fields with --topic and --map if one of them holds the joints"
    )


def _listed(topics: Sequence[Topic]) -> str:
    listed = ", ".join(f"{topic.name} ({topic.type}{_count(topic.messages)})" for topic in topics)
    return f"topics are {listed}" if topics else "there are no topics"


def _count(messages: int | None) -> str:
    return "" if messages is None else f", {messages} messages"


def _others_finding(best: Candidate, others: Sequence[Candidate]) -> tuple[Finding, ...]:
    if not others:
        return ()
    names = ", ".join(f"{c.topic} ({c.type}{_count(c.messages)})" for c in others)
    message = f"{best.topic} ({best.type}{_count(best.messages)}) was read; also there: {names}; choose with --topic"
    return (Finding(code="topic_chosen", message=message),)
