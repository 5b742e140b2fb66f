"""Files: which was read and whether it changed, outputs written whole, TOML in bounded time, documents read back."""

import errno
import json
import os
import re
import shutil
import stat
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from friction_audit.errors import InputError, UsageError

DATA_SET = "meta/info.json"  # what the folder of a LeRobot data set holds
_NUMBERS_OF_A_DATA_SET = ("meta", "data")  # of its folders; the others hold gigabytes of video
METADATA, STORAGES = "metadata.yaml", (".db3", ".mcap")  # the files of a ROS 2 bag
COMPRESSED = (".zstd", ".zst")
STORAGE_NAMES = tuple(storage + packed for storage in STORAGES for packed in ("", *COMPRESSED))
# Line of the metadata of bags that this program writes; `ros2 bag record` names a distribution of ROS.
_MADE_HERE = "ros_distro: rosbags"
_DISK_FULL = (errno.ENOSPC, errno.EDQUOT)
_MOST_BYTES = 1_000_000  # of a file of options or of a joint model, which has a few kB
# In a line, outside strings: tomllib is quadratic in the parts of a key. Keys have two, a list one for each number.
_MOST_DOTS = 100
_BIGGEST = 256 << 20  # bytes of a document; an hour with seven joints has 10 MB, a diagnosis 1 MB a joint
_STRING = re.compile(rb'"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'')


class Stamp(NamedTuple):
    """What distinguishes a file, or all files of a directory, from a changed one without reading it."""

    size: int  # bytes, of all files
    changed_ns: int  # time of the last change of content by the file system, the latest of all files [ns]
    # Name, device, inode and both times of each file: `cp -p` over a file keeps size and time of the content, but not
    # the time of the inode, and `mv` over it not the inode.
    identity: tuple[tuple[str, int, int, int, int], ...] = ()


def stamp_of(path: Path) -> Stamp:
    """Return what distinguishes a file or a directory's files from changed ones."""
    states = [(str(file), file.stat()) for file in _files_of(path)]
    return Stamp(
        size=sum(state.st_size for _, state in states),
        changed_ns=max((state.st_mtime_ns for _, state in states), default=0),
        identity=tuple((name, s.st_dev, s.st_ino, s.st_mtime_ns, s.st_ctime_ns) for name, s in states),
    )


def sha256_of(path: Path) -> str:
    """Return the hash of a file's content; of a directory: of all its files, in sorted order."""
    import hashlib

    digest, files = hashlib.sha256(), _files_of(path)
    if not files:  # all folders that cannot be listed would be one content
        raise OSError(errno.ENOENT, "holds no file that can be read", str(path))
    for file in files:
        if not stat.S_ISREG(file.stat().st_mode):  # to open a named pipe waits for its writer
            raise OSError(errno.EINVAL, "a pipe or a device, not a file", str(file))
        with file.open("rb") as stream:
            hashlib.file_digest(stream, lambda: digest)
    return digest.hexdigest()


def _files_of(path: Path) -> list[Path]:
    if not path.is_dir():
        return [path]
    folders = [path / name for name in _NUMBERS_OF_A_DATA_SET] if (path / DATA_SET).is_file() else [path]
    return sorted(file for folder in folders for file in folder.rglob("*") if file.is_file())


def starts_with(path: Path, magic: bytes) -> bool:
    """Return True if the file begins with these bytes; False if it cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(len(magic)) == magic
    except OSError:
        return False


def read_toml(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file that a person wrote; ValueError if it is none, or far beyond what one holds."""
    with path.open("rb") as stream:
        content = stream.read(_MOST_BYTES + 1)
    if len(content) > _MOST_BYTES:
        raise ValueError(f"more than {_MOST_BYTES} bytes")
    lines = _STRING.sub(b"", content).split(b"\n")
    if number := next((i for i, line in enumerate(lines, 1) if line.count(b".") > _MOST_DOTS), 0):
        raise ValueError(f"more than {_MOST_DOTS} dots in line {number}")
    import tomllib

    try:
        return tomllib.loads(content.decode("utf-8"))
    except RecursionError as error:
        raise ValueError("arrays or tables are nested too deeply") from error


@contextmanager
def whole_file(path: Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Yield a path that does not exist yet; what is made there becomes ``path`` if the block succeeds.

    It has the same suffix and lies in a private folder next to ``path``, on the same file system, for a file or a
    directory. Where ``path`` is a link, all of this concerns the file that it points to.
    """
    import tempfile

    check_place(path, overwrite=overwrite)
    target = Path(os.path.realpath(path))
    with _as_usage_error(path):
        target.parent.mkdir(parents=True, exist_ok=True)
        # A part of the name: the whole of a long one would leave no room for what makes it unique.
        workshop = Path(tempfile.mkdtemp(prefix=f".{target.name[:32]}.", dir=target.parent))
    draft, old = workshop / f"{target.stem}{path.suffix}", workshop / f"{target.name[:32]}.replaced"
    try:
        with _as_usage_error(path):
            yield draft
            check_place(path, overwrite=overwrite, folder=draft.is_dir())
            _replace(draft, target, old)
    finally:
        if not old.exists() or os.path.lexists(target):  # the only copy of what was there is kept
            shutil.rmtree(workshop, ignore_errors=True)


def check_place(path: Path, *, overwrite: bool, folder: bool | None = None) -> None:
    """Refuse to write where something is that stays: all there is, or with ``overwrite`` what is no earlier output.

    Files are replaced by files, bags that this program wrote by bags; ``folder``: what is written, None if unknown.
    """
    if not os.path.lexists(path):
        return
    if not overwrite:
        raise UsageError(f"{path}: exists already; nothing was written; use --overwrite or another name")
    target = Path(os.path.realpath(path))
    _refuse(path, {
        f"is a link to {target}, which cannot be made": target.is_symlink() or not target.parent.is_dir(),
        "is a folder, and only a ROS 2 bag that friction-audit wrote, with no other file in it, is replaced":
            target.is_dir() and (folder is False or not _is_own_bag(target)),
        "is a file, and a bag is a folder": bool(target.exists() and folder and not target.is_dir()),
        "is no regular file": target.exists() and not (target.is_dir() or target.is_file()),
    })  # fmt: skip


def keep_input(path: Path, log: Path) -> None:
    """Refuse to write over an input, over a folder that holds it, or over a file of it where it is a bag."""
    target, source = Path(os.path.realpath(path)), Path(os.path.realpath(log))
    if target.exists() and source.exists():
        is_part = target.parent == source and (target.name == METADATA or target.suffix in STORAGES)
        _refuse(path, {
            "is the log itself": target.samefile(source),
            f"holds the log {log}": target.is_dir() and source.is_relative_to(target),
            f"is a part of the log {log}": is_part,
        })  # fmt: skip


def _refuse(path: Path, faults: Mapping[str, bool]) -> None:
    if what := next((what for what, is_so in faults.items() if is_so), ""):
        raise UsageError(f"{path}: {what}; nothing was written; choose another name or folder")


def _is_own_bag(folder: Path) -> bool:
    """Return True for a ROS 2 bag as this program writes it: metadata, one storage file, nothing else."""
    files = {entry.name: entry for entry in folder.iterdir()}
    metadata = files.pop(METADATA, None)
    if metadata is None or len(files) != 1 or not all(map(Path.is_file, (metadata, *files.values()))):
        return False
    return Path(*files).suffix in STORAGES and _MADE_HERE in metadata.read_text(encoding="utf-8", errors="replace")


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
def _as_usage_error(path: Path) -> Iterator[None]:
    """Raise what the system raises as a UsageError."""
    import sqlite3

    try:
        yield
    except (OSError, sqlite3.OperationalError) as error:
        why = getattr(error, "strerror", None) or error
        full = isinstance(error, sqlite3.OperationalError) or error.errno in _DISK_FULL
        what = "make room there or choose" if full else "choose"
        raise UsageError(f"{path}: cannot be written: {why}; {what} another place") from error


def read_document(path: Path, commands: Sequence[str], otherwise: str = "") -> Mapping[str, Any]:
    """Return a document, a JSON object, of one of these commands; ``otherwise`` says what to do with another one."""
    expected = " or ".join(f"{command}.json" for command in commands)
    try:
        size = path.stat().st_size
        if size > _BIGGEST:
            raise InputError(f"{path}: {size} bytes; expected a document of at most {_BIGGEST}")
        document = json.loads(path.read_bytes())
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; give an existing {expected}") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is no JSON: {error}; expected {expected}; write it again") from error
    schema = document.get("schema") if isinstance(document, dict) else None
    if not isinstance(schema, str) or not schema.startswith(tuple(f"friction-audit/{one}/" for one in commands)):
        wanted = " or ".join(f"`{command}`" for command in commands)
        more = f"; {otherwise}" if otherwise else ""
        raise InputError(f"{path}: schema is {schema!r}; expected a document of {wanted}{more}")
    return dict(document)
