"""The torque at the friction port of a log: source, gravity, inertia and sign chosen, proved and applied."""

from collections.abc import Iterator
from itertools import chain
from typing import NamedTuple

import numpy as np

from friction_audit.errors import UsageError
from friction_audit.joint_log import Bool, Float, Int, JointLog, LogPart
from friction_audit.preprocessing.balance import Balance, gravity_cautions, grids_of, motion_on, not_used, sign_cautions
from friction_audit.preprocessing.interaction import Caution, Interaction, TorqueChoice
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.preprocessing.sign import CoarseLog, coarse_log, most, prove_sign
from friction_audit.preprocessing.torque_source import CHANNELS, Plan, arm_for_hand, make_plan
from friction_audit.preprocessing.velocity import on_time

# Ratio of mean squares: friction, inertia and noise alone move it by less about 1 where the model hardly matters.
FURTHER = 1.1


class PortTorque(NamedTuple):
    """How the torque at the friction port of a log is made, in all of it or in a part."""

    log: JointLog  # the log, its velocities on time
    balance: Balance  # the row of the balance whose energy rises
    columns: list[int]  # selected joints, 0-based
    stride: int  # samples between those at which the direction of gravity is evaluated
    choice: TorqueChoice  # how the torque is made, for people
    warnings: tuple[Caution, ...]  # what the user must know
    hand_speed: Float | None = None  # speed of the end effector, shape (n,), None where it was not asked for [m/s]

    def driving(self) -> Iterator[Interaction]:
        """Yield velocity and torque of the parts of the log; the position only where the torque is made from it."""
        plan = self.balance.plan
        names = ("dq", CHANNELS[plan.source], "tau_compensation", "tau_passivity")
        needed = {"model": ("q",), "logged": ("gravity",)}.get(plan.gravity, ())
        for part in self.log.blocks((*names, *needed)):
            yield self.interaction(part, directed=False)

    def interaction(self, part: LogPart, *, directed: bool = True) -> Interaction:
        """Return motion and torque of a part of the log, and where gravity points there."""
        index, direction = self.gravity_direction(part) if directed else (None, None)
        kept = part.take_joints(self.columns)
        active = [torque for torque in (kept.tau_compensation, kept.tau_passivity) if torque is not None]
        return Interaction(
            t=part.t,
            q=kept.q,
            dq=kept.dq,
            torque=self.balance.full(part, self.columns),
            compensation=np.add(*active) if len(active) > 1 else active[0] if active else None,
            posture=part.q if self.choice.gravity == "in-torque" else None,
            gravity_direction=direction,
            gravity_index=index,
            joint_numbers=tuple(column + 1 for column in self.columns),
            joint_names=kept.joint_names,
            choice=self.choice,
            warnings=self.warnings,
            first=part.first,
        )

    def gravity_direction(self, part: LogPart) -> tuple[Int | None, Float | None]:
        """Return samples of a part, and the direction of gravity across the selected axes there."""
        arm, samples = self.balance.plan.arm, len(part.t)
        if arm is None:
            return None, None
        index = np.arange(-part.first % self.stride, samples, self.stride)
        if part.first + samples == self.log.samples:
            index = np.union1d(index, samples - 1)
        return index, arm.gravity_direction(part.q[index])[:, self.columns]


def choose_torque(
    log: JointLog, settings: TorqueSettings, *, joints: tuple[int, ...] | None = None, hand: bool = False
) -> PortTorque:
    """Choose how the torque at the friction port of a log is made, and prove its sign.

    Every joint of the log takes part in the rigid-body model and in the proof, also those that are not kept, by their
    numbers (1..n). Velocities that lag the positions are corrected. ``hand``: whether the speed of the hand is wanted.
    """
    columns = _columns(log, joints)
    coarse = coarse_log(log)
    log, late = on_time(log, coarse)
    coarse = coarse_log(log) if late else coarse
    plan = make_plan(log, coarse, settings)
    balance, turned = _choose_row(log, coarse, plan, settings)
    _refuse_wrong_model(log, balance, settings)
    return PortTorque(
        log=log,
        balance=balance,
        columns=columns,
        stride=max(round(log.rate_hz / settings.model_rate_hz), 1),
        choice=_choice(balance, settings, turned=turned),
        warnings=(
            *plan.warnings,
            *late,
            *not_used(log, balance, settings, hand=hand),
            *_flipped(balance),
            *sign_cautions(log, balance, settings, turned=turned),
            *gravity_cautions(log, coarse, balance, columns),
        ),
        hand_speed=_hand_speed(log, settings) if hand else None,
    )


def _hand_speed(log: JointLog, settings: TorqueSettings) -> Float:
    arm, grids = arm_for_hand(log, settings), grids_of(log, settings.model_rate_hz)
    speed = np.concatenate([arm.hand_speed(q, dq) for q, dq, _ in motion_on(grids, log)])
    # Straight lines, not a spline: a speed has kinks at zero, where a spline would swing below it.
    return np.asarray(np.interp(log.t, np.concatenate([grid.t for grid in grids]), speed))


