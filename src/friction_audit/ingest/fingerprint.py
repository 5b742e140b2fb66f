"""What a file was when it was read: its hash, its size, which file it is and when it was last changed."""

import errno
import hashlib
import stat
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Stamp:
    """What tells a file, or all files of a directory, from a changed one without reading it.

    Attributes:
        size: Bytes, of all files.
        changed_ns: Time of the last change of content that the file system tells, the latest of all files. [ns]
        identity: Of each file its name, device, inode and both times: ``cp -p`` over a file keeps size and time of the
            content, but not the time of the inode, and ``mv`` over it not the inode.
    """

    size: int
    changed_ns: int
    identity: tuple[tuple[str, int, int, int, int], ...] = ()


def stamp_of(path: Path) -> Stamp:
    """Return what tells a file or a directory's files from changed ones."""
    states = [(str(file), file.stat()) for file in files_of(path)]
    return Stamp(
        size=sum(state.st_size for _, state in states),
        changed_ns=max((state.st_mtime_ns for _, state in states), default=0),
        identity=tuple((name, s.st_dev, s.st_ino, s.st_mtime_ns, s.st_ctime_ns) for name, s in states),
    )


def sha256_of(path: Path) -> str:
    """Return the hash of a file's content; of a directory: of all its files, in sorted order.

    Raises:
        OSError: If a file cannot be read, or is a pipe or a device, which might never end.
    """
    digest, files = hashlib.sha256(), files_of(path)
    if not files:  # all folders that cannot be listed would be one content
        raise OSError(errno.ENOENT, "holds no file that can be read", str(path))
    for file in files:
        if not stat.S_ISREG(file.stat().st_mode):  # to open a named pipe waits for its writer
            raise OSError(errno.EINVAL, "a pipe or a device, not a file", str(file))
        with file.open("rb") as stream:
            hashlib.file_digest(stream, lambda: digest)
    return digest.hexdigest()


def files_of(path: Path) -> list[Path]:
    """Return the file itself, or every file below a directory, sorted."""
    return sorted(file for file in path.rglob("*") if file.is_file()) if path.is_dir() else [path]
