"""JointLog -> Interaction: the torque that friction sees."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import UsageError
from friction_audit.interaction.balance import SIGNS, Balance, formula
from friction_audit.interaction.cautions import inertia_left, not_used, sign_cautions
from friction_audit.interaction.gravity_left import gravity_cautions
from friction_audit.interaction.interaction import Caution, Interaction, TorqueChoice
from friction_audit.interaction.late_velocity import on_time
from friction_audit.interaction.plan import CHANNELS, Plan, arm_for_hand, make_plan, removed_command
from friction_audit.interaction.resample import Grid, GridTorque, grids_of, position_on, torque_on_grids, velocity_on
from friction_audit.interaction.settings import TorqueSettings
from friction_audit.interaction.sign import CoarseLog, coarse_log, prove_sign
from friction_audit.joint_log import Float, JointLog

FURTHER = 1.1
"""Ratio of mean squares: friction, inertia and noise alone move it by less about 1 where the model hardly matters."""


def extract_interaction(
    log: JointLog, settings: TorqueSettings, *, joints: tuple[int, ...] | None = None, hand: bool = False
) -> Interaction:
    """Make the torque at the friction port of a log, and prove its sign.

    Every joint of the log takes part in the rigid-body model and in the proof of the sign, the selected ones or not.
    Velocities that come behind the positions are put on time.

    Args:
        log: The log.
        settings: What the user says about the torque.
        joints: Numbers (1..n) of the joints to keep, or None for all.
        hand: True if the speed of the end effector is wanted.

    Raises:
        UsageError: If the settings contradict the log, or a joint is not in it.
    """
    columns = _columns(log, joints)
    coarse = coarse_log(log)
    log, late = on_time(log, coarse)
    coarse = coarse_log(log) if late else coarse
    plan = make_plan(log, coarse, settings)
    grids = grids_of(log, settings.model_rate_hz)
    balance, turned = _choose_row(log, coarse, plan, grids)
    _refuse_wrong_model(log, coarse, plan, balance, settings)
    source: Float = getattr(log, CHANNELS[plan.source])
    kept = log.take_joints(columns)
    index, direction = _gravity_direction(log, plan, columns, settings.model_rate_hz)
    unused = not_used(log, plan, balance, settings, hand=hand)
    left = _gravity_left(log, coarse, plan, balance, columns, index, direction)
    return Interaction(
        t=log.t,
        q=kept.q,
        dq=kept.dq,
        torque=balance.full(log, source, columns),
        compensation=_compensation(kept),
        hand_speed=_hand_speed(log, settings, grids) if hand else None,
        gravity_direction=direction,
        gravity_index=index,
        joint_numbers=tuple(column + 1 for column in columns),
        joint_names=kept.joint_names,
        choice=_choice(plan, balance, settings, turned=turned),
        warnings=plan.warnings + late + unused + sign_cautions(log, plan, balance, settings, turned=turned) + left,
    )


def _columns(log: JointLog, joints: tuple[int, ...] | None) -> list[int]:
    there = range(1, len(log.joint_names) + 1)
    if joints is None:
        return [number - 1 for number in there]
    unknown = [str(number) for number in joints if number not in there]
    if unknown or not joints:
        listed = ", ".join(f"{number} ({name})" for number, name in zip(there, log.joint_names, strict=True))
        raise UsageError(f"--joints {','.join(unknown)}: not in {log.source.path}; its joints are {listed}")
    return [number - 1 for number in sorted(set(joints))]


def _choose_row(log: JointLog, coarse: CoarseLog, plan: Plan, grids: tuple[Grid, ...]) -> tuple[Balance, bool]:
    """Return the row of the balance that the energy speaks for, and whether it is not the one tried first."""
    first = _proved(log, coarse, plan, _row(log, plan, grids, plan.drives[0]))
    if first.proved:
        return first, False
    other = _other_row(log, plan, grids, first)
    if other is None:
        return first, False
    other = _proved(log, coarse, plan, other)
    return (other, True) if other.proved else (first, False)


def _other_row(log: JointLog, plan: Plan, grids: tuple[Grid, ...], first: Balance) -> Balance | None:
    """Return what the first row is held against, or None where the user left no choice."""
    if plan.source == "interaction":
        return replace(first, sign=-first.sign)
    return _row(log, plan, grids, plan.drives[1]) if len(plan.drives) > 1 else None


def _row(log: JointLog, plan: Plan, grids: tuple[Grid, ...], drive: str) -> Balance:
    inertia = drive == "robot" and plan.inertia
    return Balance(
        drive=drive,
        sign=1 if plan.source == "interaction" else SIGNS[drive],
        inertia=inertia,
        logged=log.gravity if plan.gravity == "logged" else None,
        modelled=_modelled(log, plan, grids, inertia=inertia),
    )


def _modelled(log: JointLog, plan: Plan, grids: tuple[Grid, ...], *, inertia: bool) -> GridTorque | None:
    arm = plan.arm
    gravity = plan.gravity == "model"
    if arm is None or not (gravity or inertia):
        return None

    def torque(grid: Grid) -> Float:
        position = position_on(grid, log)
        if not inertia:
            return arm.gravity(position)
        whole = arm.inverse_dynamics(position, *velocity_on(grid, log))
        return whole if gravity else whole - arm.gravity(position)

    return torque_on_grids(grids, torque)


def _proved(log: JointLog, coarse: CoarseLog, plan: Plan, balance: Balance) -> Balance:
    torque = _driving(log, coarse, plan, balance)
    return replace(balance, evidence=prove_sign(coarse, torque, log.source.dead_torque))


def _driving(log: JointLog, coarse: CoarseLog, plan: Plan, balance: Balance) -> Float:
    """Return F_m + u of all joints at the coarse log's times."""
    torque = balance.coarse(log, coarse, getattr(log, CHANNELS[plan.source]))
    for active in (log.tau_compensation, log.tau_passivity):
        if active is not None:
            torque += coarse.mean(active)
    return torque


