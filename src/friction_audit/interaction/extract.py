"""JointLog -> Interaction: the torque that friction sees."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import UsageError
from friction_audit.interaction.interaction import Caution, Interaction, SignEvidence, TorqueChoice
from friction_audit.interaction.plan import CHANNELS, Plan, arm_for_hand, make_plan
from friction_audit.interaction.resample import Grid, GridTorque, grids_of, position_on, torque_on_grids, velocity_on
from friction_audit.interaction.settings import TorqueSettings
from friction_audit.interaction.sign import CoarseLog, coarse_log, most, prevails, prove_sign, voting
from friction_audit.joint_log import Float, JointLog
from friction_audit.per_joint import per_joint
from friction_audit.robot import STANDARD_GRAVITY, check_urdf

SIGNS = {"hand": -1, "robot": 1}
"""Factor on tau_J and on tau_ext in the balance of each row."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class _Balance:
    """One row of the balance: F_m = sign * (source - each of the torques removed)."""

    drive: str
    sign: int
    inertia: bool
    logged: Float | None
    modelled: GridTorque | None
    evidence: tuple[SignEvidence, ...] = ()

    @property
    def proved(self) -> bool:
        return most(self.evidence, "rises")

    def coarse(self, log: JointLog, coarse: CoarseLog, source: Float) -> Float:
        torque = coarse.mean(source)
        if self.logged is not None:
            torque -= coarse.mean(self.logged)
        if self.modelled is not None:
            self.modelled.subtract_from(torque, coarse.t, list(range(len(log.joint_names))))
        return self.sign * torque

    def full(self, log: JointLog, source: Float, columns: list[int]) -> Float:
        """Make the torque of some joints, column by column; the recorded array itself where nothing is to be done."""
        if self.sign > 0 and self.logged is None and self.modelled is None and len(columns) == source.shape[1]:
            return source
        torque = np.empty((len(log.t), len(columns)), order="F")
        per_joint(lambda place: self._fill(torque[:, place], log.t, source, columns[place]), len(columns))
        return torque

    def _fill(self, torque: Float, t: Float, source: Float, column: int) -> None:
        if self.logged is None:
            torque[:] = source[:, column]
        else:
            np.subtract(source[:, column], self.logged[:, column], out=torque)
        if self.modelled is not None:
            self.modelled.subtract_from(torque[:, None], t, [column])
        if self.sign < 0:
            np.negative(torque, out=torque)


