"""Rows of ``run`` -> how often the only name is right where the log holds the motion that separates the names.

python -m benchmarks.hidden_effects.separable FILE.csv... [--output docs/diagnosis.md] [--separations FILE.csv]

Whether a log separates the hidden effect from competing ones is measured by ``separation``, on logs without noise.
What the file of separations holds is not computed again.
"""

import argparse
import os
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.answers import CLEAR, Row, exact, share, table
from benchmarks.hidden_effects.draw import draw_case
from benchmarks.hidden_effects.run import NOT_REACHED, SIZES, parsed, scaled
from benchmarks.hidden_effects.separation import separate
from benchmarks.hidden_effects.table import hidden_here
from benchmarks.marked_page import write_between
from benchmarks.resume import Job, read

EFFECTS = (
    "stribeck", "presliding", "load_dependent_friction", "torque_ripple", "gravity_error", "torque_drift", "time_delay",
    "warm_up", "friction_step", "joint_elasticity", "backlash", "nonlinear_viscous",
)  # fmt: skip
"""That are to be the only name wherever the log separates them."""
BEGIN, END = "<!-- separable -->", "<!-- end of separable -->"
FIELDS = ("truth", "seed", "separates", "close", "competing")
Key = tuple[str, str]


def judged(rows: Iterable[Row]) -> list[Row]:
    """Rows of one of the effects alone, strong enough, with an answer."""
    return [
        row
        for row in rows
        if row["truth"] in EFFECTS
        and row["verdict"] not in {"", "error"}
        and float(row["partial"]) >= CLEAR
        and hidden_here(row)
    ]


def separation_of(row: Row) -> list[dict[str, object]]:
    """One row of the table of separations, of a row of ``run`` or of ``strengths``."""
    truth, seed = row["truth"], int(row["seed"])
    found = separate(scaled(draw_case(seed, (truth,), SIZES[seed % len(SIZES)]), parsed(row["scales"]) or ()))
    competing = sorted(found.competing, key=lambda one: one.noncentrality)
    return [{
        "truth": truth, "seed": seed, "separates": found.separates, "close": "|".join(found.close),
        "competing": "|".join(f"{r.name}:{r.correlation:.3f}:{r.noncentrality:.1f}" for r in competing[:6]),
    }]  # fmt: skip


def job(rows: Iterable[Row]) -> Job:
    """Measure the logs of all rows whose strength is known, each once."""
    wanted = {(row["truth"], row["seed"]): dict(row) for row in rows if row["scales"] != NOT_REACHED}
    return Job(FIELDS, list(wanted.values()), separation_of)


def separations(rows: Iterable[Row], path: Path, workers: int | None = None) -> dict[Key, Row]:
    """Those of all rows; what the file holds is not computed again."""
    return {(row["truth"], row["seed"]): row for row in job(rows).run(path, workers)}


def by_effect(rows: Sequence[Row], known: Mapping[Key, Row]) -> str:
    """One line per effect, and one for all."""
    head = (
        "hidden",
        "logs",
        "the log separates [%]",
        "the only name there [%]",
        "the only name elsewhere [%]",
        "cannot be separated from",
    )
    parts = [(name, [row for row in rows if row["truth"] == name]) for name in EFFECTS]
    return table(head, [_line(name, own, known) for name, own in (*parts, ("all", rows)) if own])


def _line(label: str, rows: Sequence[Row], known: Mapping[Key, Row]) -> tuple[str, ...]:
    found = [known[row["truth"], row["seed"]] for row in rows]
    apart = [one["separates"] == "True" for one in found]
    there = [exact(row) for row, separates in zip(rows, apart, strict=True) if separates]
    elsewhere = [exact(row) for row, separates in zip(rows, apart, strict=True) if not separates]
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
    rows = judged(row for path in asked.files for row in read(path))
    text = by_effect(rows, separations(rows, asked.separations, asked.workers))
    if asked.output is None:
        print(text)
        return
    write_between(asked.output, BEGIN, END, text)


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    np.seterr(all="ignore")
    main()
