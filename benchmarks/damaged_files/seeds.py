"""Undamaged logs in every container, written by the program's own writers and by the libraries'."""

import gzip
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from scipy.io import savemat

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


def more_seeds(folder: Path) -> dict[str, Path]:
    """Write undamaged logs of the formats that this program does not write; return path by name.

    A folder ``joined`` holds two files of one log.
    """
    paths: dict[str, Path] = {}
    for joints in (1, 2):
        log = swinging_log(joints, joints)
        arrays: dict[str, Any] = {"time": log.t, "q": log.q, "dq": log.dq, "tau_J": log.tau_J}
        names = [f"{name}_{joint + 1}" for name in ("q", "dq", "tau_J") for joint in range(joints)]
        columns = np.column_stack(list(arrays.values()))
        table = pd.DataFrame(columns, columns=["time", *names])
        content = table.to_csv(index=False).encode()
        own = folder / f"own-{joints}"
        own.mkdir()
        (own / "run.csv.gz").write_bytes(gzip.compress(content))
        (own / "run.csv.zst").write_bytes(pa.compress(content, codec="zstd", asbytes=True))
        np.save(own / "plain.npy", columns)
        np.save(own / "records.npy", table.to_records(index=False))
        for compressed in (False, True):
            savemat(own / f"{'packed' if compressed else 'plain'}.mat", arrays, do_compression=compressed)
        savemat(own / "structure.mat", {"log": arrays})
        _write_hdf5(own / "version73.mat", arrays)
        _write_data_set(own / "v2.lerobot", table, "episode_000000")
        _write_data_set(own / "v3.lerobot", table, "file-000")
        for kind, other in (("csv", "parquet"), ("npz", "csv")):
            place = own / f"{kind}-{other}.joined"
            place.mkdir()
            motion = table.drop(columns=[name for name in names if name.startswith("tau")])
            _write(motion, place / f"motion.{kind}")
            _write(table[["time", *(n for n in names if n.startswith("tau"))]].iloc[::2], place / f"torque.{other}")
        paths |= {f"{own.name}-{path.name}": path for path in sorted(own.iterdir())}
    return paths


def _write(table: pd.DataFrame, path: Path) -> None:
    match path.suffix:
        case ".csv":
            table.to_csv(path, index=False)
        case ".parquet":
            table.to_parquet(path)
        case _:
            arrays: dict[str, Any] = {str(name): table[name].to_numpy() for name in table}
            np.savez(path, **arrays)


def _write_hdf5(path: Path, arrays: dict[str, Any]) -> None:
    """Write MATLAB's version 7.3, as MATLAB lays it out."""
    import h5py  # noqa: PLC0415 - an extra

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, array in arrays.items():
            file.create_dataset(name, data=np.atleast_2d(array.T)).attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .".ljust(124) + b"\x00\x02IM")


def _write_data_set(folder: Path, table: pd.DataFrame, file: str) -> None:
    """Write a LeRobot data set of one episode."""
    (folder / "meta").mkdir(parents=True)
    (folder / "data" / "chunk-000").mkdir(parents=True)
    motors = [str(name) for name in table if name != "time"]
    names = [f"axis_{name.rpartition('_')[2]}.{name.rpartition('_')[0]}" for name in motors]
    feature = {"dtype": "float32", "shape": [len(motors)], "names": names}
    features = {"observation.state": feature, "timestamp": {"dtype": "float32", "shape": [1], "names": None}}
    version = "v2.1" if file.startswith("episode") else "v3.0"
    info = {"codebase_version": version, "fps": RATE_HZ, "features": features}
    (folder / "meta" / "info.json").write_text(json.dumps(info))
    frames = {"timestamp": table["time"], "observation.state": list(table[motors].to_numpy()), "episode_index": 0}
    pd.DataFrame(frames).to_parquet(folder / "data" / "chunk-000" / f"{file}.parquet")
