"""Write logs of hidden effects, diagnose them from the command line, one row per joint.

python -m benchmarks.stranger.run --logs DIR --output FILE.csv [--effects all] [--first 0] [--seeds 4] [--joints 1|7]

``--effects`` takes names, ``one+two``, ``none``, ``pairs`` (drawn by seed), ``all`` (each alone, those outside the
catalogue too). A file that is there is gone on with.
"""

import argparse
import csv
import io
import itertools
import json
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.stranger.draw import SIZES, Case, draw_case
from benchmarks.stranger.effects import HIDDEN, OUTSIDE, RECORDED
from benchmarks.stranger.logs import write_log
from friction_audit.cli import main as command_line

FIELDS = (
    "truth", "seed", "joint", "hides", "motion", "hand", "rate_hz", "clock", "bits", "size", "strengths", "code",
    "verdict", "sets", "faults", "before_nm", "after_nm", "floor_nm", "message",
)  # fmt: skip


def diagnosed(argv: list[str]) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of the command."""
    out, err = io.StringIO(), io.StringIO()
    code = 0
    with redirect_stdout(out), redirect_stderr(err):
        try:
            command_line(argv)
        except SystemExit as stop:
            code = int(stop.code or 0)
    return code, out.getvalue(), err.getvalue()


def run_one(truth: str, seed: int, folder: Path, joints: int) -> list[dict[str, object]]:
    """One log, and what is said of each joint; a row without a verdict where the size cannot be reached.

    One joint alone is one of the shoulder or of the wrist; in an arm the effects are hidden in one of seven.
    """
    names = () if truth == "none" else tuple(truth.split("+"))
    size = SIZES[seed % len(SIZES)]
    numbers = range(1, joints + 1) if joints > 1 else [7 if seed % 3 == 0 else 1]
    felt = numbers[seed % len(numbers)]
    cases = [draw_case(seed, names if j == felt or set(names) <= set(RECORDED) else (), size, joint=j) for j in numbers]
    drawn = [case for case in cases if case is not None]
    if len(drawn) < len(cases):
        return [{"truth": truth, "seed": seed, "verdict": "", "size": size}]
    path = folder / f"{truth}_{seed}{'_arm' if joints > 1 else ''}.csv"
    model = write_log(drawn, path)
    declared = ["--joint-model", str(model)] if model else []
    code, out, err = diagnosed(["diagnose", str(path), "--json", "-q", *declared])
    found = json.loads(out)["joints"] if code == 0 else [{}] * joints
    return [{**_told(case, truth), **(_answer(one) if one else {"message": err.strip()}), "code": code}
            for case, one in zip(drawn, found, strict=True)]  # fmt: skip


def _told(case: Case, truth: str) -> dict[str, object]:
    sensors = case.setup.sensors
    return {
        "truth": truth, "seed": case.seed, "joint": case.joint, "hides": "+".join(case.names), "motion": case.motion,
        "hand": case.hand, "rate_hz": sensors.rate_hz, "clock": sensors.clock, "bits": sensors.encoder_bits,
        "size": case.size, "strengths": "+".join(f"{s:.4g}" for s in case.strengths), "verdict": "error",
    }  # fmt: skip


def _answer(joint: dict[str, Any]) -> dict[str, object]:
    gap = joint["gap"]
    return {
        "verdict": joint["verdict"],
        "sets": ";".join("|".join((e["name"], *e["alternatives"])) for e in joint["effects"]),
        "faults": ";".join(f["code"] for f in joint["findings"] if f["verdict"] == "fault"),
        **{f"{key}_nm": gap and round(gap[name], 4) for key, name in _GAPS},
        "message": joint["message"],
    }


_GAPS = (("before", "baseline_rms_nm"), ("after", "final_rms_nm"), ("floor", "noise_floor_rms_nm"))


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
    parser.add_argument("--logs", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    asked = parser.parse_args()
    started = asked.output.exists()
    done = {(row["truth"], int(row["seed"])) for row in csv.DictReader(asked.output.open())} if started else set()
    with asked.output.open("a", newline="") as file:
        writer = csv.DictWriter(file, FIELDS)
        if not started:
            writer.writeheader()
        for seed in range(asked.first, asked.first + asked.seeds):
            for truth in truths(asked.effects, seed):
                if (truth, seed) not in done:
                    rows = run_one(truth, seed, asked.logs, asked.joints)
                    writer.writerows(rows)
                    file.flush()
                    for row in rows:
                        print(truth, *map(row.get, ("seed", "joint", "motion", "verdict", "sets")), flush=True)


if __name__ == "__main__":
    main()
