"""Channels of messages -> MCAP file."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mcap.writer import Writer as McapWriter


@dataclass(frozen=True, kw_only=True, slots=True)
class Channel:
    """The channel and how its messages are written.

    Attributes:
        topic: Topic.
        schema: Name of the schema.
        schema_encoding: Language of the schema.
        schema_data: The schema.
        encoding: Encoding of the messages.
        profile: Profile of the file.
        notes: What else is said of the channel.
    """

    topic: str
    schema: str
    schema_encoding: str
    schema_data: bytes
    encoding: str
    profile: str = ""
    notes: Mapping[str, str] = field(default_factory=dict)


def write_mcap(path: Path, channel: Channel, messages: Iterable[tuple[int, bytes]]) -> None:
    """Write messages of one channel, given with their time [ns], in chunks compressed with zstd."""
    write_channels(path, (channel,), ((time, 0, payload) for time, payload in messages))


def write_channels(path: Path, channels: Sequence[Channel], messages: Iterable[tuple[int, int, bytes]]) -> None:
    """Write messages, given with their time [ns] and the place of their channel, in chunks compressed with zstd.

    Args:
        path: Where to.
        channels: The channels; those of one schema name share the schema. The first one's profile is the file's.
        messages: In the order of time, so that a viewer reads each chunk once.
    """
    from mcap.writer import Writer as McapWriter

    with path.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start(profile=channels[0].profile if channels else "", library="friction-audit")
        numbers = _register(writer, channels)
        sequence = [0] * len(channels)
        for time, place, payload in messages:
            writer.add_message(numbers[place], log_time=time, publish_time=time, data=payload, sequence=sequence[place])
            sequence[place] += 1
        writer.finish()  # type: ignore[no-untyped-call]


def _register(writer: "McapWriter", channels: Sequence[Channel]) -> list[int]:
    """Tell the file which channels there are; return their numbers in it."""
    schemas: dict[str, int] = {}
    for one in channels:
        if one.schema not in schemas:
            schemas[one.schema] = writer.register_schema(one.schema, one.schema_encoding, one.schema_data)
    return [writer.register_channel(one.topic, one.encoding, schemas[one.schema], dict(one.notes)) for one in channels]
