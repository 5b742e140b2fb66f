"""Files made to do harm: bombs, claims, deep nesting, absurd numbers, hostile names. Each must be answered or refused.

    python -m benchmarks.damaged_files.hostile [--only WORD] [--table table.md]

A case passes if the command ends by itself with an exit code that the case allows, within 10 s of processor time and 1
GB of memory, and prints no control characters. Memory is limited to 8 GB.
"""

import argparse
import tempfile
from pathlib import Path

from benchmarks.damaged_files import hostile_bags, hostile_tables, hostile_words
from benchmarks.damaged_files.case import Case, good
from benchmarks.damaged_files.run import SLOW_S
from benchmarks.damaged_files.watched import GIGABYTE, Outcome, preload, run


def fault(case: Case, outcome: Outcome) -> str:
    """Name what is wrong with an outcome, empty if nothing is."""
    if outcome.failed:
        return "crash" if outcome.crashed else "traceback"
    if outcome.code < 0 or outcome.cpu_s > SLOW_S:
        return "slow"
    if outcome.peak_bytes > GIGABYTE:
        return "large"
    if outcome.code not in case.allowed:
        return f"exit {outcome.code}"
    control = any(
        (ord(c) < 32 and c not in "\n\t") or 0x7F <= ord(c) < 0xA0 or c in "\u202e\u2066" for c in outcome.errors
    )
    return "control characters" if control else ""


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="")
    parser.add_argument("--table", type=Path)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        preload(good(Path(folder)))
    lines = ["| case | exit | CPU [s] | memory [MB] | fault |", "|---" * 5 + "|"]
    faults = tried = 0
    cases = [*hostile_tables.cases(), *hostile_bags.cases(), *hostile_words.cases()]
    for case in cases:
        if chosen.only not in case.name:
            continue
        with tempfile.TemporaryDirectory() as folder:
            outcome = run(case.make(Path(folder)), memory=8 * GIGABYTE, seconds=60)
        wrong = fault(case, outcome)
        tried, faults = tried + 1, faults + bool(wrong)
        lines.append(
            f"| {case.name} | {outcome.code} | {outcome.cpu_s:.1f} | {outcome.peak_bytes / 1e6:.0f} | {wrong} |"
        )
        print(lines[-1], " ".join(outcome.errors.split())[-160:] if wrong else "", flush=True)
    lines.append(f"\n{tried} cases, {faults} with a fault.")
    print(lines[-1])
    if chosen.table:
        chosen.table.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
