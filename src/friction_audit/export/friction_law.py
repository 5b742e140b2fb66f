"""The part of joint models that a simulator can hold: friction as a polynomial of the velocity, up to its third power.

The models are those of a file, of a document of an estimate or a batch, of their folder, or of a log. What a model has
beyond the polynomial is fitted over the speeds of the joint by non-negative least squares (Lawson, Hanson, Solving
Least Squares Problems, 1974, chapter 23), so that the simulated joint dissipates at every speed.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isclose
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from friction_audit.drift.session import COEFFICIENTS
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import SpeedFriction
from friction_audit.effects.joint_model import FittedTerm, JointModel, load_model, simple_model
from friction_audit.errors import AnalysisError, InputError, UsageError
from friction_audit.friction.history import NAN, UNDETERMINED, Coefficient
from friction_audit.io.files import read_document
from friction_audit.joint_log import Float
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.interaction import Reason, quoted, reason_of

POINTS = 200  # speeds at which a curve is fitted, many more than its four coefficients
SLOWEST = 1e-9  # rad/s: the speed at which friction at the onset of motion is read
POWERS = (0, 1, 2, 3)
DIGITS = 9  # of a number in a file, more than any log determines
SPEEDS = (0.01, 1.0)  # rad/s: of a file without a log, from the slowest motion that counts to that of a hand
MODEL, ESTIMATE, BATCH, LEDGER = "model.toml", "estimate.json", "batch.json", ".sqlite"
FOUND = ("inertia_kg_m2", *COEFFICIENTS)
OTHERWISE = f"of `diagnose`, give the {MODEL} that it writes with --output"


@dataclass(frozen=True, kw_only=True, slots=True)
class FittedFriction:
    """Friction of a joint as a polynomial of the speed: sgn(dq) (c_0 + c_1 |dq| + c_2 dq^2 + c_3 |dq|^3)."""

    coefficients: tuple[float, ...]  # c_0 [N m] to c_3 [N m s^3/rad^3]
    error_nm: float  # root mean square of the law less the polynomial over the speeds of the fit
    error_share: float  # the same over the root mean square of the law


@dataclass(frozen=True, eq=False, slots=True)
class FrictionLaw:
    """Friction of one joint as a function of its velocity."""

    joint: int  # number of the joint, 1..n
    name: str  # its name in the log or in the model's file
    terms: tuple[FittedTerm, ...]  # terms of the joint's model that follow from the velocity and are dissipated
    left_out: tuple[str, ...]  # names of its other terms
    # inertia of the joint's model, or None where it is not the reflected inertia of the motor
    inertia_kg_m2: float | None
    speeds: Float  # speeds over which the law is to hold, shape (n,), none below zero [rad/s]

    def torque(self, dq: Float, sign_width: float = 0.0) -> Float:
        """Return the friction torque at velocities, shape (n,): what a drive pays for it, 0 at rest. [N m]"""
        direction = np.clip(dq / sign_width, -1.0, 1.0) if sign_width > 0.0 else None
        still = np.zeros_like(dq)
        motion = Motion(t=still, q=still, dq=dq, ddq=still, smooth_direction=direction)
        return np.asarray(np.sum([term.torque(motion) for term in self.terms], axis=0))

    def fit(self, highest_power: int | None) -> FittedFriction:
        """Fit a polynomial of the speed; its highest power is 1 for Coulomb and viscous friction alone, up to 3.

        None is for a file that holds the law itself: its own Coulomb and viscous friction.
        """
        if highest_power is None:
            own = {term.name: term.values[0] for term in self.terms}
            ends = (own.get("coulomb", 0.0), own.get("viscous", 0.0), 0.0, 0.0)
            return FittedFriction(coefficients=ends, error_nm=0.0, error_share=0.0)
        from scipy.optimize import nnls

        torque = self.torque(self.speeds)
        columns = self.speeds[:, None] ** np.array(POWERS[: highest_power + 1])
        scale = np.abs(columns).max(axis=0)
        fitted, _ = nnls(columns / scale, torque)
        fitted[fitted < np.finfo(float).eps * POINTS * np.max(np.abs(torque))] = 0.0  # rounding, no coefficient
        found = np.zeros(len(POWERS))
        found[: highest_power + 1] = fitted / scale
        size, error = (float(np.sqrt(np.mean(values**2))) for values in (torque, torque - columns @ (fitted / scale)))
        error = error if error > np.finfo(float).eps * POINTS * size else 0.0
        share = error / size if size > 0.0 else 0.0
        return FittedFriction(coefficients=tuple(found.tolist()), error_nm=error, error_share=share)


class SourceJoint(NamedTuple):
    """One joint of a source: its model, or the coefficients of an estimate by ``FOUND``, or why it has neither."""

    number: int  # 1..n
    name: str
    known: JointModel | Mapping[str, Coefficient]
    reason: Reason = ()  # empty where it has friction

    @property
    def found(self) -> Mapping[str, Coefficient]:
        """Coefficients with their intervals; empty for a model, which has none."""
        return {} if isinstance(self.known, JointModel) else self.known


def friction_law(joint: SourceJoint, speeds: Float, *, armature: bool) -> FrictionLaw:
    """Return the friction law of a joint over speeds; ``armature``: its inertia is the motor's, reflected.

    Where an estimate has found Coulomb or viscous friction below zero, both are fitted anew over the speeds.
    """
    if joint.reason:
        raise AnalysisError(joint.reason)
    model, where = joint.known, f"joint {joint.number} ({joint.name})"
    if not isinstance(model, JointModel):
        own, *friction = np.nan_to_num([model[name].value for name in FOUND]).tolist()
        if min(friction) < 0.0:
            from scipy.optimize import nnls

            columns = speeds[:, None] ** np.array(POWERS[:2])
            friction = nnls(columns, columns @ friction)[0].tolist()
        model = simple_model(inertia_kg_m2=own, coulomb_nm=friction[0], viscous_nms_per_rad=friction[1])
    terms = tuple(term for term in model.terms if isinstance(term.effect, SpeedFriction))
    if not terms:
        raise AnalysisError(f"{where}: its model has no friction that follows from the velocity")
    left_out = tuple(term.name for term in model.terms if term not in terms)
    inertia = model.inertia_kg_m2 if armature and model.inertia_kg_m2 > 0.0 else None
    law = FrictionLaw(joint.number, joint.name, terms, left_out, inertia, speeds)
    torque = law.torque(speeds)
    if (lowest := float(torque.min())) < 0.0:
        what = f"friction is {lowest:.3g} N m at {speeds[torque.argmin()]:.3g} rad/s; expected none below zero"
        raise AnalysisError(f"{where}: {what}; give speeds that the log holds (--speeds LOW,HIGH)")
    return law


def even_speeds(low: float, high: float) -> Float:
    """Return evenly spaced speeds of a fit, shape (n,). [rad/s]"""
    return np.linspace(max(low, SLOWEST), high, POINTS)  # at rest there is no friction to fit


def moving_speeds(dq: Float) -> Float:
    """Return speeds of a log that each stand for an equal share of its moving time, shape (n,). [rad/s]"""
    speed = np.abs(dq[np.isfinite(dq)])
    moving = speed[speed > SPEEDS[0]]
    return np.quantile(moving, (np.arange(POINTS) + 0.5) / POINTS) if len(moving) else even_speeds(*SPEEDS)


@dataclass(frozen=True, eq=False, slots=True)
class ExportedJoint:
    """One joint as it is written."""

    name: str  # its name in the file
    law: FrictionLaw  # its friction law
    fitted: FittedFriction  # the law as the target holds it
    # what the source found, by ``FOUND``; empty for a model, which has no intervals
    found: Mapping[str, Coefficient]

    @property
    def written(self) -> dict[str, Coefficient]:
        """Numbers by ``FOUND`` as they are written, with the intervals of the source where it has some."""
        inertia = self.law.inertia_kg_m2
        values = (NAN if inertia is None else inertia, *self.fitted.coefficients[:2])
        pairs = ((name, self.found.get(name, UNDETERMINED), value) for name, value in zip(FOUND, values, strict=True))
        # An interval is that of the number that was found: not of a zero in its place, nor of what is fitted with it.
        return {n: replace(one if isclose(one.value, value) else UNDETERMINED, value=value) for n, one, value in pairs}

    @property
    def static_nm(self) -> float:
        """Friction at the onset of motion, with what Stribeck adds; a simulator wants no less than in motion. [N m]"""
        return max(float(self.law.torque(np.array([SLOWEST]))[0]), self.fitted.coefficients[0])

    @property
    def damping(self) -> list[float]:
        """Coefficients of dq, dq |dq| and dq^3 as MuJoCo 4 takes them; where the first is enough, as every version."""
        found = list(self.fitted.coefficients[1:])
        while len(found) > 1 and found[-1] == 0.0:
            found.pop()
        return found


def number(value: float) -> str:
    """Return a number as text."""
    return f"{value:.{DIGITS}g}"


def match_names(laws: Sequence[FrictionLaw], joints: int, found: Sequence[str], where: str) -> tuple[list[str], bool]:
    """Return the names in the user's file, of so many joints in the source, and whether the order gave them."""
    own = [law.name for law in laws]
    if all(name in found for name in own):
        return own, False
    # A log numbers its joints where it does not name them: the k-th joint is the k-th of a serial arm.
    if not any(name in found for name in own) and joints == len(found):
        return [found[law.joint - 1] for law in laws], True
    absent = ", ".join(name for name in own if name not in found)
    raise UsageError(
        f"{where}: no joint {absent}; its {len(found)} joints that turn are {', '.join(found) or 'none'}, "
        f"the source has {joints}; rename the joints of the source, or export those that the file has (--joints)"
    )


