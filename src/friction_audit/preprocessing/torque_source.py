"""What the interaction torque is made of: decided from what the log holds and what the user said."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from friction_audit.errors import UsageError
from friction_audit.joint_log import JointLog
from friction_audit.preprocessing.interaction import Caution, Reason, TorqueChoice
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.preprocessing.sign import CoarseLog
from friction_audit.presets import BUILT_IN, PRESETS
from friction_audit.robot.arm import Arm, load_arm

# Source of the torque -> channel of the log, in the order in which ``auto`` prefers them.
CHANNELS = {"interaction": "tau_interaction", "tau_ext": "tau_ext_hat_filtered", "tau_J": "tau_J"}
MODELS = ("urdf", BUILT_IN)  # robots with a rigid-body model
FROM_TAU_J = ("removed", "logged", "model")  # choices of gravity that are about tau_J
PANDA_JOINTS = 7
EXPLAINED_BY_OWN_MODEL = 0.1  # share of the torque's variance that the model of an arm of the same kind leaves
# Median difference from the vendor's own model beyond which a payload must be missing: identified inertias and the
# vendor's differ by a few tenths of a N m, a forgotten hand makes 2 to 3 N m.
VENDOR_DISAGREES_NM = 1.0


class Plan(NamedTuple):
    """How the torque will be made."""

    source: str  # key of CHANNELS
    gravity: str  # ``"logged"``, ``"model"``, ``"in-torque"`` or ``"removed"``
    drives: tuple[str, ...]  # rows of the balance to try, in order; one if the user chose
    inertia: bool  # True if the robot row removes inertial and Coriolis torque
    arm: Arm | None  # the rigid-body model, or None
    reason: Reason  # why this source
    warnings: tuple[Caution, ...]  # what the user must know


def make_plan(log: JointLog, coarse: CoarseLog, settings: TorqueSettings) -> Plan:
    """Decide how the torque is made; settings that contradict each other or the log are a UsageError."""
    settings = _in_newton_metres(log, settings)
    _check_settings(log, settings)
    robot = known_robot(log, settings)
    source, reason = _source(log, settings, robot)
    arm = _arm_for_torque(log, settings, robot) if source == "tau_J" else None
    if reason == "unfiltered" and arm is not None and _payload_missing(log, coarse, settings, robot, arm):
        source, reason, arm = "tau_ext", "payload", None
    gravity = "removed" if source != "tau_J" else settings.gravity
    if gravity == "auto":
        gravity = "logged" if log.gravity is not None else "in-torque" if arm is None else "model"
    drives = ("hand", "robot") if settings.drive == "auto" else (settings.drive,)
    return Plan(
        source=source,
        gravity=gravity,
        drives=("robot",) if settings.inertia == "model" else drives,
        inertia=arm is not None and settings.inertia != "none",
        arm=arm,
        reason=(Caution("torque_source", numbers={"case": reason}),),
        warnings=tuple(_cautions(log, coarse, settings, source, reason, gravity, robot)),
    )


def _in_newton_metres(log: JointLog, settings: TorqueSettings) -> TorqueSettings:
    """Leave gravity and inertia, which are in newton metres, in a torque that is not; refuse them if asked for."""
    unit = log.source.torque_unit
    if unit == "N m":
        return settings
    if settings.gravity in ("logged", "model") or settings.inertia == "model":
        raise UsageError(
            f"{log.source.path}: the torque column is a motor current [{unit}], gravity and inertia are in N m; leave "
            "--gravity and --inertia away, or multiply the column by torque constant and gear ratio"
        )
    return replace(settings, gravity="removed" if settings.gravity == "removed" else "in-torque", inertia="none")


def _check_settings(log: JointLog, settings: TorqueSettings) -> None:
    where = log.source.path
    if settings.torque != "auto" and getattr(log, CHANNELS[settings.torque]) is None:
        logged = ", ".join(name for name, channel in CHANNELS.items() if getattr(log, channel) is not None)
        raise UsageError(
            f"{where}: --torque {settings.torque}: no {CHANNELS[settings.torque]} in the log; it has {logged}"
        )
    if settings.inertia == "model" and settings.drive == "hand":
        raise UsageError(
            "--inertia model with --drive hand: when a hand moves the arm the link's inertia is on the link side of "
            "the sensor and not in its balance with friction; remove --inertia, or use --drive robot"
        )
    wants_tau_J = settings.gravity in FROM_TAU_J or settings.inertia == "model"
    if wants_tau_J and settings.torque in ("interaction", "tau_ext"):
        raise UsageError(
            f"--torque {settings.torque} with --gravity {settings.gravity} and --inertia {settings.inertia}: that "
            "torque contains neither gravity nor inertia; remove them, or use --torque tau_J"
        )
    if settings.torque == "auto" and wants_tau_J and log.tau_J is None:
        raise UsageError(f"{where}: --gravity and --inertia are about tau_J, and the log has none; remove them")
    if settings.gravity == "logged" and log.gravity is None:
        raise UsageError(f"{where}: --gravity logged: the log has no gravity; map it (--map gravity=NAME) or use model")


def known_robot(log: JointLog, settings: TorqueSettings) -> str:
    """Return whose model may be used: ``"urdf"``, the name of a preset, ``"none"`` or ``"unknown"``."""
    if settings.urdf is not None:
        return "urdf"
    return log.source.robot if settings.robot == "auto" else settings.robot


def _source(log: JointLog, settings: TorqueSettings, robot: str) -> tuple[str, str]:
    """Choose the channel; the second word is why."""
    if settings.torque != "auto":
        return settings.torque, "asked"
    if settings.gravity in FROM_TAU_J or settings.inertia == "model":
        return "tau_J", "asked"
    known, external = robot in MODELS, log.tau_ext_hat_filtered is not None
    ranking = (
        ("interaction", "interaction", log.tau_interaction is not None),
        ("tau_J", "logged", log.tau_J is not None and log.gravity is not None),
        ("tau_J", "unfiltered" if external else "model", log.tau_J is not None and known),
        ("tau_ext", "tau_ext", external),
        ("tau_J", "last", True),
    )
    return next((source, reason) for source, reason, there in ranking if there)


def _arm_for_torque(log: JointLog, settings: TorqueSettings, robot: str) -> Arm | None:
    """Load the model if it is needed and the log or the user names it; no arm is assumed."""
    demanded = settings.gravity == "model" or settings.inertia == "model"
    if robot in MODELS:
        by_default = log.gravity is None and settings.gravity == "auto"
        possible = robot == "urdf" or len(log.joint_names) == PANDA_JOINTS
        useful = possible and settings.drive != "hand" and settings.inertia == "auto"
        return _load(log, settings) if demanded or by_default or useful else None
    if not demanded:
        return None
    where = log.source.path
    if robot in PRESETS:
        urdf = settings.command(where, robot="auto", urdf="FILE")
        panda = f"; with the Panda's, newton metres off: {settings.command(where, robot=BUILT_IN)}"
        raise UsageError(
            f"{where}: {PRESETS[robot].label}: names and limits are known, no rigid-body model, which --gravity "
            f"model and --inertia model need; built in: {BUILT_IN}; give this arm's URDF with inertias: {urdf}"
            f"{panda if robot == 'fr3' else ''}"
        )
    if robot == "none":
        raise UsageError(f"{where}: --robot none forbids the model that --gravity or --inertia asks for; remove one")
    without = settings.command(where, gravity="auto", inertia="auto", robot="none", urdf=None)
    raise UsageError(
        f"{where}: --gravity model and --inertia model need a model of the arm, and the log does not name its robot "
        f"(joints: {len(log.joint_names)}); {with_a_model(log, settings)}; without a model: {without}"
    )


def _load(log: JointLog, settings: TorqueSettings) -> Arm:
    arm = load_arm(settings.urdf, settings.payload, settings.gravity_vector)
    lost = "; ".join(finding.message for finding in log.source.findings if finding.code == "empty_joint")
    return arm.matched(log.joint_names, f"{log.source.path}: {lost}" if lost else log.source.path)


def _payload_missing(log: JointLog, coarse: CoarseLog, settings: TorqueSettings, robot: str, arm: Arm) -> bool:
    """Compare with the vendor's estimate, which knows the payload configured in the robot."""
    if robot != "panda" or settings.payload is not None or log.tau_J is None or log.tau_ext_hat_filtered is None:
        return False  # the user described the arm, or there is nothing to compare
    # What is left holds inertial torque too, which has no preferred sign: hence the median.
    left = coarse.mean(log.tau_J) - coarse.mean(log.tau_ext_hat_filtered) - arm.gravity(coarse.q)
    left = np.delete(left, [number - 1 for number in log.source.dead_torque], axis=1)
    return bool((np.abs(np.median(left, axis=0)) > VENDOR_DISAGREES_NM).any())


