"""Files, folders, globs and URLs -> the logs among them, each once, in the order of their names; URLs by fsspec."""

import glob
import hashlib
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path, PurePath
from typing import Any

from friction_audit.drift.session import natural
from friction_audit.errors import InputError, UsageError, encodable
from friction_audit.io.files import DATA_SET, METADATA, STORAGE_NAMES, Stamp, stamp_of
from friction_audit.io.readers import LOG_SUFFIXES

LEDGER = "ledger.sqlite"  # a folder that holds one holds results, not logs
# Where file systems state whether a file has changed, the surest first.
VERSION_KEYS = (
    "ETag", "etag", "Content-MD5", "md5Hash", "mtime", "LastModified", "Last-Modified", "last_modified", "updated",
    "created",
)  # fmt: skip
UNREACHABLE = (OSError, RuntimeError, ValueError)  # of fsspec, where a place cannot be reached or looked at


@dataclass(frozen=True, kw_only=True, slots=True)
class ManifestRow:
    """What a manifest says of a log; None or empty where it says nothing."""

    path: str  # the log
    start_s: float | None = None  # Unix time of the start [s]
    robot: str = ""  # which arm
    temperature_c: float | None = None  # temperature of the session [degC]
    payload: str = ""  # what the arm carried
    note: str = ""  # for people


@dataclass(frozen=True, kw_only=True, slots=True)
class LogFile:
    """One log: a file, the directory of a ROS 2 bag, or the URL of either."""

    path: str  # as found, for people: bytes of a name that are no UTF-8 are written out
    place: str  # where a worker finds it: an absolute path, or a URL
    folders: tuple[str, ...]  # names of those that it lies in, innermost first, no further than what the user named
    size: int  # bytes, of all files of a bag; -1 where it is not known
    changed: str  # when it was last changed, in the words of its file system; empty where it is not known
    row: ManifestRow | None = None  # what the manifest says of it, or None


def find_logs(
    names: Sequence[str], rows: Mapping[str, ManifestRow], *, leave_out: Iterable[Path] = ()
) -> list[LogFile]:
    """Find the logs that a user names, in folders to the bottom; ``leave_out``, the manifest and results, are none."""
    closed = {os.path.realpath(path) for path in leave_out}
    found: dict[str, LogFile] = {}
    lost: list[str] = []
    for name in (*names, *rows):
        logs = [log for log in _logs_of(name, closed) if os.path.realpath(log.place) not in closed]
        if not logs:
            lost.append(encodable(f"{name}: {_lack(name)}"))
        for log in logs:
            key = log.place if "://" in log.place else os.path.realpath(log.place)
            found.setdefault(key, replace(log, row=rows.get(log.place)))
    if lost:
        raise InputError("; ".join(lost))
    return sorted(found.values(), key=lambda log: natural(log.path))


def _lack(name: str) -> str:
    if "://" in name or Path(name).is_dir():
        return f"no log there or below; expected files that end in {' '.join(LOG_SUFFIXES)}, or folders of ROS 2 bags"
    if glob.has_magic(name):
        return "no file matches; check the path and the pattern"
    return "no such file or directory; check the path"


def _logs_of(name: str, closed: set[str]) -> list[LogFile]:
    if "://" in name:  # a file, or those in a folder or that match a glob
        with _reached(name) as (system, place):
            if any(mark in place for mark in "*["):
                return [_at(system, match) for match in sorted(system.glob(place), key=natural)]
            if place.lower().endswith(LOG_SUFFIXES) and not system.isdir(place):
                return [_at(system, place)] if system.exists(place) else []
            top = place.rstrip("/").rpartition("/")[2]
            walk, log_at = system.walk(place, detail=True), partial(_at, system)
            return [log for listed in walk for log in _logs_at(place, top, listed, log_at)]
    path = Path(name)
    if path.is_dir():
        return list(_logs_in(path, closed))
    if os.path.lexists(path):  # a link that leads nowhere is listed as failed
        return [local_log(name)]
    matches = glob.glob(name, recursive=True) if glob.has_magic(name) else ()  # noqa: PTH207 - of absolute patterns too
    return [log for match in sorted(matches, key=natural) for log in _logs_of(match, closed)]


