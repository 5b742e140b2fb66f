"""`friction-audit batch-report` on many one-minute logs of a seven-joint arm at 1 kHz in Parquet.

    python -m benchmarks.bench_batch [--logs 100] [--runs 3] [--memory 100 1000] [--page docs/speed.md]

What two cores gain over one, what a second run on the unchanged folder takes, and whether memory stays flat. Every run
is the whole command in a process of its own: imports, figures and page included. On one core, all of its processes are
bound to that core. A run is either timed or its memory is watched. With ``--page`` the table is written into the page
between its marks, else it is printed.
"""

import argparse
import os
import shutil
import statistics
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.bench_parquet import CASES, write_log
from benchmarks.processes import machine, print_or_write, run

MINUTE_H = 1 / 60
DISTINCT = 8
"""Recordings with noise of their own; the others are copies of theirs whose bytes differ in a note."""
MARK = b"take 000000"
FASTER, SECOND_RUN_S = 1.8, 5.0
"""Goals."""
BEGIN, END = "<!-- batch speed -->", "<!-- end of batch speed -->"


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
    os.sync()  # so that nothing is written to the disk while runs are timed


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
            command = batch(folder / "logs", folder / f"out{number}-{cores}", cores)
            taken[name].append(run(command, cores=cores).wall_s)
        taken["again, nothing new"].append(run(command, cores=2).wall_s)
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
        peak = run(batch(folder / f"logs{count}", folder / f"many{count}", 2), family=True, cores=2).peak_mb
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
    print_or_write(table(arguments), arguments.page, BEGIN, END)


if __name__ == "__main__":
    main()