def _cautions(
    log: JointLog, coarse: CoarseLog, settings: TorqueSettings, source: str, reason: str, gravity: str, robot: str
) -> Iterator[Caution]:
    if source == "tau_ext":
        yield Caution(code="tau_ext_filtered")
    if reason == "payload":
        yield Caution(code="payload_missing", numbers={"most": VENDOR_DISAGREES_NM})
    if gravity != "in-torque":
        return
    if robot in PRESETS and robot not in MODELS:
        yield Caution(code="no_model", numbers={"arm": PRESETS[robot].label})
    command = _with_gravity_removed(log, coarse, settings) if log.source.torque_unit == "N m" else ""
    yield Caution(code="gravity_in_torque", numbers={"command": command})


def _with_gravity_removed(log: JointLog, coarse: CoarseLog, settings: TorqueSettings) -> str:
    """Return the one command that takes gravity out, with the built-in model where it explains the torque."""
    settings = replace(settings, gravity="auto")
    if settings.urdf is None and len(log.joint_names) == PANDA_JOINTS and log.tau_J is not None:
        measured = coarse.mean(log.tau_J)
        arm = load_arm(None, settings.payload, settings.gravity_vector)
        left = measured - arm.inverse_dynamics(coarse.q, coarse.dq, np.gradient(coarse.dq, coarse.t, axis=0))
        if np.var(left, axis=0).sum() < EXPLAINED_BY_OWN_MODEL * np.var(measured, axis=0).sum():
            return settings.command(log.source.path, robot="panda")
    robot = "auto" if settings.robot == "none" else settings.robot
    return settings.command(log.source.path, robot=robot, **({} if settings.urdf else {"urdf": "FILE"}))


