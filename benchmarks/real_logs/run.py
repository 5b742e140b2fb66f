"""Diagnose measured logs: whole with three seeds, halves, and with effects added to the torque; one row per joint.

The logs are published ones and are not part of this project; one that is not in the folder is passed over.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.answers import ANSWER, answer_of
from benchmarks.real_logs.injections import DELAY, SIZES, injected
from benchmarks.resume import Job, Row
from friction_audit.api import audit_settings, read_log
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.errors import FrictionAuditError
from friction_audit.pipeline import diagnose_estimate, estimate_log

LOGS: dict[str, tuple[str, dict[str, Any], dict[str, Any]]] = {
    "panda": ("**/panda_excitation.parquet", {}, {"drive": "robot", "robot": "panda"}),
    "panda_no_inertia": ("**/panda_excitation.parquet", {}, {"drive": "robot", "robot": "panda", "inertia": "none"}),
    "nnfm_slow": (
        "**/case4_slow.csv",
        {"mapping": {"q": "q7", "dq": "dq7", "tau_interaction": "q7_tau_J_compensate"}, "time_scale": 0.5},
        {},
    ),
    "tx40": ("**/tx40_tidy.csv", {}, {"drive": "robot", "robot": "none"}),
    "ur10e_2": (
        "**/ur10e_joint_2.csv",
        {"mapping": {"t": "#1", "q": "#3", "dq": "#9", "tau_J": "#15"}},  # motor current, gravity inside
        {"drive": "robot", "robot": "none"},
    ),
    "ocp": ("**/OCP_T3_0.81s.csv", {}, {"drive": "robot", "robot": "panda"}),
}
"""File, how it is read, what is asked, by name."""
NO_INERTIA = "panda_no_inertia"
INJECTED = {"panda": (2, 4), "nnfm_slow": (1,), "tx40": (3, 4), "ur10e_2": (1,)}
EFFECTS = ("stribeck", "torque_bias", "torque_ripple", "position_dependent_friction", "torque_drift",
           "asymmetric_viscous", DELAY)  # fmt: skip
SEEDS = (0, 1, 2)
KEYS = ("log", "part", "seed")
FIELDS = (*KEYS, "truth", "size", "joint", "untestable", *ANSWER)


def tasks(injection_seed: int) -> Iterator[Row]:
    """Parts of each log: ``whole``, ``first`` and ``second`` half, ``joint effect size``."""
    for log in LOGS:
        plain = {"log": log, "truth": "", "size": "", "asked": ""}
        for seed in (0,) if log == NO_INERTIA else SEEDS:
            yield plain | {"part": "whole", "seed": str(seed)}
        if log == NO_INERTIA:
            continue
        for part in ("first", "second"):
            yield plain | {"part": part, "seed": "0"}
        for joint in INJECTED.get(log, ()):
            for effect in EFFECTS:
                for size in (1.0,) if effect == DELAY else SIZES:
                    yield {
                        "log": log, "part": f"{joint} {effect} {size}", "seed": "0", "truth": effect, "size": str(size),
                        "asked": str(joint), "draw": str(injection_seed),
                    }  # fmt: skip


def run_part(root: Path, task: Row) -> list[dict[str, object]]:
    """Rows of one part of a log; none where the log is not there."""
    pattern, reading, estimating = LOGS[task["log"]]
    path = next(iter(sorted(root.glob(pattern))), None)
    if path is None:
        return []
    row: dict[str, object] = {key: task[key] for key in (*KEYS, "truth", "size")}
    try:
        log, settings = read_log(path, **reading), audit_settings(estimating)  # type: ignore[arg-type]
        middle = log.duration_s / 2
        if task["part"] == "first":
            settings = replace(settings, t_start_s=0.0, t_stop_s=middle)
        elif task["part"] == "second":
            settings = replace(settings, t_start_s=middle, t_stop_s=log.duration_s)
        elif task["truth"]:
            joint = int(task["asked"])
            log = injected(log, joint, task["truth"], float(task["size"]), int(task["draw"]))
            settings = replace(settings, joints=(joint,))
        found = diagnose_estimate(estimate_log(log, settings), DiagnosisSettings(seed=int(task["seed"]))).joints
    except FrictionAuditError as error:
        return [row | {"verdict": "error", "reason": str(error)}]
    return [row | {"joint": one.joint, "untestable": ";".join(one.untestable)} | answer_of(one) for one in found]


def job(root: Path, injection_seed: int) -> Job:
    """Diagnose all parts of the logs in a folder; the seed draws the numbers of injected effects."""
    return Job(FIELDS, list(tasks(injection_seed)), partial(run_part, root), KEYS)
