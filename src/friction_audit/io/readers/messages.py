"""A stream of messages -> Recording: what all message containers have in common."""

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from difflib import get_close_matches
from functools import partial
from itertools import chain, islice
from pathlib import Path

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.files import stamp_of
from friction_audit.io.readers.channel_names import serial_in
from friction_audit.io.readers.columns import MOST_JOINTS
from friction_audit.io.readers.joint_names import robot_of
from friction_audit.io.readers.message_decoder import DefinitionError, MessageDecoder, decoder_for, needs_message
from friction_audit.io.readers.message_kinds import Candidate, MessageKind, Row, choose_topic, match_kind, row_of
from friction_audit.io.readers.message_samples import JointDecoder, JointSamples, MessageClock, choose_clock
from friction_audit.io.readers.message_stream import (
    Block,
    Connection,
    MessageStream,
    UndecodableError,
    Window,
    block_of_payloads,
)
from friction_audit.io.readers.reader import IN_BLOCKS_BYTES, MARGIN_S, ReadOptions, Topic, refuse_too_large
from friction_audit.io.recording import Blocks, Recording
from friction_audit.joint_log import Finding, Float, find_window

_SAMPLED_MESSAGES = 16  # first messages of a topic, from which its joints and channels are known
_CLOCK_DRIFT = 0.01  # most drift of the time of recording against the source's clock; beyond, the whole log is read
_MOST_TIMES_SMALLER = 100  # a count in the file is believed up to a file of a hundredth of the size of its samples
_NANOSECONDS = 1e9
_UNIT = re.compile(r":m?A$")  # of a motor current, after the name of a field in --map
_CLOCKS = 3  # arrays of times that are kept with the channels
_MOST_CLOCKS = 1 << 22  # messages whose clocks are compared where a log is read in blocks, spread evenly over it
_BLOCK_ROWS = 1 << 16

Open = Callable[[Path], AbstractContextManager[MessageStream]]
_Readable = tuple[Connection, MessageDecoder, MessageKind, Block]  # with its first messages


def read_messages(open_stream: Open, path: Path, options: ReadOptions) -> Recording:
    """Read the joint states in a file; InputError, or SeveralLogsError if it holds several arms and none was named."""
    with open_stream(path) as stream:
        recording = _read(path, stream, options)
        return replace(recording, serial=serial_in(stream.notes))


def topics_of(open_stream: Open, path: Path) -> tuple[Topic, ...]:
    """List the topics in a file."""
    with open_stream(path) as stream:
        return _topics(stream, _candidates(path, stream, ReadOptions()))


