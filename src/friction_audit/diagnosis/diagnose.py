"""Where simulation and measurement disagree, joint by joint."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from friction_audit.diagnosis.data_audit import audit_data
from friction_audit.diagnosis.diagnose_joint import Subject, diagnose_joint
from friction_audit.diagnosis.known_load import known_inertias
from friction_audit.diagnosis.prepare import prepare
from friction_audit.diagnosis.result import Discrepancy, JointDiagnosis
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.registry import effects
from friction_audit.errors import AnalysisError, FrictionAuditError, bug_sentence, traced
from friction_audit.friction.history import Coefficient, FrictionHistory
from friction_audit.joint_log import JointLog
from friction_audit.parallel import in_processes, per_joint, workers_for
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.robot import Arm

FEWEST_SAMPLES = 10  # below it nothing is said about the work of a joint
WORKING_BYTES = 1000  # of a process per sample of the fine grid (benchmarks/bench_diagnose.py)


def diagnose(
    log: JointLog,
    interaction: Interaction,
    cycles: EnergyCycles,
    friction: FrictionHistory,
    settings: DiagnosisSettings,
    arm: Arm | None = None,
) -> Discrepancy:
    """Diagnose every joint of an interaction; arguments as of ``subjects_of``."""
    return diagnose_subjects(subjects_of(log, interaction, cycles, friction, settings, arm), settings)


def subjects_of(
    log: JointLog,
    interaction: Interaction,
    cycles: EnergyCycles,
    friction: FrictionHistory,
    settings: DiagnosisSettings,
    arm: Arm | None = None,
) -> tuple[Subject, ...]:
    """Prepare every joint; of the log's own samples nothing is needed afterwards.

    Args:
        log: The log, in the window of the interaction.
        interaction: Motion and torque.
        cycles: Its energy cycles.
        friction: What the energy method found, for comparison.
        settings: What is asked.
        arm: The model of the arm where it is known.
    """
    prepared = prepare(interaction, cycles, log, arm)
    inertias = known_inertias(arm, interaction.choice, log.q)

    def one(joint: int) -> Subject:
        number = interaction.joint_numbers[joint]
        return Subject(
            data=prepared[joint],
            number=number,
            name=interaction.joint_names[joint],
            findings=audit_data(log, interaction, prepared[joint]),
            from_energy=_from_energy(friction, joint),
            model=None if settings.model is None else settings.model.joints[number - 1],
            known_inertia_kg_m2=float(inertias[number - 1]),
            lacking=friction.joints[joint].reason,
        )

    return tuple(per_joint(one, len(prepared)))


def diagnose_subjects(subjects: Sequence[Subject], settings: DiagnosisSettings) -> Discrepancy:
    """Diagnose joints side by side."""
    candidates = [c for c in effects() if settings.candidates is None or c.name in settings.candidates]

    def one(k: int) -> JointDiagnosis:
        """Diagnose a joint; an error is the result of this joint and not the end of the others."""
        subject = subjects[k]
        unanswered = partial(JointDiagnosis, joint=subject.number, name=subject.name, from_energy=subject.from_energy)
        try:
            return diagnose_joint(subject, candidates, settings)
        except AnalysisError as error:
            return unanswered(verdict="not_testable", reason=str(error))
        except (FrictionAuditError, MemoryError, Warning):  # warnings are errors where the tests run
            raise
        except Exception as error:  # noqa: BLE001 - reported as a bug: verdict, traceback and exit code 1
            return unanswered(verdict="failed", reason=bug_sentence("the diagnosis", error), traceback=traced(error))

    prepared = [subject.data for subject in subjects]
    workers = workers_for(len(prepared), WORKING_BYTES * max((len(data.t) for data in prepared), default=0))
    # Half of the work is in the interpreter, for which threads would wait.
    if workers > 1:
        return Discrepancy(joints=tuple(in_processes(one, len(prepared), workers, longest_first(prepared))))
    return Discrepancy(joints=tuple(per_joint(one, len(prepared))))


def _from_energy(friction: FrictionHistory, joint: int) -> dict[str, Coefficient]:
    found = friction.joints[joint]
    return {"coulomb_nm": found.coulomb, "viscous_nms_per_rad": found.viscous}


def longest_first(prepared: Sequence[JointData]) -> list[int]:
    """Joints by what simple friction leaves of their torque over its noise: most to look for first."""
    return sorted(range(len(prepared)), key=lambda joint: -_left_over(prepared[joint]))


def _left_over(data: JointData) -> float:
    """Rms of what inertia, Coulomb and viscous friction leave, over how it scatters from sample to sample."""
    used, torque = data.used, data.torque
    if np.count_nonzero(used) < FEWEST_SAMPLES:
        return 0.0
    simple = np.stack([data.ddq, data.dq, np.sign(data.dq), np.ones(len(data.t))], axis=1)[used]
    left = torque[used] - simple @ np.linalg.lstsq(simple, torque[used], rcond=None)[0]
    scatter = float(np.median(np.abs(np.diff(left, n=2))))
    return float(np.std(left)) / scatter if scatter > 0 else 0.0
