"""What the user must know about the torque and its sign."""

from dataclasses import replace

from friction_audit.interaction.balance import Balance, formula
from friction_audit.interaction.interaction import Caution, SignEvidence
from friction_audit.interaction.plan import Plan, with_a_model
from friction_audit.interaction.settings import TorqueSettings
from friction_audit.interaction.sign import most, voting
from friction_audit.joint_log import JointLog
from friction_audit.robot import STANDARD_GRAVITY, check_urdf


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