def _read(path: Path, stream: MessageStream, options: ReadOptions) -> Recording:
    candidates = _candidates(path, stream, options)
    chosen, joints, findings = choose_topic(path, candidates, _topics(stream, candidates), options.topic)
    decoder = JointDecoder(chosen, joints, chosen.channels)
    row_bytes = np.float64().itemsize * (len(chosen.channels) * len(joints) + _CLOCKS)
    expected = min(chosen.messages, _MOST_TIMES_SMALLER * stamp_of(path).size // row_bytes)
    size, missing, blocks, skipped = expected * row_bytes, list[Finding](), None, 0
    part = _read_part(path, stream, decoder, options) if options.reads_part(size) else None
    if part is None:
        in_blocks = options.in_blocks and stream.is_lasting and size > IN_BLOCKS_BYTES
        if in_blocks:  # the clocks alone
            samples = JointSamples(len(joints), (), expected, every=-(-expected // _MOST_CLOCKS))
        else:
            refuse_too_large(path, size, size)
            samples = JointSamples(len(joints), chosen.channels, expected)
        decoder.undecodable = decoder.incomplete = 0
        missing = _missing(stream, chosen, _collect(stream, decoder, samples))
    else:
        samples, skipped = part
    if not samples.count:
        raise InputError(
            f"{path}: none of the messages on topic {chosen.topic} can be decoded as {chosen.type}; choose another "
            "topic with --topic"
        )
    clock, kind = choose_clock(samples.times), chosen.kind
    t, channels = clock.t[skipped:], {name: array[skipped:] for name, array in samples.channels.items()}
    if not channels:
        t, channels = np.empty(0), {name: np.empty((0, len(joints))) for name in chosen.channels}
        blocks = Blocks(rows=samples.rows, read=partial(_blocks, stream, decoder, clock, samples.rows))
    shown = f"{kind.elements}[{{i}}].%s" if kind.elements else "%s[{i}]"
    units = {name: found[0] for name, text in options.mapping.items() if (found := _UNIT.search(text))}
    left_out = dict.fromkeys(name for row in chosen.rows for name in row.names if name not in joints)
    if left_out:  # as the joints of a gripper are
        text = f"left out, no joints of the arm: {', '.join(left_out)}"
        findings += (Finding(code="joints_left_out", message=text, amount=float(len(left_out))),)
    findings += (*_empty_channels(chosen, candidates), *_losses(stream, decoder, samples.rows), *missing)
    return Recording(
        t=t,
        channels=channels,
        first_s=float(clock.t[:skipped].min()) if skipped else None,
        joint_names=joints,
        clock=clock.name,
        start_s=clock.start_s,
        origin_s=clock.origin_s,
        robot=_robot(joints, candidates),
        topic=chosen.topic,
        mapping={name: shown % kind.fields[name] + units.get(name, "") for name in channels},
        findings=(*findings, *clock.findings),
        blocks=blocks,
    )


def _blocks(
    stream: MessageStream, decoder: JointDecoder, clock: MessageClock, rows: int, names: Collection[str]
) -> Iterator[tuple[Float, dict[str, Float]]]:
    """Yield the clock of many messages, and those of their channels that are asked for, again and again."""
    chosen, joints = decoder.chosen, decoder.joints
    wanted = [name for name in chosen.channels if name in names]
    if not wanted and len(clock.t) == rows:
        yield from ((clock.t[first : first + _BLOCK_ROWS].copy(), {}) for first in range(0, rows, _BLOCK_ROWS))
        return
    decoder, samples = JointDecoder(chosen, joints, wanted), JointSamples(len(joints), wanted, _BLOCK_ROWS)
    for block in chain(stream.blocks(list(chosen.decoders)), [None]):  # None at the end
        if block is not None:
            samples.add(decoder.decode(block))
        if samples.count >= (1 if block is None else _BLOCK_ROWS):
            samples.resize(samples.count)
            yield clock.time_of(samples.times), samples.channels
            samples = JointSamples(len(joints), wanted, _BLOCK_ROWS)


def _topics(stream: MessageStream, candidates: Sequence[Candidate]) -> tuple[Topic, ...]:
    readable = {candidate.topic for candidate in candidates}
    groups: dict[str, list[Connection]] = {}
    for connection in stream.connections:
        groups.setdefault(connection.topic, []).append(connection)
    return tuple(
        Topic(name=name, type=own[-1].type, messages=sum(c.messages for c in own), readable=name in readable)
        for name, own in groups.items()
    )


def _candidates(path: Path, stream: MessageStream, options: ReadOptions) -> list[Candidate]:
    """Find the topics that can be read, with their first messages decoded."""
    wanted = options.topic.partition("#")[0].strip("/") if options.topic else None
    # actual.velocities[{i}] names the array actual.velocities
    stated = {c: _UNIT.sub("", text).replace("[{i}]", "").replace(".{i}", "") for c, text in options.mapping.items()}
    found: dict[str, list[_Readable]] = {}
    refusals: list[InputError] = []
    for connection in stream.connections:
        if connection.messages == 0:
            continue
        is_wanted = wanted in (None, connection.topic.strip("/"))
        decoder, first = _decoder(path, stream, connection, is_wanted=connection.topic.strip("/") == wanted)
        try:
            kind = _kind(path, connection, decoder.paths, stated if is_wanted else {}) if decoder else None
        except InputError as error:
            refusals.append(error)
            continue
        if decoder and kind and (first := first or _first_block(stream, connection)):
            found.setdefault(connection.topic, []).append((connection, decoder, kind, first))
    if refusals and (wanted is not None or not found):
        raise refusals[0]
    return [
        _candidate(path, topic, group, is_wanted=wanted in (None, topic.strip("/"))) for topic, group in found.items()
    ]


def _candidate(path: Path, topic: str, group: Sequence[_Readable], *, is_wanted: bool) -> Candidate:
    """Decode the first messages of a topic's connections of the kind of the first one."""
    first, _, kind, _ = group[0]
    same = [one for one in group if one[2] == kind]
    rows = [row for _, decoder, _, block in same for row in _first_rows(block, decoder, kind)]
    joints = max((len(row.names) for row in rows), default=0)
    if joints > MOST_JOINTS and is_wanted:
        raise InputError(
            f"{path}: a message on topic {topic} holds {joints} joints; expected at most {MOST_JOINTS}; "
            "choose another topic with --topic"
        )
    decoders = {connection.key: decoder for connection, decoder, *_ in same}
    messages = sum(connection.messages for connection, *_ in same)
    return Candidate(topic=topic, type=first.type, messages=messages, kind=kind, decoders=decoders, rows=rows)


def _decoder(
    path: Path, stream: MessageStream, connection: Connection, *, is_wanted: bool
) -> tuple[MessageDecoder | None, Block | None]:
    """Make a decoder, from the first messages where the file does not define them, which are then returned too."""
    first = None
    try:
        decoder = decoder_for(connection, None)
        if decoder is None and needs_message(connection):
            first = _first_block(stream, connection)
            payloads = map(first.payload, range(len(first))) if first else ()
            made = (decoder_for(connection, payload) for payload in payloads)
            decoder = next((one for one in made if one is not None and one.paths), None)
    except DefinitionError as error:  # a broken definition matters only on the topic that the user asked for
        if not is_wanted:
            return None, None
        raise InputError(
            f"{path}: topic {connection.topic} of type {connection.type} cannot be read: {error}; "
            "choose another topic with --topic, or convert the log"
        ) from error
    return decoder, first


def _first_block(stream: MessageStream, connection: Connection) -> Block | None:
    """Return the first messages of a connection, which may lie in several blocks."""
    blocks = stream.blocks([connection.key])
    timed = ((int(one.log_time[index]), one.payload(index)) for one in blocks for index in range(len(one)))
    found = list(islice(timed, min(_SAMPLED_MESSAGES, connection.messages)))
    return block_of_payloads(connection.key, *zip(*found, strict=True)) if found else None


def _first_rows(block: Block, decoder: MessageDecoder, kind: MessageKind) -> Iterator[Row]:
    for index in range(len(block)):
        try:
            row = row_of(decoder.decode(block.payload(index)), kind)
        except UndecodableError:
            continue  # counted when the topic is read
        yield row
        if len(row.names) > MOST_JOINTS:
            return


def _kind(path: Path, connection: Connection, paths: Sequence[str], stated: Mapping[str, str]) -> MessageKind | None:
    """Match the fields of a connection; what the user mapped wins, InputError if it does not have that."""
    absent = [field for field in stated.values() if field not in paths]
    if absent:
        near = sorted({name for field in absent for name in get_close_matches(field, paths, cutoff=0.5)})
        hint = f"; did you mean {', '.join(near)}?" if near else ""
        raise InputError(
            f"{path}: topic {connection.topic}: no field {', '.join(absent)} in {connection.type}{hint}; "
            f"its fields are {', '.join(paths)}; correct --map"
        )
    kind = match_kind(paths)
    if not stated:
        return kind
    stamps = ("header.stamp",) if "header.stamp" in paths else ()
    kind = kind or MessageKind(rank=0, fields={}, required=(), stamps=stamps)
    fields = {**kind.fields, **{channel: field for channel, field in stated.items() if channel != "t"}}
    return replace(kind, fields=fields, robot_time=stated.get("t", kind.robot_time))


def _collect(
    stream: MessageStream, decoder: JointDecoder, samples: JointSamples, window: Window | None = None
) -> Counter[int]:
    """Decode the messages of the topic chosen; returns how many each connection has."""
    seen: Counter[int] = Counter()
    for found in stream.blocks(list(decoder.chosen.decoders), window):
        block = window.part_of(found) if window else found
        seen[block.key] += len(block)
        if len(block):
            samples.add(decoder.decode(block))
    samples.resize(samples.count)
    return seen


def _read_part(
    path: Path, stream: MessageStream, decoder: JointDecoder, options: ReadOptions
) -> tuple[JointSamples, int] | None:
    """Decode the first messages, from which time counts, and those of the part asked for, found by log time.

    Returns also how many are the first ones; None if the log time does not follow the clock chosen.
    """
    chosen = decoder.chosen
    samples = JointSamples(len(decoder.joints), chosen.channels, 0)
    for connection in stream.connections:
        if connection.key in chosen.decoders and (first := _first_block(stream, connection)):
            samples.add(decoder.of_messages(first))
    skipped, decoder.undecodable = samples.count, 0
    if not skipped:
        return None
    start, stop = options.window_of_clock()
    origin = float(samples.times["log_time"].min())
    window = Window(
        origin + _NANOSECONDS * (start - MARGIN_S - _CLOCK_DRIFT * abs(start)),
        origin + _NANOSECONDS * (stop + MARGIN_S + _CLOCK_DRIFT * abs(stop)),
    )
    _collect(stream, decoder, samples, window)
    if samples.count == skipped:
        duration = max(window.latest - origin, 0.0) / _NANOSECONDS * options.time_scale
        find_window(np.array([0.0, duration]), options.t_start_s, options.t_end_s, str(path))
        return None
    t = choose_clock(samples.times).t
    t = t[skipped:] - t[:skipped].min()
    reached = (not window.before or t.min() <= start) and (not window.after or t.max() >= stop)
    return (samples, skipped) if reached else None


def _missing(stream: MessageStream, chosen: Candidate, seen: Mapping[int, int]) -> list[Finding]:
    """Compare the messages read with their number by the file's own index and by metadata.yaml."""
    own = [c for c in stream.connections if c.topic == chosen.topic]
    indexed = sum(max(c.messages - seen[c.key], 0) for c in own if c.key in chosen.decoders)
    found = sum(seen[c.key] if c.key in chosen.decoders else c.messages for c in own)
    lost = max(indexed, stream.stated.get(chosen.topic, 0) - found)
    if lost <= 0:
        return []
    where = "metadata.yaml" if lost > indexed else "the index of the file"
    text = f"{lost} of {found + lost} messages on {chosen.topic} that {where} counts are missing"
    return [Finding(code="missing_messages", message=text, amount=float(lost), damaged=True)]


def _losses(stream: MessageStream, decoder: JointDecoder, count: int) -> Iterator[Finding]:
    for d in stream.damage:
        place = "" if d.byte is None else f" at byte {d.byte} of {d.file_bytes}"
        text = f"the file is damaged{place} ({d.reason}); the {count} messages outside the damage were read"
        amount = None if d.byte is None else float(d.byte)
        yield Finding(code="truncated", message=text, amount=amount, damaged=True)
    if lost := decoder.undecodable:
        text = f"{lost} messages do not fit their definition and were left out"
        yield Finding(code="undecodable_messages", message=text, amount=float(lost), damaged=True)
    if some := decoder.incomplete:
        text = f"{some} messages hold only some of the joints; the others are missing there"
        yield Finding(code="incomplete_messages", message=text, amount=float(some))


def _robot(joints: Sequence[str], candidates: Sequence[Candidate]) -> str:
    """Return the robot by the joints' names; where the topic has none, by those of the other topics."""
    robot = robot_of(joints)
    if robot != "unknown" or joints[0] != "joint1":
        return robot
    others = {robot_of(row.names) for candidate in candidates for row in candidate.rows[:1]} - {"unknown"}
    return others.pop() if len(others) == 1 else "unknown"


def _empty_channels(chosen: Candidate, candidates: Sequence[Candidate]) -> list[Finding]:
    """Say which of the kind's main channels hold nothing, and which topic has them."""
    empty = [name for name in ("q", "dq", "tau_J") if name in chosen.kind.fields and name not in chosen.channels]
    if not empty:
        return []
    better = [c.topic for c in candidates if c is not chosen and set(empty) <= set(c.channels)]
    hint = f"; {', '.join(better)} has them: choose with --topic" if better else ""
    fields = ", ".join(chosen.kind.fields[name] for name in empty)
    return [Finding(code="channel_empty", message=f"{chosen.topic} holds no values in {fields}{hint}")]
