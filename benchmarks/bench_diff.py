"""How often `diff` is right on pairs of simulated logs: coverage, changes found, false alarms.

    python benchmarks/bench_diff.py [--pairs 400] [--seed 10000] [--output benchmarks/diff.md]

Each side of a pair is a recording of 60 s of the scenario `joint`, with a person and noise of its own; in every second
pair the joint has 10 % more Coulomb friction after than before.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from statsmodels.stats.proportion import proportion_confint

from friction_audit import estimate_log, simulate_log
from friction_audit.batch.work import recording_of
from friction_audit.drift.covariates import Recording
from friction_audit.drift.two_sides import compare_sides
from friction_audit.simulation import JointParameters

JOINT = JointParameters()
CHANGE = 0.1
COEFFICIENTS = ("Coulomb", "viscous")


def record(seed: int, joint: JointParameters) -> Recording:
    """Simulate and estimate one side."""
    log = simulate_log("joint", seed=seed, duration_s=60.0, joints=(joint,)).log
    return recording_of(estimate_log(log))


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


def share(hits: np.ndarray) -> str:
    """Return a share in per cent with its exact binomial interval (Clopper-Pearson)."""
    low, high = proportion_confint(int(hits.sum()), len(hits), method="beta")
    return f"{100 * hits.mean():.1f} ({100 * low:.1f} to {100 * high:.1f})"


def table(rows: np.ndarray) -> list[str]:
    """Return the figures as a Markdown table."""
    lines = ["| figure | pairs | % (95 % interval) |", "| --- | --- | --- |"]
    coefficient, changed, true, found, half, p_value = rows.T
    covered, alarm = np.abs(found - true) <= half, p_value <= 0.05
    for k, name in enumerate(COEFFICIENTS):
        own = coefficient == k
        lines.append(
            f"| 95 % interval of the {name} difference holds the truth | {own.sum()} | {share(covered[own])} |"
        )
    more = (coefficient == 0) & (changed == 1)
    lines.append(f"| change of Coulomb friction by 10 % found | {more.sum()} | {share(alarm[more])} |")
    quiet = changed == 0
    pairs = alarm[quiet].reshape(-1, len(COEFFICIENTS)).any(axis=1)
    lines.append(f"| false alarm in a pair without a change, of either coefficient | {len(pairs)} | {share(pairs)} |")
    return lines


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
    text = "\n".join(table(rows)) + "\n"
    print(text)
    if options.rows:
        np.savetxt(options.rows, rows, delimiter=",", header="coefficient,changed,true,found,half,p", comments="")
    if options.output:
        head = (
            "# `diff` on simulated pairs\n\nMade by `python benchmarks/bench_diff.py --output benchmarks/diff.md`.\n\n"
        )
        options.output.write_text(head + text)


if __name__ == "__main__":
    main()
