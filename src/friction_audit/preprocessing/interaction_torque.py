"""Gravity and offsets that are left in the torque that friction sees.

The constants of a gravity error are ill-determined over a short range: two of hundreds of newton metres may cancel.
What a log determines is their torque over the range that the joint moved, and whether that depends on the position.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import UsageError
from friction_audit.joint_log import Float, JointLog
from friction_audit.preprocessing.cautions import SIGNS, Balance, formula, inertia_left, not_used, sign_cautions
from friction_audit.preprocessing.interaction import Caution, Interaction, TorqueChoice
from friction_audit.preprocessing.resampling import (
    Grid,
    GridTorque,
    grids_of,
    position_on,
    torque_on_grids,
    velocity_on,
)
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.preprocessing.sign import CoarseLog, coarse_log, prove_sign, strokes_of
from friction_audit.preprocessing.torque_source import CHANNELS, Plan, arm_for_hand, make_plan, removed_command
from friction_audit.preprocessing.velocity import on_time

LARGEST_NM = 1.5
"""An identified model errs by a few tenths of a newton metre, the vendor's by up to two on the heaviest joints; a
forgotten hand makes two to three."""
LEAST_RANGE_RAD = 0.3
"""Over less, gravity looks like an offset or a spring."""
LEAST_ACROSS = 0.1
"""Share of gravity across an axis below which the axis is vertical: a payload does not load it."""
LEAST_STROKES = 10
ENOUGH = 20_000
"""Means of 20 ms; more tell nothing of what changes with the position alone."""
SIGNIFICANCE = 0.01


@dataclass(frozen=True, kw_only=True, slots=True)
class _Left:
    """What is left beside friction on one joint: mean and rms over the range moved [N m], the friction [N m]."""

    column: int
    mean_nm: float
    rms_nm: float
    range_rad: float
    friction_nm: float
    by_position: bool


def gravity_cautions(
    coarse: CoarseLog, torque: Float, direction: Float | None, columns: list[int], names: tuple[str, ...], gravity: str
) -> tuple[Caution, ...]:
    """Say on which joints gravity or an offset is left in the torque.

    Args:
        coarse: Motion.
        torque: F_m + u of all joints, shape (m, j). [N m]
        direction: Direction of gravity across the axes of the joints, shape (m, len(columns), 2), or None.
        columns: Joints to look at, 0-based.
        names: Their names.
        gravity: Where gravity came from, as in ``TorqueChoice``.
    """
    found = [
        one
        for place, column in enumerate(columns)
        for one in _left(coarse, torque, None if direction is None else direction[:, place], column)
    ]
    several = sum(one.rms_nm > one.friction_nm for one in found) > 1
    labels = dict(zip(columns, names, strict=True))
    return tuple(_caution(one, labels[one.column], gravity if several else "") for one in found)


def _left(coarse: CoarseLog, torque: Float, direction: Float | None, column: int) -> Iterator[_Left]:
    moving, way, stroke = strokes_of(coarse, column)
    if not stroke.size or stroke[-1] + 1 < LEAST_STROKES:
        return
    rows = np.flatnonzero(moving)
    thin = slice(None, None, max(len(rows) // ENOUGH, 1))
    rows, way = rows[thin], way[thin]
    q, dq = coarse.q[rows, column], coarse.dq[rows, column]
    ddq = np.gradient(coarse.dq[:, column], coarse.t)[rows]
    across = np.column_stack([np.sin(q), np.cos(q)]) if direction is None else direction[rows]
    plain = np.column_stack([way, dq, ddq, np.ones(len(q))])
    factors, square, square_plain = _fit(plain, across, torque[rows, column])
    at_rest = factors[3] + across @ factors[4:]
    freedom = int(stroke[-1] + 1) - len(factors)
    wide = np.ptp(q) >= LEAST_RANGE_RAD and float(np.hypot(*across.T).max()) >= LEAST_ACROSS
    by_position = bool(wide and _significant(square_plain, square, freedom))
    mean, rms = float(at_rest.mean()), float(np.sqrt(np.mean(at_rest**2)))
    if (rms if by_position else abs(mean)) > LARGEST_NM:
        yield _Left(
            column=column,
            mean_nm=mean,
            rms_nm=rms,
            range_rad=float(np.ptp(q)),
            friction_nm=abs(float(factors[0])),
            by_position=by_position,
        )


def _significant(without: float, with_gravity: float, freedom: int) -> bool:
    """F test of the columns of gravity; strokes are independent, not samples."""
    from scipy.special import fdtrc

    ratio = (without - with_gravity) / 2.0 / max(with_gravity / freedom, np.finfo(float).tiny)
    return bool(fdtrc(2.0, freedom, max(ratio, 0.0)) < SIGNIFICANCE)


def _fit(plain: Float, across: Float, torque: Float) -> tuple[Float, float, float]:
    """Return the factors of all columns, and the sums of squares that these and the plain ones alone leave."""
    columns = np.column_stack([plain, across])
    scale = np.linalg.norm(columns, axis=0).clip(min=np.finfo(float).tiny)
    # Both fits on the triangular factor: a decomposition of all samples takes most of the time.
    triangle = np.asarray(np.linalg.qr(np.column_stack([columns / scale, torque]), "r"), np.float64)
    fits = []
    for count in (columns.shape[1], plain.shape[1]):
        design, right = triangle[:, :count], triangle[:, -1]
        factors = np.linalg.lstsq(design, right, rcond=1e-8)[0]
        fits.append((factors, float(np.sum((right - design @ factors) ** 2))))
    (factors, square), (_, square_plain) = fits
    return factors / scale, square, square_plain


def _caution(one: _Left, name: str, gravity: str) -> Caution:
    where = f"joint {one.column + 1} ({name})"
    if not one.by_position:
        message = (
            f"{where}: the torque holds a constant {one.mean_nm:.1f} N m that is not friction; over the "
            f"{one.range_rad:.2g} rad that the joint moves an offset of the sensor cannot be separated from gravity"
        )
        return Caution(code="torque_offset", joint=one.column + 1, message=message)
    cause = {
        "model": "; several joints have it, so a payload is probably missing from the model (--payload mass,x,y,z), or "
        "another arm is modelled",
        "logged": "; several joints have it, so the payload was probably not set on the robot",
    }.get(gravity, "; check the gravity that was removed, and its direction")
    message = (
        f"{where}: gravity of at least {one.rms_nm:.1f} N m rms over the {one.range_rad:.2g} rad that the joint moves "
        f"is left in the torque{cause}"
    )
    return Caution(code="gravity_error", joint=one.column + 1, message=message)


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
