"""A stream of messages -> Recording: what all message containers have in common."""

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import partial
from itertools import chain, islice
from pathlib import Path

import numpy as np

from friction_audit.errors import InputError, few, near_misses
from friction_audit.io.files import stamp_of
from friction_audit.io.readers.channel_names import robot_of
from friction_audit.io.readers.clocks import UNITS, Clock, choose_clock
from friction_audit.io.readers.columns import MOST_JOINTS
from friction_audit.io.readers.joint_states import Candidate, JointDecoder, MessageKind, choose_topic, kind_of, rows_of
from friction_audit.io.readers.message_decoder import decoder_for
from friction_audit.io.readers.message_stream import Block, BrokenError, Connection, MessageStream, Window, one_block
from friction_audit.io.readers.reader import IN_BLOCKS_BYTES, MARGIN_S, ReadOptions, Topic, refuse_too_large, serial_in
from friction_audit.io.recording import Blocks, Recording, Samples
from friction_audit.joint_log import Finding, Float, find_window
from friction_audit.parallel import ahead

_SAMPLED_MESSAGES = 16  # first messages of a topic, from which its joints and channels are known
_CLOCK_DRIFT = 0.01  # most drift of the time of recording against the source's clock; beyond, the whole log is read
_MOST_TIMES_SMALLER = 100  # a count in the file is believed up to a file of a hundredth of the size of its samples
_NANOSECONDS = 1e9
_UNIT = re.compile(r":m?A$")  # of a motor current, after the name of a field in --map
_CLOCKS = 3  # arrays of times that are kept with the channels
_MOST_CLOCKS = 1 << 22  # messages whose clocks are compared where a log is read in blocks, spread evenly over it
_BLOCK_ROWS = 1 << 16

Open = Callable[[Path], AbstractContextManager[MessageStream]]


def read_messages(open_stream: Open, path: Path, options: ReadOptions) -> Recording:
    """Read the joint states in a file; InputError, or SeveralLogsError if it holds several arms and none was named."""
    with open_stream(path) as stream:
        return replace(_read(path, stream, options), serial=serial_in(stream.notes))


def topics_of(open_stream: Open, path: Path) -> tuple[Topic, ...]:
    """List the topics in a file."""
    with open_stream(path) as stream:
        return _topics(stream, _candidates(path, stream, ReadOptions()))


