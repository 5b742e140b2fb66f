"""How often `diff` is right on pairs of simulated logs: coverage, changes found, false alarms.

    python -m benchmarks.bench_diff [--pairs 400] [--seed 10000] [--output benchmarks/diff.md]

Each side of a pair is a recording of 60 s of the scenario `joint`, with a person and noise of its own; in every second
pair the joint has 10 % more Coulomb friction after than before.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.answers import share, table
from friction_audit import estimate_log, simulate_log
from friction_audit.batch.work import session_of
from friction_audit.drift.session import Session
from friction_audit.drift.two_sides import compare_sides
from friction_audit.simulation import JointParameters

JOINT = JointParameters()
CHANGE = 0.1
COEFFICIENTS = ("Coulomb", "viscous")


def record(seed: int, joint: JointParameters) -> Session:
    """Simulate and estimate one side."""
    log = simulate_log("joint", seed=seed, duration_s=60.0, joints=(joint,)).log
    return session_of(estimate_log(log))


def compare(first: int, pair: int) -> list[tuple[int, bool, float, float, float, float]]:
    """Return per coefficient: coefficient, whether it changed, true change, and found change, half width, p value."""
    changed = pair % 2 == 1
    after = replace(JOINT, coulomb_nm=(1.0 + CHANGE) * JOINT.coulomb_nm) if changed else JOINT
    before, later = record(first + 2 * pair, JOINT), record(first + 2 * pair + 1, after)
    (joint,) = compare_sides([before], [later]).joints
    true = (after.coulomb_nm - JOINT.coulomb_nm, 0.0)
    return [
        (k, changed, true[k], one.found.change.value, one.found.change.high - one.found.change.value, one.found.p_value)
        for k, one in enumerate(joint.coefficients)
    ]


def lines_of(rows: np.ndarray) -> list[tuple[str, str, str]]:
    """Return the figures: what, of how many pairs, share with its interval."""
    coefficient, changed, true, found, half, p_value = rows.T
    covered, alarm = np.abs(found - true) <= half, p_value <= 0.05
    kinds = {
        f"95 % interval of the {name} difference holds the truth": covered[coefficient == k]
        for k, name in enumerate(COEFFICIENTS)
    }
    kinds["change of Coulomb friction by 10 % found"] = alarm[(coefficient == 0) & (changed == 1)]
    pairs = alarm[changed == 0].reshape(-1, len(COEFFICIENTS)).any(axis=1)
    kinds["false alarm in a pair without a change, of either coefficient"] = pairs
    return [(what, str(len(hits)), share(hits, 1)) for what, hits in kinds.items()]


def main() -> None:
    """Run all pairs and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=400)
    parser.add_argument("--seed", type=int, default=10000)
    parser.add_argument("--output", type=Path)
    parser.add_argument("--rows", type=Path, help="also keep the numbers of each pair (CSV)")
    options = parser.parse_args()
    with ProcessPoolExecutor(2) as pool:
        found = pool.map(partial(compare, options.seed), range(options.pairs), chunksize=10)
        rows = np.array([row for pair in found for row in pair], float)
    text = table(("figure", "pairs", "% (95 % interval)"), lines_of(rows)) + "\n"
    print(text)
    if options.rows:
        np.savetxt(options.rows, rows, delimiter=",", header="coefficient,changed,true,found,half,p", comments="")
    if options.output:
        head = (
            "# `diff` on simulated pairs\n\nMade by `python -m benchmarks.bench_diff --output benchmarks/diff.md`.\n\n"
        )
        options.output.write_text(head + text)


if __name__ == "__main__":
    main()