def _gravity_left(
    log: JointLog,
    coarse: CoarseLog,
    plan: Plan,
    balance: Balance,
    columns: list[int],
    index: NDArray[np.int64] | None,
    direction: Float | None,
) -> tuple[Caution, ...]:
    """Say what gravity is left in the torque, unless it is declared to be inside or something else is in it too."""
    mixed = not balance.proved or inertia_left(log, plan, balance)
    if plan.gravity == "none" or mixed or log.source.torque_unit != "N m":
        return ()
    if index is not None and direction is not None:
        nearest = np.searchsorted(log.t[index], coarse.t).clip(max=len(index) - 1)
        direction = direction[nearest]
    dead = [number - 1 for number in log.source.dead_torque]
    alive = [place for place, column in enumerate(columns) if column not in dead]
    return gravity_cautions(
        coarse,
        _driving(log, coarse, plan, balance),
        None if direction is None else direction[:, alive],
        [columns[place] for place in alive],
        tuple(log.joint_names[columns[place]] for place in alive),
        plan.gravity,
    )


def _refuse_wrong_model(
    log: JointLog, coarse: CoarseLog, plan: Plan, balance: Balance, settings: TorqueSettings
) -> None:
    """Refuse a model of the arm that explains less of the measured torque than no model does.

    The criterion is a negative explained variance of the arm as a whole, moving and at rest. A payload that the model
    lacks may shift the torque by more than a short motion changes it, so the mean square must grow too.

    Raises:
        UsageError: If the model is further from the torque than none.
    """
    if balance.modelled is None or plan.gravity != "model":
        return
    alive = [number not in log.source.dead_torque for number in range(1, len(log.joint_names) + 1)]
    measured = coarse.mean(getattr(log, CHANNELS[plan.source]))[:, alive]
    left = balance.coarse(log, coarse, getattr(log, CHANNELS[plan.source]))[:, alive]
    further = (np.sum(np.var(left, axis=0)) > FURTHER * np.sum(np.var(measured, axis=0))) and (
        np.sum(left**2) > FURTHER * np.sum(measured**2)
    )
    if not further:
        return
    where = log.source.path
    rms = [" ".join(f"{value:.2f}" for value in np.std(torque, axis=0)) for torque in (left, measured)]
    joints = ", ".join(str(number + 1) for number in np.flatnonzero(alive))
    without = settings.command(where, gravity="auto", inertia="auto", robot="none", urdf=None, payload=None)
    raise UsageError(
        f"{where}: the model of {plan.arm.name if plan.arm else 'the arm'} is further from the torque than no model: "
        f"tau_J less the model has {rms[0]} N m rms about its mean on joints {joints}, tau_J alone {rms[1]} N m. If "
        f"it is another arm: {without}, or give its --urdf. If gravity is already removed from tau_J: "
        f"{removed_command(log, settings)}. If the base does not stand upright, give its --gravity-vector"
    )


def _compensation(log: JointLog) -> Float | None:
    if log.tau_compensation is None or log.tau_passivity is None:
        return log.tau_passivity if log.tau_compensation is None else log.tau_compensation
    both: Float = log.tau_compensation + log.tau_passivity
    return both


def _hand_speed(log: JointLog, settings: TorqueSettings, grids: tuple[Grid, ...]) -> Float:
    arm = arm_for_hand(log, settings)
    speed = np.concatenate([arm.hand_speed(position_on(grid, log), velocity_on(grid, log)[0]) for grid in grids])
    # Straight lines, not a spline: a speed has kinks at zero, where a spline would swing below it.
    at_samples: Float = np.interp(log.t, np.concatenate([grid.t for grid in grids]), speed)
    return at_samples


def _gravity_direction(
    log: JointLog, plan: Plan, columns: list[int], rate_hz: float
) -> tuple[NDArray[np.int64] | None, Float | None]:
    """Return at which samples the direction of gravity across the selected axes is known, and the direction."""
    if plan.arm is None:
        return None, None
    stride = max(round(log.rate_hz / rate_hz), 1)
    index = np.append(np.arange(0, len(log.t) - 1, stride), len(log.t) - 1)
    return index, plan.arm.gravity_direction(log.q[index])[:, columns]


def _choice(plan: Plan, balance: Balance, settings: TorqueSettings, *, turned: bool) -> TorqueChoice:
    modelled = balance.modelled is not None
    return TorqueChoice(
        source=plan.source,
        gravity=plan.gravity,
        inertia="model" if balance.inertia else "none",
        drive=balance.drive,
        sign=balance.sign,
        sign_proved=balance.proved,
        sign_turned=turned,
        robot=plan.arm.name if modelled and plan.arm is not None else "none",
        payload=settings.payload if modelled else None,
        model_rate_hz=settings.model_rate_hz if modelled else None,
        formula=formula(plan, balance),
        reason=plan.reason,
        sign_evidence=balance.evidence,
    )
