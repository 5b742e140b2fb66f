"""``friction-audit plan``."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from friction_audit.cli import chain
from friction_audit.cli.chain import audit_settings, read_options
from friction_audit.cli.choices import option, parse_joints, parse_numbers
from friction_audit.cli.grouped_help import GENERAL, MOTION
from friction_audit.cli.options import LogOptions, folder_option
from friction_audit.cli.outputs import ResultFolder, show
from friction_audit.errors import InputError, UsageError

if TYPE_CHECKING:
    from friction_audit.io.writers.joint_trajectory import Trajectory
    from friction_audit.planning.limits import Limits
    from friction_audit.planning.plan import JointPlan
    from friction_audit.planning.source import Arm, Task
    from friction_audit.reporting.plan import Recording

EXAMPLES = """Examples:
  friction-audit plan run.mcap -o next
  friction-audit plan results/diagnose.json --joints 4 --drive robot
  friction-audit plan run.parquet --range=-0.5,0.5 --speed 1.0 --duration 180
  friction-audit plan"""

DOCUMENT, TRAJECTORY = "plan.json", "trajectory"
PURPOSES = ("decide", "diagnose", "estimate")


@dataclass(frozen=True, kw_only=True, slots=True)
class MotionOptions:
    """What the motion may be."""

    duration: Annotated[float, option(MOTION, "Length of the motion of a joint.", metavar="SECONDS")] = 120.0
    range_: Annotated[
        str | None,
        option(MOTION, "Positions relative to the start [rad]. Default: the log's, at least -0.8,0.8.", "--range",
               metavar="LOW,HIGH"),
    ] = None  # fmt: skip
    speed: Annotated[
        float | None, option(MOTION, "Highest speed. Default: that of the arm, or of a hand.", metavar="RAD_S")
    ] = None
    acceleration: Annotated[
        float | None, option(MOTION, "Highest acceleration. Default: likewise.", metavar="RAD_S2")
    ] = None
    jerk: Annotated[float | None, option(MOTION, "Highest jerk. Default: likewise.", metavar="RAD_S3")] = None
    start: Annotated[
        str | None,
        option(MOTION, "Pose at the start [rad]. Default: the log's median pose; without one the Panda's ready pose.",
               metavar="Q1,Q2,..."),
    ] = None  # fmt: skip
    check: Annotated[
        bool, option(MOTION, "Simulate the motion and what diagnose would answer.", "--check/--no-check")
    ] = True
    trajectory_rate: Annotated[float, option(GENERAL, "Points of the trajectory per second.", metavar="HZ")] = 100.0


def command(
    motion: MotionOptions,
    shared: LogOptions,
    source: Annotated[
        Path | None, typer.Argument(metavar="[SOURCE]", help="A log, a diagnose.json or an estimate.json.")
    ] = None,
    folder: Annotated[
        Path | None, folder_option(f"Also write {DOCUMENT}, {TRAJECTORY}.csv and {TRAJECTORY}.mcap to DIR.")
    ] = None,
) -> None:
    """Plan the recording that decides what the last one left open."""
    from friction_audit.reporting.documents import write_document
    from friction_audit.reporting.notices import notice_lines
    from friction_audit.reporting.plan import plan_document, plan_lines, plan_notices

    voice, out = shared.general.voice, ResultFolder(folder=folder, name="plan", overwrite=shared.overwrite)
    out.check(source or Path(), _files(PURPOSES))
    with voice.step("read" if source else "prepare"):
        arm, tasks = _tasks(source, motion, shared)
    recordings, purposes = [], {one.purpose for one in tasks} - {None}
    for purpose in (one for one in PURPOSES if one in purposes):
        with voice.step(f"plan to {purpose}"):
            plans = tuple(_plan(one, arm, motion, shared) for one in tasks if one.purpose == purpose)
        rate, alone = motion.trajectory_rate, len(purposes) == 1
        recordings.append(_written(purpose, plans, arm, rate, out, alone=alone))
    settled = [one for one in tasks if one.purpose is None]
    warnings = list(plan_notices(recordings, known_start=arm.known_start))
    document = write_document(plan_document("" if source is None else str(source), recordings, settled, warnings))
    out.write_text(DOCUMENT, document)
    if not shared.general.json:
        voice.warn(notice_lines(warnings))
    show(document, lambda: plan_lines(recordings, settled), json=shared.general.json)


def _files(purposes: Sequence[str]) -> list[str]:
    """Return the names of the files that may be written."""
    stems = [TRAJECTORY, *(f"{TRAJECTORY}_{purpose}" for purpose in purposes)]
    return [DOCUMENT, *(f"{stem}.{kind}" for stem in stems for kind in ("csv", "mcap"))]


def _tasks(source: Path | None, motion: MotionOptions, shared: LogOptions) -> "tuple[Arm, list[Task]]":
    """Return the arm and what its joints need; where nothing is to be decided, the best recordings of the first one."""
    from friction_audit.io.documents import read_document
    from friction_audit.planning.question import Joint
    from friction_audit.planning.source import Task, arm_alone, of_document

    start, wanted = _parse_start(motion.start), parse_joints(shared.selection.joints)
    if source is None:
        arm = arm_alone(start, shared.reading.robot)
        number = (wanted or (1,))[0]
        if number > len(arm.names):
            raise UsageError(f"--joints {number}: the arm has {len(arm.names)} joints; choose one of them")
        tasks = [Task(joint=Joint(number=number, name=arm.names[number - 1]), purpose=None, why="there is no log")]
    elif source.suffix.lower() == ".json":
        arm, tasks = of_document(read_document(source, ("diagnose", "estimate")), source, start, wanted)
    else:
        arm, tasks = _tasks_of_log(source, start, shared)
    if shared.torque.drive != "auto":
        tasks = [one.driven(hand=shared.torque.drive == "hand") for one in tasks]
    if not tasks:
        raise InputError(f"{source}: holds no joint of --joints; name one that it has")
    if any(one.purpose for one in tasks):
        return arm, tasks
    best = [replace(tasks[0], purpose=purpose, why="") for purpose in ("diagnose", "estimate")]
    return arm, [*(tasks if source else []), *best]


def _tasks_of_log(source: Path, start: "tuple[float, ...] | None", shared: LogOptions) -> "tuple[Arm, list[Task]]":
    from friction_audit.diagnosis.diagnose import diagnose_subjects
    from friction_audit.diagnosis.settings import DiagnosisSettings
    from friction_audit.pipeline import Diagnosis, diagnosis_subjects, estimate_log
    from friction_audit.planning.source import arm_of_log, tasks_of_log

    voice, settings = shared.general.voice, DiagnosisSettings()
    log = chain.read(source, read_options(shared.reading, shared.selection), voice)
    if log.source.torque_unit != "N m":
        raise UsageError(f"{source}: its torque is a motor current [{log.source.torque_unit}]; expected newton metres")
    arm = arm_of_log(log, start)
    with voice.step("diagnose"):
        estimate = estimate_log(log, audit_settings(shared))
        subjects = diagnosis_subjects(estimate, settings)
        found = Diagnosis(estimate=estimate, discrepancy=diagnose_subjects(subjects, settings), settings=settings)
    return arm, list(tasks_of_log(found, subjects, arm))


def _plan(task: "Task", arm: "Arm", motion: MotionOptions, shared: LogOptions) -> "JointPlan":
    from friction_audit.planning import plan

    limits = _limits(task, arm, motion, shared)
    if task.purpose == "decide" and task.question is not None:
        return plan.plan_to_decide(task.question, limits, task.why, motion.duration, check=motion.check)
    make = plan.plan_to_estimate if task.purpose == "estimate" else plan.plan_to_diagnose
    return make(task.joint, limits, task.why, motion.duration, check=motion.check)


def _limits(task: "Task", arm: "Arm", motion: MotionOptions, shared: LogOptions) -> "Limits":
    from friction_audit.planning.limits import Wanted, limits_of

    between = None if motion.range_ is None else parse_numbers("--range", motion.range_, ("LOW", "HIGH"))
    wanted = Wanted(
        range_rad=None if between is None else (between[0], between[1]),
        speed_rad_s=motion.speed,
        acceleration_rad_s2=motion.acceleration,
        jerk_rad_s3=motion.jerk,
    )
    joint = task.joint
    return limits_of(
        joint.name,
        joint.number,
        arm.start_rad[joint.number - 1],
        urdf=shared.torque.urdf,
        panda=arm.panda and shared.reading.robot != "none",
        hand=joint.hand,
        reach_rad=joint.reach_rad,
        wanted=wanted,
    )


def _parse_start(text: str | None) -> tuple[float, ...] | None:
    if text is None:
        return None
    return parse_numbers("--start", text, tuple(f"Q{k}" for k in range(1, text.count(",") + 2)))


def _written(
    purpose: str, plans: "tuple[JointPlan, ...]", arm: "Arm", rate_hz: float, out: ResultFolder, *, alone: bool
) -> "Recording":
    """Write the trajectory of a recording, if there is a folder."""
    from friction_audit.io.writers.joint_trajectory import write_csv, write_mcap
    from friction_audit.reporting.plan import Recording

    if out.folder is None:
        return Recording(purpose=purpose, plans=plans)
    trajectory, stem = _trajectory(plans, arm, rate_hz), TRAJECTORY if alone else f"{TRAJECTORY}_{purpose}"
    out.write(f"{stem}.csv", lambda draft: write_csv(trajectory, draft))
    out.write(f"{stem}.mcap", lambda draft: write_mcap(trajectory, draft))
    files = tuple(str(out.folder / f"{stem}.{kind}") for kind in ("csv", "mcap"))
    return Recording(purpose=purpose, plans=plans, files=files)


def _trajectory(plans: "Sequence[JointPlan]", arm: "Arm", rate_hz: float) -> "Trajectory":
    """Return the motions of the joints one after the other, all other joints held at the start."""
    import numpy as np

    from friction_audit.io.writers.joint_trajectory import Trajectory

    parts, begin = [], 0.0
    for plan in plans:
        t, q, dq, ddq = plan.trajectory(rate_hz)
        whole = np.zeros((3, len(t), len(arm.names)))
        whole[0] = arm.start_rad
        whole[:, :, plan.joint.number - 1] = q, dq, ddq
        parts.append((begin + t, *whole))
        begin = float(parts[-1][0][-1]) + 1.0 / rate_hz
    return Trajectory(arm.names, *(np.concatenate(one) for one in zip(*parts, strict=True)))
