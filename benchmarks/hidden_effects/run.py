"""Simulate, diagnose, and hold the answer against the truth, over many seeds.

python -m benchmarks.hidden_effects.run [--effects all] [--seeds 30] [--first 0] [--noise COLOUR] [--output FILE.csv]

``--effects`` takes names, ``one+two``, ``none``, ``pairs`` (drawn by seed) and the kinds of ``outside``. A file that is
there is gone on with: what it holds is not run again.
"""

import argparse
import csv
import json
import os
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.hidden_effects.draw import NOISES, Case, draw_case, model_of, settings_of
from benchmarks.hidden_effects.outside import OUTSIDE, log_with
from benchmarks.hidden_effects.pairs import draw_pairs
from benchmarks.hidden_effects.recovery import compared
from benchmarks.hidden_effects.strength import scales_for
from friction_audit.diagnosis.result import JointDiagnosis, NamedEffect
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.errors import FrictionAuditError
from friction_audit.joint_log import JointLog
from friction_audit.pipeline import AuditSettings, diagnose_log
from friction_audit.simulation.effects import EFFECTS
from friction_audit.simulation.scenarios import simulate

SIZES = (0.2, 0.3, 0.5, 1.0, 3.0)
FIELDS = (
    "truth", "seed", "scenario", "noise", "form", "partial", "joint", "hidden_here", "verdict", "named", "sets",
    "shrink", "over_floor", "before_nm", "after_nm", "floor_nm", "motion_before", "motion_after", "omnibus_p",
    "remaining_p", "numbers", "message", "scales",
)  # fmt: skip


def run_case(seed: int, truth: str, scenario: str | None = None) -> list[dict[str, object]]:
    """One log: one row per joint that moves; a row without a verdict where the strength cannot be reached."""
    case, kinds = case_of(seed, truth, scenario), [kind for kind, _ in OUTSIDE]
    try:
        scales = () if truth in kinds else scales_for(case)
        if scales is None:
            return [{"truth": truth, "seed": seed, "scenario": case.scenario, "verdict": ""}]
        if truth in kinds:
            log = log_with(case, truth)
        else:
            case = scaled(case, scales)
            log = _log_of(case)
        found = diagnose_log(log, AuditSettings(), DiagnosisSettings(seed=seed, model=model_of(case))).discrepancy
    except FrictionAuditError as error:
        return [{"truth": truth, "seed": seed, "scenario": case.scenario, "verdict": "error", "message": str(error)}]
    found_with = {"scales": "/".join(map(repr, scales))}
    return [_row(case, truth, joint) | found_with for joint in found.joints]


def case_of(seed: int, truth: str, scenario: str | None = None) -> Case:
    """The case of a seed and a truth, strengths not yet scaled."""
    names = () if truth == "none" or truth in {kind for kind, _ in OUTSIDE} else tuple(truth.split("+"))
    return draw_case(seed, names, SIZES[seed % len(SIZES)], scenario)


def scaled(case: Case, scales: Iterable[float]) -> Case:
    """The case with the strength of its effects as it was found."""
    groups = []
    for name, group, scale in zip(case.effects, case.groups, scales, strict=True):
        strength = next(effect for effect in EFFECTS if effect.name == name).strength_name()
        groups.append(replace(group, **{strength: getattr(group, strength) * scale}))
    return replace(case, groups=tuple(groups))


def _log_of(case: Case) -> JointLog:
    return simulate(settings_of(case, (1.0,) * len(case.effects)), case.seed).log


def _row(case: Case, truth: str, joint: JointDiagnosis) -> dict[str, object]:
    gap, motion = joint.gap, joint.simulation
    return {
        "truth": truth, "seed": case.seed, "scenario": case.scenario, "noise": case.noise,
        "form": "/".join(str(getattr(group, "form", "")) for group in case.groups),
        "partial": case.partial, "joint": joint.joint, "hidden_here": not case.effects or joint.joint in case.felt_in,
        "verdict": joint.verdict,
        "named": "+".join(e.name for e in joint.effects),
        "sets": ";".join("|".join((e.name, *e.alternatives)) for e in joint.effects),
        "shrink": gap and round(gap.shrink, 3), "over_floor": gap and round(gap.over_floor, 3),
        "before_nm": gap and round(gap.before, 4), "after_nm": gap and round(gap.after, 4),
        "floor_nm": gap and round(gap.floor, 4),
        "motion_before": motion and round(motion.before, 6), "motion_after": motion and round(motion.after, 6),
        "omnibus_p": joint.omnibus_p, "remaining_p": joint.remaining_p,
        "numbers": json.dumps(_numbers(case, joint.effects)), "message": joint.message,
    }  # fmt: skip


def _numbers(case: Case, found: Iterable[NamedEffect]) -> list[dict[str, object]]:
    """Numbers of the hidden effects that were named, beside the truth."""
    hidden = dict(zip(case.effects, case.groups, strict=True))
    return [
        {"effect": e.name, **row}
        for e in found
        if e.name in hidden
        for row in compared(
            e.name, hidden[e.name], case, {k: (c.value, c.low, c.high) for k, c in e.parameters.items()}
        )
    ]


def tasks(effects: str, first: int, seeds: int) -> list[tuple[str, int]]:
    """Truth and seed of every log."""
    names = [effect.name for effect in EFFECTS] if effects == "all" else effects.split(",")
    every = range(first, first + seeds)
    return [
        one for name in names for one in (draw_pairs(first, seeds) if name == "pairs" else [(name, s) for s in every])
    ]


def main() -> None:
    """Run all cases that the file does not hold, and write one row per joint as they are done."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--effects", default="all")
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--scenario")
    parser.add_argument("--noise", choices=NOISES)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--output", type=Path, default=Path("hidden_effects.csv"))
    asked = parser.parse_args()
    started = asked.output.exists()
    there = list(csv.DictReader(asked.output.open())) if started else []
    done = {(row["truth"], int(row["seed"])) for row in there}
    wanted = [one for one in tasks(asked.effects, asked.first, asked.seeds) if one not in done]
    wanted = [one for one in wanted if asked.noise in {None, case_of(one[1], one[0]).noise}]
    with asked.output.open("a", newline="") as file, ProcessPoolExecutor(asked.workers) as pool:
        writer = csv.DictWriter(file, FIELDS)
        if not started:
            writer.writeheader()
        pending = {pool.submit(run_case, seed, truth, asked.scenario): truth for truth, seed in wanted}
        found: dict[str, list[dict[str, object]]] = {}
        for future in as_completed(pending):
            writer.writerows(future.result())
            file.flush()
            found.setdefault(pending[future], []).extend(future.result())
    for name, rows in found.items():
        print(summary(name, rows), flush=True)


def summary(truth: str, rows: list[dict[str, object]]) -> str:
    """One line: how often the set holds the truth, how often it is the only name, how often another name is given."""
    wanted = set() if truth == "none" else set(truth.split("+"))
    held = exact = wrong = found = 0
    for row in (row for row in rows if row.get("hidden_here", True)):
        sets = [set(one.split("|")) for one in str(row.get("sets") or "").split(";") if one]
        names = set().union(*sets)
        held += wanted <= names
        exact += [sorted(one) for one in sets] == [[name] for name in sorted(wanted)] and row["verdict"] == "named"
        wrong += any(not one & wanted for one in sets) and row["verdict"] in {"named", "ambiguous"}
        found += row["verdict"] != "adequate"
    return f"{truth:28s} n {len(rows):3d} found {found:3d} held {held:3d} exact {exact:3d} with a wrong name {wrong:3d}"


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    np.seterr(all="ignore")
    main()
