"""`friction-audit diagnose --json` against `estimate --json` of the same log: seven joints at 1 kHz in Parquet.

    python -m benchmarks.bench_diagnose [--seconds 120 600] [--runs 3] [--page docs/speed.md]

Logs are those of `friction-audit simulate panda`, clean and with two hidden effects. Every run is a process of its own,
imports included; the commands take turns, and the first turn, in which caches are filled, does not count. The peak is
that of all processes of a command together, memory that they share counted once (Linux: proportional set size). With
``--page`` the table is written into the page between its marks, else it is printed.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.processes import Run, machine, print_or_write, run

GOALS, GOAL_MB = {120: 4.0, 600: 8.0}, 800
"""Times as long as `estimate` of the same log, by the seconds of the log; peak."""
HIDDEN = {"clean": {}, "two effects": {2: "stribeck", 4: "torque_ripple"}}
"""Of each log: joint and effect."""
BEGIN, END = "<!-- diagnose speed -->", "<!-- end of diagnose speed -->"
PROGRAM = [sys.executable, "-m", "friction_audit"]


def check(output: Path, hidden: dict[int, str]) -> None:
    """Make sure that the command did its whole work: what is hidden is named, and no joint has failed."""
    joints = {one["joint"]: one for one in json.loads(output.read_text())["joints"]}
    missed = [k for k, name in hidden.items() if name not in {one["name"] for one in joints[k]["effects"]}]
    if missed or any(one["verdict"] == "failed" for one in joints.values()):
        raise SystemExit(f"hidden in joints {missed}, and not named, or a joint has failed")


def rows(seconds: int, kind: str, runs: int, folder: Path) -> Iterator[str]:
    """Run both commands in turns on one log; yield a row of the table."""
    path, output = folder / f"{seconds}.parquet", folder / "output.json"
    effects = [part for joint, name in HIDDEN[kind].items() for part in ("--effect", f"{name}@{joint}")]
    simulated = [*PROGRAM, "simulate", "panda", "--duration", str(seconds), "--overwrite", "-q", "-o", str(path)]
    subprocess.run([*simulated, *effects], check=True, stdout=subprocess.DEVNULL)
    taken: dict[str, list[Run]] = {"estimate": [], "diagnose": []}
    for _ in range(runs + 1):
        for name, some in taken.items():
            with output.open("wb") as file:
                some.append(run([*PROGRAM, name, str(path), "-q", "--json"], file, family=True))
    check(output, HIDDEN[kind])
    base = statistics.median(one.wall_s for one in taken["estimate"][1:])
    _, *counted = taken["diagnose"]
    wall, cpu = statistics.median(one.wall_s for one in counted), statistics.median(one.cpu_s for one in counted)
    goals = (f" (goal {GOALS[seconds]:g})", f" (goal {GOAL_MB})") if seconds in GOALS else ("", "")
    peak = max(one.peak_mb for one in counted)
    yield f"| {seconds} | {kind} | {wall:.2f} | {cpu:.2f} | {wall / base:.2f}{goals[0]} | {peak:.0f}{goals[1]} |"


def table(lengths_s: Sequence[int], runs: int) -> Iterator[str]:
    """Yield the lines of the table."""
    seconds = " ".join(map(str, lengths_s))
    yield f"Made by `python -m benchmarks.bench_diagnose --seconds {seconds} --runs {runs}`."
    yield f"Machine: {machine()}"
    yield ""
    yield "| log [s] | hidden | wall [s] | CPU [s] | times `estimate` | peak [MB] |"
    yield "| ---: | --- | ---: | ---: | ---: | ---: |"
    with tempfile.TemporaryDirectory() as folder:
        for length in lengths_s:
            for kind in HIDDEN:
                yield from rows(length, kind, runs, Path(folder))


def main() -> None:
    """Print the table, or write it into a page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=int, nargs="+", default=[120, 600])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--page", type=Path, default=None)
    arguments = parser.parse_args()
    print_or_write(table(arguments.seconds, arguments.runs), arguments.page, BEGIN, END)


if __name__ == "__main__":
    main()
