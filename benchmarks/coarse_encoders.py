"""Clean joints whose position or velocity is read in coarse steps: the clean logs of ``hidden_effects``, rounded.

By seed in turn: q in steps of 1 mrad; dq in steps of 50 mrad/s; q in steps of 1 mrad, and no velocity but its slope;
q in steps of 0.3 mrad likewise. Rows that failed before: coarse_118021 (named joint_elasticity), most of the last two
kinds (unexplained; now not_testable).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.answers import ANSWER, answer_of
from benchmarks.hidden_effects.run import case_of, log_of
from benchmarks.resume import Job, Row
from friction_audit.api import diagnose_log
from friction_audit.joint_log import DERIVATIVE, JointLog

FIELDS = ("truth", "seed", "scenario", "joint", *ANSWER)
KINDS = (("q", 1e-3), ("dq", 0.05), ("q alone", 1e-3), ("q alone", 3e-4))


def rounded(log: JointLog, kind: str, step: float) -> JointLog:
    """A log with one channel in steps; of ``q alone`` the velocity is the slope of what is left."""
    if kind == "dq":
        return replace(log, dq=step * np.round(log.dq / step))
    q = step * np.round(log.q / step)
    if kind == "q":
        return replace(log, q=q)
    source = replace(log.source, channels={**log.source.channels, "dq": DERIVATIVE})
    return replace(log, q=q, dq=np.gradient(q, log.t, axis=0), source=source)


def run_one(task: Row) -> list[dict[str, object]]:
    """The row of one joint."""
    seed = int(task["seed"])
    case, (kind, step) = case_of(seed, "none"), KINDS[seed % len(KINDS)]
    log = rounded(log_of(case), kind, step)
    (joint,) = diagnose_log(log).joints
    scenario = f"{case.scenario}, {kind} in steps of {step:g}"
    return [{"truth": "none", "seed": seed, "scenario": scenario, "joint": 1, **answer_of(joint)}]


def job(seeds: Sequence[int]) -> Job:
    """Diagnose joints of some seeds."""
    return Job(FIELDS, [{"truth": "none", "seed": str(seed)} for seed in seeds], run_one)
