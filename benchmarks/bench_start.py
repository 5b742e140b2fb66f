"""How long the program takes to start, against the imports that it cannot do without.

    python -m benchmarks.bench_start [--runs 9]

The log is 20 s of a seven-joint arm at 1 kHz. *First* runs have an empty cache of compiled loops, as after an
installation by pip, which compiles Python's bytecode itself.
"""

import argparse
import shutil
import statistics
import sys
import tempfile
from pathlib import Path

from benchmarks.bench_parquet import CASES, write_log
from benchmarks.processes import INSTALLED, run

PROGRAM = [sys.executable, "-m", "friction_audit"]
HOURS = 20 / 3600


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=9)
    runs = parser.parse_args().runs
    with tempfile.TemporaryDirectory() as folder:
        log, cache = str(Path(folder) / "log.parquet"), Path(folder) / "cache"
        INSTALLED["NUMBA_CACHE_DIR"] = str(cache)
        write_log(Path(log), CASES[0], HOURS)
        programs = {
            "`import typer`": [sys.executable, "-c", "import typer"],
            "`friction-audit --help`": [*PROGRAM, "--help"],
            "`import numpy, pyarrow, typer`": [sys.executable, "-c", "import numpy, pyarrow, typer"],
            "`estimate`, first": [*PROGRAM, "estimate", log, "-q"],
            "`estimate`, again": [*PROGRAM, "estimate", log, "-q"],
            "`diagnose`, first": [*PROGRAM, "diagnose", log, "-q"],
            "`diagnose`, again": [*PROGRAM, "diagnose", log, "-q"],
        }
        taken: dict[str, list[float]] = {name: [] for name in programs}
        for turn in range(runs + 1):
            for name, command in programs.items():
                if name.endswith("first"):
                    shutil.rmtree(cache, ignore_errors=True)
                seconds = run(command).wall_s
                if turn:  # the turn before compiled the bytecode
                    taken[name].append(seconds)
    medians = {name: statistics.median(times) for name, times in taken.items()}
    against = {
        "`friction-audit --help`": ("`import typer`", ""),
        "`estimate`, first": ("`estimate`, again", " (goal 1.5)"),
        "`estimate`, again": ("`import numpy, pyarrow, typer`", " (goal 2)"),
        "`diagnose`, first": ("`diagnose`, again", ""),
    }
    print(f"20 s, seven joints, 1 kHz; medians of {runs} runs in turns\n")
    print("| process | wall [s] | ratio | of |")
    print("|---|---:|---:|---|")
    for name, median in medians.items():
        other, goal = against.get(name, ("", ""))
        ratio = f"{median / medians[other]:.2f}{goal}" if other else ""
        print(f"| {name} | {median:.2f} | {ratio} | {other} |")


if __name__ == "__main__":
    main()
