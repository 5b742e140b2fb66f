"""Undamaged logs in every container, written by the program's own writers and by the libraries'."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from friction_audit.io.writers.write_log import WRITERS
from friction_audit.joint_log import JointLog, Source

RATE_HZ, DURATION_S = 100.0, 12.0


def swinging_log(joints: int, seed: int) -> JointLog:
    """Make a log of joints that swing, with Coulomb and viscous friction and sensor noise."""
    draw = np.random.default_rng(seed)
    t = np.arange(int(RATE_HZ * DURATION_S)) / RATE_HZ
    # Every stroke has the same ends, at another speed: gravity that is left in the torque cancels over the path.
    phase = 3.0 * t + 2.0 * np.sin(0.6 * t)
    q = np.outer(np.sin(phase), 0.5 - 0.1 * np.arange(joints))
    dq = np.gradient(q, t, axis=0)
    torque = 0.3 * np.sign(dq) + 0.1 * dq + 0.01 * draw.normal(size=q.shape)
    return JointLog(
        t=t,
        q=q,
        dq=dq,
        tau_interaction=torque,
        tau_J=torque,
        joint_names=tuple(f"axis_{number}" for number in range(1, joints + 1)),
        source=Source(path="made", sha256="0" * 64, format="made", start_s=1.7e9),
    )


def seeds(folder: Path, samples: Path) -> dict[str, Path]:
    """Write the undamaged logs; return path by name: the project's samples, two own logs per dialect, MCAP variants."""
    paths = {f"sample-{path.name}": path for path in sorted(samples.iterdir())}
    for joints in (1, 2):
        log = swinging_log(joints, joints)
        for writer in WRITERS:
            if writer.joints in (None, joints):
                path = folder / f"own-{joints}-{writer.name}{writer.suffix}"
                writer.write(log, path)
                paths[path.name] = path
    return paths | dict(_mcap_variants(paths["sample-mcap.mcap"], folder))


def _mcap_variants(source: Path, folder: Path) -> Iterator[tuple[str, Path]]:
    """Write one MCAP again with other compressions, without check sums, without chunks."""
    variants = {
        "zstd": {"compression": CompressionType.ZSTD},
        "lz4": {"compression": CompressionType.LZ4},
        "none": {"compression": CompressionType.NONE},
        "no-crc": {"compression": CompressionType.ZSTD, "enable_crcs": False},
        "no-chunks": {"use_chunking": False, "enable_crcs": False},
    }
    for name, options in variants.items():
        path = folder / f"mcap-{name}.mcap"
        with source.open("rb") as stream, path.open("wb") as out:
            reader = make_reader(stream)
            writer = Writer(out, chunk_size=1 << 16, **options)  # type: ignore[arg-type]
            writer.start(profile="ros2")
            channels: dict[int, int] = {}
            for schema, channel, message in reader.iter_messages():
                if schema is None:
                    continue
                if channel.id not in channels:
                    number = writer.register_schema(schema.name, schema.encoding, schema.data)
                    channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, number)
                writer.add_message(
                    channels[channel.id], message.log_time, message.data, message.publish_time, message.sequence
                )
            writer.finish()  # type: ignore[no-untyped-call]
        yield f"mcap-{name}", path
