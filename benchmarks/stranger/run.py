"""Write logs of hidden effects as people write them, read and diagnose them, one row each: ``diagnosis_figures``."""

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.answers import ANSWER, answer_of
from benchmarks.resume import Job, Row
from benchmarks.stranger.draw import SIZES, Case, draw_case
from benchmarks.stranger.effects import RECORDED
from friction_audit.api import diagnose_log, read_log
from friction_audit.effects.joint_model import load_model
from friction_audit.errors import FrictionAuditError

FIELDS = (
    "truth", "seed", "joint", "hides", "hidden_here", "motion", "hand", "rate_hz", "clock", "bits", "partial",
    "strengths", *ANSWER,
)  # fmt: skip


def run_one(task: Row) -> list[dict[str, object]]:
    """The row of one log, of a joint of the shoulder or of the wrist; without a verdict where no strength will do."""
    truth, seed = task["truth"], int(task["seed"])
    names, size = () if truth == "none" else tuple(truth.split("+")), SIZES[seed % len(SIZES)]
    case = draw_case(seed, names, size, joint=7 if seed % 3 == 0 else 1)
    if case is None:
        return [{"truth": truth, "seed": seed, "verdict": "", "partial": size}]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"
        model = write_log(case, path)
        arm = None if model is None else load_model(model)
        try:
            (found,) = diagnose_log(read_log(path), model=arm).joints
        except FrictionAuditError as error:
            return [_row(case, truth) | {"verdict": "error", "reason": str(error)}]
    return [_row(case, truth) | answer_of(found)]


def _row(case: Case, truth: str) -> dict[str, object]:
    sensors = case.setup.sensors
    return {
        "truth": truth, "seed": case.seed, "joint": case.joint, "hides": "+".join(case.names), "motion": case.motion,
        "hidden_here": bool(set(case.names) - set(RECORDED)), "hand": case.hand, "rate_hz": sensors.rate_hz,
        "clock": sensors.clock, "bits": sensors.encoder_bits, "partial": case.size,
        "strengths": "+".join(f"{s:.4g}" for s in case.strengths),
    }  # fmt: skip


def job(truths: Sequence[str], seeds: Sequence[int]) -> Job:
    """Diagnose logs of some seeds, each with each truth."""
    return Job(FIELDS, [{"truth": truth, "seed": str(seed)} for seed in seeds for truth in truths], run_one)


def write_log(case: Case, path: Path) -> Path | None:
    """Write a CSV, and next to it the declared model where the case states an inertia, which is returned.

    The torque is the interaction torque itself, or tau_J with the known gravity in it: a hand pushes from beyond the
    sensor, tau_J = gravity - F_m; a robot that moves itself has tau_J = gravity + F_m.
    """
    made, joint, number = case.recording, case.setup.joint, case.joint
    columns = {"time": made.t, f"q_{number}": made.q, f"dq_{number}": made.dq}
    if joint.pendulum > 0.0 or case.seed % 2 == 1:
        sign = -1.0 if case.hand else 1.0
        columns |= {f"tau_J_{number}": case.load + sign * made.torque, f"gravity_{number}": case.load}
    else:
        columns |= {f"tau_interaction_{number}": made.torque}
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, fmt="%.7g", delimiter=",", header=",".join(columns), comments="")
    if case.setup.declared_inertia is None:
        return None
    model = path.with_suffix(".toml")
    model.write_text(f"""schema = "friction-audit/model/1"
version = "0.1.0"
[[joint]]
name = "joint{number}"
inertia_kg_m2 = {case.setup.declared_inertia}
[joint.terms.coulomb]
coulomb_nm = {joint.coulomb}
[joint.terms.viscous]
viscous_nms_per_rad = {joint.viscous}
""")
    return model
