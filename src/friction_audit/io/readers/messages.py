"""A stream of messages -> Recording: what all message containers have in common."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from itertools import islice
from pathlib import Path

import numpy as np

from friction_audit.errors import InputError
from friction_audit.io.files import stamp_of
from friction_audit.io.readers.columns import MOST_JOINTS
from friction_audit.io.readers.joint_names import robot_of
from friction_audit.io.readers.message_decoder import DefinitionError, MessageDecoder, decoder_for, needs_message
from friction_audit.io.readers.message_kinds import MessageKind, Row, UndecodableError, match_kind, row_of
from friction_audit.io.readers.message_layout import LARGEST_EXPECTATION, BlockDecoder, JointSamples
from friction_audit.io.readers.message_stream import (
    Block,
    Connection,
    MessageStream,
    Window,
    block_of_payloads,
    choose_clock,
)
from friction_audit.io.readers.reader import MARGIN_S, ReadOptions, Topic, refuse_too_large
from friction_audit.io.readers.topics import Candidate, Choice, choose_topic
from friction_audit.io.recording import Recording
from friction_audit.joint_log import Finding, find_window

_SAMPLED_MESSAGES = 16  # first messages of a topic, from which its joints and channels are known
_CLOCK_DRIFT = 0.01  # most drift of the time of recording against the source's clock; beyond, the whole log is read
_MOST_TIMES_SMALLER = 100  # a count in the file is believed up to a file of a hundredth of the size of its samples
_NANOSECONDS = 1e9
_UNIT = re.compile(r":m?A$")  # of a motor current, after the name of a field in --map
_CLOCKS = 3  # arrays of times that are kept with the channels


def read_messages(
    path: Path, stream: MessageStream, options: ReadOptions, stated: Mapping[str, int] | None = None
) -> Recording:
    """Read the joint states in a stream.

    Raises:
        InputError: If there is no joint state to read.
        SeveralLogsError: If the log holds several arms and the user named none.
    """
    candidates = _candidates(path, stream, options)
    choice = choose_topic(path, candidates, _topics(stream, candidates), options.topic)
    candidate = choice.candidate
    row_bytes = np.float64().itemsize * (len(candidate.channels) * len(choice.joints) + _CLOCKS)
    believed = _MOST_TIMES_SMALLER * stamp_of(path).size // row_bytes
    expected = min(candidate.messages or 0, LARGEST_EXPECTATION, believed)
    part = _read_part(path, stream, choice, options) if options.reads_part(expected * row_bytes) else None
    missing: list[Finding] = []
    if part is None:
        refuse_too_large(path, expected * row_bytes, expected * row_bytes)
        samples, skipped = JointSamples(choice.joints, candidate.channels, expected), 0
        undecodable, seen = _collect(stream, candidate, samples)
        missing = _missing(stream, candidate, seen, (stated or {}).get(candidate.topic, 0))
    else:
        samples, undecodable, skipped = part
    if not samples.count:
        raise InputError(
            f"{path}: none of the messages on topic {candidate.topic} can be decoded as {candidate.type}; choose "
            "another topic with --topic"
        )
    clock, kind = choose_clock(samples.log_time, samples.stamp, samples.robot_time), candidate.kind
    shown = f"{kind.elements}[{{i}}].%s" if kind.elements else "%s[{i}]"
    losses = [*_losses(stream, samples, undecodable), *missing]
    return Recording(
        t=clock.t[skipped:],
        channels={name: array[skipped:] for name, array in samples.channels.items()},
        first_s=float(clock.t[:skipped].min()) if skipped else None,
        joint_names=choice.joints,
        clock=clock.name,
        start_s=clock.start_s,
        origin_s=clock.origin_s,
        robot=_robot(choice, candidates),
        topic=candidate.topic,
        mapping={
            name: shown % kind.fields[name] + _unit_of(options.mapping.get(name, "")) for name in samples.channels
        },
        findings=(
            *choice.findings,
            *_left_out(choice),
            *_empty_channels(candidate, candidates),
            *losses,
            *clock.findings,
        ),
    )


def _unit_of(stated: str) -> str:
    return found[0] if (found := _UNIT.search(stated)) else ""


def topics_of(path: Path, stream: MessageStream) -> tuple[Topic, ...]:
    """List the topics in a stream."""
    return _topics(stream, _candidates(path, stream, ReadOptions()))


def _topics(stream: MessageStream, candidates: Sequence[Candidate]) -> tuple[Topic, ...]:
    readable = {candidate.topic for candidate in candidates}
    topics: dict[str, Topic] = {}
    for connection in stream.connections:
        known = topics.get(connection.topic)
        topics[connection.topic] = Topic(
            name=connection.topic,
            type=connection.type,
            messages=_sum([connection.messages] + ([known.messages] if known else [])),
            readable=connection.topic in readable,
        )
    return tuple(topics.values())


def _sum(counts: Sequence[int | None]) -> int | None:
    known = [count for count in counts if count is not None]
    return sum(known) if len(known) == len(counts) else None


def _candidates(path: Path, stream: MessageStream, options: ReadOptions) -> list[Candidate]:
    """Find the topics that can be read, with their first messages decoded."""
    wanted = options.topic.partition("#")[0].strip("/") if options.topic else None
    used = [c for c in stream.connections if c.messages != 0]
    decoders = {c.key: decoder for c in used if (decoder := _decoder(path, c, None, wanted)) is not None}
    unknown = [c for c in used if c.key not in decoders and needs_message(c)]
    firsts = _first_blocks(stream, unknown)
    for connection in unknown:
        block = firsts.get(connection.key)
        payloads = [] if block is None else map(block.payload, range(len(block)))
        found = (_decoder(path, connection, payload, wanted) for payload in payloads)
        if (late := next((decoder for decoder in found if decoder is not None and decoder.paths), None)) is not None:
            decoders[connection.key] = late
    kinds = _kinds(path, [c for c in used if c.key in decoders], decoders, options.mapping, wanted)
    firsts |= _first_blocks(stream, [c for c in used if c.key in kinds and c.key not in firsts])
    groups: dict[str, list[Connection]] = {}
    for connection in used:
        if connection.key in kinds and connection.key in firsts:
            groups.setdefault(connection.topic, []).append(connection)
    candidates = []
    for topic, group in groups.items():
        kind = kinds[group[0].key]
        same = [c for c in group if kinds[c.key] == kind]  # connections of one topic, of the kind of the first one
        rows = [row for c in same for row in _first_rows(firsts[c.key], decoders[c.key], kind)]
        joints = max((len(row.names) for row in rows), default=0)
        if joints > MOST_JOINTS and wanted in (None, topic.strip("/")):
            raise InputError(
                f"{path}: a message on topic {topic} holds {joints} joints; expected at most {MOST_JOINTS}; "
                "choose another topic with --topic"
            )
        candidates.append(
            Candidate(
                topic=topic,
                type=group[0].type,
                messages=_sum([c.messages for c in same]),
                kind=kind,
                decoders={c.key: decoders[c.key] for c in same},
                rows=rows,
            )
        )
    return candidates


def _decoder(path: Path, connection: Connection, payload: bytes | None, wanted: str | None) -> MessageDecoder | None:
    """Make a decoder; a broken definition matters only on the topic that the user asked for."""
    try:
        return decoder_for(connection, payload)
    except DefinitionError as error:
        if connection.topic.strip("/") != wanted:
            return None
        raise InputError(
            f"{path}: topic {connection.topic} of type {connection.type} cannot be read: {error}; "
            "choose another topic with --topic, or convert the log"
        ) from error


def _first_blocks(stream: MessageStream, connections: Sequence[Connection]) -> dict[int, Block]:
    """Return the first messages of each connection, which may lie in several blocks."""
    # One connection at a time: a container may hand over all messages of one before it comes to the next.
    found = {}
    for c in connections:
        blocks = stream.blocks([c.key])
        timed = ((int(one.log_time[index]), one.payload(index)) for one in blocks for index in range(len(one)))
        found[c.key] = list(islice(timed, min(_SAMPLED_MESSAGES, c.messages or 1)))
    return {key: block_of_payloads(key, *zip(*timed, strict=True)) for key, timed in found.items() if timed}


def _first_rows(block: Block, decoder: MessageDecoder, kind: MessageKind) -> list[Row]:
    rows = []
    for index in range(min(len(block), _SAMPLED_MESSAGES)):
        try:
            rows.append(row_of(decoder.decode(block.payload(index)), kind))
        except UndecodableError:
            continue  # counted when the topic is read
        if len(rows[-1].names) > MOST_JOINTS:
            break
    return rows


def _kinds(
    path: Path,
    connections: Sequence[Connection],
    decoders: Mapping[int, MessageDecoder],
    mapping: Mapping[str, str],
    wanted: str | None,
) -> dict[int, MessageKind]:
    """Match the fields of all connections; what the user mapped wins, InputError if no connection has it."""
    kinds: dict[int, MessageKind] = {}
    refusals: list[InputError] = []
    # actual.velocities[{i}] names the array actual.velocities
    stated = {
        channel: _UNIT.sub("", text).replace("[{i}]", "").replace(".{i}", "") for channel, text in mapping.items()
    }
    for connection in connections:
        paths = decoders[connection.key].paths
        named = stated if wanted in (None, connection.topic.strip("/")) else {}
        kind, absent = match_kind(paths), [field for field in named.values() if field not in paths]
        if absent:
            near = sorted({name for field in absent for name in get_close_matches(field, paths, cutoff=0.5)})
            hint = f"; did you mean {', '.join(near)}?" if near else ""
            text = (
                f"{path}: topic {connection.topic}: no field {', '.join(absent)} in {connection.type}{hint}; "
                f"its fields are {', '.join(paths)}; correct --map"
            )
            refusals.append(InputError(text))
        elif named:
            stamps = ("header.stamp",) if "header.stamp" in paths else ()
            base = kind or MessageKind(rank=0, fields={}, required=(), stamps=stamps)
            fields = {**base.fields, **{channel: field for channel, field in named.items() if channel != "t"}}
            kinds[connection.key] = replace(base, fields=fields, robot_time=named.get("t", base.robot_time))
        elif kind is not None:
            kinds[connection.key] = kind
    if refusals and (wanted is not None or not kinds):
        raise refusals[0]
    return kinds


def _collect(
    stream: MessageStream, candidate: Candidate, samples: JointSamples, window: Window | None = None
) -> tuple[int, Counter[int]]:
    """Decode the messages of the topic chosen; returns how many failed, and how many each connection has."""
    fast: dict[int, BlockDecoder] = {}
    seen: Counter[int] = Counter()
    undecodable = 0
    for found in stream.blocks(list(candidate.decoders), window):
        block = window.part_of(found) if window else found
        seen[block.key] += len(block)
        decoder = candidate.decoders[block.key]
        if len(block) and not _add_block(samples, block, decoder, candidate.kind, fast):
            undecodable += _add_rows(samples, block, decoder, candidate.kind)
    samples.trim()
    return undecodable, seen


def _read_part(
    path: Path, stream: MessageStream, choice: Choice, options: ReadOptions
) -> tuple[JointSamples, int, int] | None:
    """Decode the first messages, from which time counts, and those of the part asked for, found by log time.

    Returns the samples, the number of messages that failed, and how many of the first samples are no more than the
    origin; None if the log time does not follow the clock chosen.
    """
    candidate = choice.candidate
    firsts = _first_blocks(stream, [c for c in stream.connections if c.key in candidate.decoders])
    samples = JointSamples(choice.joints, candidate.channels, None)
    for key, block in firsts.items():
        _add_rows(samples, block, candidate.decoders[key], candidate.kind)
    skipped = samples.count
    if not skipped:
        return None
    start, stop = options.window_of_clock()
    origin = float(samples.log_time.min())
    window = Window(
        origin + _NANOSECONDS * (start - MARGIN_S - _CLOCK_DRIFT * abs(start)),
        origin + _NANOSECONDS * (stop + MARGIN_S + _CLOCK_DRIFT * abs(stop)),
    )
    undecodable, _ = _collect(stream, candidate, samples, window)
    if samples.count == skipped:
        duration = max(window.latest - origin, 0.0) / _NANOSECONDS * options.time_scale
        find_window(np.array([0.0, duration]), options.t_start_s, options.t_end_s, str(path))
        return None
    t = choose_clock(samples.log_time, samples.stamp, samples.robot_time).t
    t = t[skipped:] - t[:skipped].min()
    reached = (not window.before or t.min() <= start) and (not window.after or t.max() >= stop)
    return (samples, undecodable, skipped) if reached else None


def _add_block(
    samples: JointSamples, block: Block, decoder: MessageDecoder, kind: MessageKind, fast: dict[int, BlockDecoder]
) -> bool:
    """Append a block by the layout in use, or by that of its own first message; False if neither fits."""
    for attempt in (fast.get(block.key), None):
        block_decoder = attempt or _block_decoder(block, decoder, kind, samples)
        if block_decoder is None:
            return False
        records = block_decoder.decode(block)
        if records is not None:
            fast[block.key] = block_decoder
            return samples.add_records(records, block_decoder.layout, kind, block.log_time)
    return False


def _block_decoder(
    block: Block, decoder: MessageDecoder, kind: MessageKind, samples: JointSamples
) -> BlockDecoder | None:
    layout = decoder.layout(block.payload(0))
    paths = [*(kind.fields[name] for name in samples.channels), *kind.stamp_paths]
    paths += [kind.robot_time] if kind.robot_time else []
    if layout is None or any(path not in layout.numbers for path in paths):
        return None
    return BlockDecoder(layout, block.payload(0), tuple(dict.fromkeys(paths)))


def _add_rows(samples: JointSamples, block: Block, decoder: MessageDecoder, kind: MessageKind) -> int:
    """Append a block message by message, with the library's decoder; returns how many it refused."""
    undecodable = 0
    for index, log_time in enumerate(block.log_time.tolist()):
        try:
            row = row_of(decoder.decode(block.payload(index)), kind)
        except UndecodableError:
            undecodable += 1
            continue
        if len(row.names) > MOST_JOINTS:
            undecodable += 1
        else:
            samples.add_row(row, log_time)
    return undecodable


