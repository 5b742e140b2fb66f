"""Work that kills its worker; workers import nothing else for it."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

from friction_audit.batch.find_logs import LogFile
from friction_audit.batch.identity import Worked


def tasks(folder: Path, *names: str) -> Iterator[LogFile]:
    """Yield logs of these names."""
    return (LogFile(path=name, place=str(folder / name), folders=(), size=0, changed="") for name in names)


def fragile(task: LogFile) -> Worked:
    """Kill the worker on some tasks, always or the first time, or end it, or fail."""
    if task.path == "deadly" or (task.path == "once" and not Path(task.place).exists()):
        Path(task.place).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if task.path == "leaves":
        os._exit(3)
    if task.path == "bug":
        raise ZeroDivisionError("by nought")
    return Worked(sha256=f"{task.path} {os.getpid()}")