class Joints(NamedTuple):
    """What a source says of its joints."""

    every: tuple[SourceJoint, ...]
    reflected: bool | None  # whether the inertias are the reflected ones of the motors; None if not known


def result_file(source: Path) -> Path | None:
    """Return the file of results that a source is or holds; None for a log."""
    if source.is_dir():
        return next((source / name for name in (MODEL, ESTIMATE, BATCH) if (source / name).is_file()), None)
    if source.suffix.lower() == LEDGER:
        return source.with_name(BATCH)  # which holds the reference that its sessions were compared with
    return source if source.suffix.lower() in (".toml", ".json") else None


def read_result(path: Path, arm: str | None = None) -> Joints:
    """Read a model file, or the document of an estimate or of a batch, of which the reference of an arm is taken."""
    is_model = path.suffix.lower() == ".toml"
    document = {} if is_model else read_document(path, ("estimate", "batch"), OTHERWISE)
    is_batch = str(document.get("schema")).startswith("friction-audit/batch/")
    if arm is not None and not is_batch:
        raise UsageError(f"--arm {arm}: {path} is no document of batch-report and holds one arm; leave the option out")
    if is_model:
        arm_model = load_model(path)
        lacking = quoted("no model in the file")
        known = zip(arm_model.names, arm_model.joints, strict=True)
        every = (SourceJoint(k, name, one or {}, () if one else lacking) for k, (name, one) in enumerate(known, 1))
        return Joints(tuple(every), reflected=None)
    try:
        return _of_batch(document, path, arm) if is_batch else _of_document(document, path)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        command = "batch-report" if is_batch else "estimate"
        raise InputError(f"{path}: is no whole document of `{command}` ({error!r}); write it again") from error


