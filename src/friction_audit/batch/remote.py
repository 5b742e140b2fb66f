"""LogFile: one log of a batch, before it is opened; and logs behind URLs, through fsspec."""

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from friction_audit.drift.session import natural
from friction_audit.errors import InputError, UsageError

LEDGER = "ledger.sqlite"  # a folder that holds one holds results, not logs
# Where file systems state whether a file has changed, the surest first.
VERSION_KEYS = (
    "ETag", "etag", "Content-MD5", "md5Hash", "mtime", "LastModified", "Last-Modified", "last_modified", "updated",
    "created",
)  # fmt: skip
# What file systems of fsspec raise where a place cannot be reached or may not be looked at.
UNREACHABLE = (OSError, RuntimeError, ValueError)
BagFolders = Callable[[Mapping[str, Sequence[str]]], set[str]]


@dataclass(frozen=True, kw_only=True, slots=True)
class ManifestRow:
    """What a manifest says of a log; None or empty where it says nothing.

    Attributes:
        path: The log.
        start_s: Unix time of the start. [s]
        robot: Which arm.
        temperature_c: Temperature of the session. [degC]
        payload: What the arm carried.
        note: For people.
    """

    path: str
    start_s: float | None = None
    robot: str = ""
    temperature_c: float | None = None
    payload: str = ""
    note: str = ""


@dataclass(frozen=True, kw_only=True, slots=True)
class LogFile:
    """One log: a file, the directory of a ROS 2 bag, or the URL of either.

    Attributes:
        path: As found, for people: bytes of a name that are no UTF-8 are written out.
        place: Where a worker finds it: an absolute path, or a URL.
        folders: Names of the folders that it lies in, the innermost first, no further than what the user named.
        size: Bytes, of all files of a bag; -1 where it is not known.
        changed: When it was last changed, in the words of its file system; empty where it is not known.
        row: What the manifest says of it, or None.
    """

    path: str
    place: str
    folders: tuple[str, ...]
    size: int
    changed: str
    row: ManifestRow | None = None

    @property
    def is_remote(self) -> bool:
        """True if it is named by a URL."""
        return "://" in self.place


def as_text(name: str) -> str:
    r"""Return text that can be printed and stored as UTF-8: bytes of a name that are none are written as ``\udcff``."""
    return name.encode("utf-8", "backslashreplace").decode()


def find(url: str, suffixes: Sequence[str], bag_folders: BagFolders) -> list[LogFile]:
    """Return the logs at a URL: the file itself, or those in a folder or that match a glob.

    Raises:
        InputError: If the place cannot be reached.
        UsageError: If what it takes to reach it is not installed.
    """
    system, path = _open(url)
    try:
        if any(mark in path for mark in "*["):
            return [log for match in sorted(system.glob(path), key=natural) for log in _at(system, match, ())]
        if path.lower().endswith(tuple(suffixes)) and not system.isdir(path):
            return _at(system, path, ()) if system.exists(path) else []
        return list(_below(system, path, suffixes, bag_folders))
    except UNREACHABLE as error:
        raise _unreachable(url, error) from error


@contextmanager
def fetched(place: str) -> Iterator[Path]:
    """Yield a local copy of a log, under its own name; it is gone after the block.

    Raises:
        InputError: If it cannot be fetched.
        UsageError: If what it takes is not installed.
    """
    system, path = _open(place)
    with tempfile.TemporaryDirectory(prefix="friction-audit-") as folder:
        copy = Path(folder) / path.rstrip("/").rpartition("/")[2]
        try:
            if system.isdir(path):
                copy.mkdir()
                for file in system.find(path):
                    system.get_file(file, str(copy / file.rpartition("/")[2]))
            else:
                system.get_file(path, str(copy))
        except UNREACHABLE as error:
            raise _unreachable(place, error) from error
        yield copy


def _open(url: str) -> tuple[Any, str]:
    """Return the file system of a URL and the path on it."""
    try:
        from fsspec.core import url_to_fs
    except ImportError as error:
        raise UsageError(
            f"{url}: URLs are read with fsspec, which is not installed; run: pip install 'friction-audit[remote]'"
        ) from error
    try:
        system, path = url_to_fs(url)
    except ImportError as error:
        raise UsageError(f"{url}: {error}") from error
    except ValueError as error:
        raise UsageError(f"{url}: {error}; check the part before ://") from error
    return system, str(path)


def _below(system: Any, top: str, suffixes: Sequence[str], bag_folders: BagFolders) -> Iterator[LogFile]:  # noqa: ANN401
    listing = {folder: files for folder, files in _walk(system, top) if LEDGER not in files}
    bags = bag_folders(listing)
    for folder in sorted(listing, key=natural):
        around = _around(top, folder)
        if folder in bags:
            yield from _at(system, folder, around[1:])
            continue
        if any(folder.startswith(f"{bag.rstrip('/')}/") for bag in bags):
            continue
        for file in sorted(listing[folder], key=natural):
            if not file.startswith(".") and file.lower().endswith(tuple(suffixes)):
                yield from _at(system, f"{folder.rstrip('/')}/{file}", around)


def _walk(system: Any, top: str) -> Iterator[tuple[str, list[str]]]:  # noqa: ANN401 - fsspec has no types
    for folder, _, files in system.walk(top):
        if not any(part.startswith(".") for part in _around(top, folder)[:-1]):
            yield folder, list(files)


def _around(top: str, folder: str) -> tuple[str, ...]:
    inner = [part for part in folder.removeprefix(top.rstrip("/")).split("/") if part]
    return (*reversed(inner), top.rstrip("/").rpartition("/")[2])


def _at(system: Any, path: str, folders: tuple[str, ...]) -> list[LogFile]:  # noqa: ANN401
    url = system.unstrip_protocol(path)
    infos = [system.info(file) for file in (system.find(path) if system.isdir(path) else [path])]
    sizes = [info.get("size") for info in infos]
    around = folders or (path.rstrip("/").rpartition("/")[0].rpartition("/")[2],)
    versions = [next((str(info[key]) for key in VERSION_KEYS if info.get(key)), "") for info in infos]
    changed = " ".join(versions) if all(versions) else ""
    size = -1 if None in sizes else sum(sizes)
    return [LogFile(path=url, place=url, folders=around, size=size, changed=changed)]


def _unreachable(url: str, error: Exception) -> InputError:
    said = " ".join(str(error).split()) or type(error).__name__
    return InputError(f"{url}: cannot be read: {said}; check the address and your access to it")
