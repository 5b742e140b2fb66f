"""Where simulation and measurement disagree, joint by joint."""

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from friction_audit.diagnosis.data_audit import audit_joints
from friction_audit.diagnosis.diagnose_joint import Subject, diagnose_joint
from friction_audit.diagnosis.known_load import known_inertias
from friction_audit.diagnosis.prepare import prepare, spread_parts
from friction_audit.diagnosis.result import Discrepancy, JointDiagnosis
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.registry import effects
from friction_audit.errors import AnalysisError, FrictionAuditError, bug_sentence, traced
from friction_audit.friction.history import FrictionHistory
from friction_audit.joint_log import JointLog
from friction_audit.parallel import WORKERS, in_processes, one_joint_at_a_time, per_joint, workers_for
from friction_audit.preprocessing.energy_cycles import KEPT, EnergyCycles
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.robot import Arm

WORKING_BYTES = 1000  # of a process per sample of the fine grid (benchmarks/bench_diagnose.py)

PREPARED = 2.0  # times as long as what is diagnosed is a window in which that is spread
WINDOWS = 10  # that are tried per window's length
SMALL = 1e-6  # of the information in the whole log: of a joint without any in a window


def best_window(cycles: EnergyCycles, duration_s: float, length_s: float) -> tuple[float, float]:
    """Return the window in which the cycles determine both coefficients of all joints best: D-optimality. [s]"""
    rows = np.column_stack([cycles.sums.path_rad, cycles.sums.square_speed_rad2_s])
    kept = [
        (cycles.joint == joint) & (cycles.reason == KEPT) for joint in np.unique(cycles.joint[cycles.reason == KEPT])
    ]

    def information(start: float) -> float:
        inside = (cycles.start_s >= start) & (cycles.stop_s <= start + length_s)
        grams = [(rows[own].T @ rows[own], rows[own & inside].T @ rows[own & inside]) for own in kept]
        return float(sum(np.linalg.slogdet(part + SMALL * whole)[1] for whole, part in grams))

    starts = np.linspace(0.0, duration_s - length_s, int(WINDOWS * duration_s / length_s))
    start = max(starts.tolist(), key=information)
    return start, start + length_s


def subjects_of(
    log: JointLog,
    interaction: Interaction,
    cycles: EnergyCycles,
    friction: FrictionHistory,
    settings: DiagnosisSettings,
    arm: Arm | None = None,
) -> tuple[Subject, ...]:
    """Prepare every joint of a log in the window of its interaction; of its samples nothing is needed afterwards."""
    inertias, subjects = known_inertias(arm, interaction.choice, log.q), []
    prepared = [*prepare(interaction, cycles, log, arm)]
    joined: dict[str, Any] = {}
    for findings in audit_joints(log, interaction, prepared):
        data = spread_parts(prepared.pop(0), settings.at_most_s, joined)  # of a long log, the rest is freed at once
        number, found = interaction.joint_numbers[data.joint], friction.joints[data.joint]
        subjects.append(
            Subject(
                data=replace(data, logged_dq=None),  # the audit alone has looked at it
                number=number,
                name=interaction.joint_names[data.joint],
                findings=findings,
                from_energy={"coulomb_nm": found.coulomb, "viscous_nms_per_rad": found.viscous},
                model=None if settings.model is None else settings.model.joints[number - 1],
                known_inertia_kg_m2=float(inertias[number - 1]),
                lacking=found.reason,
            )
        )
    return tuple(subjects)


def diagnose_subjects(
    subjects: Sequence[Subject], settings: DiagnosisSettings, report: Callable[[float], None] | None = None
) -> Discrepancy:
    """Diagnose joints side by side; ``report`` takes the share of them that is done."""
    candidates = [c for c in effects() if settings.candidates is None or c.name in settings.candidates]

    def one(k: int) -> JointDiagnosis:
        """Diagnose a joint; an error is the result of this joint and not the end of the others."""
        subject = subjects[k]
        unanswered = partial(JointDiagnosis, joint=subject.number, name=subject.name, from_energy=subject.from_energy)
        # The last of an odd number of joints has a second core to itself, for the columns of its effects.
        last = k == joints - 1 and joints % (workers if workers > 1 else WORKERS) == 1
        try:
            with nullcontext() if last else one_joint_at_a_time():
                return diagnose_joint(subject, candidates, settings)
        except AnalysisError as error:
            return unanswered(verdict="not_testable", reason=str(error))
        except (FrictionAuditError, MemoryError, Warning):  # warnings are errors where the tests run
            raise
        except Exception as error:  # noqa: BLE001 - reported as a bug: verdict, traceback and exit code 1
            return unanswered(verdict="failed", reason=bug_sentence("the diagnosis", error), traceback=traced(error))

    joints = len(subjects)
    workers = workers_for(joints, WORKING_BYTES * max(len(subject.data.t) for subject in subjects))
    # Half of the work is in the interpreter, for which threads would wait.
    found = in_processes(one, joints, workers) if workers > 1 else per_joint(one, joints)
    diagnosed: list[JointDiagnosis] = []
    for joint in found:
        diagnosed.append(joint)
        if report is not None:
            report(len(diagnosed) / joints)
    return Discrepancy(joints=tuple(diagnosed))
