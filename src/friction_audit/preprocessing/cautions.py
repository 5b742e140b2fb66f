"""Cautions about the interaction torque: its sign, unused options, and gravity or offsets that are left in it."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from friction_audit.joint_log import Float, JointLog
from friction_audit.preprocessing.balance import Balance
from friction_audit.preprocessing.interaction import Caution
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.preprocessing.sign import CoarseLog, most, strokes_of, voting
from friction_audit.preprocessing.torque_source import with_a_model
from friction_audit.robot import STANDARD_GRAVITY, check_urdf

# An identified model errs by a few tenths of a newton metre, the vendor's by up to two on the heaviest joints; a
# forgotten hand makes two to three.
LARGEST_NM = 1.5
LEAST_RANGE_RAD = 0.3  # over less, gravity looks like an offset or a spring
LEAST_ACROSS = 0.1  # share of gravity across an axis below which it is vertical: a payload does not load it
LEAST_STROKES = 10
ENOUGH = 20_000  # means of 20 ms; more add nothing about what changes with the position alone
SIGNIFICANCE = 0.01


def not_used(log: JointLog, balance: Balance, settings: TorqueSettings, *, hand: bool) -> tuple[Caution, ...]:
    """Name options about the arm that change nothing, because the torque needs no model of it."""
    known, modelled = balance.plan.arm is not None, balance.modelled is not None
    if settings.urdf is not None and not known:
        check_urdf(settings.urdf)  # a file that is no arm is refused though it is not used
    given = (
        ("--payload", settings.payload is not None and not modelled),
        # Even with logged gravity the direction of gravity is the model's.
        ("--urdf", settings.urdf is not None and not (known or hand)),
        ("--gravity-vector", settings.gravity_vector != STANDARD_GRAVITY and not known),
    )
    unused = [option for option, idle in given if idle]
    if not unused:
        return ()
    instead = "" if log.tau_J is None else ", or ask for the model with --torque tau_J --gravity model"
    message = f"{', '.join(unused)}: not used: {balance.formula} needs no model of the arm; remove the option{instead}"
    return (Caution(code="model_not_used", message=message),)


def sign_cautions(log: JointLog, balance: Balance, settings: TorqueSettings, *, turned: bool) -> Iterator[Caution]:
    """Say what the energy shows about the sign, and that inertia is still in the torque."""
    evidence = balance.evidence
    if turned:
        yield Caution(code="sign_turned", message=_turned(balance))
    if most(evidence, "falls"):
        yield Caution(code="sign_contradicts_drive", message=_contradicted(log, balance, settings))
    elif not balance.proved and voting(evidence):
        message = (
            f"the sign of {balance.formula} is undecided: the net energy of most joints neither rises nor falls "
            "significantly; move back and forth more often, or give --drive"
        )
        yield Caution(code="sign_unproved", message=message)
    if balance.inertia_left:
        # Where gravity is left too, its caution has the commands.
        model = with_a_model(log, replace(settings, inertia="auto"))
        advice = "" if balance.plan.gravity == "in-torque" else f"; {model}"
        message = (
            "inertial and Coriolis torques of the robot's own motion are in F_m: inertial coupling between moving "
            f"joints biases the energy balance{advice}"
        )
        yield Caution(code="inertia_in_torque", message=message)
    minority = "falls" if balance.proved else "rises" if most(evidence, "falls") else ""
    for one in voting(evidence):
        if one.verdict == minority:
            message = (
                f"its net energy {one.verdict} ({one.against_motion_nm:.2f} ± {one.standard_error_nm:.2f} N m against "
                "the motion), that of most joints does not: its gravity, payload or inertia is wrong"
            )
            yield Caution(code="sign_disagrees", message=message, joint=one.joint)


def _contradicted(log: JointLog, balance: Balance, settings: TorqueSettings) -> str:
    """Say what may be wrong where the energy falls: it depends on what the user left open."""
    plan, causes = balance.plan, []
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
    return (
        f"with {balance.formula}{row} the net energy falls on most of the moving joints, "
        f"which friction cannot do{tried}; perhaps {wrong}"
    )


def _turned(balance: Balance) -> str:
    if balance.plan.source == "interaction":
        return "torque sign flipped: with the logged sign the net energy falls"
    return (
        f"detected: the robot's motors move the arm (--drive robot), {balance.formula}; with --drive hand the net "
        "energy does not rise"
    )


def gravity_cautions(
    log: JointLog,
    coarse: CoarseLog,
    balance: Balance,
    columns: list[int],
    direction: Float | None,
) -> tuple[Caution, ...]:
    """Say on which joints gravity or an offset is left in the torque, unless gravity is declared to be inside.

    The constants of a gravity error are ill-determined over a short range: two of hundreds of newton metres may cancel.
    What a log determines is their torque over the range that the joint moved, and whether it depends on the position.

    Args:
        log: The log.
        coarse: Its means.
        balance: The row of the balance.
        columns: Selected joints, 0-based.
        direction: Direction of gravity across their axes at the means, shape (m, len(columns), 2), or None.
    """
    gravity = balance.plan.gravity
    mixed = not balance.proved or balance.inertia_left
    if gravity == "in-torque" or mixed or log.source.torque_unit != "N m":
        return ()
    torque, found = balance.driving(log, coarse), []
    for place, column in enumerate(columns):
        if column + 1 not in log.source.dead_torque:
            left = _left(coarse, torque[:, column], None if direction is None else direction[:, place], column)
            found += [] if left is None else [(column, *left)]
    several = sum(rms > friction for _, _, rms, _, friction, _ in found) > 1
    return tuple(_left_caution(column + 1, left, gravity if several else "") for column, *left in found)


def _left(
    coarse: CoarseLog, torque: Float, direction: Float | None, column: int
) -> tuple[float, float, float, float, bool] | None:
    """Return mean and rms of what is left, range moved, Coulomb friction, and whether gravity shows; None if little."""
    moving, way, stroke = strokes_of(coarse, column)
    if not stroke.size or stroke[-1] + 1 < LEAST_STROKES:
        return None
    rows = np.flatnonzero(moving)
    thin = slice(None, None, max(len(rows) // ENOUGH, 1))
    rows, way = rows[thin], way[thin]
    q, dq = coarse.q[rows, column], coarse.dq[rows, column]
    ddq = np.gradient(coarse.dq[:, column], coarse.t)[rows]
    across = np.column_stack([np.sin(q), np.cos(q)]) if direction is None else direction[rows]
    plain = np.column_stack([way, dq, ddq, np.ones(len(q))])
    coefficients, square, square_plain = _fit(plain, across, torque[rows])
    at_rest = coefficients[3] + across @ coefficients[4:]
    wide = np.ptp(q) >= LEAST_RANGE_RAD and float(np.hypot(*across.T).max()) >= LEAST_ACROSS
    # Strokes are independent, not samples.
    by_position = bool(wide and _significant(square_plain, square, int(stroke[-1] + 1) - len(coefficients)))
    mean, rms = float(at_rest.mean()), float(np.sqrt(np.mean(at_rest**2)))
    if (rms if by_position else abs(mean)) <= LARGEST_NM:
        return None
    return mean, rms, float(np.ptp(q)), abs(float(coefficients[0])), by_position


def _significant(without: float, with_gravity: float, freedom: int) -> bool:
    """F test of the two columns of gravity."""
    from scipy.special import fdtrc

    ratio = (without - with_gravity) / 2.0 / max(with_gravity / freedom, np.finfo(float).tiny)
    return bool(fdtrc(2.0, freedom, max(ratio, 0.0)) < SIGNIFICANCE)


def _fit(plain: Float, across: Float, torque: Float) -> tuple[Float, float, float]:
    """Return the coefficients of all columns, and the sums of squares that these and the plain ones alone leave."""
    columns = np.column_stack([plain, across])
    scale = np.linalg.norm(columns, axis=0).clip(min=np.finfo(float).tiny)
    # Both fits on the triangular factor: a decomposition of all samples takes most of the time.
    triangle = np.asarray(np.linalg.qr(np.column_stack([columns / scale, torque]), "r"), np.float64)
    fits = []
    for count in (columns.shape[1], plain.shape[1]):
        design, right = triangle[:, :count], triangle[:, -1]
        coefficients = np.linalg.lstsq(design, right, rcond=1e-8)[0]
        fits.append((coefficients, float(np.sum((right - design @ coefficients) ** 2))))
    (coefficients, square), (_, square_plain) = fits
    return coefficients / scale, square, square_plain


def _left_caution(joint: int, left: list[float], gravity: str) -> Caution:
    mean, rms, moved, _, by_position = left
    if not by_position:
        message = (
            f"constant torque of {mean:.1f} N m that is not friction; over {moved:.2g} rad a sensor offset cannot be "
            "separated from gravity"
        )
        return Caution(code="torque_offset", joint=joint, message=message)
    cause = {
        "model": ", of several joints: the model lacks the payload (--payload MASS,X,Y,Z), or the arm is another",
        "logged": ", of several joints: the payload was probably not set on the robot",
    }.get(gravity, "; check the gravity that was removed, and its direction")
    message = f"gravity of at least {rms:.1f} N m rms over {moved:.2g} rad is left in the torque{cause}"
    return Caution(code="gravity_error", joint=joint, message=message)
