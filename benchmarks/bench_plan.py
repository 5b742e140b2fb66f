"""How often the motion of `plan` leaves the right name, where the log before left several.

    python -m benchmarks.bench_plan ROWS.csv [--joints 60] [--seed 42000] [--page benchmarks/plan.md]

Joints of the simulator with one hidden effect each, numbers drawn by seed, 40 s long; those whose diagnosis is
ambiguous with the true name among others that a motion can separate are taken, in the order of the seeds.
Each is recorded again twice, for as long as the plan takes: along the planned motion, and along its own kind of motion.
ROWS.csv gets a row per joint and is resumed.
"""

import argparse
import os
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.answers import answer_of, share, table as markdown
from benchmarks.hidden_effects.draw import draw_case, settings_of
from benchmarks.resume import Job, Row, read
from friction_audit.diagnosis.diagnose import diagnose_subjects
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.registry import same_as
from friction_audit.joint_log import JointLog
from friction_audit.pipeline import AuditSettings, Diagnosis, diagnosis_subjects, estimate_log
from friction_audit.planning.design import limits_of
from friction_audit.planning.plan import plan_task
from friction_audit.planning.task import AUTO, SERVO, tasks_of
from friction_audit.reporting.diagnosis import DIAGNOSE
from friction_audit.simulation import Operator
from friction_audit.simulation.scenarios import simulate

EFFECTS = (
    *("stribeck", "stiction", "nonlinear_viscous", "asymmetric_coulomb", "asymmetric_viscous", "presliding"),
    *("frictional_lag", "load_dependent_friction", "position_dependent_friction", "torque_ripple", "gravity_error"),
    *("cable_spring", "torque_bias", "torque_drift", "time_delay", "joint_elasticity", "backlash", "warm_up"),
)
SCALES = (0.15, 0.3, 0.6)  # of the usual strength, half to twice of it: small effects are the ambiguous ones
LENGTH_S = 40.0
FIELDS = ("seed", "truth", "scenario", "scale", "before", "unknown", "planned", "repeated", "seconds", "cpu_s")


def draw(seed: int) -> tuple[str, float, Any]:
    """Draw the hidden effect, its scale and the settings of the recording."""
    rng = np.random.default_rng([seed, 20261124])
    name, scale = str(rng.choice(EFFECTS)), float(rng.choice(SCALES))
    case = replace(draw_case(seed, [name], 1.0), duration_s=LENGTH_S)
    return case.scenario, scale, replace(settings_of(case, [scale]), rate_hz=500.0)


def truth_of(settings: Any) -> str:  # noqa: ANN401 - of a bench
    """Name the hidden effect."""
    return str(settings.hidden[0].present()[0].name)


def diagnosed(log: JointLog, settings: AuditSettings) -> tuple[Any, Diagnosis]:
    """Return prepared joints and diagnosis of a log of one joint."""
    estimate = estimate_log(log, settings)
    subjects = diagnosis_subjects(estimate, DiagnosisSettings())
    found = diagnose_subjects(subjects, DiagnosisSettings())
    return subjects, Diagnosis(estimate=estimate, joints=found, settings=DiagnosisSettings())


def sets_of(found: Diagnosis) -> Any:  # noqa: ANN401 - a text, among columns of all kinds
    """Write the answer: names that may be each other by |, effects by ;."""
    return answer_of(found.joints[0])["sets"]


def open_names(truth: str, sets: str) -> bool:
    """Whether the true name stands with others that a motion can separate."""
    found = [set(one.split("|")) for one in sets.split(";")]
    return any(truth in one and one - same_as(truth) - {"contact_event"} for one in found)


def right(truth: str, sets: str, *, strict: bool = False) -> bool:
    """Whether the truth is the only name, up to names that no motion separates from it unless strict."""
    names = set(sets.replace(";", "|").split("|"))
    return truth in names and names <= ({truth} if strict else same_as(truth)) and ";" not in sets


def work(asked: Row) -> list[dict[str, Any]]:
    """Return the row of a seed; with an empty plan where the log is not ambiguous."""
    began, seed = time.process_time(), int(asked["seed"])
    scenario, scale, settings = draw(seed)
    truth = truth_of(settings)
    row: dict[str, Any] = dict.fromkeys(FIELDS, "") | {
        "seed": seed, "truth": truth, "scenario": scenario, "scale": scale
    }  # fmt: skip
    log = simulate(settings, seed).log
    subjects, found = diagnosed(log, AuditSettings())
    row["before"] = sets_of(found)
    if found.joints[0].verdict == "ambiguous" and open_names(truth, row["before"]):
        pairs = [(subjects[0], found.joints[0])]
        _, (task,) = tasks_of(DIAGNOSE.of(found), Path(log.source.path), [0.0], subjects=pairs)
        limits = limits_of(task.joint, 0.0, urdf=None, robot="panda")
        plan = plan_task(task, limits, check=False)
        row["unknown"] = "|".join(task.unknown)
        operator = Operator(motion=plan.motion, **({} if task.joint.hand else SERVO))
        again = replace(settings, duration_s=plan.duration_s)
        row["planned"] = sets_of(diagnosed(simulate(replace(again, operator=operator), seed + 10**6).log, AUTO)[1])
        row["repeated"] = sets_of(diagnosed(simulate(again, seed + 10**6).log, AUTO)[1])
        row["seconds"] = round(plan.duration_s, 1)
    row["cpu_s"] = round(time.process_time() - began, 1)
    return [row]


def table(rows: list[Row]) -> str:
    """Return the figures and every joint as Markdown tables."""
    lines = []
    for words, strict in (
        ("right name, alone or with one that no motion separates from it", False),
        ("right name alone", True),
    ):
        hits = [[right(r["truth"], r[key], strict=strict) for r in rows] for key in ("planned", "repeated")]
        lines.append((words, *(f"{sum(own)} of {len(own)}, {share(own)}" for own in hits)))
    keys = ("seed", "truth", "scenario", "before", "planned", "repeated")
    joints = [tuple(r[key].replace("|", " or ") or "none" for key in keys) for r in rows]
    head = ("figure", "planned motion, % (95 % interval)", "plain repetition, % (95 % interval)")
    return f"{markdown(head, lines)}\n\n{markdown(keys, joints)}\n"


def main() -> None:
    """Go through the seeds until there are enough ambiguous joints, then print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", type=Path)
    parser.add_argument("--joints", type=int, default=60)
    parser.add_argument("--seed", type=int, default=42000)
    parser.add_argument("--workers", type=int, default=min(2, os.cpu_count() or 1))
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args()
    rows = read(asked.rows)
    seed = max((int(row["seed"]) for row in rows), default=asked.seed - 1) + 1
    while sum(row["seconds"] != "" for row in rows) < asked.joints:
        more = [{"seed": str(one)} for one in range(seed, seed + 4 * asked.workers)]
        rows, seed = Job(FIELDS, more, work, ("seed",)).run(asked.rows, asked.workers), seed + len(more)
    rows.sort(key=lambda row: int(row["seed"]))
    chosen = [row for row in rows if row["seconds"] != ""][: asked.joints]
    text = table(chosen)
    print(text)
    if asked.page:
        head = (
            "# `plan` on ambiguous simulated joints\n\n"
            f"Made by `python -m benchmarks.bench_plan ROWS.csv --seed {asked.seed} --page benchmarks/plan.md`: the "
            f"first {len(chosen)} ambiguous of the joints {asked.seed} to {chosen[-1]['seed']}.\n\n"
        )
        asked.page.write_text(head + text)


if __name__ == "__main__":
    main()
