"""The joint as a log shows it, for counterfactuals in which it moves otherwise than recorded."""

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.closed_loop import Recorded
from friction_audit.compensation.settings import OperatorImpedance
from friction_audit.friction.history import Coefficient, JointFriction, TorqueRegression
from friction_audit.joint_log import Float, median_step

LEAST_INERTIA_KG_M2 = 1e-3  # no motor with its gear has less; what seems to was recorded without its inertia


def fit_joint(friction: JointFriction) -> TorqueRegression | str:
    """Return inertia and friction as the torque regression of the log found them, or why they cannot be simulated."""
    if friction.reason:
        return friction.reason
    found = friction.regression
    if found is None:
        return "too few moving samples or motions to fit inertia and friction; record more motions back and forth"
    if not (found.inertia.low > 0.0 and found.inertia.value > LEAST_INERTIA_KG_M2):
        one = found.inertia
        value = f"{one.value:.3g}, 95 % {one.low:.3g} to {one.high:.3g}" if isfinite(one.value) else "no value"
        return (
            f"its inertia is not determined ({value} kg m^2), and without it the motion cannot "
            "be predicted; record brisker motions with quick reversals, or use --assume same-motion"
        )
    pushing = [name for name, one in (("Coulomb", found.coulomb), ("viscous", found.viscous)) if not one.high > 0.0]
    if pushing:
        return f"its fitted {' and '.join(pushing)} friction is negative; a joint that pushes cannot be simulated"
    return found


BAND_HZ = (3.0, 15.0)  # above what a person intends, below where sensors show noise only
ORDER = 2
BEFORE_S, AFTER_S = 0.1, 0.25  # window around a reversal
DEFINITE_RAD_S = 0.05  # speed at which the direction is certain
LONGEST_TURN_S = 0.12  # a reversal that takes longer is a pause
FEWEST_REVERSALS = 20
WIDEST = 0.3  # relative half-width of the interval from the reversals alone, beyond which a number is not determined
# Error of inertia, damping and stiffness over their values that 95 % of persons stay below whose log has no noise, by
# what they intend above the lower end of the band: 47 simulated persons, none of whom is in ``bench_operator_fit``.
INTENTION = (0.06, 0.07, 0.21)
# The rate must be above the band by this, and above twice the 20 Hz that reversals are found below.
LEAST_PERIODS = 2.75
NORMAL_95 = 1.96
TYPICAL = "an adult's arm, at a joint half a metre from the hand: --operator 0.3,9,60 (0.1 to 0.6, 3 to 15, 20 to 150)"


@dataclass(frozen=True, kw_only=True, slots=True)
class FittedOperator:
    """Impedance of the person with its 95 % intervals; given ones have none."""

    inertia: Coefficient
    damping: Coefficient
    stiffness: Coefficient
    reversals: int = 0  # reversals it rests on; 0 if it was given


def given_operator(given: OperatorImpedance) -> FittedOperator:
    """Return an impedance that the user gave."""
    numbers = (given.inertia_kg_m2, given.damping_nms_per_rad, given.stiffness_nm_per_rad)
    inertia, damping, stiffness = (Coefficient(value=n, low=float("nan"), high=float("nan")) for n in numbers)
    return FittedOperator(inertia=inertia, damping=damping, stiffness=stiffness)


def fit_operator(recorded: Recorded, q: Float) -> FittedOperator | str:
    """Fit the person's impedance at one joint, of position q, or return why the log does not determine it."""
    from scipy.signal import butter, sosfiltfilt

    step = median_step(recorded.t)
    if step * LEAST_PERIODS * BAND_HZ[1] > 1.0:
        return f"{1.0 / step:.3g} samples per second are too few to see the person's arm give way; give {TYPICAL}"
    t = np.arange(recorded.t[0], recorded.t[-1], step)
    dq = np.interp(t, recorded.t, recorded.dq)
    turns, direction = _reversals(dq, step)
    before, after = int(BEFORE_S / step), int(AFTER_S / step)
    inside = (turns >= before) & (turns + after <= len(t))
    turns, direction = turns[inside], direction[inside]
    if len(turns) < FEWEST_REVERSALS:
        return (
            f"the person's impedance cannot be estimated from this log: {len(turns)} quick reversals, at least "
            f"{FEWEST_REVERSALS} are needed; record motions back and forth without pauses, or give {TYPICAL}"
        )
    rows = turns[:, None] + np.arange(-before, after)
    torque, place = (np.interp(t, recorded.t, one) for one in (recorded.torque, q))
    band = butter(ORDER, BAND_HZ, "band", fs=1.0 / step, output="sos")
    signals = (np.gradient(dq, step), dq, place, -torque)
    windows = np.stack([sosfiltfilt(band, signal)[rows] * direction[:, None] for signal in signals], axis=2)
    return _solve(windows)


def _reversals(dq: Float, step: float) -> tuple[NDArray[np.int64], Float]:
    """Return the samples at which motion is under way again after a quick reversal, and its direction then."""
    from scipy.signal import butter, sosfiltfilt

    smooth = sosfiltfilt(butter(ORDER, 20.0, fs=1.0 / step, output="sos"), dq)
    definite = np.flatnonzero(np.abs(smooth) > DEFINITE_RAD_S)
    direction = np.sign(smooth[definite])
    turned = np.flatnonzero(np.diff(direction) != 0.0)
    quick = np.diff(definite)[turned] * step < LONGEST_TURN_S
    return definite[turned + 1][quick], direction[turned + 1][quick]


def _solve(windows: Float) -> FittedOperator | str:
    """Solve for inertia, damping and stiffness, with a jackknife over the reversals.

    ``windows`` are acceleration, velocity, position and minus the torque around r reversals, shape (r, w, 4).
    """
    count = len(windows)
    total = windows.sum(axis=0)

    def solve(mean: Float) -> Float:
        return np.asarray(np.linalg.lstsq(mean[:, :3], mean[:, 3], rcond=None)[0])

    value = solve(total / count)
    others = np.array([solve((total - one) / (count - 1)) for one in windows])
    spread = (count - 1) / count * ((others - others.mean(axis=0)) ** 2).sum(axis=0)
    unsure = NORMAL_95 * np.sqrt(spread)
    half = np.hypot(unsure, np.array(INTENTION) * value)
    found = [Coefficient(value=float(v), low=float(v - h), high=float(v + h)) for v, h in zip(value, half, strict=True)]
    names = ("inertia", "damping", "stiffness")
    loose = [
        f"{name} {one.value:.3g} (95 % {one.low:.3g} to {one.high:.3g})"
        for name, one, h in zip(names, found, unsure, strict=True)
        if not h < WIDEST * one.value
    ]
    if loose:
        return (
            f"the person's impedance is not determined by this log: {', '.join(loose)}; record more quick reversals, "
            f"or give {TYPICAL}"
        )
    return FittedOperator(inertia=found[0], damping=found[1], stiffness=found[2], reversals=count)
