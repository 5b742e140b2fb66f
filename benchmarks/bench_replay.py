"""`friction-audit replay` next to `friction-audit estimate` on the same file: seven joints at 1 kHz in Parquet.

    python -m benchmarks.bench_replay [--runs 3] [--hours 1]

The file is that of bench_parquet.py. Every run is a process of its own; the two commands take turns.
"""

import argparse
import statistics
import sys
import tempfile
from pathlib import Path

from benchmarks.bench_parquet import CASES, write_apart
from benchmarks.processes import Run, run

GOAL = 1.6  # times the CPU time of ``estimate``, along the recorded motion


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--hours", type=float, default=1.0)
    arguments = parser.parse_args()
    taken: dict[str, list[Run]] = {"estimate": [], "replay": []}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.parquet"
        write_apart(path, CASES[0], arguments.hours)
        for _ in range(arguments.runs + 1):
            for command, runs in taken.items():
                runs.append(run([sys.executable, "-m", "friction_audit", command, str(path), "-q"]))
    base = statistics.median(one.cpu_s for one in taken["estimate"][1:])
    print("| command | CPU [s] | times `estimate` | peak [MB] |")
    print("|---|---:|---:|---:|")
    for name, (_, *runs) in taken.items():  # the first run of each compiles what no cache holds
        cpu = statistics.median(one.cpu_s for one in runs)
        goal = f" (goal {GOAL:g})" if name == "replay" else ""
        print(f"| `{name}` | {cpu:.2f} | {cpu / base:.2f}{goal} | {max(one.peak_mb for one in runs):.0f} |")


if __name__ == "__main__":
    main()
