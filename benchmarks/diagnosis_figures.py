"""Every figure of the diagnosis by one command: run what is missing, then write the summary beside its goals.

python -m benchmarks.diagnosis_figures [KIND ...] [--rows FOLDER] [--first SEED] [--real FOLDER] [--page FILE.md]

Kinds, all if none is given: strengths (the costly search), limits and separations (what the logs hold, without the
engine), none, effects, pairs, outside, arms, smoothed, stranger_none, stranger, real (with a folder of measured logs),
time (on an idle machine). Each is a table in the folder of rows, and is gone on with; ``--table`` runs none.
"""

import argparse
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks import bench_diagnose, smoothed_sign
from benchmarks.diagnosis_summary import EFFECT_KINDS, load, page
from benchmarks.hidden_effects import limits, run, separable, strengths
from benchmarks.hidden_effects.outside import OUTSIDE
from benchmarks.real_logs import run as real_logs
from benchmarks.resume import Row, read, resume
from benchmarks.stranger import run as stranger
from friction_audit.simulation.effects import EFFECTS

ROWS = Path(__file__).parent / "rows"
ON_ARMS = ("torque_crosstalk", "inertial_coupling")
NUMBERS = {"none": 200, "smoothed": 200, "stranger_none": 40, "stranger": 2, "effects": 10, "on_arms": 5, "pairs": 50,
           "outside": 12, "arms": 3}  # fmt: skip
"""Seeds of each kind, from the first on; of ``effects``, ``outside`` and ``stranger`` for every effect."""


class Figures:
    """Where rows are, and the seeds that they are of."""

    def __init__(self, rows: Path, first: int, real: Path | None, workers: int | None) -> None:
        """Take the folder of rows, the first seed, the folder of measured logs, and the number of processes."""
        self.rows, self.first, self.real, self.workers = rows, first, real, workers

    def path(self, kind: str) -> Path:
        """Table of a kind."""
        return self.rows / f"{kind}.csv"

    def wanted(self, kind: str) -> list[tuple[str, int]]:
        """Truth and seed of each log of ``hidden_effects``."""
        if kind != "effects":
            names = {"outside": ",".join(name for name, _ in OUTSIDE), "arms": "none"}.get(kind, kind)
            return run.tasks(names, self.first + (1000 if kind == "arms" else 0), NUMBERS[kind])
        alone = ",".join(effect.name for effect in EFFECTS if effect.name not in ON_ARMS)
        return [*run.tasks(alone, self.first, NUMBERS[kind]),
                *run.tasks(",".join(ON_ARMS), self.first, NUMBERS["on_arms"])]  # fmt: skip

    def searched(self) -> list[Row]:
        """Strengths of all effects."""
        tasks = [{"truth": t, "seed": str(s)} for kind in EFFECT_KINDS for t, s in self.wanted(kind)]
        return resume(self.path("strengths"), strengths.FIELDS, tasks, strengths.searched, self.workers)

    def hidden_effects(self, kind: str) -> None:
        """Logs of the simulator."""
        more = {"scenario": "panda"} if kind == "arms" else {}
        run.run(self.wanted(kind), self.path(kind), [self.path("strengths")], self.workers, **more)

    def strangers(self, kind: str) -> None:
        """Logs of the second generator."""
        seeds = range(self.first, self.first + NUMBERS[kind])
        stranger.run("none" if kind == "stranger_none" else "all", seeds, self.path(kind), 1, self.workers)

    def smoothed(self) -> None:
        """Clean joints whose sign is smoothed."""
        smoothed_sign.run(range(self.first, self.first + NUMBERS["smoothed"]), self.path("smoothed"), self.workers)

    def measured(self) -> None:
        """Measured logs, if there is a folder of them."""
        if self.real is not None:
            real_logs.run(self.real, self.path("real"), self.first, self.workers)

    def limits(self) -> None:
        """How much the logs hold of each effect."""
        rows = limits.judged(read(self.path("strengths")))
        resume(self.path("limits"), limits.FIELDS, rows, limits.limits_of, self.workers)

    def separations(self) -> None:
        """Which logs separate their effect."""
        rows = [r for r in read(self.path("strengths")) if r["truth"] in separable.EFFECTS and clear(r)]
        separable.separations(rows, self.path("separations"), self.workers)

    def time(self) -> None:
        """Time and memory beside ``estimate``."""
        lines = list(bench_diagnose.table([120, 600], 3))
        (self.rows / "time.md").write_text("\n".join(lines) + "\n")

    @property
    def kinds(self) -> dict[str, Callable[[], object]]:
        """What each kind runs."""
        simulated = {
            kind: lambda kind=kind: self.hidden_effects(kind)
            for kind in ("none", "effects", "pairs", "outside", "arms")
        }
        second = {kind: lambda kind=kind: self.strangers(kind) for kind in ("stranger_none", "stranger")}
        return {"strengths": self.searched, "limits": self.limits, "separations": self.separations, **simulated,
                "smoothed": self.smoothed, **second, "real": self.measured, "time": self.time}  # fmt: skip


def clear(row: Row) -> bool:
    """Whether the log of a row has to show its effect."""
    return run.SIZES[int(row["seed"]) % len(run.SIZES)] >= separable.CLEAR


def main() -> None:
    """Run what is asked for, then print or write the summary."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinds", nargs="*")
    parser.add_argument("--rows", type=Path, default=ROWS)
    parser.add_argument("--first", type=int, default=30000)
    parser.add_argument("--real", type=Path)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--table", action="store_true", help="run nothing")
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args()
    figures = Figures(asked.rows, asked.first, asked.real, asked.workers)
    for kind in () if asked.table else asked.kinds or figures.kinds:
        print(kind, flush=True)
        figures.kinds[kind]()
    text = page(load(asked.rows))
    if asked.page is None:
        print(text)
    else:
        asked.page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    np.seterr(all="ignore")
    main()
