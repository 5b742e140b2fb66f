"""One channel of messages -> MCAP file."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path


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
    """

    topic: str
    schema: str
    schema_encoding: str
    schema_data: bytes
    encoding: str
    profile: str = ""


def write_mcap(path: Path, channel: Channel, messages: Iterable[tuple[int, bytes]]) -> None:
    """Write messages, given with their time [ns], in chunks compressed with zstd."""
    from mcap.writer import Writer as McapWriter

    with path.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start(profile=channel.profile, library="friction-audit")
        schema = writer.register_schema(channel.schema, channel.schema_encoding, channel.schema_data)
        number = writer.register_channel(channel.topic, channel.encoding, schema)
        for sequence, (time, payload) in enumerate(messages):
            writer.add_message(number, log_time=time, publish_time=time, data=payload, sequence=sequence)
        writer.finish()  # type: ignore[no-untyped-call]
