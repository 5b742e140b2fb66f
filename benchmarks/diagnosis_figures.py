"""Every figure of the diagnosis by one command: run what is missing, then write the summary next to its goals.

python -m benchmarks.diagnosis_figures [KIND ...] [--rows FOLDER] [--first SEED] [--only TRUTH] [--real FOLDER]
    [--page FILE.md]

Kinds, all if none is given: strengths (the costly search), limits and separations (what the logs hold, without the
engine), none, effects, on_arms, pairs, outside, arms, coarse, smoothed, resampled, stranger_none, stranger, real (of a
folder of measured logs), time (on an idle machine). ``weighed`` and ``whole_arms`` only if asked for. Each is a table
in the folder of rows, and is gone on with; ``--table`` runs none.
"""

import argparse
import os
from pathlib import Path

import numpy as np

from benchmarks import bench_diagnose, coarse_encoders, resampled, smoothed_sign, weighed_joints, whole_arms
from benchmarks.answers import CLEAR, answered
from benchmarks.diagnosis_summary import EFFECT_KINDS, Tables, load, page, real, separated, simulated
from benchmarks.hidden_effects import limits, run, separable
from benchmarks.hidden_effects.outside import OUTSIDE
from benchmarks.hidden_effects.table import everything
from benchmarks.processes import write_between
from benchmarks.real_logs import run as real_logs
from benchmarks.resume import Job, Row, read
from benchmarks.stranger import run as stranger
from benchmarks.stranger.effects import HIDDEN, OUTSIDE as STRANGE, RECORDED
from friction_audit.simulation.effects import EFFECTS

ROWS = Path(__file__).parent / "rows"
SIMULATED = ("none", "effects", "on_arms", "pairs", "outside", "arms", "smoothed", "coarse", "stranger_none",
             "stranger", "resampled")  # fmt: skip
KINDS = ("strengths", "limits", "separations", *SIMULATED, "real", "time")
ON_ARMS = ("torque_crosstalk", "inertial_coupling")
NUMBERS = {"none": 200, "coarse": 50, "smoothed": 200, "stranger_none": 40, "stranger": 2, "effects": 10, "on_arms": 4,
           "pairs": 40, "outside": 10, "arms": 2, "weighed": 60, "whole_arms": 2}  # fmt: skip
"""Seeds of each kind, from the first on; of ``effects``, ``outside`` and ``stranger`` for every effect."""


class Figures:
    """What makes each table, for the seeds from a first one on."""

    def __init__(self, rows: Path, first: int, real: Path) -> None:
        """Take the folder of rows, the first seed and the folder of measured logs."""
        self.rows, self.first, self.real = rows, first, real

    def path(self, kind: str) -> Path:
        """Table of a kind."""
        return self.rows / f"{kind}.csv"

    def wanted(self, kind: str) -> list[tuple[str, int]]:
        """Truth and seed of each log of ``hidden_effects``."""
        names = {
            "outside": [name for name, _ in OUTSIDE],
            "arms": ["none"],
            "on_arms": ON_ARMS,
            "effects": [effect.name for effect in EFFECTS if effect.name not in ON_ARMS],
        }
        return run.tasks(names.get(kind, [kind]), self.first + (1000 if kind == "arms" else 0), NUMBERS[kind])

    def job(self, kind: str) -> Job:
        """What makes a table."""
        known, seeds = read(self.path("strengths")), range(self.first, self.first + NUMBERS.get(kind, 0))
        judged = (row for row in known if row["truth"] in separable.EFFECTS and clear(row))
        doubtful = (row for row in known if "+" in row["truth"] or not clear(row))
        others = {
            "strengths": lambda: run.strengths_job([task for each in EFFECT_KINDS for task in self.wanted(each)]),
            "limits": lambda: Job(limits.FIELDS, limits.judged(doubtful), limits.limits_of),
            "separations": lambda: separable.job(judged),
            "coarse": lambda: coarse_encoders.job(seeds),
            "smoothed": lambda: smoothed_sign.job(seeds),
            "weighed": lambda: weighed_joints.job(("none", *weighed_joints.HIDDEN), seeds),
            "whole_arms": lambda: whole_arms.job(seeds),
            "resampled": lambda: resampled.job(self.first),
            "stranger_none": lambda: stranger.job(("none",), seeds),
            "stranger": lambda: stranger.job((*HIDDEN, *STRANGE, *RECORDED), seeds),
            "real": lambda: real_logs.job(self.real, self.first),
        }
        if kind in others:
            return others[kind]()
        return run.job(self.wanted(kind), self.path("strengths"), "panda" if kind == "arms" else None)


def clear(row: Row) -> bool:
    """Whether the log of a row has to show its effect."""
    return run.SIZES[int(row["seed"]) % len(run.SIZES)] >= CLEAR


def main() -> None:
    """Run what is asked for, then print or write the summary."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinds", nargs="*", metavar="KIND")
    parser.add_argument("--rows", type=Path, default=ROWS)
    parser.add_argument("--first", type=int, default=30000)
    parser.add_argument("--only", default="", help="what is hidden, or a part of its name")
    parser.add_argument("--real", type=Path, default=Path("real_logs"), help="folder of measured logs")
    parser.add_argument("--workers", type=int)
    parser.add_argument("--table", action="store_true", help="run nothing")
    parser.add_argument("--page", type=Path)
    parser.add_argument("--docs", type=Path, help="folder of the documentation, whose marked tables are written")
    asked = parser.parse_args()
    figures = Figures(asked.rows, asked.first, asked.real)
    for kind in () if asked.table else asked.kinds or KINDS:
        print(kind, flush=True)
        if kind == "time":
            (asked.rows / "time.md").write_text("\n".join(bench_diagnose.table([120, 600], 3)) + "\n")
        elif kind != "real" or asked.real.is_dir():
            job = figures.job(kind)
            tasks = [task for task in job.tasks if asked.only in task["truth"]]
            job._replace(tasks=tasks).run(figures.path(kind), asked.workers)
    tables = load(asked.rows)
    if asked.docs is not None:
        write_documents(tables, asked.docs)
    if asked.page is not None:
        asked.page.write_text(page(tables), encoding="utf-8")
    else:
        print(page(tables))


def write_documents(tables: Tables, docs: Path) -> None:
    """Write the marked tables of the documentation."""
    rows = [row for kind in SIMULATED[:6] for row in answered(tables[kind])]
    texts = {
        ("diagnosis.md", "hidden effects"): simulated(tables),
        ("diagnosis.md", "real logs"): real(tables),
        ("../benchmarks/effects.md", "effect by effect"): everything(rows),
    }
    if tables["separations"]:
        texts["../benchmarks/effects.md", "separable"] = separated(tables)
    for (name, mark), text in texts.items():
        write_between(docs / name, f"<!-- {mark} -->", f"<!-- end of {mark} -->", text)
    if tables["time"]:
        write_between(docs / "speed.md", bench_diagnose.BEGIN, bench_diagnose.END, tables["time"][0]["text"])


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    np.seterr(all="ignore")
    main()