def _columns(log: JointLog, joints: tuple[int, ...] | None) -> list[int]:
    there = range(1, len(log.joint_names) + 1)
    chosen = sorted(set(there if joints is None else joints))
    unknown = [str(number) for number in joints or () if number not in there]
    if unknown or not chosen:
        listed = ", ".join(f"{number} ({name})" for number, name in zip(there, log.joint_names, strict=True))
        raise UsageError(f"--joints {','.join(unknown)}: not in {log.source.path}; its joints are {listed}")
    return [number - 1 for number in chosen]


def _choose_row(log: JointLog, coarse: CoarseLog, plan: Plan, settings: TorqueSettings) -> tuple[Balance, bool]:
    """Return the row of the balance whose energy rises, and whether it is not the one tried first."""
    rows = (Balance.of(log, coarse, plan, drive, settings.model_rate_hz) for drive in plan.drives)
    first, tried = next(rows), list[Balance]()
    others = [first._replace(sign=-first.sign)] if plan.source == "interaction" else rows
    for row in chain([first], others):
        tried.append(row._replace(evidence=prove_sign(coarse, row.driving(log, coarse), log.source.dead_torque)))
        if most(tried[-1].evidence, "rises"):
            return tried[-1], len(tried) > 1
    return tried[0], False


def _refuse_wrong_model(log: JointLog, balance: Balance, settings: TorqueSettings) -> None:
    """Refuse a model of the arm that explains less of the measured torque than no model does.

    The criterion is a negative explained variance of the arm as a whole, moving and at rest. A payload that the model
    lacks may shift the torque by more than a short motion changes it, so the mean square must grow too.
    """
    plan = balance.plan
    if plan.gravity != "model":
        return
    alive = [number not in log.source.dead_torque for number in range(1, len(log.joint_names) + 1)]
    measured, left = balance.source[:, alive], balance.left[:, alive]
    if not (
        np.sum(np.var(left, axis=0)) > FURTHER * np.sum(np.var(measured, axis=0))
        and np.sum(left**2) > FURTHER * np.sum(measured**2)
    ):
        return
    where = log.source.path
    rms = [" ".join(f"{value:.2f}" for value in np.std(torque, axis=0)) for torque in (left, measured)]
    numbers = np.flatnonzero(alive) + 1
    joints, sign = ", ".join(map(str, numbers)), ""
    opposite, as_is = _fits_opposite(measured, left)
    if opposite.any():  # of all joints where none fits as it is
        wrong = numbers[opposite] if as_is.any() else numbers
        sign = f" With the opposite sign it would explain it: --flip {','.join(map(str, wrong))}."
    without = settings.command(where, gravity="auto", inertia="auto", robot="none", urdf=None, payload=None)
    removed = settings.command(where, torque="auto", gravity="removed", inertia="auto")
    raise UsageError(
        f"{where}: the model of {plan.arm.name if plan.arm else 'the arm'} is further from the torque than no model: "
        f"tau_J less the model has {rms[0]} N m rms about its mean on joints {joints}, tau_J alone {rms[1]} N m."
        f"{sign} If it is another arm, or its joints are in another order: {without}, or give its --urdf. If gravity "
        f"is already removed from tau_J: {removed}. If the base does not stand upright, give its --gravity-vector"
    )


def _fits_opposite(measured: Float, left: Float) -> tuple[Bool, Bool]:
    """Return which joints' torque what was removed fits far better with the opposite sign, and which as it is."""
    turned, as_is = np.var(2.0 * measured - left, axis=0), np.var(left, axis=0)
    return 2.0 * turned < as_is, 2.0 * as_is < turned


def _flipped(balance: Balance) -> Iterator[Caution]:
    """Warn of joints whose torque has the opposite sign of that of the others."""
    opposite, as_is = _fits_opposite(balance.source, balance.left)
    if balance.plan.gravity in ("model", "logged") and opposite.any() and as_is.any():
        yield Caution("torque_flipped", numbers={"joints": (np.flatnonzero(opposite) + 1).tolist()})


def _choice(balance: Balance, settings: TorqueSettings, *, turned: bool) -> TorqueChoice:
    plan = balance.plan
    return TorqueChoice(
        source=plan.source,
        gravity=plan.gravity,
        inertia="model" if balance.inertial is not None else "none",
        drive=balance.drive,
        sign=balance.sign,
        sign_proved=most(balance.evidence, "rises"),
        sign_turned=turned,
        robot=plan.arm.name if balance.has_model and plan.arm is not None else "none",
        payload=settings.payload if balance.has_model else None,
        model_rate_hz=None if balance.inertial is None else settings.model_rate_hz,
        formula=balance.formula,
        reason=plan.reason,
        sign_evidence=balance.evidence,
    )
