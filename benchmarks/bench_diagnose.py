"""`friction-audit diagnose` beside `friction-audit estimate` on the same file: seven joints at 1 kHz in Parquet.

    python -m benchmarks.bench_diagnose [--seconds 120 600] [--runs 3] [--page docs/speed.md]

A third of the joints hides Stribeck friction, a third a ripple, a third nothing; what is named is checked. Every run is
a process of its own, imports included; the two commands take turns, and the first turn, in which caches are filled,
does not count. With ``--page`` the table is written into the page between its marks, else it is printed.
"""

import argparse
import json
import multiprocessing
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.bench_parquet import JOINTS, RATE_HZ, Run, run
from benchmarks.bench_speed import machine
from benchmarks.marked_page import write_between

GOALS = {120: 4.0, 600: 8.0}
"""Times `estimate` of the same log, by its seconds."""
INERTIA, COULOMB, VISCOUS, STRIBECK, RIPPLE, NOISE = 0.15, 0.3, 0.1, 0.15, 0.1, 0.05
HIDDEN = ("stribeck", "torque_ripple", None)
"""In turn, joint by joint."""
MOST_MISSED = 1
"""Joints whose effect may go unnamed: this is no test of the detector, only that it had its whole work to do."""
BEGIN, END = "<!-- diagnose speed -->", "<!-- end of diagnose speed -->"


def write_log(path: Path, seconds: float, seed: int = 1) -> None:
    """Write strokes of changing size and pace, felt by torque sensors of a hand-guided arm without gravity."""
    import numpy as np  # noqa: PLC0415 (the process that measures stays small)
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    rng = np.random.default_rng(seed)
    t = np.arange(int(seconds * RATE_HZ)) / RATE_HZ
    columns = {"time": t}
    for joint in JOINTS:
        pace = 1.2 + 0.3 * joint
        phase = pace * t + 4.0 * np.sin(0.02 * joint * t)
        q = (0.5 + 0.3 * np.sin(0.13 * t + joint)) * np.sin(phase) + 0.3 * np.sin(0.05 * t + joint)
        dq = np.gradient(q, t)
        torque = INERTIA * np.gradient(dq, t) + COULOMB * np.sign(dq) + VISCOUS * dq
        hidden = HIDDEN[joint % len(HIDDEN)]
        if hidden == "stribeck":
            torque += STRIBECK * np.sign(dq) * np.exp(-np.abs(dq) / 0.1)
        elif hidden == "torque_ripple":
            torque += RIPPLE * np.cos(20.0 * q)
        noise = rng.standard_normal((3, len(t)))
        columns[f"q_{joint}"] = q + 1e-5 * noise[0]
        columns[f"dq_{joint}"] = dq + 1e-3 * noise[1]
        columns[f"tau_interaction_{joint}"] = torque + NOISE * noise[2]
    pq.write_table(pa.table(columns), path, compression="zstd")


def check(command: Sequence[str]) -> None:
    """Make sure that what is hidden is among what is named."""
    output = subprocess.run(command, check=True, capture_output=True).stdout
    found = [tuple(effect["name"] for effect in joint["effects"]) for joint in json.loads(output)["joints"]]
    hidden = [HIDDEN[joint % len(HIDDEN)] for joint in JOINTS]
    missed = [
        (joint, name) for joint, name, names in zip(JOINTS, hidden, found, strict=True) if name not in (*names, None)
    ]
    if len(missed) > MOST_MISSED:
        raise SystemExit(f"hidden, and not named: {missed}")


def rows(seconds: int, runs: int, folder: Path) -> Iterator[str]:
    """Run both commands in turns on a log of so many seconds; yield rows of the table."""
    path = folder / f"{seconds}.parquet"
    # A process of its own: the parent's memory would count for its children until they run another program.
    writer = multiprocessing.get_context("spawn").Process(target=write_log, args=(path, seconds))
    writer.start()
    writer.join()
    commands = {
        f"`{name}`": [sys.executable, "-m", "friction_audit", name, str(path), "-q", "--json"]
        for name in ("estimate", "diagnose")
    }
    check(commands["`diagnose`"])
    taken: dict[str, list[Run]] = {name: [] for name in commands}
    for _ in range(runs + 1):
        for name, command in commands.items():
            taken[name].append(run(command))
    base = statistics.median(one.wall_s for one in taken["`estimate`"][1:])
    for name, (_, *counted) in taken.items():
        walls = sorted(one.wall_s for one in counted)
        middle, cpu = statistics.median(walls), statistics.median(one.cpu_s for one in counted)
        goal = f" (goal {GOALS[seconds]:g})" if name == "`diagnose`" and seconds in GOALS else ""
        yield (
            f"| {seconds} | {name} | {middle:.2f} ({walls[0]:.2f} to {walls[-1]:.2f}) | {cpu:.2f} "
            f"| {middle / base:.2f}{goal} | {max(one.peak_mb for one in counted):.0f} |"
        )


def table(lengths_s: Sequence[int], runs: int) -> Iterator[str]:
    """Yield the lines of the table."""
    seconds = " ".join(map(str, lengths_s))
    yield f"Made by `python -m benchmarks.bench_diagnose --seconds {seconds} --runs {runs}`."
    yield f"Machine: {machine()}"
    yield ""
    yield "| log [s] | command | wall [s], median (range) | CPU [s] | times `estimate` | peak [MB] |"
    yield "| ---: | --- | --- | ---: | ---: | ---: |"
    with tempfile.TemporaryDirectory() as folder:
        for length in lengths_s:
            yield from rows(length, runs, Path(folder))


def main() -> None:
    """Print the table, or write it into a page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=int, nargs="+", default=[120, 600])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--page", type=Path, default=None)
    arguments = parser.parse_args()
    lines = []
    for line in table(arguments.seconds, arguments.runs):
        print(line, flush=True)
        lines.append(line)
    if arguments.page is not None:
        write_between(arguments.page, BEGIN, END, "\n".join(lines))


if __name__ == "__main__":
    main()