def with_a_model(log: JointLog, settings: TorqueSettings, *more: str) -> str:
    """Return the commands that name the arm of a log."""
    where = log.source.path
    panda = f"if it is a Panda: {settings.command(where, *more, robot='panda')}; "
    other = f"by its URDF: {settings.command(where, *more, robot='auto', urdf='FILE')}"
    return (panda if len(log.joint_names) == PANDA_JOINTS else "") + other


def arm_for_hand(log: JointLog, settings: TorqueSettings) -> Arm:
    """Return the arm whose kinematics give the speed of the hand; an FR3 has the Panda's lengths."""
    if known_robot(log, settings) not in (*MODELS, "fr3"):
        raise UsageError(
            f"{log.source.path}: the speed of the hand needs the kinematics of the arm, and the log does not name one "
            f"that is built in; {with_a_model(log, settings, '--cycles-from', 'hand')}; or use --cycles-from joint"
        )
    return _load(log, settings)


def known_arm(log: JointLog, settings: TorqueSettings, choice: TorqueChoice) -> Arm | None:
    """Return the model that the torque was made with, or that the log or the user names; None where none is known."""
    robot = known_robot(log, settings)
    panda = robot == "panda" and len(log.joint_names) == PANDA_JOINTS
    return _load(log, settings) if robot == "urdf" or panda or choice.robot != "none" else None
