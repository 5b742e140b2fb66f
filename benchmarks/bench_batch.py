"""`friction-audit batch-report` on many one-minute logs of a seven-joint arm at 1 kHz in Parquet.

    python -m benchmarks.bench_batch [--logs 100] [--runs 3] [--memory 100 1000] [--page docs/speed.md]

What two cores gain over one, what a second run on the unchanged folder takes, and whether memory stays flat. Every run
is the whole command in a process of its own: imports, figures and page included. On one core, all of its processes are
bound to that core. A run is either timed or watched: to ask the kernel for the memory of three processes takes 14 ms,
and twenty times a second, that is a fifth of a core, which a run on all cores would have to spare. With ``--page`` the
table is written into the page between its marks, else it is printed.
"""

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from benchmarks.bench_parquet import CASES, MEGABYTE, write_log
from benchmarks.bench_speed import machine
from benchmarks.marked_page import write_between

MINUTE_H = 1 / 60
DISTINCT = 8
"""Recordings with noise of their own; the others are copies of theirs whose bytes differ in a note."""
MARK = b"take 000000"
FASTER, SECOND_RUN_S = 1.8, 5.0
"""Goals."""
BEGIN, END = "<!-- batch speed -->", "<!-- end of batch speed -->"
SAMPLE_S = 0.05


def write_logs(folder: Path, count: int) -> None:
    """Write logs, one an hour; a note in each file makes its content its own."""
    import pyarrow.parquet as pq  # noqa: PLC0415 (the process that measures stays small)

    folder.mkdir()
    originals = []
    for seed in range(min(count, DISTINCT)):
        path = folder.with_name(f"original{seed}.parquet")
        write_log(path, CASES[1], MINUTE_H, seed)
        pq.write_table(pq.read_table(path).replace_schema_metadata({"note": MARK}), path, compression="zstd")
        originals.append(path)
    for number in range(count):
        original = originals[number % len(originals)]
        content = original.read_bytes().replace(MARK, b"take %06d" % number)
        day, hour = divmod(number, 24)
        (folder / f"2026-{1 + day // 28:02d}-{1 + day % 28:02d}T{hour:02d}-00-00.parquet").write_bytes(content)
    os.sync()  # nobody writes to the disk any more while runs are timed


@contextmanager
def running(command: Sequence[str], cores: int) -> "Iterator[subprocess.Popen[bytes]]":
    """Start a command on so many cores, and wait for its end."""
    chosen = sorted(os.sched_getaffinity(0))[:cores]
    process = subprocess.Popen(
        command,
        stdout=subprocess.DEVNULL,
        preexec_fn=lambda: os.sched_setaffinity(0, chosen),  # noqa: PLW1509 - nothing else runs yet
    )
    yield process
    if process.wait() != 0:
        raise SystemExit(f"{' '.join(command)}: exit status {process.returncode}")


def wall_s(command: Sequence[str], cores: int) -> float:
    """Run a command and return how long it took. [s]"""
    begin = time.perf_counter()
    with running(command, cores):
        pass
    return time.perf_counter() - begin


def peak_mb(command: Sequence[str], cores: int) -> float:
    """Run a command and return the most memory that all its processes took together. [MB]"""
    peak = 0.0
    with running(command, cores) as process:
        while process.poll() is None:
            peak = max(peak, sum(_resident_mb(pid) for pid in _family(process.pid)))
            time.sleep(SAMPLE_S)
    return peak


def _family(pid: int) -> Iterator[int]:
    """Yield a process and all that it has started."""
    yield pid
    try:
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()
    except OSError:  # it has ended
        return
    for child in children:
        yield from _family(int(child))


def _resident_mb(pid: int) -> float:
    """Return the memory of a process, what it shares with others in equal parts. [MB]"""
    try:
        text = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii")
    except OSError:
        return 0.0
    return next((int(line.split()[1]) * 1024 / MEGABYTE for line in text.splitlines() if line.startswith("Pss:")), 0.0)


def batch(logs: Path, output: Path, cores: int) -> list[str]:
    """Return the command for a folder, a worker for each core."""
    words = ["batch-report", str(logs), "-o", str(output), "--workers", str(cores), "--quiet"]
    return [sys.executable, "-m", "friction_audit", *words]


def speed_rows(folder: Path, count: int, runs: int) -> Iterator[str]:
    """Compare one core, two, and a second run, in turns."""
    write_logs(folder / "logs", count)
    taken: dict[str, list[float]] = {"one core": [], "two cores": [], "again, nothing new": []}
    for number in range(runs):
        for cores, name in enumerate(("one core", "two cores"), start=1):
            taken[name].append(wall_s(batch(folder / "logs", folder / f"out{number}-{cores}", cores), cores))
        taken["again, nothing new"].append(wall_s(batch(folder / "logs", folder / f"out{number}-2", 2), 2))
    single = statistics.median(taken["one core"])
    goal = {"two cores": f" (goal {FASTER:g})", "again, nothing new": f" (goal: under {SECOND_RUN_S:g} s)"}
    for name, walls in taken.items():
        middle = statistics.median(walls)
        yield f"| {count} | {name} | {middle:.1f} | {single / middle:.2f}{goal.get(name, '')} | |"
    shutil.rmtree(folder / "logs")


def memory_rows(folder: Path, counts: Sequence[int]) -> Iterator[str]:
    """Run two cores on more and more logs, each number once."""
    for count in counts:
        write_logs(folder / f"logs{count}", count)
        peak = peak_mb(batch(folder / f"logs{count}", folder / f"many{count}", 2), 2)
        yield f"| {count} | two cores | | | {peak:.0f} |"
        shutil.rmtree(folder / f"logs{count}")


def table(arguments: argparse.Namespace) -> Iterator[str]:
    """Yield the lines of the table."""
    options = f"--logs {arguments.logs} --runs {arguments.runs} --memory {' '.join(map(str, arguments.memory))}".strip()
    yield f"Made by `python -m benchmarks.bench_batch {options}`."
    yield f"Machine: {machine()}"
    yield "Peaks are of all processes of the command together, in runs of their own."
    yield ""
    yield "| logs | run | wall [s] | times one core | peak [MB] |"
    yield "|---:|---|---:|---:|---:|"
    with tempfile.TemporaryDirectory() as folder:
        yield from speed_rows(Path(folder), arguments.logs, arguments.runs)
        yield from memory_rows(Path(folder), arguments.memory)


def main() -> None:
    """Print the table, or write it into a page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--logs", type=int, default=100)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument(
        "--memory", type=int, nargs="*", default=[100, 1000], help="numbers of logs; 15 MB of disk each"
    )
    parser.add_argument("--page", type=Path, default=None)
    arguments = parser.parse_args()
    lines = []
    for line in table(arguments):
        print(line, flush=True)
        lines.append(line)
    if arguments.page is not None:
        write_between(arguments.page, BEGIN, END, "\n".join(lines))


if __name__ == "__main__":
    main()
