"""Simulate, diagnose, and hold the answer against the truth: jobs of ``diagnosis_figures``, and of the strengths.

What is hidden is named as ``one``, ``one+two``, ``none``, ``pairs`` (drawn by seed) or by a kind of ``outside``.
"""

import json
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.answers import ANSWER, answer_of
from benchmarks.hidden_effects.draw import Case, draw_case, draw_pairs, model_of, settings_of
from benchmarks.hidden_effects.outside import OUTSIDE, log_with
from benchmarks.hidden_effects.recovery import compared
from benchmarks.hidden_effects.strength import scales_for
from benchmarks.resume import Job, Row, read
from friction_audit.api import diagnose_log
from friction_audit.diagnosis.result import JointDiagnosis, NamedEffect
from friction_audit.errors import FrictionAuditError
from friction_audit.joint_log import JointLog
from friction_audit.simulation.effects import EFFECTS
from friction_audit.simulation.scenarios import simulate

SIZES = (0.2, 0.3, 0.5, 1.0, 3.0)
FIELDS = (
    "truth", "seed", "scenario", "noise", "form", "partial", "joint", "hidden_here", *ANSWER, "motion_before",
    "motion_after", "numbers", "scales",
)  # fmt: skip
NOT_REACHED = "-"  # in the column of the scales
Scales = tuple[float, ...] | None


def run_case(task: Row) -> list[dict[str, object]]:
    """One log: one row per joint that moves; a row without a verdict where the strength cannot be reached.

    Args:
        task: ``truth`` and ``seed``; ``scenario`` and ``scales`` where they are known.
    """
    truth, seed = task["truth"], int(task["seed"])
    case, outside = case_of(seed, truth, task.get("scenario")), truth in dict(OUTSIDE)
    row: dict[str, object] = {"truth": truth, "seed": seed, "scenario": case.scenario, "partial": case.partial}
    try:
        scales = parsed(task["scales"]) if "scales" in task else () if outside else scales_for(case)
        if scales is None:
            return [row | {"verdict": "", "scales": NOT_REACHED}]
        case = case if outside else scaled(case, scales)
        log = log_with(case, truth) if outside else log_of(case)
        found = diagnose_log(log, seed=seed, model=model_of(case))
    except FrictionAuditError as error:
        return [row | {"verdict": "error", "reason": str(error)}]
    found_with = {"scales": "/".join(map(repr, scales))}
    return [row | _row(case, joint) | found_with for joint in found.joints]


def parsed(text: str) -> Scales:
    """Scales as the column holds them."""
    return None if text == NOT_REACHED else tuple(float(one) for one in text.split("/") if one)


def case_of(seed: int, truth: str, scenario: str | None = None) -> Case:
    """The case of a seed and a truth, strengths not yet scaled."""
    names = () if truth == "none" or truth in {kind for kind, _ in OUTSIDE} else tuple(truth.split("+"))
    return draw_case(seed, names, SIZES[seed % len(SIZES)], scenario)


def scaled(case: Case, scales: Iterable[float]) -> Case:
    """The case with the strength of its effects as it was found."""
    groups = []
    for name, group, scale in zip(case.effects, case.groups, scales, strict=True):
        strength = next(effect for effect in EFFECTS if effect.name == name).strength_name
        groups.append(replace(group, **{strength: getattr(group, strength) * scale}))
    return replace(case, groups=tuple(groups))


def log_of(case: Case) -> JointLog:
    """The log of a case whose strengths are scaled."""
    return simulate(settings_of(case, (1.0,) * len(case.effects)), case.seed).log


def _row(case: Case, joint: JointDiagnosis) -> dict[str, object]:
    motion = joint.simulation
    return {
        "noise": case.noise, "form": "/".join(str(getattr(group, "form", "")) for group in case.groups),
        "joint": joint.joint, "hidden_here": not case.effects or joint.joint in case.felt_in, **answer_of(joint),
        "motion_before": motion and round(motion.before, 6), "motion_after": motion and round(motion.after, 6),
        "numbers": json.dumps(_numbers(case, (*joint.effects, *joint.negligible))),
    }  # fmt: skip


def _numbers(case: Case, found: Iterable[NamedEffect]) -> list[dict[str, object]]:
    """Numbers of the hidden effects that were named, next to the truth."""
    hidden = dict(zip(case.effects, case.groups, strict=True))
    return [
        {"effect": e.name, "identifiable": row["parameter"] not in e.not_identifiable, **row}
        for e in found
        if e.name in hidden
        for row in compared(
            e.name, hidden[e.name], case, {k: (c.value, c.low, c.high) for k, c in e.parameters.items()}
        )
    ]


def tasks(names: Sequence[str], first: int, seeds: int) -> list[tuple[str, int]]:
    """Truth and seed of every log."""
    every = range(first, first + seeds)
    return [
        one for name in names for one in (draw_pairs(first, seeds) if name == "pairs" else [(name, s) for s in every])
    ]


def job(wanted: Sequence[tuple[str, int]], strengths: Path, scenario: str | None = None) -> Job:
    """Diagnose logs, of truth and seed each; strengths that no row of a table holds are searched."""
    known, tasks_ = {(row["truth"], row["seed"]): row["scales"] for row in read(strengths) if row.get("scales")}, []
    for truth, seed in wanted:
        task = {"truth": truth, "seed": str(seed)}
        task |= {"scales": known[truth, str(seed)]} if (truth, str(seed)) in known else {}
        tasks_.append(task | ({"scenario": scenario} if scenario else {}))
    return Job(FIELDS, tasks_, run_case)


def strengths_job(wanted: Sequence[tuple[str, int]]) -> Job:
    """Search strengths of logs, each by truth and seed."""
    return Job(("truth", "seed", "scales"), [{"truth": truth, "seed": str(seed)} for truth, seed in wanted], searched)


def searched(task: Row) -> list[Row]:
    """Scales of one log."""
    try:
        scales = scales_for(case_of(int(task["seed"]), task["truth"]))
    except FrictionAuditError:  # so strong that the joint does not move
        scales = None
    return [{**task, "scales": NOT_REACHED if scales is None else "/".join(map(repr, scales))}]
