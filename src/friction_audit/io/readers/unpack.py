"""What a file was when it was read: its hash, its size, which file it is and when it was last changed."""

import errno
import hashlib
import stat
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Stamp:
    """What tells a file, or all files of a directory, from a changed one without reading it.

    Attributes:
        size: Bytes, of all files.
        changed_ns: Time of the last change of content that the file system tells, the latest of all files. [ns]
        identity: Of each file its name, device, inode and both times: ``cp -p`` over a file keeps size and time of the
            content, but not the time of the inode, and ``mv`` over it not the inode.
    """

    size: int
    changed_ns: int
    identity: tuple[tuple[str, int, int, int, int], ...] = ()


def stamp_of(path: Path) -> Stamp:
    """Return what tells a file or a directory's files from changed ones."""
    states = [(str(file), file.stat()) for file in files_of(path)]
    return Stamp(
        size=sum(state.st_size for _, state in states),
        changed_ns=max((state.st_mtime_ns for _, state in states), default=0),
        identity=tuple((name, s.st_dev, s.st_ino, s.st_mtime_ns, s.st_ctime_ns) for name, s in states),
    )


def sha256_of(path: Path) -> str:
    """Return the hash of a file's content; of a directory: of all its files, in sorted order.

    Raises:
        OSError: If a file cannot be read, or is a pipe or a device, which might never end.
    """
    digest, files = hashlib.sha256(), files_of(path)
    if not files:  # all folders that cannot be listed would be one content
        raise OSError(errno.ENOENT, "holds no file that can be read", str(path))
    for file in files:
        if not stat.S_ISREG(file.stat().st_mode):  # to open a named pipe waits for its writer
            raise OSError(errno.EINVAL, "a pipe or a device, not a file", str(file))
        with file.open("rb") as stream:
            hashlib.file_digest(stream, lambda: digest)
    return digest.hexdigest()


def files_of(path: Path) -> list[Path]:
    """Return the file itself, or every file below a directory, sorted."""
    return sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]


def starts_with(path: Path, magic: bytes) -> bool:
    """Return True if the file begins with these bytes; False if it cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(len(magic)) == magic
    except OSError:
        return False


MOST_TIMES_PACKED = 4000
"""Joint states that are all zero are packed 36 times (7 joints, zstd) to 1 000 times (1 000 joints), bombs 25 000."""
SMALLEST_BOUND = 1 << 20
"""Below it the ratio is not looked at. [byte]"""
LARGEST_CHUNK = 256 << 20
"""Recorders close a chunk after 0.75 to 16 MB; a larger one would have to lie in memory as a whole. [byte]"""


class UnpackError(Exception):
    """The data cannot be decompressed, or are not of the size that they claim."""


def bound_of(packed_bytes: int) -> int:
    """Return how large data can be at most that were packed into so many bytes."""
    return max(SMALLEST_BOUND, MOST_TIMES_PACKED * packed_bytes)


def unpack(compression: str, packed: bytes, claimed: int, *, cut: bool = False) -> bytes:
    """Decompress data whose header claims a size, without making more than that.

    Args:
        compression: ``"zstd"``, ``"lz4"``, ``"bz2"``, or ``"none"`` or ``""``.
        packed: The compressed data.
        claimed: Their size when decompressed. [byte]
        cut: Return what there is of data whose end is missing.

    Raises:
        UnpackError: If they are broken, or of another size.
    """
    if compression in ("none", ""):
        return packed
    most = min(bound_of(len(packed)), LARGEST_CHUNK)
    if claimed > most and not cut:
        raise UnpackError(f"{len(packed)} bytes claim to hold {claimed}, expected at most {most}")
    try:
        data = _decompress(compression, packed, min(claimed, most))
    except (OSError, EOFError, ValueError, RuntimeError, MemoryError) as error:
        raise UnpackError(str(error) or "not enough memory") from error
    if len(data) != claimed and not cut:
        held = "more" if len(data) > claimed else f"only {len(data)}"
        raise UnpackError(f"{len(packed)} bytes claim to hold {claimed} bytes, and hold {held}")
    return data


def _decompress(compression: str, packed: bytes, limit: int) -> bytes:
    """Decompress as far as it goes, up to one byte more than the limit."""
    if compression == "zstd":
        return _zstd(packed, limit)
    if compression == "lz4":
        from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

        data: bytes = LZ4FrameDecompressor().decompress(packed, max_length=limit + 1)
        return data
    if compression == "bz2":
        from bz2 import BZ2Decompressor

        return BZ2Decompressor().decompress(packed, max_length=limit + 1)
    raise ValueError(f"unknown compression {compression!r}")


def _zstd(packed: bytes, limit: int) -> bytes:
    from zstandard import ZstdDecompressor, ZstdError, frame_content_size

    try:
        if frame_content_size(packed) == limit:  # the stream, which reads cut frames too, takes 1.3 times as long
            return ZstdDecompressor().decompress(packed, max_output_size=limit)
    except ZstdError:
        pass  # the stream says what is wrong, or how far it goes
    try:
        with ZstdDecompressor().stream_reader(BytesIO(packed)) as stream:
            return stream.read(limit + 1)
    except ZstdError as error:
        raise ValueError(str(error)) from error
