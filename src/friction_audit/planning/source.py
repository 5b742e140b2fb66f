"""What is to be recorded next: from the diagnosis of a log, or from a document of `diagnose` or `estimate`."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from friction_audit.diagnosis.diagnose_joint import Subject
from friction_audit.effects.joint_data import CORNER_HZ
from friction_audit.effects.registry import effect_of, motion_to_decide
from friction_audit.errors import InputError, UsageError
from friction_audit.joint_log import JointLog
from friction_audit.pipeline import Diagnosis
from friction_audit.planning.plan import Purpose
from friction_audit.planning.question import Joint, Question, joint_of, question_of, question_of_log
from friction_audit.robot.arm import BUILT_IN
from friction_audit.simulation.panda_joint import READY_RAD


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Arm:
    """The arm that is recorded, j joints, and where its motion starts."""

    names: tuple[str, ...]
    start_rad: tuple[float, ...]
    panda: bool
    known_start: bool


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Task:
    """What a joint needs.

    Attributes:
        joint: The joint.
        purpose: What the recording is for; None where nothing is left to decide.
        why: What is open, or the answer that there is.
        question: The competing effects, of ``decide``.
    """

    joint: Joint
    purpose: Purpose | None
    why: str
    question: Question | None = None

    def driven(self, *, hand: bool) -> "Task":
        """Return the task for a joint that a person moves, or the robot."""
        joint = replace(self.joint, hand=hand)
        question = None if self.question is None else replace(self.question, joint=joint)
        return replace(self, joint=joint, question=question)


def arm_of_log(log: JointLog, start: Sequence[float] | None) -> Arm:
    """Return the arm of a log; without a start its median pose."""
    place = np.median(log.q, axis=0).tolist() if start is None else start
    return _arm(log.joint_names, place, log.source.robot)


def arm_alone(start: Sequence[float] | None, robot: str) -> Arm:
    """Return the arm without any log: the Panda in its ready pose, or as many joints as the start has."""
    if robot == BUILT_IN or start is None:
        return _arm([f"panda_joint{k}" for k in range(1, 8)], READY_RAD if start is None else start, BUILT_IN)
    return _arm([f"joint{k}" for k in range(1, len(start) + 1)], start, robot)


def _arm(names: Sequence[str], start: Sequence[float], robot: str, *, known: bool = True) -> Arm:
    if len(start) != len(names) or not np.isfinite(start).all():
        raise UsageError(f"--start: {len(start)} positions; expected {len(names)}, one per joint [rad]")
    return Arm(names=tuple(names), start_rad=tuple(map(float, start)), panda=robot == BUILT_IN, known_start=known)


def tasks_of_log(found: Diagnosis, subjects: Sequence[Subject], arm: Arm) -> Iterator[Task]:
    """Yield what each joint of a log needs."""
    hand = found.estimate.interaction.choice.drive == "hand"
    energy = {one.joint: one for one in found.estimate.friction.joints}
    for one, subject in zip(found.discrepancy.joints, subjects, strict=True):
        question = question_of_log(one, subject, hand=hand, start_rad=arm.start_rad[one.joint - 1])
        coefficients = [energy[one.joint].coulomb.value, energy[one.joint].viscous.value]
        yield _task(question, one.verdict, one.reason, coefficients)


def _task(question: Question, verdict: str, reason: str, coefficients: Sequence[float]) -> Task:
    joint = question.joint
    if verdict == "not_testable":
        return Task(joint=joint, purpose="diagnose", why=reason)
    if verdict == "ambiguous" and question.names:
        names = question.names
        if set(names) <= {names[0], *effect_of(names[0]).indistinguishable}:
            motion = motion_to_decide(names[0], names[1:])
            why = f"no motion of the joint separates {' from '.join(names)}: {motion}"
            return Task(joint=joint, purpose=None, why=why)
        return Task(joint=joint, purpose="decide", why=" or ".join(names), question=question)
    lacking = [name for name, value in zip(("Coulomb", "viscous"), coefficients, strict=True) if not np.isfinite(value)]
    if lacking and verdict != "data_fault":
        return Task(joint=joint, purpose="estimate", why=f"{' and '.join(lacking)} friction is not determined")
    if verdict == "ambiguous":  # every competing name is named as well, or cannot be fitted
        return Task(joint=joint, purpose=None, why="no two of its names can be simulated apart from each other")
    return Task(joint=joint, purpose=None, why=reason or verdict.replace("_", " "))


def of_document(
    document: Mapping[str, Any], path: Path, start: Sequence[float] | None, wanted: Sequence[int] | None
) -> tuple[Arm, list[Task]]:
    """Return the arm of a result and what each joint needs.

    Args:
        document: Of `diagnose` or `estimate`.
        path: Its file, for messages.
        start: Where the motion starts, None for the ready pose of a Panda and zero else. [rad]
        wanted: Numbers of the joints, None for all.

    Raises:
        InputError: If keys are missing.
        UsageError: If the start has another number of joints.
    """
    try:
        source, chosen = document["source"], document["settings"]["torque_chosen"]
        own = {int(one["joint"]): str(one["name"]) for one in document["joints"]}
        usual_name = "panda_joint" if source["robot"] == BUILT_IN else "joint"
        names = [own.get(k, f"{usual_name}{k}") for k in range(1, int(source["joints"]) + 1)]
        usual = READY_RAD if source["robot"] == BUILT_IN and len(names) == len(READY_RAD) else [0.0] * len(names)
        arm = _arm(names, usual if start is None else start, str(source["robot"]), known=start is not None)
        places = {k: arm.start_rad[k - 1] for k in own if wanted is None or k in wanted}
        found = [one for one in document["joints"] if int(one["joint"]) in places]
        tasks = [_of_joint(one, hand=chosen["drive"] == "hand", start_rad=places[int(one["joint"])]) for one in found]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"{path}: is no whole document of its schema ({error!r}); write it again") from error
    return arm, tasks


def _of_joint(found: Mapping[str, Any], *, hand: bool, start_rad: float) -> Task:
    verdict, gap = found.get("verdict", "estimate"), found.get("gap")
    energy = found.get("from_energy", found)
    coefficients = [_value(energy.get(key)) for key in ("coulomb_nm", "viscous_nms_per_rad")]
    fitted = (
        found.get("augmented")
        or found.get("nominal")
        or dict(zip(("coulomb_nm", "viscous_nms_per_rad"), coefficients, strict=True))
    )
    joint = joint_of(
        {key: _value(number) for key, number in fitted.items()},
        number=int(found["joint"]),
        name=str(found["name"]),
        noise_nm=Joint().noise_nm if gap is None else float(gap["noise_floor_rms_nm"]),
        corner_hz=CORNER_HZ,
        hand=hand,
    )
    reason = str(found.get("reason") or (found.get("message", "") if verdict == "not_testable" else ""))
    effects = found.get("effects", ()) if verdict == "ambiguous" else ()
    return _task(question_of(joint, effects, None, start_rad), verdict, reason, coefficients)


def _value(number: Any) -> float:  # noqa: ANN401 - of a document: a number, an object with one, or null
    value = number.get("value") if isinstance(number, dict) else number
    return float("nan") if value is None else float(value)