def extract_interaction(
    log: JointLog, settings: TorqueSettings, *, joints: tuple[int, ...] | None = None, hand: bool = False
) -> Interaction:
    """Make the torque at the friction port of a log, and prove its sign.

    Every joint of the log takes part in the rigid-body model and in the proof of the sign, the selected ones or not.

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
    plan = make_plan(log, coarse, settings)
    grids = grids_of(log, settings.model_rate_hz)
    balance, turned = _choose_row(log, coarse, plan, grids)
    source: Float = getattr(log, CHANNELS[plan.source])
    kept = log.take_joints(columns)
    index, direction = _gravity_direction(log, plan, columns, settings.model_rate_hz)
    unused = _not_used(log, plan, balance, settings, hand=hand)
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
        warnings=plan.warnings + unused + _sign_cautions(log, plan, balance, settings, turned=turned),
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


def _choose_row(log: JointLog, coarse: CoarseLog, plan: Plan, grids: tuple[Grid, ...]) -> tuple[_Balance, bool]:
    """Return the row of the balance that the energy speaks for, and whether it is not the one tried first."""
    first = _proved(log, coarse, plan, _row(log, plan, grids, plan.drives[0]))
    if first.proved:
        return first, False
    other = _other_row(log, plan, grids, first)
    if other is None:
        return first, False
    other = _proved(log, coarse, plan, other)
    # Gravity that is still inside leaves most joints undecided; the others may still tell one row from the other.
    better = prevails(other.evidence) and not prevails(first.evidence)
    return (other, True) if better else (first, False)


def _other_row(log: JointLog, plan: Plan, grids: tuple[Grid, ...], first: _Balance) -> _Balance | None:
    """Return what the first row is held against, or None where the user left no choice."""
    if plan.source == "interaction":
        return replace(first, sign=-first.sign)
    return _row(log, plan, grids, plan.drives[1]) if len(plan.drives) > 1 else None


def _row(log: JointLog, plan: Plan, grids: tuple[Grid, ...], drive: str) -> _Balance:
    inertia = drive == "robot" and plan.inertia
    return _Balance(
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


def _proved(log: JointLog, coarse: CoarseLog, plan: Plan, balance: _Balance) -> _Balance:
    torque = balance.coarse(log, coarse, getattr(log, CHANNELS[plan.source]))
    for active in (log.tau_compensation, log.tau_passivity):
        if active is not None:
            torque += coarse.mean(active)
    return replace(balance, evidence=prove_sign(coarse, torque))


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


def _choice(plan: Plan, balance: _Balance, settings: TorqueSettings, *, turned: bool) -> TorqueChoice:
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
        formula=_formula(plan, balance),
        reason=plan.reason,
        sign_evidence=balance.evidence,
    )


def _formula(plan: Plan, balance: _Balance) -> str:
    if plan.source != "tau_J":
        return f"F_m = {'-' if balance.sign < 0 else ''}{CHANNELS[plan.source]}"
    removed = [name for name, there in (("M ddq", balance.inertia), ("c", balance.inertia)) if there]
    removed += ["g"] if plan.gravity != "none" else []
    inside = "" if plan.gravity != "none" else ", gravity still inside"
    if balance.drive == "hand":
        return f"F_m = {''.join(f'{name} ' for name in removed)}-{' ' if removed else ''}tau_J{inside}"
    listed = " + ".join(removed)
    return "F_m = tau_J" + (f" - ({listed})" if len(removed) > 1 else f" - {listed}" if removed else "") + inside


def _not_used(
    log: JointLog, plan: Plan, balance: _Balance, settings: TorqueSettings, *, hand: bool
) -> tuple[Caution, ...]:
    """Name what was said about the arm and changes nothing, because the torque needs no model of it."""
    if settings.urdf is not None and plan.arm is None:
        check_urdf(settings.urdf)  # no use is no excuse for a file that is no arm
    modelled = balance.modelled is not None
    placed = plan.arm is not None  # even beside logged gravity its direction is the model's
    given = (
        ("--payload", settings.payload is not None and not modelled),
        ("--urdf", settings.urdf is not None and not (placed or hand)),
        ("--gravity-vector", settings.gravity_vector != STANDARD_GRAVITY and not placed),
    )
    unused = [option for option, idle in given if idle]
    if not unused:
        return ()
    instead = "" if log.tau_J is None else ", or ask for the model with --torque tau_J --gravity model"
    message = (
        f"{', '.join(unused)}: not used: {_formula(plan, balance)} needs no model of the arm; leave it away{instead}"
    )
    return (Caution(code="model_not_used", message=message),)


def _sign_cautions(
    log: JointLog, plan: Plan, balance: _Balance, settings: TorqueSettings, *, turned: bool
) -> tuple[Caution, ...]:
    found = []
    if turned:
        found.append(_turned(plan, balance))
    if most(balance.evidence, "falls"):
        found.append(_contradicted(log, plan, balance, settings))
    elif not balance.proved and any(one.verdict != "still" for one in balance.evidence):
        found.append(
            Caution(
                code="sign_unproved",
                message=f"the energy of most joints neither rises nor falls beyond its noise, so nothing proves "
                f"{_formula(plan, balance)}; record more strokes in both directions, or make sure of --drive",
            )
        )
    if balance.drive == "robot" and plan.source == "tau_J" and not balance.inertia:
        found.append(
            Caution(
                code="inertia_in_torque",
                message="the arm moves by itself and its inertial and Coriolis torque is still in F_m; joints that "
                "move together spoil each other's energy: give --urdf, or --robot panda",
            )
        )
    return (*found, *_disagreeing(balance.evidence))


def _contradicted(log: JointLog, plan: Plan, balance: _Balance, settings: TorqueSettings) -> Caution:
    """Say what may be wrong where the energy falls: it depends on what the user left open."""
    causes: list[str] = []
    if plan.source == "interaction":
        tried = ", nor does it rise with the sign turned"
    elif len(plan.drives) > 1:
        tried = ", nor does it rise with the other row of the balance"
    else:
        asked = f"--drive {balance.drive}" if settings.drive != "auto" else "--inertia model (the robot moves the arm)"
        tried = f"; {asked} is kept as asked"
        causes.append("the other --drive is meant")
    if log.tau_compensation is not None or log.tau_passivity is not None:
        causes.append(
            "tau_compensation has the wrong sign (it is positive towards positive motion): flip it in the log"
        )
    if plan.source == "tau_J":
        causes.append("gravity or the payload is wrong")
    row = "" if plan.source == "interaction" else f" (drive {balance.drive})"
    wrong = ", or ".join(causes or ["velocity and torque do not belong together"])
    message = (
        f"with {_formula(plan, balance)}{row} the net energy falls on most of the moving joints, "
        f"which friction cannot do{tried}; perhaps {wrong}"
    )
    return Caution(code="sign_contradicts_drive", message=message)


def _turned(plan: Plan, balance: _Balance) -> Caution:
    if plan.source == "interaction":
        text = "the interaction torque as logged makes the net energy fall; its sign was turned"
    else:
        text = (
            "with the hand's balance the net energy does not rise, with the robot's it does: the arm moved by itself, "
            f"so {_formula(plan, balance)}; say --drive robot, or --drive hand to keep the other"
        )
    return Caution(code="sign_turned", message=text)


def _disagreeing(evidence: tuple[SignEvidence, ...]) -> tuple[Caution, ...]:
    """Name the joints whose energy falls where that of most rises, or rises where that of most falls."""
    minority = "falls" if most(evidence, "rises") else "rises" if most(evidence, "falls") else ""
    return tuple(
        Caution(
            code="sign_disagrees",
            message=f"its energy {one.verdict} ({one.against_motion_nm:.2f} +- {one.standard_error_nm:.2f} N m against "
            "the motion) while that of most joints does not: gravity, payload or inertia of this joint is wrong",
            joint=one.joint,
        )
        for one in voting(evidence)
        if one.verdict == minority
    )
