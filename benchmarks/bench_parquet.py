"""`friction-audit estimate` on one hour of a seven-joint arm at 1 kHz in Parquet or CSV, and pyarrow's bare read.

    python -m benchmarks.bench_parquet [--runs 5] [--hours 1] [--csv]

Every run is a process of its own, imports included. The programs compared take turns, and medians are compared.
"""

import argparse
import json
import multiprocessing
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.processes import INSTALLED, MEGABYTE, Run, run

if TYPE_CHECKING:
    import numpy as np

    from friction_audit.joint_log import Float
    from friction_audit.robot.arm import Arm

JOINTS = range(1, 8)
RATE_HZ = 1000
GROUP = 1 << 20  # rows of a row group, written one after the other: a day of log needs no more memory than an hour
COULOMB_NM, VISCOUS_NMS_PER_RAD = 0.3, 0.05
TOLERANCE = 0.05
"""Relative error of the coefficients that shows that the command has done its work."""

GOAL_MEMORY_MB = 400
COMMAND = "**`friction-audit estimate`**"
BARE = {
    ".parquet": "import sys, pyarrow.parquet; pyarrow.parquet.read_table(sys.argv[1], columns=sys.argv[2:])",
    ".csv": "import sys, pyarrow.csv; pyarrow.csv.read_csv(sys.argv[1])",
}


@dataclass(frozen=True)
class Case:
    """A log to be estimated: its channels, and the options of the command."""

    name: str
    channels: tuple[str, ...]
    options: tuple[str, ...] = ()
    goal: float = 1.5  # times as long as the bare read

    @property
    def columns(self) -> list[str]:
        """The columns of the file."""
        return ["time", *(f"{channel}_{joint}" for channel in self.channels for joint in JOINTS)]


CASES = (
    Case("q, dq, tau_interaction", ("q", "dq", "tau_interaction")),
    Case("q, dq, tau_J, gravity", ("q", "dq", "tau_J", "gravity")),
    Case("q, dq, tau_J, --robot panda", ("q", "dq", "tau_J"), ("--robot", "panda", "--drive", "hand"), 2.0),
)


def write_apart(path: Path, case: Case, hours: float) -> None:
    """Write a log in a process of its own: the peak memory of a child starts from that of its parent."""
    write = write_csv if path.suffix == ".csv" else write_log
    writer = multiprocessing.get_context("spawn").Process(target=write, args=(path, case, hours))
    writer.start()
    writer.join()


def write_csv(path: Path, case: Case, hours: float) -> None:
    """Write the same log as a text table."""
    import pyarrow.csv  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    write_log(path.with_suffix(".parquet"), case, hours)
    with pq.ParquetFile(path.with_suffix(".parquet")) as log, pyarrow.csv.CSVWriter(path, log.schema_arrow) as writer:
        for batch in log.iter_batches():
            writer.write_batch(batch)


def write_log(path: Path, case: Case, hours: float, seed: int = 1) -> None:
    """Write back-and-forth motion of slowly changing amplitude with Coulomb and viscous friction, and sensor noise."""
    import numpy as np  # noqa: PLC0415 (the process that measures stays small)
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    from friction_audit.robot.arm import load_arm  # noqa: PLC0415

    rng, arm, samples = np.random.default_rng(seed), load_arm(), int(hours * 3600 * RATE_HZ)
    schema = pa.schema([(name, pa.float64()) for name in case.columns])
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        for first in range(0, samples, GROUP):
            t = np.arange(first, min(first + GROUP, samples)) / RATE_HZ
            writer.write_table(pa.table(_columns(t, case, rng, arm), schema=schema))


def _columns(t: "Float", case: Case, rng: "np.random.Generator", arm: "Arm") -> "dict[str, Float]":
    """Return the columns of a row group."""
    import numpy as np  # noqa: PLC0415

    omega = 0.5 + 0.1 * np.array(JOINTS)
    swell = 0.011 * np.array(JOINTS)
    size, growth = 0.6 + 0.24 * np.sin(np.outer(t, swell)), 0.24 * swell * np.cos(np.outer(t, swell))
    phase = np.outer(t, omega)
    q = size * np.sin(phase)
    dq = size * omega * np.cos(phase) + growth * np.sin(phase)
    noise = rng.standard_normal((3, *q.shape))
    friction = COULOMB_NM * np.sign(dq) + VISCOUS_NMS_PER_RAD * dq + 0.05 * noise[2]
    gravity = arm.gravity(q)
    channels = {
        "q": q + 1e-5 * noise[0],
        "dq": dq + 1e-3 * noise[1],
        "tau_interaction": friction,
        "tau_J": gravity - friction,
        "gravity": gravity,
    }
    return {"time": t} | {f"{c}_{joint}": channels[c][:, joint - 1] for c in case.channels for joint in JOINTS}


def check_estimates(command: list[str]) -> None:
    """Make sure that the command has an answer for every joint, and the right one."""
    output = subprocess.run([*command, "--json", "--quiet"], check=True, capture_output=True, env=INSTALLED).stdout
    for joint in json.loads(output)["joints"]:
        for name, truth in (("coulomb_nm", COULOMB_NM), ("viscous_nms_per_rad", VISCOUS_NMS_PER_RAD)):
            assert abs(joint[name]["value"] / truth - 1) < TOLERANCE, (joint["joint"], joint[name])


def compare(case: Case, path: Path, hours: float, runs: int) -> Iterator[str]:
    """Run the programs in turns; yield rows of the table."""
    whole = [sys.executable, "-m", "friction_audit", "estimate", str(path), *case.options]
    bare_read = f"pyarrow `{'read_csv' if path.suffix == '.csv' else 'read_table'}`"
    programs = {bare_read: [sys.executable, "-c", BARE[path.suffix], str(path), *case.columns], COMMAND: whole}
    check_estimates(whole)
    taken: dict[str, list[Run]] = {name: [] for name in programs}
    for _ in range(runs):
        for name, command in programs.items():
            taken[name].append(run(command))
    bare = statistics.median(one.wall_s for one in next(iter(taken.values())))
    kept = hours * 3600 * RATE_HZ * len(case.columns) * 8 / MEGABYTE
    for name, results in taken.items():
        middle = statistics.median(one.wall_s for one in results)
        peak = max(one.peak_mb for one in results)
        goals = (f" (goal {case.goal:g})", f" (goal {GOAL_MEMORY_MB})") if name == COMMAND else ("", "")
        yield (
            f"| {case.name} | {name} | {middle:.2f} | {middle / bare:.2f}{goals[0]} "
            f"| {peak:.0f}{goals[1]} | {peak / kept:.2f} |"
        )


def main() -> None:
    """Write the files, print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--hours", type=float, default=1.0)
    parser.add_argument("--csv", action="store_true", help="the first log alone, as a text table")
    arguments = parser.parse_args()
    form, cases = ("CSV", CASES[:1]) if arguments.csv else ("zstd", CASES)
    print(f"{arguments.hours:g} h, seven joints, 1 kHz, {form}; medians of {arguments.runs} runs in turns\n")
    print("| log | process | wall [s] | times pyarrow | peak [MB] | peak / arrays |")
    print("|---|---|---:|---:|---:|---:|")
    for case in cases:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / ("hour.csv" if arguments.csv else "hour.parquet")
            write_apart(path, case, arguments.hours)
            for row in compare(case, path, arguments.hours, arguments.runs):
                print(row, flush=True)


if __name__ == "__main__":
    main()
