"""How much of a file that was cut off is read, against what a streaming decompressor can still get from it.

    python -m benchmarks.damaged_files.cut [--table table.md]

The log has 20 s of seven joints at 500 Hz. What is possible is counted by the container's own rules: whole messages in
the bytes that are there, the last chunk decompressed as far as it goes; of sqlite3 the share that is there.
"""

import argparse
import bz2
import shutil
import struct
import tempfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import lz4.frame  # type: ignore[import-untyped]
import zstandard

from benchmarks.damaged_files.run import storage_of
from benchmarks.damaged_files.watched import preload, run
from friction_audit.io.writers.write_log import WRITERS

CUTS = (0.5, 0.9, 0.99)
DIALECTS = (
    "mcap", "mcap-json", "mcap-protobuf", "mcap-franka-robot-state", "rosbag1-joint-state", "rosbag1-franka-state",
    "rosbag2-sqlite3", "rosbag2-db3", "rosbag2-mcap", "csv",
)  # fmt: skip


def _unpacked(packed: bytes, compression: str) -> bytes:
    """Decompress as far as the bytes go."""
    if compression in ("", "none"):
        return packed
    stream: Any
    if compression == "zstd":
        stream = zstandard.ZstdDecompressor().decompressobj()
    elif compression == "lz4":
        stream = lz4.frame.LZ4FrameDecompressor()
    else:
        stream = bz2.BZ2Decompressor()
    whole = b""
    for start in range(0, len(packed), 64):  # small pieces: what was decompressed before the fault is kept
        try:
            whole += stream.decompress(packed[start : start + 64])
        except (EOFError, OSError, RuntimeError, zlib.error, ValueError):
            break
    return whole


def _mcap_records(data: bytes) -> Iterator[tuple[int, bytes, bool]]:
    place = 0
    while place + 9 <= len(data):
        code, length = struct.unpack_from("<BQ", data, place)
        yield code, data[place + 9 : place + 9 + length], place + 9 + length <= len(data)
        place += 9 + length


def possible_mcap(data: bytes) -> int:
    """Count the whole messages of an MCAP file that was cut off."""
    count = 0
    for code, body, whole in _mcap_records(data[8:]):
        if code == 5 and whole:
            count += 1
        if code == 6 and len(body) > 40:
            size = struct.unpack_from("<I", body, 28)[0]
            compression, start = body[32 : 32 + size].decode(), 40 + size
            inner = _unpacked(body[start:], compression)
            count += sum(1 for one, _, complete in _mcap_records(inner) if one == 5 and complete)
    return count


def _bag_records(data: bytes) -> Iterator[tuple[dict[bytes, bytes], bytes, bool]]:
    place = 0
    while place + 4 <= len(data):
        size = struct.unpack_from("<I", data, place)[0]
        head = data[place + 4 : place + 4 + size]
        if place + 8 + size > len(data):
            return
        fields, at = {}, 0
        while at + 4 <= len(head):
            length = struct.unpack_from("<I", head, at)[0]
            key, _, value = head[at + 4 : at + 4 + length].partition(b"=")
            fields[key] = value
            at += 4 + length
        length = struct.unpack_from("<I", data, place + 4 + size)[0]
        body = data[place + 8 + size : place + 8 + size + length]
        yield fields, body, len(body) == length
        place += 8 + size + length


def possible_bag(data: bytes) -> int:
    """Count the whole messages of a ROS 1 bag that was cut off."""
    count = 0
    for fields, body, _ in _bag_records(data[13:]):
        if fields.get(b"op") == b"\x05":
            inner = _unpacked(body, fields[b"compression"].decode())
            count += sum(1 for one, _, whole in _bag_records(inner) if one.get(b"op") == b"\x02" and whole)
    return count


def possible(path: Path, rows: int, share: float) -> int:
    """Count the messages that can still be read of a file that was cut off."""
    storage = storage_of(path)
    if storage.suffix == ".mcap":
        return possible_mcap(storage.read_bytes())
    if storage.suffix == ".bag":
        return possible_bag(storage.read_bytes())
    if storage.suffix == ".csv":
        return max(storage.read_bytes().count(b"\n") - 1, 0)
    return int(share * rows)


def _messages(path: Path) -> tuple[int, int]:
    """Return how many rows are read, repeated ones included, and the exit code."""
    outcome = run(["info", str(path), "--json"])
    log = ((outcome.document or {}).get("logs") or [{}])[0]
    return log.get("samples", 0) + log.get("stale_samples", 0), outcome.code


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--table", type=Path)
    chosen = parser.parse_args()
    lines = ["| file | cut at | read | possible | share | exit |", "|---" * 6 + "|"]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        whole = folder / "whole.parquet"
        simulate = [
            "simulate",
            "panda-joint",
            "--duration",
            "20",
            "--rate",
            "500",
            "--seed",
            "1",
            "-q",
            "-o",
            str(whole),
        ]
        if (made := run(simulate, seconds=600)).code != 0:
            parser.error(f"the log could not be made: {made.errors}")
        preload(whole)
        for dialect in DIALECTS:
            suffix = next(writer.suffix for writer in WRITERS if writer.name == dialect)
            path = folder / f"{dialect}{suffix}"
            run(["convert", str(whole), str(path), "--dialect", dialect, "-q"], seconds=600)
            rows, _ = _messages(path)
            for share in CUTS:
                target = folder / f"cut{suffix}"
                (shutil.copytree if path.is_dir() else shutil.copyfile)(path, target)
                storage = storage_of(target)
                storage.write_bytes(storage.read_bytes()[: int(share * storage.stat().st_size)])
                read, code = _messages(target)
                best = possible(target, rows, share)
                lines.append(f"| {dialect} | {share:.0%} | {read} | {best} | {read / max(best, 1):.1%} | {code} |")
                print(lines[-1], flush=True)
                shutil.rmtree(target) if target.is_dir() else target.unlink()
    if chosen.table:
        chosen.table.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
