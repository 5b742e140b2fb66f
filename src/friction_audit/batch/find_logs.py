"""Files, folders, globs and URLs -> the logs among them, each once, in the order of their names."""

import glob
import hashlib
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path, PurePath

from friction_audit.batch import remote
from friction_audit.batch.remote import LEDGER, LogFile, ManifestRow, as_text
from friction_audit.drift.session import natural
from friction_audit.errors import InputError
from friction_audit.io.files import DATA_SET, Stamp, stamp_of
from friction_audit.io.readers import READERS

BAG_METADATA = "metadata.yaml"
STORAGE_SUFFIXES = (".db3", ".mcap")
COMPRESSED = (".zstd", ".zst")
# Suffixes of too much that is no log: read where the user names the file, left alone in a folder.
NEEDS_A_NAME = (".txt", ".dat", *COMPRESSED)
# Endings of what is taken for a log in a folder.
SUFFIXES = tuple(
    sorted({suffix for reader in READERS for suffix in reader.suffixes if suffix not in NEEDS_A_NAME})
    + [storage + packed for storage in STORAGE_SUFFIXES for packed in COMPRESSED]
)


def find_logs(
    names: Sequence[str], rows: Mapping[str, ManifestRow], *, leave_out: Iterable[Path] = ()
) -> list[LogFile]:
    """Find the logs that a user names; those of a manifest are among them.

    Args:
        names: Files, folders (searched to the bottom), globs and URLs.
        rows: Rows of the manifest by the place of their log.
        leave_out: Files and folders that are no logs: the manifest itself, the folder of the results.

    Raises:
        InputError: If a name leads nowhere, or there is no log at all.
    """
    closed = {os.path.realpath(path) for path in leave_out}
    found: dict[str, LogFile] = {}
    lost: list[str] = []
    for name in (*names, *rows):
        logs = [log for log in _logs_of(name, closed) if os.path.realpath(log.place) not in closed]
        if not logs:
            lost.append(as_text(_nothing(name)))
        for log in logs:
            key = log.place if log.is_remote else os.path.realpath(log.place)
            found.setdefault(key, replace(log, row=rows.get(log.place)))
    if lost:
        raise InputError("; ".join(lost))
    if not found:
        raise InputError("no log was named; give files, folders, globs or URLs, or a manifest that names some")
    return sorted(found.values(), key=lambda log: natural(log.path))


def _logs_of(name: str, closed: set[str]) -> list[LogFile]:
    if "://" in name:
        return remote.find(name, SUFFIXES, bag_folders)
    path = Path(name)
    if path.is_dir():
        return [] if os.path.realpath(path) in closed else list(_logs_in(path, closed))
    if os.path.lexists(path):  # a link that leads nowhere is listed as failed
        return [_local(path, ())]
    if not glob.has_magic(name):
        return []
    matches = sorted(glob.glob(name, recursive=True), key=natural)  # noqa: PTH207 - Path knows no absolute patterns
    return [log for match in matches for log in _logs_of(match, closed)]


def _logs_in(top: Path, closed: set[str]) -> Iterator[LogFile]:
    """Walk through a folder; a folder that is a bag is one log, and results of this program are none."""
    closed_to_us: list[OSError] = []
    for folder, folders, files in os.walk(top, onerror=closed_to_us.append):
        here = Path(folder)
        if LEDGER in files or os.path.realpath(here) in closed:
            folders.clear()
            continue
        folders[:] = sorted((name for name in folders if not name.startswith(".")), key=natural)
        around = _folders_around(top, here)
        is_one_bag = is_bag(here.resolve().name, files)
        if is_one_bag or (here / DATA_SET).is_file():
            folders.clear()
            yield _local(here, around[1:] if is_one_bag else around)
            continue
        for file in sorted(files, key=natural):
            if not file.startswith(".") and file.lower().endswith(SUFFIXES):
                yield _local(here / file, around)
    for error in closed_to_us:  # a folder that cannot be listed: its reader says why
        yield _local(Path(error.filename), _folders_around(top, Path(error.filename)))


def _folders_around(top: Path, here: Path) -> tuple[str, ...]:
    """Return the names of the folders from here up to the one that the user named."""
    inner = here.relative_to(top).parts
    return (*reversed(inner), top.resolve().name)


def is_bag(folder: str, files: Sequence[str]) -> bool:
    """Return True if a folder is one ROS 2 bag: it says so, or its storage files are called as it is."""
    storage = [
        name for name in files if name.lower().endswith(tuple(s for s in SUFFIXES if s.startswith(STORAGE_SUFFIXES)))
    ]
    named = [PurePath(name.removesuffix(".zstd").removesuffix(".zst")).stem for name in storage]
    parts = [stem.rpartition("_") for stem in named]
    return bool(storage) and (
        BAG_METADATA in files or all(head == folder and tail.isdecimal() for head, _, tail in parts)
    )


def bag_folders(listing: Mapping[str, Sequence[str]]) -> set[str]:
    """Return the folders of a listing (folder -> its files) that are bags."""
    return {folder for folder, files in listing.items() if is_bag(folder.rstrip("/").rpartition("/")[2], files)}


def _local(path: Path, folders: tuple[str, ...]) -> LogFile:
    place = path.absolute()
    try:
        stamp = stamp_of(path)
    except OSError:  # the worker says why
        stamp = Stamp(size=-1, changed_ns=0)
    # Devices are numbered anew at every start.
    which = repr([(inode, *times) for _, _, inode, *times in stamp.identity])
    return LogFile(
        path=as_text(str(path)),
        place=str(place),
        folders=tuple(map(as_text, folders or (place.parent.name,))),
        size=stamp.size,
        changed=f"{stamp.changed_ns} {hashlib.sha256(which.encode()).hexdigest()[:16]}",
    )


def _nothing(name: str) -> str:
    kinds = " ".join(SUFFIXES)
    if "://" in name:
        return f"{name}: no log there; expected files that end in {kinds}, or the folder of a ROS 2 bag"
    if Path(name).is_dir():
        return f"{name}: no log in this folder or below; expected files that end in {kinds}, or folders of ROS 2 bags"
    if glob.has_magic(name):
        return f"{name}: no file matches; check the path and the pattern"
    return f"{name}: no such file or directory; check the path"
