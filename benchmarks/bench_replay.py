"""`friction-audit replay` beside `friction-audit estimate` on the same file: seven joints at 1 kHz in Parquet.

    python benchmarks/bench_replay.py [--runs 3] [--hours 1]

The file is that of bench_parquet.py. Every run is a process of its own; the two commands take turns.
"""

import argparse
import multiprocessing
import statistics
import sys
import tempfile
from pathlib import Path

from bench_parquet import CASES, Run, run, write_log  # type: ignore[import-not-found]  # beside this script

GOAL = 1.6
"""Times the CPU time of ``estimate``, along the recorded motion."""

COMMANDS = {"`estimate`": "estimate", "`replay`": "replay"}


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--hours", type=float, default=1.0)
    arguments = parser.parse_args()
    taken: dict[str, list[Run]] = {name: [] for name in COMMANDS}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.parquet"
        # A process of its own: the parent's memory would count for its children until they run another program.
        writer = multiprocessing.get_context("spawn").Process(target=write_log, args=(path, CASES[0], arguments.hours))
        writer.start()
        writer.join()
        for _ in range(arguments.runs + 1):
            for name, command in COMMANDS.items():
                taken[name].append(run([sys.executable, "-m", "friction_audit", command, str(path), "-q"]))
    base = statistics.median(one.cpu_s for one in taken["`estimate`"][1:])
    print("| command | CPU [s] | times `estimate` | peak [MB] |")
    print("|---|---:|---:|---:|")
    for name, (_, *runs) in taken.items():  # the first run of each compiles what no cache holds
        cpu = statistics.median(one.cpu_s for one in runs)
        goal = f" (goal {GOAL:g})" if name == "`replay`" else ""
        print(f"| {name} | {cpu:.2f} | {cpu / base:.2f}{goal} | {max(one.peak_mb for one in runs):.0f} |")


if __name__ == "__main__":
    main()
