"""Text tables compressed with gzip or zstd, opened as if they were not."""

import io
import os
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from friction_audit.errors import InputError
from friction_audit.io.files import starts_with
from friction_audit.io.readers.reader import refuse_bomb

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer

PACKED = {b"\x1f\x8b": "gzip", b"\x28\xb5\x2f\xfd": "zstd"}  # magic bytes -> codec of Arrow
_SKIP_BYTES = 1 << 20


def open_table(path: Path) -> BinaryIO:
    """Open a text table for reading, decompressed if it is compressed.

    Raises:
        OSError: If it cannot be opened.
        InputError: While it is read: if the compressed stream breaks off or is damaged, or is a bomb.
    """
    codec = next((codec for magic, codec in PACKED.items() if starts_with(path, magic)), None)
    return path.open("rb") if codec is None else io.BufferedReader(_Unpacked(path, codec))


class _Unpacked(io.RawIOBase):
    """A decompressed file: seeking backwards starts again from its begin."""

    def __init__(self, path: Path, codec: str) -> None:
        self._path, self._codec = path, codec
        self._packed = path.stat().st_size
        self._rewind()

    def _rewind(self) -> None:
        import pyarrow as pa

        self._stream = pa.CompressedInputStream(pa.OSFile(str(self._path)), self._codec)
        self._place = 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def tell(self) -> int:
        return self._place

    def readinto(self, buffer: "WriteableBuffer") -> int:
        view = memoryview(buffer)
        chunk = self._read(len(view))
        view[: len(chunk)] = chunk
        return len(chunk)

    def _read(self, size: int) -> bytes:
        try:
            chunk: bytes = self._stream.read(size)
        except OSError as error:
            raise InputError(
                f"{self._path}: the {self._codec} stream breaks off or is damaged ({error}); expected a whole one; "
                f"copy it again, or read the part that there is: `{self._codec} -dc {self._path} > part.csv`"
            ) from error
        self._place += len(chunk)
        refuse_bomb(self._path, self._place, self._packed)
        return chunk

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        target = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._place}.get(whence, 0)
        if whence != os.SEEK_END and target < self._place:
            self._rewind()
        while whence == os.SEEK_END or self._place < target:
            if not self._read(_SKIP_BYTES if whence == os.SEEK_END else min(_SKIP_BYTES, target - self._place)):
                break
        return self._place
