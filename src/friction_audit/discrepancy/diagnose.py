"""Where simulation and measurement disagree, joint by joint."""

from collections.abc import Sequence
from functools import partial

from friction_audit.cycles.energy_cycles import EnergyCycles
from friction_audit.discrepancy.candidate import Candidate
from friction_audit.discrepancy.candidates import CANDIDATES
from friction_audit.discrepancy.data_audit import audit_data
from friction_audit.discrepancy.diagnose_joint import Subject, diagnose_joint
from friction_audit.discrepancy.known_inertia import known_inertias
from friction_audit.discrepancy.likely_work import longest_first
from friction_audit.discrepancy.prepare import prepare
from friction_audit.discrepancy.result import Discrepancy, JointDiscrepancy
from friction_audit.discrepancy.settings import DiagnosisSettings
from friction_audit.friction.history import Coefficient, FrictionHistory
from friction_audit.in_copies import in_copies, workers_for
from friction_audit.interaction.interaction import Interaction
from friction_audit.joint_log import JointLog
from friction_audit.per_joint import per_joint
from friction_audit.robot import Arm


def diagnose(
    log: JointLog,
    interaction: Interaction,
    cycles: EnergyCycles,
    friction: FrictionHistory,
    settings: DiagnosisSettings,
    arm: Arm | None = None,
) -> Discrepancy:
    """Diagnose every joint of an interaction.

    Args:
        log: The log, in the window of the interaction.
        interaction: Motion and torque.
        cycles: Its energy cycles.
        friction: What the energy method found, for comparison.
        settings: What is asked.
        arm: The model of the arm where it is known.
    """
    prepared = prepare(interaction, cycles, log, arm)
    candidates = [c for c in CANDIDATES if settings.candidates is None or c.name in settings.candidates]
    inertias = known_inertias(arm, interaction.choice, log.q)
    subjects = [
        Subject(
            data=data,
            number=interaction.joint_numbers[data.joint],
            name=interaction.joint_names[data.joint],
            findings=audit_data(log, interaction, data),
            from_energy=_from_energy(friction, data.joint),
            model=None if settings.model is None else settings.model.joints[interaction.joint_numbers[data.joint] - 1],
            known_inertia_kg_m2=float(inertias[interaction.joint_numbers[data.joint] - 1]),
            lacking=friction.joints[data.joint].reason,
        )
        for data in prepared
    ]
    one = partial(_one, subjects, candidates, settings)
    workers = workers_for(len(subjects))
    # Half of the work is in the interpreter, for which threads would wait.
    if workers > 1:
        return Discrepancy(joints=tuple(in_copies(one, len(subjects), workers, longest_first(prepared))))
    return Discrepancy(joints=tuple(per_joint(one, len(subjects))))


def _one(
    subjects: Sequence[Subject], candidates: Sequence[Candidate], settings: DiagnosisSettings, k: int
) -> JointDiscrepancy:
    return diagnose_joint(subjects[k], candidates, settings)


def _from_energy(friction: FrictionHistory, joint: int) -> dict[str, Coefficient]:
    found = friction.joints[joint]
    return {"coulomb_nm": found.coulomb, "viscous_nms_per_rad": found.viscous}
