"""Simulate, diagnose, and hold the answer against the truth, over many seeds.

python -m benchmarks.hidden_effects.run [--effects all] [--seeds 30] [--first 0] [--output FILE.csv]
"""

import argparse
import csv
import os
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.hidden_effects.draw import Case, draw_case, settings_of
from benchmarks.hidden_effects.outside import OUTSIDE, log_with
from benchmarks.hidden_effects.strength import scales_for
from friction_audit.audit import AuditSettings, diagnose_log
from friction_audit.discrepancy.candidates import CANDIDATES
from friction_audit.discrepancy.settings import DiagnosisSettings
from friction_audit.errors import FrictionAuditError
from friction_audit.joint_log import JointLog
from friction_audit.simulate.dispatch import simulate

SIZES = (0.2, 0.3, 0.5, 1.0, 3.0)
FIELDS = (
    "truth", "seed", "scenario", "noise", "form", "partial", "joint", "verdict", "named", "sets", "shrink",
    "over_floor", "before_nm", "after_nm", "floor_nm", "omnibus_p", "remaining_p", "message",
)  # fmt: skip


def run_case(seed: int, truth: str, scenario: str | None = None) -> list[dict[str, object]]:
    """One log: one row per joint that moves."""
    kinds = [kind for kind, _ in OUTSIDE]
    names = () if truth == "none" or truth in kinds else tuple(truth.split("+"))
    size = SIZES[seed % len(SIZES)]
    case = draw_case(seed, names, size, scenario)
    try:
        log = log_with(case, truth) if truth in kinds else _log_of(case)
        if log is None:
            return []
        found = diagnose_log(log, AuditSettings(), DiagnosisSettings(seed=seed)).discrepancy
    except FrictionAuditError as error:
        return [{"truth": truth, "seed": seed, "scenario": case.scenario, "verdict": "error", "message": str(error)}]
    return [_row(case, truth, joint) for joint in found.joints]


def _log_of(case: Case) -> JointLog | None:
    """The log of a case; None where the strength cannot be reached."""
    scales = scales_for(case)
    return None if scales is None else simulate(settings_of(case, scales), case.seed).log


def _row(case: Case, truth: str, joint: object) -> dict[str, object]:
    gap = joint.gap  # type: ignore[attr-defined]
    effects = joint.effects  # type: ignore[attr-defined]
    return {
        "truth": truth, "seed": case.seed, "scenario": case.scenario, "noise": case.noise,
        "form": "/".join(str(getattr(group, "form", "")) for group in case.groups),
        "partial": case.partial, "joint": joint.joint, "verdict": joint.verdict,  # type: ignore[attr-defined]
        "named": "+".join(e.name for e in effects),
        "sets": ";".join("|".join((e.name, *e.alternatives)) for e in effects),
        "shrink": gap and round(gap.shrink, 3), "over_floor": gap and round(gap.over_floor, 3),
        "before_nm": gap and round(gap.before, 4), "after_nm": gap and round(gap.after, 4),
        "floor_nm": gap and round(gap.floor, 4), "omnibus_p": joint.omnibus_p,  # type: ignore[attr-defined]
        "remaining_p": joint.remaining_p, "message": joint.message,  # type: ignore[attr-defined]
    }  # fmt: skip


def main() -> None:
    """Run all cases and write one row per joint."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--effects", default="all")
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--scenario")
    parser.add_argument("--output", type=Path, default=Path("hidden_effects.csv"))
    asked = parser.parse_args()
    names = [c.name for c in CANDIDATES] if asked.effects == "all" else asked.effects.split(",")
    with asked.output.open("w", newline="") as file, ProcessPoolExecutor() as pool:
        writer = csv.DictWriter(file, FIELDS)
        writer.writeheader()
        for name in names:
            cases = range(asked.first, asked.first + asked.seeds)
            rows = [
                row for rows in pool.map(partial(run_case, truth=name, scenario=asked.scenario), cases) for row in rows
            ]
            writer.writerows(rows)
            file.flush()
            print(summary(name, rows), flush=True)


def summary(truth: str, rows: list[dict[str, object]]) -> str:
    """One line: how often the set holds the truth, how often it is the only name, how often another name is given."""
    wanted = set() if truth == "none" else set(truth.split("+"))
    held = exact = wrong = found = 0
    for row in rows:
        sets = [set(one.split("|")) for one in str(row.get("sets") or "").split(";") if one]
        names = set().union(*sets)
        held += wanted <= names
        exact += [sorted(one) for one in sets] == [[name] for name in sorted(wanted)] and row["verdict"] == "named"
        wrong += any(not one & wanted for one in sets) and row["verdict"] in {"named", "ambiguous"}
        found += row["verdict"] != "none"
    return f"{truth:28s} n {len(rows):3d} found {found:3d} held {held:3d} exact {exact:3d} with a wrong name {wrong:3d}"


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    np.seterr(all="ignore")
    main()
