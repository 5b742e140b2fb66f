"""TOML that people write, read in bounded time: ``tomllib`` is quadratic in the parts of a dotted key."""

import errno
import os
import re
import shutil
import sqlite3
import tempfile
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from friction_audit.errors import UsageError

MOST_BYTES = 1_000_000
"""Files of options and of joint models have a few kB."""
MOST_DOTS = 100
"""Dots in a line, outside strings; keys have two, and a list of numbers one for each."""
STRING = re.compile(rb'"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'')


def read_toml(path: Path) -> dict[str, Any]:
    """Return the content of a file.

    Raises:
        OSError: If it cannot be read.
        ValueError: If it is no TOML, or far beyond what such a file holds; the message says which.
    """
    with path.open("rb") as stream:
        content = stream.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise ValueError(f"more than {MOST_BYTES} bytes")
    lines = STRING.sub(b"", content).split(b"\n")
    number = next((i for i, line in enumerate(lines, 1) if line.count(b".") > MOST_DOTS), None)
    if number is not None:
        raise ValueError(f"more than {MOST_DOTS} dots in line {number}")
    try:
        return tomllib.loads(content.decode("utf-8"))
    except RecursionError as error:
        raise ValueError("arrays or tables are nested too deeply") from error


METADATA, STORAGES = "metadata.yaml", (".db3", ".mcap")
"""Files of a ROS 2 bag."""
MADE_HERE = "ros_distro: rosbags"
"""Line of the metadata of bags that this program writes; ``ros2 bag record`` names a distribution of ROS."""
FULL = (errno.ENOSPC, errno.EDQUOT)


@contextmanager
def whole_file(path: Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Yield a path that does not exist yet; what is made there becomes ``path`` if the block succeeds.

    The temporary path has the same suffix and lies in a private folder beside ``path``, so that the rename stays on
    one file system; a writer may make a file or a directory there. Where ``path`` is a link, all of this concerns the
    file that it points to, and the link stays.

    Raises:
        UsageError: If something is at ``path`` that may not be replaced, or the file cannot be written there.
    """
    check_place(path, overwrite=overwrite)
    target = Path(os.path.realpath(path))
    with _said_of(path):
        target.parent.mkdir(parents=True, exist_ok=True)
        # A part of the name: the whole of a long one would leave no room for what makes it unique.
        workshop = Path(tempfile.mkdtemp(prefix=f".{target.name[:32]}.", dir=target.parent))
    draft, old = workshop / f"{target.stem}{path.suffix}", workshop / f"{target.name[:32]}.replaced"
    try:
        with _said_of(path):
            yield draft
            check_place(path, overwrite=overwrite, folder=draft.is_dir())
            _replace(draft, target, old)
    finally:
        if not old.exists() or os.path.lexists(target):  # the only copy of what was there is kept
            shutil.rmtree(workshop, ignore_errors=True)


def check_place(path: Path, *, overwrite: bool, folder: bool | None = None) -> None:
    """Refuse to write where something is that stays: all there is, or with ``overwrite`` what is no earlier output.

    Args:
        path: Where to.
        overwrite: Whether earlier outputs are replaced: files by files, bags that this program wrote by bags.
        folder: Whether a folder is written there, None if that is not known yet.

    Raises:
        UsageError: Naming what is there.
    """
    if not os.path.lexists(path):
        return
    if not overwrite:
        raise UsageError(f"{path}: exists already; nothing was written; use --overwrite or another name")
    target = Path(os.path.realpath(path))
    if target.is_symlink() or not target.parent.is_dir():
        what = f"is a link to {target}, which cannot be made"
    elif target.is_dir() and (folder is False or not _is_own_bag(target)):
        what = "is a folder, and only a ROS 2 bag that friction-audit wrote, with no other file in it, is replaced"
    elif target.exists() and folder and not target.is_dir():
        what = "is a file, and a bag is a folder"
    elif target.exists() and not (target.is_dir() or target.is_file()):
        what = "is no regular file"
    else:
        return
    raise UsageError(f"{path}: {what}; nothing was written; choose another name")


def keep_input(path: Path, log: Path) -> None:
    """Refuse to write over an input, over a folder that holds it, or over a file of it where it is a bag.

    Raises:
        UsageError: Naming the input.
    """
    target, source = Path(os.path.realpath(path)), Path(os.path.realpath(log))
    if not (target.exists() and source.exists()):
        return
    if target.samefile(source):
        what = "is the log itself"
    elif target.is_dir() and source.is_relative_to(target):
        what = f"holds the log {log}"
    elif target.parent == source and (target.name == METADATA or target.suffix in STORAGES):
        what = f"is a part of the log {log}"
    else:
        return
    raise UsageError(f"{path}: {what}; nothing was written; choose another name or folder")


def _is_own_bag(folder: Path) -> bool:
    """Return True for a ROS 2 bag as this program writes it: metadata, one storage file, nothing else."""
    files = {entry.name: entry for entry in folder.iterdir()}
    metadata = files.pop(METADATA, None)
    if metadata is None or len(files) != 1 or not all(map(Path.is_file, (metadata, *files.values()))):
        return False
    return Path(*files).suffix in STORAGES and MADE_HERE in metadata.read_text(encoding="utf-8", errors="replace")


def _replace(draft: Path, target: Path, old: Path) -> None:
    """Put the draft in place; a directory cannot be renamed over another one, so the old one steps aside until then."""
    try:
        if target.is_dir():
            target.rename(old)
        draft.replace(target)
    except BaseException:  # a signal too
        if old.exists() and not os.path.lexists(target):
            old.rename(target)
        raise


@contextmanager
def _said_of(path: Path) -> Iterator[None]:
    """Say in words why something could not be written."""
    try:
        yield
    except (OSError, sqlite3.OperationalError) as error:
        why = getattr(error, "strerror", None) or error
        full = isinstance(error, sqlite3.OperationalError) or error.errno in FULL
        what = "make room there or choose" if full else "choose"
        raise UsageError(f"{path}: cannot be written: {why}; {what} another place") from error