def _missing(stream: MessageStream, candidate: Candidate, seen: Mapping[int, int], stated: int) -> list[Finding]:
    """Compare the messages read with their number by the file's own index and by metadata.yaml."""
    own = [c for c in stream.connections if c.topic == candidate.topic]
    indexed = sum(max((c.messages or 0) - seen[c.key], 0) for c in own if c.key in candidate.decoders)
    found = sum(seen[c.key] if c.key in candidate.decoders else c.messages or 0 for c in own)
    lost = max(indexed, stated - found)
    if lost <= 0:
        return []
    where = "metadata.yaml" if lost > indexed else "the index of the file"
    text = f"{lost} of {found + lost} messages on {candidate.topic} that {where} counts are missing"
    return [Finding(code="missing_messages", message=text, amount=float(lost), damaged=True)]


def _losses(stream: MessageStream, samples: JointSamples, undecodable: int) -> list[Finding]:
    findings = []
    for d in stream.damage:
        place = "" if d.byte is None else f" at byte {d.byte} of {d.file_bytes}"
        text = f"the file is damaged{place} ({d.reason}); the {samples.count} messages outside the damage were read"
        amount = None if d.byte is None else float(d.byte)
        findings.append(Finding(code="truncated", message=text, amount=amount, damaged=True))
    if undecodable:
        text = f"{undecodable} messages do not fit their definition and were left out"
        findings.append(Finding(code="undecodable_messages", message=text, amount=float(undecodable), damaged=True))
    if samples.incomplete:
        text = f"{samples.incomplete} messages hold only some of the joints; the others are missing there"
        findings.append(Finding(code="incomplete_messages", message=text, amount=float(samples.incomplete)))
    return findings


def _left_out(choice: Choice) -> tuple[Finding, ...]:
    """Notice joints of the messages that are none of the arm's, as those of a gripper are."""
    others = dict.fromkeys(name for row in choice.candidate.rows for name in row.names if name not in choice.joints)
    message = f"left out, no joints of the arm: {', '.join(others)}"
    return (Finding(code="joints_left_out", message=message, amount=float(len(others))),) if others else ()


def _robot(choice: Choice, candidates: Sequence[Candidate]) -> str:
    """Return the robot by the joints' names; where the topic has none, by those of the other topics."""
    robot = robot_of(choice.joints)
    if robot != "unknown" or choice.joints[0] != "joint1":
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
