"""What scripts about speed share: processes that are measured, the machine, tables between two marks of a page."""

import os
import platform
import subprocess
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import IO

LIBRARIES = ("numpy", "scipy", "numba", "pyarrow", "mcap", "rosbags", "typer")
MEGABYTE = 1e6
SAMPLED_S = 0.05
# As after an installation, Python keeps compiled modules: the first run of a script makes them.
INSTALLED = {name: text for name, text in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}


@dataclass(frozen=True)
class Run:
    """What one process took."""

    wall_s: float
    cpu_s: float
    peak_mb: float


def run(
    command: Sequence[str], output: IO[bytes] | int = subprocess.DEVNULL, *, family: bool = False, cores: int = 0
) -> Run:
    """Run a process, on so many cores or all, and measure it; ``family``: the peak of all its processes together.

    To ask for the memory of three processes takes 14 ms; twenty times a second, that is a fifth of a core.
    """
    every, began, peak, ended = os.sched_getaffinity(0), time.perf_counter(), 0.0, 0
    os.sched_setaffinity(0, sorted(every)[: cores or None])  # a process inherits it
    process = subprocess.Popen(command, stdout=output, env=INSTALLED)
    os.sched_setaffinity(0, every)
    while not ended:
        ended, status, usage = os.wait4(process.pid, os.WNOHANG if family else 0)
        if not ended:
            peak = max(peak, sum(map(_shared_mb, _family(process.pid))))
            time.sleep(SAMPLED_S)
    seconds = time.perf_counter() - began
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"{' '.join(command)}: exit status {process.returncode}")
    return Run(seconds, usage.ru_utime + usage.ru_stime, peak if family else usage.ru_maxrss * 1024 / MEGABYTE)


def _family(pid: int) -> Iterator[int]:
    """Yield a process and all that it has started."""
    yield pid
    try:
        threads = [*Path(f"/proc/{pid}/task").iterdir()]
        children = [child for thread in threads for child in (thread / "children").read_text().split()]
    except OSError:  # it has ended
        return
    for child in children:
        yield from _family(int(child))


def _shared_mb(pid: int) -> float:
    """Return the memory of a process, what it shares with others in equal parts (proportional set size). [MB]"""
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii").splitlines()
    except OSError:  # it has ended
        return 0.0
    return next((int(line.split()[1]) * 1024 / MEGABYTE for line in lines if line.startswith("Pss:")), 0.0)


def machine() -> str:
    """Describe what the figures were measured on."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9
    listing = Path("/proc/cpuinfo")
    lines = listing.read_text(encoding="utf-8").splitlines() if listing.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    libraries = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    return (
        f"{os.cpu_count()} cores ({names[0] if names else platform.machine()}), {memory:.0f} GB, {platform.system()}, "
        f"Python {platform.python_version()}, {libraries}."
    )


def write_between(page: Path, begin: str, end: str, text: str) -> None:
    """Put text between two marks of a page, in the place of what was there; ValueError if it does not hold both."""
    whole = page.read_text(encoding="utf-8")
    before, after = whole[: whole.index(begin)], whole[whole.index(end) :]
    page.write_text(f"{before}{begin}\n\n{text}\n\n{after}", encoding="utf-8")


def print_or_write(lines: Iterator[str], page: Path | None, begin: str, end: str) -> None:
    """Print the lines of a table as they are made, and write them between two marks of a page if there is one."""
    kept = []
    for line in lines:
        print(line, flush=True)
        kept.append(line)
    if page is not None:
        write_between(page, begin, end, "\n".join(kept))