def of_estimate(estimate: Estimate) -> Joints:
    """Return the coefficients of an estimate: inertia, Coulomb and viscous friction."""
    choice, rows = estimate.interaction.choice, []
    for one in estimate.friction.joints:
        inertia = UNDETERMINED if one.regression is None else one.regression.inertia
        rows.append((one.joint, one.name, (inertia, one.coulomb, one.viscous), one.reason))
    return _joints(rows, choice.drive, choice.inertia)


def laws_of(
    joints: Joints, speeds: Mapping[int, Float], usual: Float, *, wanted: Sequence[int] | None, armature: bool
) -> tuple[list[FrictionLaw], list[tuple[int, Reason]]]:
    """Return the friction laws of the joints wanted, each over its speeds, and number and reason of those without."""
    numbers = [one.number for one in joints.every]
    if absent := ", ".join(str(number) for number in wanted or () if number not in numbers):
        raise UsageError(f"--joints {absent}: not in the source; its joints are {', '.join(map(str, numbers))}")
    laws, lacking = [], []
    for one in (one for one in joints.every if wanted is None or one.number in wanted):
        try:
            laws.append(friction_law(one, speeds.get(one.number, usual), armature=armature))
        except AnalysisError as error:
            lacking.append((one.number, reason_of(error)))
    if not laws:
        raise AnalysisError("no joint has friction to export:", lacking)
    return laws, lacking


def _of_document(document: Mapping[str, Any], path: Path) -> Joints:
    chosen, unit = document["settings"]["torque_chosen"], str(document["source"].get("torque_unit", "N m"))
    if unit != "N m":
        raise UsageError(f"{path}: its torque is in {unit}; expected N m; estimate again with --torque-constant")
    rows = []
    for one in document["joints"]:
        fitted = one["regression"] or {"inertia_kg_m2": None}
        inertia = {"value": fitted["inertia_kg_m2"], "ci95": fitted.get("inertia_kg_m2_ci95")}
        found = [Coefficient.read(each) for each in (inertia, *(one[name] for name in COEFFICIENTS))]
        rows.append((int(one["joint"]), str(one["name"]), found, quoted(str(one["reason"] or ""))))
    return _joints(rows, chosen["drive"], chosen["inertia"])


def _of_batch(document: Mapping[str, Any], path: Path, arm: str | None) -> Joints:
    """Return the levels in the reference of an arm, which hold no inertia."""
    arms = [str(one["robot"]) for one in document["robots"]]
    chosen = arms[0] if arm is None and len(arms) == 1 else arm
    if chosen not in arms:
        asked = f"no arm {arm}" if arm else f"{len(arms)} arms"
        raise UsageError(f"{path}: {asked}; it holds {', '.join(arms)}; choose one with --arm")
    rows = []
    for one in (one for one in document["joints"] if one["robot"] == chosen):
        levels = [Coefficient.read(one["coefficients"].get(name, {}).get("level")) for name in COEFFICIENTS]
        lacking = all(np.isnan(level.value) for level in levels)
        reason = quoted("no session of the reference has its friction" if lacking else "")
        rows.append((int(one["joint"]), str(one["name"]), (UNDETERMINED, *levels), reason))
    return _joints(rows, "robot", "none")


def _joints(rows: Iterable[tuple[int, str, Sequence[Coefficient], Reason]], drive: str, inertia: str) -> Joints:
    """Return the joints of an estimate.

    Their inertia is that of the motor alone where a person drives the link, for then the sensor is between the two, and
    where a rigid-body model has taken the inertia of the links out.
    """
    every = (SourceJoint(number, name, dict(zip(FOUND, found, strict=True)), why) for number, name, found, why in rows)
    return Joints(tuple(every), reflected=drive == "hand" or inertia == "model")
