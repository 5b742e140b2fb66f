"""One hour, seven joints, 1 kHz in Parquet: our reading and vetting beside pyarrow's bare read of the same columns.

Every case is a process of its own, imports included; cases alternate, and the medians are compared.
    python benchmarks/bench_parquet.py [--runs 5] [--hours 1]
"""

import argparse
import multiprocessing
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

JOINTS = 7
RATE_HZ = 1000

BARE = """
import sys, pyarrow.parquet
names = ["time"] + [f"{channel}_{joint}" for channel in ("q", "dq", "tau_J") for joint in range(1, 8)]
table = pyarrow.parquet.read_table(sys.argv[1], columns=names)
"""
OURS = """
import sys
from friction_audit.ingest import read_log
log = read_log(sys.argv[1])
"""
NO_READING = """
import numpy, pyarrow.parquet
from friction_audit.ingest import read_log
"""


def write_hour(path: Path, hours: float, compression: str) -> None:
    """Write a log of sines with measurement noise: q, dq and tau_J of seven joints."""
    import numpy as np  # noqa: PLC0415 (this process stays small)
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    rng = np.random.default_rng(1)
    samples = int(hours * 3600 * RATE_HZ)
    t = np.arange(samples) / RATE_HZ
    columns = {"time": t}
    for joint in range(1, JOINTS + 1):
        rate = 0.5 + 0.1 * joint
        columns[f"q_{joint}"] = 0.8 * np.sin(rate * t) + 1e-5 * rng.standard_normal(samples)
        columns[f"dq_{joint}"] = 0.8 * rate * np.cos(rate * t) + 1e-3 * rng.standard_normal(samples)
        columns[f"tau_J_{joint}"] = 0.25 * np.sign(np.cos(rate * t)) + 0.05 * rng.standard_normal(samples)
    pq.write_table(pa.table(columns), path, compression=compression, row_group_size=1 << 20)


def run(code: str, path: Path) -> tuple[float, float]:
    """Return the wall time [s] and the peak memory [MB] of a process."""
    before = time.perf_counter()
    process = subprocess.Popen([sys.executable, "-c", code, str(path)])
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"exit status {status}")
    return time.perf_counter() - before, usage.ru_maxrss / 1024


def compare(path: Path, runs: int) -> None:
    """Print the medians of the cases and their ratios."""
    cases = {"bare read_table": BARE, "read_log": OURS, "imports only": NO_READING}
    taken: dict[str, list[tuple[float, float]]] = {name: [] for name in cases}
    for _ in range(runs):
        for name, code in cases.items():
            taken[name].append(run(code, path))
    bare = statistics.median(seconds for seconds, _ in taken["bare read_table"])
    for name, results in taken.items():
        seconds = statistics.median(seconds for seconds, _ in results)
        memory = max(memory for _, memory in results)
        print(f"{path.name:12} {name:16} {seconds:6.2f} s  {seconds / bare:5.2f} x bare  {memory:6.0f} MB")


def main() -> None:
    """Write the files and compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--hours", type=float, default=1.0)
    arguments = parser.parse_args()
    kept = arguments.hours * 3600 * RATE_HZ * (1 + 3 * JOINTS) * 8 / 2**20
    print(f"arrays kept: {kept:.0f} MB")
    with tempfile.TemporaryDirectory() as folder:
        for compression in ("zstd", "snappy"):
            path = Path(folder) / f"{compression}.parquet"
            # In a process of its own: a child's peak memory starts from that of its parent.
            writer = multiprocessing.get_context("spawn").Process(
                target=write_hour, args=(path, arguments.hours, compression)
            )
            writer.start()
            writer.join()
            compare(path, arguments.runs)


if __name__ == "__main__":
    main()
