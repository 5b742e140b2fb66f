"""How long `friction-audit --help` takes beside importing Typer.

python benchmarks/bench_help.py [--runs 15]
"""

import argparse
import statistics
import subprocess
import sys
import time

PROGRAMS = {
    "`import typer`": [sys.executable, "-c", "import typer"],
    "`friction-audit --help`": [sys.executable, "-m", "friction_audit", "--help"],
    "`friction-audit estimate --help`": [sys.executable, "-m", "friction_audit", "estimate", "--help"],
}
GOAL_S = 0.1


def seconds(command: list[str]) -> float:
    """Return how long a process takes."""
    before = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - before


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=15)
    runs = parser.parse_args().runs
    taken: dict[str, list[float]] = {name: [] for name in PROGRAMS}
    for _ in range(runs):
        for name, command in PROGRAMS.items():
            taken[name].append(seconds(command))
    medians = {name: statistics.median(times) for name, times in taken.items()}
    typer = next(iter(medians.values()))
    print(f"medians of {runs} runs in turns; goal: at most {GOAL_S:g} s more than importing Typer\n")
    print("| process | wall [s] | more than `import typer` [s] |")
    print("|---|---:|---:|")
    for name, median in medians.items():
        print(f"| {name} | {median:.3f} | {median - typer:.3f} |")


if __name__ == "__main__":
    main()
