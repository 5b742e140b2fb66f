"""A row of the balance: which torques are taken from the source, and with which sign."""

from dataclasses import dataclass, replace

import numpy as np

from friction_audit.joint_log import Float, JointLog
from friction_audit.parallel import per_joint
from friction_audit.preprocessing.interaction import Caution, SignEvidence
from friction_audit.preprocessing.resampling import GridTorque
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.preprocessing.sign import CoarseLog, most, voting
from friction_audit.preprocessing.torque_source import CHANNELS, Plan, with_a_model
from friction_audit.robot import STANDARD_GRAVITY, check_urdf

SIGNS = {"hand": -1, "robot": 1}
"""Factor on tau_J and on tau_ext in the balance of each row."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Balance:
    """One row of the balance: F_m = sign * (source - each of the torques removed)."""

    drive: str
    sign: int
    inertia: bool
    logged: Float | None
    modelled: GridTorque | None
    evidence: tuple[SignEvidence, ...] = ()

    @property
    def proved(self) -> bool:
        """True if the energy rises on most of the moving joints."""
        return most(self.evidence, "rises")

    def coarse(self, log: JointLog, coarse: CoarseLog, source: Float) -> Float:
        """Make the torque of all joints at the coarse log's times, for the proof of the sign."""
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


def formula(plan: Plan, balance: Balance) -> str:
    """Return the balance in words, for people."""
    if plan.source != "tau_J":
        return f"F_m = {'-' if balance.sign < 0 else ''}{CHANNELS[plan.source]}"
    removed = [name for name, there in (("M ddq", balance.inertia), ("c", balance.inertia)) if there]
    removed += ["g"] if plan.gravity != "none" else []
    inside = "" if plan.gravity != "none" else ", gravity still inside"
    if balance.drive == "hand":
        return f"F_m = {''.join(f'{name} ' for name in removed)}-{' ' if removed else ''}tau_J{inside}"
    listed = " + ".join(removed)
    return "F_m = tau_J" + (f" - ({listed})" if len(removed) > 1 else f" - {listed}" if removed else "") + inside


def not_used(
    log: JointLog, plan: Plan, balance: Balance, settings: TorqueSettings, *, hand: bool
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
        f"{', '.join(unused)}: not used: {formula(plan, balance)} needs no model of the arm; leave it away{instead}"
    )
    return (Caution(code="model_not_used", message=message),)


def sign_cautions(
    log: JointLog, plan: Plan, balance: Balance, settings: TorqueSettings, *, turned: bool
) -> tuple[Caution, ...]:
    """Say what the energy tells about the sign, and what is still in the torque."""
    found = []
    if turned:
        found.append(_turned(log, plan, balance, settings))
    if most(balance.evidence, "falls"):
        found.append(_contradicted(log, plan, balance, settings))
    elif not balance.proved and voting(balance.evidence):
        found.append(
            Caution(
                code="sign_unproved",
                message=f"the energy of most joints neither rises nor falls beyond its noise, so nothing proves "
                f"{formula(plan, balance)}; record more strokes in both directions, or make sure of --drive",
            )
        )
    if inertia_left(log, plan, balance):
        # Where gravity is left too, its caution has the commands.
        advice = "" if plan.gravity == "none" else f"; {with_a_model(log, replace(settings, inertia='auto'))}"
        found.append(
            Caution(
                code="inertia_in_torque",
                message="the arm moves by itself and its inertial and Coriolis torque is still in F_m; joints that "
                f"move together spoil each other's energy{advice}",
            )
        )
    return (*found, *_disagreeing(balance.evidence))


def inertia_left(log: JointLog, plan: Plan, balance: Balance) -> bool:
    """Return True if joints that move together leave inertial and Coriolis torque in F_m."""
    several = log.q.shape[1] > 1
    return several and balance.drive == "robot" and plan.source == "tau_J" and not balance.inertia


def _contradicted(log: JointLog, plan: Plan, balance: Balance, settings: TorqueSettings) -> Caution:
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
        f"with {formula(plan, balance)}{row} the net energy falls on most of the moving joints, "
        f"which friction cannot do{tried}; perhaps {wrong}"
    )
    return Caution(code="sign_contradicts_drive", message=message)


def _turned(log: JointLog, plan: Plan, balance: Balance, settings: TorqueSettings) -> Caution:
    if plan.source == "interaction":
        text = "the interaction torque as logged makes the net energy fall; its sign was turned"
    else:
        model = "none" if plan.arm is None else settings.robot
        robot, hand = (settings.command(log.source.path, drive=drive, robot=model) for drive in ("robot", "hand"))
        text = (
            "with the hand's balance the net energy does not rise, with the robot's it does: the arm moved by itself, "
            f"so {formula(plan, balance)}; to say so: {robot}; to keep the other: {hand}"
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
