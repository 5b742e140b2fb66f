"""Decompression of chunks and messages, bounded by what their headers claim."""

from io import BytesIO

# Joint states that are all zero are packed 36 times (7 joints, zstd) to 1 000 times (1 000 joints), bombs 25 000 times.
MOST_TIMES_PACKED = 4000
_SMALLEST_BOUND = 1 << 20  # below it the ratio is not checked [byte]
# Recorders close a chunk after 0.75 to 16 MB; a larger one would have to lie in memory as a whole. [byte]
LARGEST_CHUNK = 256 << 20


class UnpackError(Exception):
    """The data cannot be decompressed, or are not of the size that they claim."""


def bound_of(packed_bytes: int) -> int:
    """Return how large data can be at most that were packed into so many bytes."""
    return max(_SMALLEST_BOUND, MOST_TIMES_PACKED * packed_bytes)


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
