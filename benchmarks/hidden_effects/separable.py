"""Rows of ``run`` -> how often the only name is right where the log holds the motion that separates the names.

python -m benchmarks.hidden_effects.separable FILE.csv... [--output docs/diagnosis.md] [--separations FILE.csv]

Whether a log separates the hidden effect from its rivals is told by ``separation``, from logs without noise. What the
file of separations holds is not worked out again.
"""

import argparse
import csv
import os
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from benchmarks.hidden_effects.draw import draw_case
from benchmarks.hidden_effects.run import SIZES
from benchmarks.hidden_effects.separation import separate
from benchmarks.hidden_effects.table import CLEAR, Row, exact, hidden_here, share, table
from benchmarks.marked_page import write_between

EFFECTS = (
    "stribeck", "presliding", "load_dependent_friction", "torque_ripple", "gravity_error", "torque_drift", "time_delay",
    "warm_up", "friction_step", "joint_elasticity", "backlash", "nonlinear_viscous",
)  # fmt: skip
"""That are to be the only name wherever the log separates them."""
BEGIN, END = "<!-- separable -->", "<!-- end of separable -->"
FIELDS = ("truth", "seed", "separates", "close", "rivals", "needed")
Key = tuple[str, int]


def judged(rows: Sequence[Row]) -> list[Row]:
    """Rows of one of the effects alone, strong enough, with an answer."""
    return [
        row
        for row in rows
        if row["truth"] in EFFECTS
        and row["verdict"] not in {"", "error"}
        and float(row["partial"]) >= CLEAR
        and hidden_here(row)
    ]


def separation_of(row: Row) -> Row:
    """One row of the file of separations, of one row of ``run``.

    Raises:
        ValueError: If the log was not drawn by its seed alone, or its strength cannot be reached.
    """
    truth, seed = row["truth"], int(row["seed"])
    case = draw_case(seed, (truth,), SIZES[seed % len(SIZES)])
    if case.scenario != row["scenario"]:
        message = (
            f"{truth}, seed {seed}: {row['scenario']} where the seed draws {case.scenario}; run without --scenario"
        )
        raise ValueError(message)
    # Rows of earlier runs do not hold the scales.
    found = separate(case, tuple(map(float, filter(None, (row.get("scales") or "").split("/")))))
    if found is None:
        raise ValueError(f"{truth}, seed {seed}: an answer to a log whose strength cannot be reached; run it again")
    rivals = sorted(found.rivals, key=lambda rival: rival.noncentrality)
    return {
        "truth": truth,
        "seed": str(seed),
        "separates": str(found.separates),
        "close": "|".join(found.close),
        "rivals": "|".join(f"{r.name}:{r.correlation:.3f}:{r.noncentrality:.1f}" for r in rivals if r.alike),
        "needed": f"{found.needed:.1f}" if found.numbers else "",
    }


def _read(path: Path) -> list[Row]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def separations(rows: Sequence[Row], path: Path, workers: int | None) -> dict[Key, Row]:
    """Those of all rows; the file holds what is known, and gets what is new."""
    started = path.exists()
    known = {(row["truth"], int(row["seed"])): row for row in _read(path)} if started else {}
    wanted = {key: row for row in rows if (key := (row["truth"], int(row["seed"]))) not in known}
    with path.open("a", newline="") as file, ProcessPoolExecutor(workers) as pool:
        writer = csv.DictWriter(file, FIELDS)
        if not started:
            writer.writeheader()
        for key, found in zip(wanted, pool.map(separation_of, wanted.values()), strict=True):
            known[key] = found
            writer.writerow(found)
            file.flush()
    return known


def by_effect(rows: Sequence[Row], known: dict[Key, Row]) -> str:
    """One line per effect, and one for all."""
    head = (
        "hidden",
        "logs",
        "the log separates [%]",
        "the only name there [%]",
        "the only name elsewhere [%]",
        "not told from",
    )
    parts = [(name, [row for row in rows if row["truth"] == name]) for name in EFFECTS]
    return table(head, [_line(name, own, known) for name, own in (*parts, ("all", rows)) if own])


def _line(label: str, rows: Sequence[Row], known: dict[Key, Row]) -> tuple[str, ...]:
    found = [known[row["truth"], int(row["seed"])] for row in rows]
    apart = [one["separates"] == "True" for one in found]
    there = [exact(row) for row, told in zip(rows, apart, strict=True) if told]
    elsewhere = [exact(row) for row, told in zip(rows, apart, strict=True) if not told]
    names = Counter(name for one in found for name in one["close"].split("|") if name)
    close = ", ".join(f"{name} {times}" for name, times in names.most_common()) if label != "all" else ""
    return label, str(len(rows)), share(apart), share(there), share(elsewhere), close


def main() -> None:
    """Print the table, or put it between the marks of a page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--output", type=Path)
    parser.add_argument("--separations", type=Path, default=Path("separations.csv"))
    parser.add_argument("--workers", type=int)
    asked = parser.parse_args()
    rows = judged([row for path in asked.files for row in _read(path)])
    text = by_effect(rows, separations(rows, asked.separations, asked.workers))
    if asked.output is None:
        print(text)
        return
    write_between(asked.output, BEGIN, END, text)


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    np.seterr(all="ignore")
    main()
