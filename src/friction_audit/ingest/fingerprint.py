"""What a file was when it was read: its hash, its size and the time of its last change."""

import hashlib
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Stamp:
    """Size and time of the last change of a file, or of all files of a directory."""

    size: int
    changed_ns: int


def stamp_of(path: Path) -> Stamp:
    """Return the size and the time of the last change of a file or a directory's files."""
    states = [file.stat() for file in files_of(path)]
    return Stamp(sum(state.st_size for state in states), max((state.st_mtime_ns for state in states), default=0))


def sha256_of(path: Path) -> str:
    """Return the hash of a file's content; of a directory: of all its files, in sorted order."""
    digest = hashlib.sha256()
    for file in files_of(path):
        with file.open("rb") as stream:
            hashlib.file_digest(stream, lambda: digest)
    return digest.hexdigest()


def files_of(path: Path) -> list[Path]:
    """Return the file itself, or every file below a directory, sorted."""
    return sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]