def _logs_in(top: Path, closed: set[str]) -> Iterator[LogFile]:
    unread: list[OSError] = []
    name = top.resolve().name
    for folder, inside, files in os.walk(top, onerror=unread.append):
        inside.sort(key=natural)
        if os.path.realpath(folder) in closed:
            inside.clear()
        else:
            is_set = (Path(folder) / DATA_SET).is_file()
            yield from _logs_at(str(top), name, (folder, inside, files), local_log, is_set=is_set)
    for error in unread:  # a folder that cannot be listed: its reader says why
        yield local_log(error.filename, (*reversed(Path(error.filename).relative_to(top).parts), name))


def _logs_at(
    top: str,
    name: str,
    listed: tuple[str, Any, Iterable[str]],
    log_at: Callable[[str, tuple[str, ...]], LogFile],
    *,
    is_set: bool = False,
) -> Iterator[LogFile]:
    """Yield the logs of one folder below a top of a name; a bag or a data set is one log, and results are none."""
    folder, inside, files = listed
    inner = [part for part in folder.removeprefix(top.rstrip("/")).split("/") if part]
    around = (*reversed(inner), name)
    bag = is_bag(around[0], [*files])
    if LEDGER in files or (around[0].startswith(".") and inner):
        inside.clear()
    elif bag or is_set:
        inside.clear()
        yield log_at(folder, around[1:] if bag else around)
    else:
        logs = [file for file in files if not file.startswith(".") and file.lower().endswith(LOG_SUFFIXES)]
        yield from (log_at(f"{folder.rstrip('/')}/{file}", around) for file in sorted(logs, key=natural))


def is_bag(folder: str, files: Sequence[str]) -> bool:
    """Return True if a folder is one ROS 2 bag: it says so, or its storage files are called as it is."""
    storage = [name for name in files if name.lower().endswith(STORAGE_NAMES)]
    named = [PurePath(name.removesuffix(".zstd").removesuffix(".zst")).stem for name in storage]
    parts = [stem.rpartition("_") for stem in named]
    return bool(storage) and (METADATA in files or all(head == folder and tail.isdecimal() for head, _, tail in parts))


def local_log(name: str, folders: tuple[str, ...] = ()) -> LogFile:
    """Return a log of this machine as it is now."""
    place, stamp = Path(name).absolute(), Stamp(size=-1, changed_ns=0)
    with suppress(OSError):  # the worker says why
        stamp = stamp_of(place)
    which = repr([(inode, *times) for _, _, inode, *times in stamp.identity])  # devices are numbered anew at each start
    return LogFile(
        path=encodable(str(Path(name))),
        place=str(place),
        folders=tuple(map(encodable, folders or (place.parent.name,))),
        size=stamp.size,
        changed=f"{stamp.changed_ns} {hashlib.sha256(which.encode()).hexdigest()[:16]}",
    )


@contextmanager
def fetched(place: str) -> Iterator[Path]:
    """Yield a local copy of a log, under its own name; it is gone after the block."""
    with tempfile.TemporaryDirectory(prefix="friction-audit-") as folder:
        with _reached(place) as (system, path):
            copy = Path(folder) / path.rstrip("/").rpartition("/")[2]
            whole = system.isdir(path)
            if whole:
                copy.mkdir()
            for file in system.find(path) if whole else [path]:
                system.get_file(file, str(copy / file.rpartition("/")[2] if whole else copy))
        yield copy


@contextmanager
def _reached(url: str) -> Iterator[tuple[Any, str]]:
    """Yield the file system of a URL and the path on it."""
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
    try:
        yield system, str(path)
    except UNREACHABLE as error:
        said = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{url}: cannot be read: {said}; check the address and your access to it") from error


def _at(system: Any, path: str, folders: tuple[str, ...] = ()) -> LogFile:  # noqa: ANN401
    url = system.unstrip_protocol(path)
    infos = [system.info(file) for file in (system.find(path) if system.isdir(path) else [path])]
    sizes = [info.get("size") for info in infos]
    around = folders or (path.rstrip("/").rpartition("/")[0].rpartition("/")[2],)
    versions = [next((str(info[key]) for key in VERSION_KEYS if info.get(key)), "") for info in infos]
    changed = " ".join(versions) if all(versions) else ""
    size = -1 if None in sizes else sum(sizes)
    return LogFile(path=url, place=url, folders=around, size=size, changed=changed)
