"""The part of a joint model that a simulator can hold: friction as a polynomial of the velocity, up to its third power.

What a model has beyond that is fitted over the speeds of the joint by non-negative least squares (Lawson, Hanson,
Solving Least Squares Problems, 1974, chapter 23), so that the simulated joint dissipates at every speed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.errors import AnalysisError, UsageError
from friction_audit.joint_log import Float

SPEEDS = 200  # at which a curve is fitted, many more than its four coefficients
SLOWEST = 1e-9  # rad/s: the speed at which friction at the onset of motion is read
POWERS = (0, 1, 2, 3)
DIGITS = 9  # of a number in a file, more than any log determines


@dataclass(frozen=True, kw_only=True, slots=True)
class FittedFriction:
    """Friction of a joint as a polynomial of the speed: sgn(dq) (c_0 + c_1 |dq| + c_2 dq^2 + c_3 |dq|^3)."""

    coefficients: tuple[float, ...]  # c_0 [N m] to c_3 [N m s^3/rad^3]
    error_nm: float  # root mean square of the law less the polynomial over the speeds of the fit
    error_share: float  # the same over the root mean square of the law


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
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
        way = np.clip(dq / sign_width, -1.0, 1.0) if sign_width > 0.0 else None
        still = np.zeros_like(dq)
        motion = Motion(t=still, q=still, dq=dq, ddq=still, way=way)
        return np.asarray(np.sum([term.torque(motion) for term in self.terms], axis=0))

    def fit(self, highest_power: int) -> FittedFriction:
        """Fit a polynomial of the speed; its highest power is 1 for Coulomb and viscous friction alone, up to 3."""
        from scipy.optimize import nnls

        torque = self.torque(self.speeds)
        columns = self.speeds[:, None] ** np.array(POWERS[: highest_power + 1])
        scale = np.abs(columns).max(axis=0)
        fitted, _ = nnls(columns / scale, torque)
        fitted[fitted < np.finfo(float).eps * SPEEDS * np.max(np.abs(torque))] = 0.0  # rounding, no coefficient
        found = np.zeros(len(POWERS))
        found[: highest_power + 1] = fitted / scale
        size, error = (float(np.sqrt(np.mean(values**2))) for values in (torque, torque - columns @ (fitted / scale)))
        error = error if error > np.finfo(float).eps * SPEEDS * size else 0.0
        share = error / size if size > 0.0 else 0.0
        return FittedFriction(coefficients=tuple(found.tolist()), error_nm=error, error_share=share)


def friction_law(joint: int, name: str, model: JointModel, speeds: Float, *, armature: bool) -> FrictionLaw:
    """Return the friction law of a joint's model over speeds; ``armature``: its inertia is the motor's, reflected."""
    terms = tuple(term for term in model.terms if term.effect.friction and term.effect.speed_only)
    if not terms:
        raise AnalysisError(f"joint {joint} ({name}): its model has no friction that follows from the velocity")
    left_out = tuple(term.name for term in model.terms if term not in terms)
    inertia = model.inertia_kg_m2 if armature and model.inertia_kg_m2 > 0.0 else None
    law = FrictionLaw(joint=joint, name=name, terms=terms, left_out=left_out, inertia_kg_m2=inertia, speeds=speeds)
    lowest = float(np.min(law.torque(speeds)))
    if lowest < 0.0:
        where = float(speeds[np.argmin(law.torque(speeds))])
        what = f"friction is {lowest:.3g} N m at {where:.3g} rad/s; expected none below zero"
        raise AnalysisError(f"joint {joint} ({name}): {what}; give speeds that the log holds (--speeds LOW,HIGH)")
    return law


def even_speeds(low: float, high: float) -> Float:
    """Return evenly spaced speeds of a fit, shape (n,). [rad/s]"""
    return np.linspace(max(low, SLOWEST), high, SPEEDS)  # at rest there is no friction to fit


def moving_speeds(dq: Float, slowest: float) -> Float:
    """Return speeds of a log that each stand for an equal share of its moving time, shape (n,). [rad/s]"""
    pace = np.abs(dq[np.isfinite(dq)])
    moving = pace[pace > slowest]
    if not len(moving):
        return even_speeds(slowest, 1.0)
    return np.quantile(moving, (np.arange(SPEEDS) + 0.5) / SPEEDS)


@dataclass(frozen=True, eq=False, slots=True)
class ExportedJoint:
    """One joint as it is written."""

    name: str  # its name in the file
    law: FrictionLaw  # its friction law
    fitted: FittedFriction  # the law as the target holds it

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


def match_names(laws: Sequence[FrictionLaw], count: int, found: Sequence[str], where: str) -> tuple[list[str], bool]:
    """Return the names in the user's file, of ``count`` joints in the source, and whether the order gave them."""
    own = [law.name for law in laws]
    if all(name in found for name in own):
        return own, False
    # A log numbers its joints where it does not name them: the k-th joint is the k-th of a serial arm.
    if not any(name in found for name in own) and count == len(found):
        return [found[law.joint - 1] for law in laws], True
    absent = ", ".join(name for name in own if name not in found)
    raise UsageError(
        f"{where}: no joint {absent}; its {len(found)} joints that turn are {', '.join(found) or 'none'}, "
        f"the source has {count}; rename the joints of the source, or export those that the file has (--joints)"
    )
