"""Write logs of hidden effects, read and diagnose them, one row per joint.

python -m benchmarks.stranger.run --output FILE.csv [--effects all] [--first 0] [--seeds 4] [--joints 1|7]

``--effects`` takes names, ``one+two``, ``none``, ``pairs`` (drawn by seed), ``all`` (each alone, those outside the
catalogue too). A file that is there is gone on with.
"""

import argparse
import itertools
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.answers import ANSWER, answer_of
from benchmarks.resume import Job, Row
from benchmarks.stranger.draw import SIZES, Case, draw_case
from benchmarks.stranger.effects import HIDDEN, OUTSIDE, RECORDED
from benchmarks.stranger.logs import write_log
from friction_audit.api import read_log
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.joint_model import load_model
from friction_audit.errors import FrictionAuditError
from friction_audit.pipeline import AuditSettings, diagnose_log

FIELDS = (
    "truth", "seed", "joint", "hides", "hidden_here", "motion", "hand", "rate_hz", "clock", "bits", "partial",
    "strengths", *ANSWER,
)  # fmt: skip


def run_one(task: Row) -> list[dict[str, object]]:
    """One log, and what is said of each joint; a row without a verdict where the size cannot be reached.

    One joint alone is one of the shoulder or of the wrist; in an arm the effects are hidden in one of seven.
    """
    truth, seed, joints = task["truth"], int(task["seed"]), int(task["joints"])
    names = () if truth == "none" else tuple(truth.split("+"))
    size = SIZES[seed % len(SIZES)]
    numbers = range(1, joints + 1) if joints > 1 else [7 if seed % 3 == 0 else 1]
    felt = numbers[seed % len(numbers)]
    cases = [draw_case(seed, names if j == felt or set(names) <= set(RECORDED) else (), size, joint=j) for j in numbers]
    drawn = [case for case in cases if case is not None]
    if len(drawn) < len(cases):
        return [{"truth": truth, "seed": seed, "verdict": "", "partial": size}]
    drawn_rows = [_row(case, truth) for case in drawn]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"
        file = write_log(drawn, path)
        settings = DiagnosisSettings(model=None if file is None else load_model(file))
        try:
            found = diagnose_log(read_log(path), AuditSettings(), settings).discrepancy.joints
        except FrictionAuditError as error:
            return [row | {"verdict": "error", "reason": str(error)} for row in drawn_rows]
    return [row | answer_of(one) for row, one in zip(drawn_rows, found, strict=True)]


def _row(case: Case, truth: str) -> dict[str, object]:
    sensors = case.setup.sensors
    return {
        "truth": truth, "seed": case.seed, "joint": case.joint, "hides": "+".join(case.names), "motion": case.motion,
        "hidden_here": bool(set(case.names) - set(RECORDED)), "hand": case.hand, "rate_hz": sensors.rate_hz,
        "clock": sensors.clock, "bits": sensors.encoder_bits, "partial": case.size,
        "strengths": "+".join(f"{s:.4g}" for s in case.strengths),
    }  # fmt: skip


def job(effects: str, seeds: Sequence[int], joints: int = 1) -> Job:
    """Diagnose logs of some seeds."""
    wanted = [{"truth": t, "seed": str(seed), "joints": str(joints)} for seed in seeds for t in truths(effects, seed)]
    return Job(FIELDS, wanted, run_one)


def truths(asked: str, seed: int) -> list[str]:
    """What is hidden in the logs of a seed."""
    if asked == "all":
        return [*HIDDEN, *OUTSIDE, *RECORDED]
    if asked == "pairs":
        pairs = [*itertools.combinations(HIDDEN, 2)]
        return ["+".join(pairs[np.random.default_rng([seed, 4]).integers(len(pairs))])]
    return asked.split(",")


def main() -> None:
    """Run what the file does not hold."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--effects", default="all")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--joints", type=int, choices=(1, 7), default=1)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--output", type=Path, required=True)
    asked = parser.parse_args()
    seeds = range(asked.first, asked.first + asked.seeds)
    job(asked.effects, seeds, asked.joints).run(asked.output, asked.workers)


if __name__ == "__main__":
    np.seterr(all="ignore")
    main()
