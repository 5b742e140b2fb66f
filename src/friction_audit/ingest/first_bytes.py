"""The bytes at the start of a file, by which most formats are told apart."""

from pathlib import Path


def starts_with(path: Path, magic: bytes) -> bool:
    """Return True if the file begins with these bytes; False if it cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(len(magic)) == magic
    except OSError:
        return False
