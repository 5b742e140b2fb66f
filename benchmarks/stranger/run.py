"""Write logs of hidden effects, diagnose them from the command line, one row per joint.

python -m benchmarks.stranger.run --logs DIR --output FILE.csv [--effects all] [--first 0] [--seeds 4]

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

import numpy as np

from benchmarks.stranger.draw import SIZES, Case, draw_case
from benchmarks.stranger.effects import HIDDEN, OUTSIDE, RECORDED
from benchmarks.stranger.logs import write_log
from friction_audit.cli import main as command_line

FIELDS = (
    "truth", "seed", "motion", "hand", "rate_hz", "clock", "bits", "size", "strengths", "code",
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


def run_one(truth: str, seed: int, folder: Path) -> dict[str, object]:
    """One log, and what is said of it; a row without a verdict where the size cannot be reached."""
    names = () if truth == "none" else tuple(truth.split("+"))
    case = draw_case(seed, names, SIZES[seed % len(SIZES)], distal=seed % 3 == 0)
    if case is None:
        return {"truth": truth, "seed": seed, "verdict": "", "size": SIZES[seed % len(SIZES)]}
    path = folder / f"{truth}_{seed}.csv"
    model = write_log(case, path)
    declared = ["--model", str(model)] if model else []
    code, out, err = diagnosed(["diagnose", str(path), "--json", "-q", *declared])
    return {**_told(case, truth), "code": code, **(_answer(json.loads(out)) if code == 0 else {"message": err.strip()})}


def _told(case: Case, truth: str) -> dict[str, object]:
    sensors = case.setup.sensors
    return {
        "truth": truth, "seed": case.seed, "motion": case.motion, "hand": case.hand, "rate_hz": sensors.rate_hz,
        "clock": sensors.clock, "bits": sensors.encoder_bits, "size": case.size,
        "strengths": "+".join(f"{s:.4g}" for s in case.strengths), "verdict": "error",
    }  # fmt: skip


def _answer(document: dict[str, list[dict[str, list[dict[str, object]]]]]) -> dict[str, object]:
    joint = document["joints"][0]
    gap: dict[str, float] = dict(joint.get("gap") or {})  # type: ignore[arg-type]
    return {
        "verdict": joint["verdict"],
        "sets": ";".join("|".join((str(e["name"]), *map(str, e["alternatives"]))) for e in joint["effects"]),  # type: ignore[call-overload]
        "faults": ";".join(str(f["code"]) for f in joint["findings"] if f["verdict"] == "fault"),
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
                    row = run_one(truth, seed, asked.logs)
                    writer.writerow(row)
                    file.flush()
                    print(truth, seed, row.get("motion", ""), row["verdict"], row.get("sets", ""), flush=True)


if __name__ == "__main__":
    main()
