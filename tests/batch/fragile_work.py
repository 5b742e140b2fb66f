"""Work that kills its worker; workers import nothing else for it."""

import os
import signal
from pathlib import Path

from friction_audit.batch.identity import Worked
from friction_audit.batch.work import Task


def deadly_once(task: Task) -> Worked:
    """Kill the worker on one of the tasks, the first time."""
    if task.path == "3" and not Path(task.place).exists():
        Path(task.place).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if task.path == "bug":
        raise ZeroDivisionError("by nought")
    return Worked(sha256=task.path)
