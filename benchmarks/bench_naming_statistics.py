"""How often the statistics of naming are wrong, and what they miss, on synthetic columns with noise of known memory.

    python -m benchmarks.bench_naming_statistics [--sets 400] [--output FILE]

Twelve candidates, twenty-five with their shapes, many of them alike, on top of inertia, Coulomb and viscous columns.
No robot and no log is simulated: this is about the tests alone. A name is given where the omnibus test rejects at 5 %
and the search adds something; the noise is worth as many samples as its memory leaves, and this number is given.
"In the set" counts the named effects and their alternatives.
"""

import argparse
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import product
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from scipy.stats import binomtest

from friction_audit.diagnosis.alternatives import name_effects
from friction_audit.diagnosis.cross_products import cross_products
from friction_audit.diagnosis.groups import Group
from friction_audit.diagnosis.omnibus import independent_clusters, neighbours_remember, omnibus_test
from friction_audit.diagnosis.search import search
from tests.diagnosis.synthetic_columns import synthetic_columns

ALPHA = 0.05
CYCLES = (12, 20, 30, 60)
MEMORIES = (0.0, 0.9, 0.98)
SIZES = (0.2, 0.3)
Outcome = tuple[bool, bool, bool, bool]


def one_set(seed: int, *, cycles: int, memory: float, n_eff_rho2: float) -> Outcome:
    """Omnibus rejects, a name is given, it is right or its set holds the right one, a single wrong name."""
    rng = np.random.default_rng([seed, cycles, round(100 * memory)])
    data = synthetic_columns(rng, cycles=cycles, memory=memory)
    truth = seed % len(data.groups)
    shape = int(rng.integers(len(data.groups[truth].shapes)))
    size = np.sqrt(n_eff_rho2 / data.n_eff)
    y = data.noise + size * data.partial(truth, shape)
    cluster = independent_clusters(data.cycle, len(y) / data.n_eff)
    remember = neighbours_remember(cluster, len(y) / data.n_eff)
    rejected = omnibus_test(y, data.base, data.groups, cluster, rng, draws=399, remember=remember).p_value <= ALPHA
    products = cross_products(y, data.base, data.groups)
    found = search(products, data.n_eff)
    namings = name_effects(products, found, data.n_eff, {})
    held = {name for naming in namings for name in (naming.name, *naming.alternatives)}
    right = data.groups[truth].name in held
    alone = len(held) == 1
    return rejected, rejected and bool(namings), rejected and right, rejected and alone and not right


def shares(sets: int, cycles: int, memory: float, n_eff_rho2: float) -> list[str]:
    """Share of data sets of each outcome with its 95 % interval (Wilson)."""
    run = partial(one_set, cycles=cycles, memory=memory, n_eff_rho2=n_eff_rho2)
    with ProcessPoolExecutor() as pool:
        outcomes = np.array(list(pool.map(run, range(sets), chunksize=10)))
    intervals = [binomtest(int(k), sets).proportion_ci(method="wilson") for k in outcomes.sum(axis=0)]
    means = outcomes.mean(axis=0)
    return [f"{m:.3f} ({i.low:.3f} to {i.high:.3f})" for m, i in zip(means, intervals, strict=True)]


def false_names(sets: int) -> list[str]:
    """Table of logs in which nothing is missing."""
    head = ["| cycles | memory | omnibus rejects at 5 % | a name is given |", "|---|---|---|---|"]
    rows = [(c, m, *shares(sets, c, m, 0.0)[:2]) for c, m in product(CYCLES, MEMORIES)]
    return [*head, *("| " + " | ".join(map(str, row)) + " |" for row in rows)]


def power(sets: int) -> list[str]:
    """Table of logs with one effect of a given partial size, worth 600 samples."""
    head = [
        "| partial size | cycles | memory | omnibus rejects | a name is given | right in the set | single wrong name |",
        "|---|---|---|---|---|---|---|",
    ]
    cases = product(SIZES, (20, 60), (0.0, 0.9))
    rows = [(size, c, m, *shares(sets, c, m, 600 * size**2)) for size, c, m in cases]
    return [*head, *("| " + " | ".join(map(str, row)) + " |" for row in rows)]


def speed() -> list[str]:
    """Seconds of one joint: 24 000 samples, 60 cycles, 30 candidates of 10 shapes."""
    rng = np.random.default_rng(0)
    base, y, cycle = rng.standard_normal((24000, 3)), rng.standard_normal(24000), np.repeat(np.arange(60), 400)
    groups = [
        Group(name=str(i), shapes=tuple(rng.standard_normal((24000, 1 + (i % 3 == 0))) for _ in range(10)))
        for i in range(30)
    ]
    y += 0.2 * groups[4].shapes[3][:, 0] + 0.2 * groups[7].shapes[1][:, 0]
    products = cross_products(y, base, groups)
    steps: dict[str, Callable[[], object]] = {
        "omnibus test, 999 draws": lambda: omnibus_test(y, base, groups, cycle, rng),
        "cross products": lambda: cross_products(y, base, groups),
        "search, two effects found": lambda: search(products, 2000.0),
    }
    lines = ["| step | wall s | CPU s |", "|---|---|---|"]
    for name, step in steps.items():
        wall, cpu = perf_counter(), process_time()
        step()
        lines.append(f"| {name} | {perf_counter() - wall:.2f} | {process_time() - cpu:.2f} |")
    return lines


def main() -> None:
    """Writes the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sets", type=int, default=400)
    parser.add_argument("--output", type=Path)
    args = parser.parse_args()
    tables = ["\n".join(table) for table in (speed(), false_names(args.sets), power(args.sets))]
    text = f"{args.sets} data sets per line; 95 % intervals.\n\n" + "\n\n".join(tables) + "\n"
    print(text)
    if args.output is not None:
        args.output.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
