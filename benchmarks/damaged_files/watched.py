"""A command in a child process of its own, with limits of memory and time."""

import importlib
import json
import os
import resource
import signal
import sys
import tempfile
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

GIGABYTE = 1 << 30


@dataclass(frozen=True, kw_only=True, slots=True)
class Outcome:
    """How a command ended."""

    code: int  # exit code; minus the signal's number if a signal ended it
    cpu_s: float  # processor time [s]
    peak_bytes: int  # largest resident memory above what the process began with [B]
    document: dict[str, Any] | None  # the JSON document on standard output, or None
    errors: str  # standard error

    @property
    def failed(self) -> bool:
        """A bug: a traceback, or an end by a signal other than the limit of time."""
        return self.code == 1 or "Traceback (most recent call last)" in self.errors or self.crashed

    @property
    def crashed(self) -> bool:
        """The process was ended by a signal that is no limit of this module."""
        return self.code < 0 and self.code != -signal.SIGALRM

    @property
    def warnings(self) -> frozenset[str]:
        """Codes of the warnings in the document."""
        return frozenset(str(one["code"]) for one in (self.document or {}).get("warnings", ()))

    @property
    def coefficients(self) -> dict[tuple[int, str], float]:
        """Coefficient by joint and name, of all joints that have one."""
        joints = (self.document or {}).get("joints", ())
        found = ((j["joint"], name, j.get(name)) for j in joints for name in ("coulomb_nm", "viscous_nms_per_rad"))
        return {
            (joint, name): float(entry["value"]) for joint, name, entry in found if entry and entry["value"] is not None
        }


def preload(example: Path) -> None:
    """Import here what an estimate of an example imports, so that children begin with it."""
    reader, writer = os.pipe()
    if os.fork() == 0:
        with tempfile.TemporaryFile() as sink:
            _command(["estimate", str(example), "--json"], sink.fileno(), sink.fileno())
        os.write(writer, "\n".join(name for name in sys.modules if "__mp" not in name).encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as stream:
        names = stream.read().split()
    os.wait()
    for name in names:
        if name.split(".")[0] in sys.stdlib_module_names or name == "__main__":
            continue
        importlib.import_module(name)


def run(argv: Sequence[str], *, memory: int = 6 * GIGABYTE, seconds: int = 30) -> Outcome:
    """Run the command line in a child process.

    Args:
        argv: The words of the command.
        memory: Limit of the address space. [B]
        seconds: Limit of the processor and of the wall time. [s]
    """
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        begin = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        child = os.fork()
        if child == 0:
            resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.alarm(seconds)
            os._exit(_command(argv, out.fileno(), err.fileno()))
        _, status, usage = os.wait4(child, 0)
        out.seek(0)
        err.seek(0)
        text = out.read()
        try:
            document = json.loads(text)
        except ValueError:
            document = None
        return Outcome(
            code=os.waitstatus_to_exitcode(status),
            cpu_s=usage.ru_utime + usage.ru_stime,
            peak_bytes=max(usage.ru_maxrss - begin, 0) * 1024,
            document=document,
            errors=err.read().decode(errors="replace"),
        )


def _command(argv: Sequence[str], out: int, err: int) -> int:
    """Run the command line with its outputs in files; return its exit code, 1 with a traceback for a bug."""
    os.dup2(out, 1)
    os.dup2(err, 2)
    sys.stdout, sys.stderr = open(1, "w", closefd=False), open(2, "w", closefd=False)  # noqa: SIM115
    code = 1
    try:
        from friction_audit.cli import main  # noqa: PLC0415  # its imports are part of the command

        main(list(argv))
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 0
    except BaseException:  # noqa: BLE001  # what escapes the program is what is counted here
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
    return code
