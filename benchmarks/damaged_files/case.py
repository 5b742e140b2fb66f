"""What a hostile case is: files that do harm, the command that reads them, and the exit codes that are right."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.damaged_files.seeds import swinging_log
from friction_audit.io.writers.write_log import WRITERS

REFUSED = (2, 3)
ANSWERED = (0, 4, 6)
ANY = (*ANSWERED, *REFUSED)


@dataclass(frozen=True, slots=True)
class Case:
    """A hostile input."""

    name: str  # what it is
    make: Callable[[Path], Sequence[str]]  # makes the files in a folder and returns the words of the command
    allowed: tuple[int, ...] = ANY  # exit codes that are right


def estimate(path: Path, *more: str) -> list[str]:
    """Return the words of an estimate."""
    return ["estimate", str(path), "--json", *more]


def good(folder: Path, dialect: str = "csv", suffix: str = ".csv") -> Path:
    """Write a sound log of one joint."""
    path = folder / f"good{suffix}"
    next(writer for writer in WRITERS if writer.name == dialect).write(swinging_log(1, 1), path)
    return path


def written(name: str, content: bytes | str) -> Callable[[Path], Sequence[str]]:
    """Return what writes a file and estimates it."""

    def make(folder: Path) -> Sequence[str]:
        path = folder / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return estimate(path)

    return make


def late(name: str, content: Callable[[], bytes | str]) -> Callable[[Path], Sequence[str]]:
    """Return what makes large content when its turn comes, writes it and estimates it."""

    def make(folder: Path) -> Sequence[str]:
        return written(name, content())(folder)

    return make
