"""Everything about speed and memory, on one page.

    python -m benchmarks.bench_speed [--hours 1] [--messages 1000000] [--runs 5] [--output docs/speed.md]

Runs the other scripts one after the other and gathers their tables.
"""

import argparse
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from benchmarks.processes import machine


def table(script: str, *options: str) -> str:
    """Return what another script prints."""
    command = [sys.executable, "-m", f"benchmarks.{script}", *options]
    print(f"{script} ...", file=sys.stderr)
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()


def page(arguments: argparse.Namespace) -> Iterator[str]:
    """Yield the parts of the page."""
    hours, messages, runs = f"{arguments.hours:g}", str(arguments.messages), str(arguments.runs)
    yield "# Speed and memory"
    yield f"Made by `python -m benchmarks.bench_speed --hours {hours} --messages {messages} --runs {runs}`."
    yield f"Machine: {machine()}"
    yield "Times are medians; peaks include libraries."
    yield "## `estimate` and a bare read of Parquet"
    yield (
        "*Peak / arrays*: peak memory over the size of the columns read. The estimates are checked against the "
        "friction written."
    )
    yield (
        "A log is read in blocks, twice: the clock, then checks, sign and estimate. A mended fault, inertia of the "
        "model, `--thresholds auto` and an undecided sign add passes. Batched stamps, a slow bus and damaged row "
        "groups need all in memory."
    )
    yield table("bench_parquet", "--hours", hours, "--runs", runs)
    yield "## Start of the program"
    yield table("bench_start")
    yield "## Replay and estimate"
    yield "The log of the first rows above."
    yield table("bench_replay", "--hours", hours, "--runs", runs)
    yield "## Bags: reading joint states"
    yield table("bench_bags", "--messages", messages, "--repeat", runs)


def main() -> None:
    """Print the page, or write it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, default=1.0, help="length of the Parquet logs")
    parser.add_argument("--messages", type=int, default=1_000_000, help="messages in each bag")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--output", type=Path)
    arguments = parser.parse_args()
    text = "\n\n".join(page(arguments)) + "\n"
    print(text)
    if arguments.output:
        arguments.output.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