def _read(path: Path, stream: MessageStream, options: ReadOptions) -> Recording:
    candidates = _candidates(path, stream, options)
    chosen, joints, findings = choose_topic(path, candidates, _topics(stream, candidates), options.topic)
    decoder, names = JointDecoder(chosen, joints, chosen.channels), chosen.channels
    row_bytes = np.float64().itemsize * (len(names) * len(joints) + _CLOCKS)
    expected = min(chosen.messages, _MOST_TIMES_SMALLER * stamp_of(path).size // row_bytes)
    size, missing, blocks, skipped = expected * row_bytes, list[Finding](), None, 0
    part = _read_part(path, stream, decoder, options) if options.reads_part(size) else None
    if part is not None:
        samples, skipped = part
    else:
        if options.in_blocks and stream.is_lasting and size > IN_BLOCKS_BYTES:  # the clocks alone
            samples = Samples(len(joints), (), expected, every=-(-expected // _MOST_CLOCKS))
        else:
            refuse_too_large(path, size, size)
            samples = Samples(len(joints), names, expected)
        decoder.undecodable = decoder.incomplete = 0
        missing = _missing(stream, chosen, _collect(stream, decoder, samples))
    if not samples.count:
        raise InputError(f"{path}: no message on {chosen.name} can be decoded as {chosen.type}; choose another topic")
    if decoder.incomplete >= samples.rows:
        every, advice = ", ".join(few(joints)), "record the topic of one node, or all joints in one message"
        raise InputError(f"{path}: no message on {chosen.name} holds all of {every}; expected one that does; {advice}")
    clock = choose_clock(samples.times)
    t, channels = clock.t[skipped:], {name: array[skipped:] for name, array in samples.channels.items()}
    if not channels:
        t, channels = np.empty(0), {name: np.empty((0, len(joints))) for name in names}
        blocks = Blocks(rows=samples.rows, read=partial(_blocks, stream, decoder, clock, samples.rows))
    robot = robot_of(joints)
    if joints[0] == "joint1" and robot == "unknown":  # the topic has no names of joints: those of the other topics
        others = {robot_of(candidate.names) for candidate in candidates} - {"unknown"}
        robot = others.pop() if len(others) == 1 else "unknown"
    paths = {name: chosen.kind.fields[name] for name in channels}
    units = {name: found[0] for name, text in options.mapping.items() if (found := _UNIT.search(text))}
    return Recording(
        t=t,
        channels=channels,
        first_s=float(clock.t[:skipped].min()) if skipped else None,
        joint_names=joints,
        clock=clock.name,
        start_s=clock.start_s,
        origin_s=clock.origin_s,
        robot=robot,
        topic=chosen.name,
        mapping={
            name: (path.replace("[]", "[{i}]") if "[]" in path else f"{path}[{{i}}]") + units.get(name, "")
            for name, path in paths.items()
        },
        findings=(
            *findings,
            *_joints_and_channels(decoder, candidates),
            *_losses(stream, decoder, samples.rows),
            *missing,
            *clock.findings,
        ),
        blocks=blocks,
    )


def _blocks(
    stream: MessageStream, decoder: JointDecoder, clock: Clock, rows: int, names: Collection[str]
) -> Iterator[tuple[Float, dict[str, Float]]]:
    """Yield the clock of many messages, and those of their channels that are asked for, again and again."""
    chosen, joints = decoder.chosen, decoder.joints
    wanted = [name for name in chosen.channels if name in names]
    if not wanted and len(clock.t) == rows:
        yield from ((clock.t[first : first + _BLOCK_ROWS].copy(), {}) for first in range(0, rows, _BLOCK_ROWS))
        return
    decoder, samples = JointDecoder(chosen, joints, wanted), Samples(len(joints), wanted, _BLOCK_ROWS)
    for block in chain(stream.blocks(list(chosen.decoders)), [None]):  # None at the end
        if block is not None:
            samples.add(*decoder.decode(block))
        if samples.count >= (1 if block is None else _BLOCK_ROWS):
            samples.resize(samples.count)
            yield (samples.times[clock.name] - clock.first) / UNITS[clock.unit], samples.channels
            samples = Samples(len(joints), wanted, _BLOCK_ROWS)


def _topics(stream: MessageStream, candidates: Sequence[Candidate]) -> tuple[Topic, ...]:
    readable = {candidate.name for candidate in candidates}
    groups = defaultdict[str, list[Connection]](list)
    for connection in stream.connections:
        groups[connection.topic].append(connection)
    return tuple(
        Topic(name=name, type=own[-1].type, messages=sum(c.messages for c in own), readable=name in readable)
        for name, own in groups.items()
    )


def _candidates(path: Path, stream: MessageStream, options: ReadOptions) -> list[Candidate]:
    """Find the topics that can be read, with their first messages decoded."""
    wanted = options.topic.partition("#")[0].strip("/") if options.topic else None
    # actual.velocities[{i}] names the array actual.velocities
    stated = {c: _UNIT.sub("", text).replace("[{i}]", "").replace(".{i}", "") for c, text in options.mapping.items()}
    found, refusals = dict[str, Candidate](), list[InputError]()
    for connection in stream.connections:
        try:
            new = _candidate(path, stream, connection, stated, wanted) if connection.messages else None
        except InputError as error:
            refusals.append(error)
            continue
        if new and (old := found.setdefault(new.name, new)) is not new and old.kind == new.kind:
            found[new.name] = replace(
                old,
                messages=old.messages + new.messages,
                decoders={**old.decoders, **new.decoders},
                is_decoded=old.is_decoded or new.is_decoded,
                names=tuple(dict.fromkeys((*old.names, *new.names))),
                channels=tuple(name for name in old.kind.fields if name in {*old.channels, *new.channels}),
            )
    if refusals and (wanted is not None or not found):
        raise refusals[0]
    return list(found.values())


def _candidate(
    path: Path, stream: MessageStream, connection: Connection, stated: Mapping[str, str], wanted: str | None
) -> Candidate | None:
    """Find out what a connection's messages hold, and decode the first ones; None if these are no joint states."""
    topic, first = connection.topic, filter(None, map(_first_block, [stream], [connection]))  # read when it is needed
    try:
        decoder = decoder_for(connection, (payload for block in first for payload in block.payloads()))
    except BrokenError as error:  # a broken definition matters only on the topic that the user asked for
        if topic.strip("/") != wanted:
            return None
        raise InputError(
            f"{path}: topic {topic} of type {connection.type} cannot be read: {error}; choose another with --topic"
        ) from error
    is_wanted = wanted in (None, topic.strip("/"))
    kind = _kind(path, connection, decoder.paths, stated if is_wanted else {}) if decoder else None
    block = _first_block(stream, connection) if kind else None
    if decoder is None or kind is None or block is None:
        return None
    rows = [row for row in rows_of(block, decoder, kind) if row]
    joints = max((len(row.names) for row in rows), default=0)
    if joints > MOST_JOINTS and is_wanted:
        raise InputError(f"{path}: {joints} joints on {topic}; expected at most {MOST_JOINTS}; choose another topic")
    return Candidate(
        name=topic,
        type=connection.type,
        messages=connection.messages,
        readable=True,
        kind=kind,
        decoders={connection.key: decoder},
        is_decoded=bool(rows),
        names=tuple(dict.fromkeys(name for row in rows for name in row.names)),
        channels=tuple(name for name in kind.fields if any(name in row.channels for row in rows)),
    )


def _first_block(stream: MessageStream, connection: Connection) -> Block | None:
    """Return the first messages of a connection, which may lie in several blocks."""
    blocks = stream.blocks([connection.key])
    timed = (one for block in blocks for one in zip(block.log_time.tolist(), block.payloads(), strict=True))
    found = list(islice(timed, min(_SAMPLED_MESSAGES, connection.messages)))
    return one_block(connection.key, *zip(*found, strict=True)) if found else None


def _kind(path: Path, connection: Connection, paths: Sequence[str], stated: Mapping[str, str]) -> MessageKind | None:
    """Match the fields of a connection; what the user mapped wins, InputError if it does not have that."""
    if absent := [field for field in stated.values() if field not in paths]:
        near = "".join(near_misses(field, paths) for field in absent)
        raise InputError(
            f"{path}: topic {connection.topic}: no field {', '.join(absent)} in {connection.type}{near}; "
            f"its fields are {', '.join(paths)}; correct --map"
        )
    kind = kind_of(paths)
    if not stated:
        return kind
    kind = kind or MessageKind(rank=0, fields={}, stamps=tuple({"header.stamp"} & {*paths}))
    fields = {**kind.fields, **{channel: field for channel, field in stated.items() if channel != "t"}}
    return replace(kind, fields=fields, robot_time=stated.get("t", kind.robot_time))


def _collect(
    stream: MessageStream, decoder: JointDecoder, samples: Samples, window: Window | None = None
) -> Counter[int]:
    """Decode the messages of the topic chosen; returns how many each connection has."""
    seen: Counter[int] = Counter()
    for found in ahead(stream.blocks(list(decoder.chosen.decoders), window)):
        kept = window.keeps(found.log_time, found.log_time) if window else slice(None)
        block = Block(found.key, found.log_time[kept], found.buffer, found.start[kept], found.size[kept])
        seen[block.key] += len(block)
        if len(block):
            samples.add(*decoder.decode(block))
    samples.resize(samples.count)
    return seen


def _read_part(
    path: Path, stream: MessageStream, decoder: JointDecoder, options: ReadOptions
) -> tuple[Samples, int] | None:
    """Decode the first messages, from which time counts, and those of the part asked for, found by log time.

    Returns also how many are the first ones; None if the log time does not follow the clock chosen.
    """
    chosen = decoder.chosen
    samples = Samples(len(decoder.joints), chosen.channels, 0)
    own = [connection for connection in stream.connections if connection.key in chosen.decoders]
    for first in filter(None, map(partial(_first_block, stream), own)):
        samples.add(*decoder.of_messages(first))
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
    own = [c for c in stream.connections if c.topic == chosen.name]
    indexed = sum(max(c.messages - seen[c.key], 0) for c in own if c.key in chosen.decoders)
    found = sum(seen[c.key] if c.key in chosen.decoders else c.messages for c in own)
    lost = max(indexed, stream.stated.get(chosen.name, 0) - found)
    if lost <= 0:
        return []
    where = "metadata.yaml" if lost > indexed else "the index of the file"
    text = f"{lost} of {found + lost} messages on {chosen.name} that {where} counts are missing"
    return [Finding("missing_messages", text, amount=float(lost), damaged=True)]


def _losses(stream: MessageStream, decoder: JointDecoder, count: int) -> Iterator[Finding]:
    for place, byte in stream.damage.values():
        text = f"the file is damaged{place}; the {count} messages outside the damage were read"
        yield Finding("truncated", text, amount=None if byte is None else float(byte), damaged=True)
    if lost := decoder.undecodable:
        text = f"{lost} messages do not fit their definition and were left out"
        yield Finding("undecodable_messages", text, amount=float(lost), damaged=True)
    if some := decoder.incomplete:
        text = f"{some} messages hold only some of the joints; the others are missing there"
        yield Finding("incomplete_messages", text, amount=float(some))


def _joints_and_channels(decoder: JointDecoder, candidates: Sequence[Candidate]) -> Iterator[Finding]:
    """Say which joints are not of the arm, which main channels of the kind hold nothing, and which topic has them."""
    chosen = decoder.chosen
    if left_out := [name for name in chosen.names if name not in decoder.joints]:
        text = f"left out, no joints of the arm: {', '.join(left_out)}"  # as the joints of a gripper are
        yield Finding("joints_left_out", text, amount=float(len(left_out)))
    if empty := [name for name in ("q", "dq", "tau_J") if name in chosen.kind.fields and name not in chosen.channels]:
        better = [c.name for c in candidates if c is not chosen and set(empty) <= set(c.channels)]
        hint = f"; {', '.join(better)} has them: choose with --topic" if better else ""
        fields = ", ".join(chosen.kind.fields[name] for name in empty)
        yield Finding("channel_empty", f"{chosen.name} holds no values in {fields}{hint}")
