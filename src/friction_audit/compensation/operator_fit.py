"""The impedance of the person who moved a joint, from its quick reversals."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.closed_loop import Recorded
from friction_audit.errors import AnalysisError
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float, median_step

LEAST_INERTIA_KG_M2 = 1e-3  # no motor with its gear has less; what seems to was recorded without its inertia
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


class FittedOperator(NamedTuple):
    """Impedance of the person with its 95 % intervals; given ones have none."""

    inertia: Coefficient
    damping: Coefficient
    stiffness: Coefficient
    reversals: int = 0  # reversals it rests on; 0 if it was given


def fit_operator(recorded: Recorded, q: Float) -> FittedOperator:
    """Fit the person's impedance at one joint, of position q."""
    from scipy.signal import butter, sosfiltfilt

    step = median_step(recorded.t)
    if step * LEAST_PERIODS * BAND_HZ[1] > 1.0:
        raise AnalysisError(
            f"{1.0 / step:.3g} samples per second are too few to see the person's arm give way; give {TYPICAL}"
        )
    t = np.arange(recorded.t[0], recorded.t[-1], step)
    dq = np.interp(t, recorded.t, recorded.dq)
    turns, direction = _reversals(dq, step)
    before, after = int(BEFORE_S / step), int(AFTER_S / step)
    inside = (turns >= before) & (turns + after <= len(t))
    turns, direction = turns[inside], direction[inside]
    if len(turns) < FEWEST_REVERSALS:
        raise AnalysisError(
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


def _solve(windows: Float) -> FittedOperator:
    """Solve acceleration, velocity, position and minus torque around reversals, shape (r, w, 4), with a jackknife."""
    count, total = len(windows), windows.sum(axis=0)

    def solve(mean: Float) -> Float:
        return np.asarray(np.linalg.lstsq(mean[:, :3], mean[:, 3], rcond=None)[0])

    value = solve(total / count)
    others = np.array([solve((total - one) / (count - 1)) for one in windows])
    spread = (count - 1) / count * ((others - others.mean(axis=0)) ** 2).sum(axis=0)
    unsure = NORMAL_95 * np.sqrt(spread)
    half = np.hypot(unsure, np.array(INTENTION) * value)
    ends = zip(value.tolist(), (value - half).tolist(), (value + half).tolist(), strict=True)
    found = FittedOperator._make([*(Coefficient(value=v, low=low, high=high) for v, low, high in ends), count])
    known = zip(found._fields, found[:3], unsure < WIDEST * value, strict=False)
    loose = [f"{name} {one.value:.3g} (95 % {one.low:.3g} to {one.high:.3g})" for name, one, sure in known if not sure]
    if loose:
        raise AnalysisError(
            f"the person's impedance is not determined by this log: {', '.join(loose)}; record more quick reversals, "
            f"or give {TYPICAL}"
        )
    return found
