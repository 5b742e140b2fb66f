"""``friction-audit plan``."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from friction_audit.cli import chain, options as opt, parameters as params
from friction_audit.cli.outputs import ResultFolder, show
from friction_audit.cli.parameters import group, option, parse_joints, parse_numbers, parse_range, positive
from friction_audit.errors import InputError
from friction_audit.joint_numbers import require_joints

if TYPE_CHECKING:
    from friction_audit.planning.task import Arm, Task

EXAMPLES = """Examples:
  friction-audit plan run.mcap -o next
  friction-audit plan results/diagnose.json --joints 4 --drive robot
  friction-audit plan run.parquet --range=-0.5,0.5 --speed 1.0 --duration 180
  friction-audit plan"""

DOCUMENT, TRAJECTORY = "plan.json", "trajectory"
LONGEST_S = 7200.0  # that can be simulated
RESULTS = ("diagnose.json", "estimate.json")


@group(params.MOTION)
class MotionOptions:
    """What the motion may be."""

    duration: float = positive("Length of the motion of a joint.", default=120.0, max=LONGEST_S, metavar="SECONDS")
    range_: str | None = option(
        "Positions relative to the start [rad]. Default: the log's, at least -0.8,0.8.", "--range", metavar="LOW,HIGH"
    )
    speed: float | None = option("Highest speed. Default: that of the arm, or of a hand.", metavar="RAD_S")
    acceleration: float | None = option("Highest acceleration. Default: likewise.", metavar="RAD_S2")
    jerk: float | None = option("Highest jerk. Default: likewise.", metavar="RAD_S3")
    start: str | None = option(
        "Pose at the start [rad]. Default: the log's median pose; without one the Panda's ready pose.",
        metavar="Q1,Q2,...",
    )
    check: bool | None = option(
        "Simulate the motion and what diagnose would answer. Default: where effects are to be separated.",
        "--check/--no-check",
    )
    trajectory_rate: float = positive(
        "Trajectory points per second.", default=100.0, metavar="HZ", panel=params.GENERAL
    )


def command(
    motion: MotionOptions,
    shared: opt.LogOptions,
    source: Annotated[
        Path | None,
        typer.Argument(metavar="[SOURCE]", help="A log, a diagnose.json, an estimate.json, or their folder."),
    ] = None,
    folder: Path | None = opt.folder_option(f"Also write {DOCUMENT}, {TRAJECTORY}.csv and {TRAJECTORY}.mcap to DIR."),
) -> None:
    """Plan the motion that separates ambiguous effects."""
    from friction_audit.io.writers.mcap import write_trajectory
    from friction_audit.io.writers.tables import write_trajectory_csv
    from friction_audit.planning.design import limits_of
    from friction_audit.planning.plan import plan_tasks, trajectory_of
    from friction_audit.reporting.notices import notice_lines
    from friction_audit.reporting.plan import PLAN, PURPOSES, Recording, plan_lines, plan_notices

    voice, out = shared.general.voice, ResultFolder(folder=folder, name="plan", overwrite=shared.overwrite)
    stems = [TRAJECTORY, *(f"{TRAJECTORY}_{purpose}" for purpose in PURPOSES)]
    out.check(source or Path(), [DOCUMENT, *(f"{stem}.{kind}" for stem in stems for kind in ("csv", "mcap"))])
    within = parse_range("--range", motion.range_, "rad")
    with voice.step("read" if source else "prepare"):
        arm, tasks = _tasks(source, motion, shared)
    robot = {"auto": arm.robot, "none": ""}.get(shared.reading.robot, shared.reading.robot)
    asked: dict[str, Any] = {"urdf": shared.torque.urdf, "robot": robot, "range_rad": within}
    asked |= {"speed_rad_s": motion.speed, "acceleration_rad_s2": motion.acceleration, "jerk_rad_s3": motion.jerk}
    starts = [(one, arm.start_rad[one.joint.number - 1]) for one in tasks if one.purpose]
    limited = [(one, limits_of(one.joint, start, **asked)) for one, start in starts]
    with voice.step("plan") as report:
        every = plan_tasks(limited, motion.duration, check=motion.check, report=report)
    recordings, purposes = [], {one.purpose for one in tasks} - {None}
    for purpose in (one for one in PURPOSES if one in purposes):
        plans = tuple(one for one in every if one.task.purpose == purpose)
        files: tuple[str, ...] = ()
        if folder is not None:
            trajectory = trajectory_of(plans, arm, motion.trajectory_rate)
            stem = TRAJECTORY if len(purposes) == 1 else f"{TRAJECTORY}_{purpose}"
            out.write(f"{stem}.csv", partial(write_trajectory_csv, trajectory))
            out.write(f"{stem}.mcap", partial(write_trajectory, trajectory))
            files = tuple(str(folder / f"{stem}.{kind}") for kind in ("csv", "mcap"))
        recordings.append(Recording(purpose, plans, files))
    settled = [one for one in tasks if one.purpose is None]
    warnings = list(plan_notices(recordings, known_start=arm.known_start))
    values = {"source": str(source or ""), "recordings": recordings, "settled": settled, "warnings": warnings}
    text = out.write_document(DOCUMENT, partial(PLAN.json, values), voice)
    voice.warn(notice_lines(warnings), held=True)
    show(text, lambda: plan_lines(recordings, settled), voice)


def _tasks(source: Path | None, motion: MotionOptions, shared: opt.LogOptions) -> "tuple[Arm, list[Task]]":
    """Return the arm and what its joints need.

    Where nothing is to be decided, it is the best recordings of the joints wanted, else of the first one that moved.
    """
    from friction_audit.io.files import read_document
    from friction_audit.planning.task import Joint, Task, arm_of, tasks_of
    from friction_audit.presets import BUILT_IN, PRESETS
    from friction_audit.simulation.bench import READY_RAD

    wanted, start = parse_joints(shared.selection.joints), None
    if source is not None and source.is_dir():  # of results; one of a bag holds none
        source = next((source / name for name in RESULTS if (source / name).is_file()), source)
    if motion.start is not None:
        names = tuple(f"Q{k}" for k in range(1, motion.start.count(",") + 2))
        start = parse_numbers("--start", motion.start, names)
    if source is None:
        asked = shared.reading.robot
        robot = asked if asked in PRESETS else BUILT_IN if start is None else ""
        joints = len(PRESETS[robot].joints if robot else start or ())
        arm = arm_of(robot, joints, start or (READY_RAD if robot == BUILT_IN else None), {})
        numbers = wanted or (1,)
        require_joints(numbers, len(arm.names), f"--joints {shared.selection.joints}")
        tasks = [Task(joint=Joint(number=k, name=arm.names[k - 1]), why="there is no log") for k in numbers]
    elif source.suffix.lower() == ".json":
        arm, tasks = tasks_of(read_document(source, ("diagnose", "estimate")), source, start, wanted=wanted)
    else:
        arm, tasks = _tasks_of_log(source, start, wanted, shared)
    if shared.torque.drive != "auto":
        tasks = [replace(one, joint=replace(one.joint, hand=shared.torque.drive == "hand")) for one in tasks]
    if not tasks:
        raise InputError(f"{source}: holds no joint of --joints; name one that it has")
    if any(one.purpose for one in tasks):
        return arm, tasks
    chosen = tasks if wanted or source is None else [min(tasks, key=lambda one: one.at_rest)]
    best = [replace(one, purpose=purpose, why="") for purpose in ("diagnose", "estimate") for one in chosen]
    return arm, [*(tasks if source else []), *best]


def _tasks_of_log(
    source: Path, start: tuple[float, ...] | None, wanted: tuple[int, ...] | None, shared: opt.LogOptions
) -> "tuple[Arm, list[Task]]":
    import numpy as np

    from friction_audit.diagnosis.diagnose import diagnose_subjects
    from friction_audit.diagnosis.settings import DiagnosisSettings
    from friction_audit.pipeline import Diagnosis, diagnosis_subjects, estimate_log
    from friction_audit.planning.task import tasks_of
    from friction_audit.reporting.diagnosis import DIAGNOSE

    voice, settings = shared.general.voice, DiagnosisSettings()
    log = chain.read_torque(source, shared, voice)
    with voice.step("diagnose") as report:
        estimate = estimate_log(log, chain.audit_settings(shared))
        subjects = diagnosis_subjects(estimate, settings)
        found = Diagnosis(estimate=estimate, joints=diagnose_subjects(subjects, settings, report), settings=settings)
    pose = np.median(log.q, axis=0).tolist() if start is None else start
    pairs = list(zip(subjects, found.joints, strict=True))
    return tasks_of(DIAGNOSE.of(found), source, pose, wanted=wanted, names=log.joint_names, subjects=pairs)
