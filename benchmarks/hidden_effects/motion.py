"""Rows of ``run`` -> how much of what can be closed of the gap in motion is closed.

python -m benchmarks.hidden_effects.motion ROWS.csv... [--output MOTION.csv] [--page docs/diagnosis.md]

A model that is simulated under the measured torque strays from the motion whatever it knows, for that torque is noisy.
How far the declared one strays where nothing is hidden, in the same joint with the same noise, is the least that can be
left. What the output holds is not run again.
"""

import argparse
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from benchmarks.answers import Row, sets_of, share, table
from benchmarks.hidden_effects.draw import model_of, settings_of
from benchmarks.hidden_effects.run import case_of, scaled
from benchmarks.marked_page import write_between
from benchmarks.resume import Job, read
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.joint_log import Float
from friction_audit.pipeline import AuditSettings, diagnose_log
from friction_audit.simulation.scenarios import simulate

PLAIN = 1.5
"""Times what is left without an effect: from there on the gap in motion is the effect's."""
MOST = 80.0
"""Share of the gap that is most of it. [%]"""
ANY = "stribeck"
"""A diagnosis looks for something; what it says is not asked for."""
STRENGTHS = ("0.3", "0.5", "1.0", "3.0")
BEGIN, END = "<!-- motion -->", "<!-- end of motion -->"
FIELDS = ("truth", "seed", "partial", "before", "after", "least")


def judged(rows: Iterable[Row]) -> list[Row]:
    """Rows of one effect in one joint, strong enough, that was named and simulated."""
    return [
        row
        for row in rows
        if row["motion_before"]
        and row["partial"] in STRENGTHS
        and row["scenario"].startswith("joint")
        and any(row["truth"] in one for one in sets_of(row))
    ]


def motion_of(row: Row) -> list[dict[str, object]]:
    """Before, after, and with nothing hidden. [rad/s]"""
    case = scaled(case_of(int(row["seed"]), row["truth"]), map(float, row["scales"].split("/")))
    log = simulate(settings_of(case, (0.0,) * len(case.effects)), case.seed).log
    settings = DiagnosisSettings(seed=case.seed, model=model_of(case), candidates=(ANY,))
    simulated = diagnose_log(log, AuditSettings(), settings).discrepancy.joints[0].simulation
    return [{
        "truth": row["truth"], "seed": row["seed"], "partial": row["partial"],
        "before": row["motion_before"], "after": row["motion_after"],
        "least": "" if simulated is None else round(simulated.before, 6),
    }]  # fmt: skip


def _line(strength: str, rows: Sequence[Row]) -> tuple[str, ...]:
    own = [row for row in rows if row["partial"] == strength and row["least"]]
    before, after, least = (np.array([float(row[name]) for row in own]) for name in ("before", "after", "least"))
    plain = before > PLAIN * least
    closed = 100.0 * (before - after)[plain] / (before - least)[plain]
    return (
        strength.removesuffix(".0"),
        str(len(own)),
        _median(after / least, "{:.2f}"),
        str(len(closed)),
        _median(closed, "{:.0f}"),
        share(closed >= MOST),
    )


def _median(values: Float, form: str) -> str:
    return form.format(float(np.median(values))) if len(values) else "-"


def summary(rows: Sequence[Row]) -> str:
    """One line per strength."""
    head = (
        "strength",
        "logs",
        "after, over the least that can be left, median",
        "logs where it was 1.5 of that before",
        "closed there, median [%]",
        "of these closed by 80 % or more [%]",
    )
    return table(head, [_line(strength, rows) for strength in STRENGTHS])


def main() -> None:
    """Simulate what the output does not hold, and print the table, or put it between the marks of a page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", type=Path, nargs="+")
    parser.add_argument("--output", type=Path, default=Path("hidden_effects_motion.csv"))
    parser.add_argument("--page", type=Path)
    parser.add_argument("--workers", type=int)
    asked = parser.parse_args()
    rows = judged(row for path in asked.files for row in read(path))
    text = summary(Job(FIELDS, rows, motion_of).run(asked.output, asked.workers))
    if asked.page is None:
        print(text)
        return
    write_between(asked.page, BEGIN, END, text)


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    np.seterr(all="ignore")
    main()
