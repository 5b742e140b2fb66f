"""Do q, dq and the clock belong together? Degrees, a wrong time unit, a stretched clock, a wrong column.

The change of q is regressed on the integral of dq over many short windows. One number per joint comes out: 1 if all is
well, 57.3 if q is in degrees, 1000 if the clock was read in the wrong unit, 1.05 if it runs 5 % too short.
"""

from dataclasses import dataclass, replace

import numpy as np

from friction_audit.errors import InputError
from friction_audit.ingest.reader import Recording
from friction_audit.ingest.vet.rows import with_findings
from friction_audit.ingest.vet.sampling import gap_threshold_s
from friction_audit.joint_log import Finding, Float

DEGREES_PER_RADIAN = 180.0 / np.pi
_WINDOW_S = 0.5
_WINDOW_SAMPLES = 15
_FEWEST_PARTS = 16
_MOST_SAMPLES = 1 << 18
"""Samples that are looked at; of longer logs, stretches spread evenly over the whole."""
_STRETCHES = 64
_MOVED = 0.003
"""Integral of dq over a window from which on the joint counts as moving there. [rad]"""
_FEWEST_WINDOWS = 5
_LARGEST_Q_RAD = 4.0 * np.pi
_LARGEST_DQ_RAD_S = 12.0
_LARGEST_Q_DEG = 720.0
"""Beyond this a joint turns without end, whatever the unit: a bench rig, where magnitudes prove nothing."""
_STRETCHED = 0.02
_TINY = 1e-3
"""A clock is never wrong by more than units are: a smaller ratio means that q does not follow dq at all."""
_STRETCHED_TOO_FAR = 1.5
_DISAGREES = 0.05
_TRUSTED_R2 = 0.8
_MAJORITY = 3
_UNIT_FACTORS = (1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9)


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class MotionRatio:
    """Change of q over integral of dq.

    Attributes:
        ratio: One per joint, NaN where the joint hardly moves, shape (j,).
        determination: Share of the change of q that the integral explains, shape (j,).
    """

    ratio: Float
    determination: Float

    @property
    def common(self) -> float:
        """Median of the joints whose motion is explained, or NaN. A wrong column does not vote."""
        trusted = self.ratio[self.determination > _TRUSTED_R2]
        return float(np.median(trusted)) if len(trusted) else float("nan")


def mend_units(recording: Recording) -> Recording:
    """Turn degrees into radians, and mend a unit of time that was misjudged."""
    ratio = _ratios(recording).common
    turned = _turn_degrees(recording, ratio)
    return _mend_unit(turned, ratio if turned is recording else _ratios(turned).common)


def check_motion(recording: Recording, path: str, *, scaled: bool) -> Recording:
    """Notice a stretched clock and columns of the wrong joint; nothing is changed.

    Args:
        recording: In order of time, in SI units, without stale samples.
        path: The file, for messages.
        scaled: True if the user stated the clock's factor, which then is not refused.

    Raises:
        InputError: If the clock is wrong by a factor that nothing explains.
    """
    ratios = _ratios(recording)
    recording = with_findings(recording, *_mismatches(recording, ratios))
    return with_findings(recording, _stretch(ratios.common, path, scaled=scaled))


def _ratios(recording: Recording) -> MotionRatio:
    return motion_ratios(recording.t, recording.channels["q"], recording.channels["dq"])


def motion_ratios(t: Float, q: Float, dq: Float) -> MotionRatio:
    """Regress the change of q on the integral of dq, per joint.

    A second regressor, the change of dq over the window, takes up a delay between q and dq.
    """
    starts, stops = _windows(t)
    pairs = [_ratio(*_changes(t, q[:, j], dq[:, j], starts, stops)) for j in range(q.shape[1])]
    return MotionRatio(ratio=np.array([r for r, _ in pairs]), determination=np.array([d for _, d in pairs]))


def _windows(t: Float) -> tuple[np.ndarray, np.ndarray]:
    """Return first and last sample of windows without gaps, at most _MOST_SAMPLES long together."""
    step = (t[-1] - t[0]) / (len(t) - 1)
    # The step is in doubt, its unit may be misjudged: a window never is a large part of the log.
    length = max(_WINDOW_SAMPLES, min(round(_WINDOW_S / step), len(t) // _FEWEST_PARTS))
    starts = np.arange(0, len(t) - length, length)
    if len(t) > _MOST_SAMPLES:
        per_stretch = max(_MOST_SAMPLES // length // _STRETCHES, 1)
        heads = np.linspace(0, len(starts) - per_stretch, _STRETCHES).astype(np.intp)
        starts = np.unique(starts[heads[:, None] + np.arange(per_stretch)])
    stops = starts + length
    even = t[stops] - t[starts] < length * np.median(np.diff(t[:_MOST_SAMPLES])) + gap_threshold_s(0.0)
    return starts[even], stops[even]


def _changes(t: Float, q: Float, dq: Float, starts: np.ndarray, stops: np.ndarray) -> tuple[Float, Float, Float]:
    """Return per window the change of q, the integral of dq (trapezoid on the real stamps) and the change of dq."""
    if len(starts) == 0:
        return np.empty(0), np.empty(0), np.empty(0)
    rows = starts[:, None] + np.arange(stops[0] - starts[0] + 1)
    speeds = dq[rows]
    integral = 0.5 * ((speeds[:, 1:] + speeds[:, :-1]) * np.diff(t[rows], axis=1)).sum(axis=1)
    return q[stops] - q[starts], integral, dq[stops] - dq[starts]


def _ratio(change: Float, integral: Float, dq_change: Float) -> tuple[float, float]:
    """Fit change = ratio * integral + delay * dq_change, twice: the second time without the outliers of the first."""
    # What counts as motion depends on the units, which are in doubt: the threshold holds for either quantity in SI.
    moved = np.maximum(np.abs(change), np.abs(integral)) > _MOVED
    change, integral, dq_change = change[moved], integral[moved], dq_change[moved]
    if len(change) < _FEWEST_WINDOWS or not integral.any():
        return float("nan"), 0.0
    columns = np.column_stack((integral, dq_change))
    kept = np.ones(len(change), dtype=np.bool_)
    for _ in range(2):
        solution = np.linalg.lstsq(columns[kept], change[kept], rcond=None)[0]
        residual = np.abs(change - columns @ solution)
        kept = residual <= max(6.0 * float(np.median(residual)), 1e-12)
    total = float(np.dot(change, change))
    return float(solution[0]), 1.0 - float(np.dot(residual, residual)) / total if total > 0.0 else 0.0


def _turn_degrees(recording: Recording, ratio: float) -> Recording:
    """Turn q, dq or both into radians where their ratio and their magnitudes say degrees."""
    q, dq = recording.channels["q"], recording.channels["dq"]
    largest_q = max(float(np.abs(column).max()) for column in (q.min(axis=0), q.max(axis=0)))
    largest_dq = max(float(np.abs(column).max()) for column in (dq.min(axis=0), dq.max(axis=0)))
    degrees = []
    if _near(ratio, DEGREES_PER_RADIAN) or (np.isnan(ratio) and largest_q > _LARGEST_Q_RAD):
        degrees = ["q"]
    elif _near(ratio, 1.0 / DEGREES_PER_RADIAN):
        degrees = ["dq"]
    elif _near(ratio, 1.0, 0.3) and largest_q > _LARGEST_Q_RAD and largest_dq > _LARGEST_DQ_RAD_S:
        if q.shape[1] == 1 or largest_q > _LARGEST_Q_DEG:
            return with_findings(recording, _suspected(largest_q, largest_dq))
        degrees = ["q", "dq"]
    for channel in degrees:
        array = recording.channels[channel]
        array /= DEGREES_PER_RADIAN
    noticed = (_degrees(channel, largest_q if channel == "q" else largest_dq, ratio) for channel in degrees)
    return with_findings(recording, *noticed)


def _near(value: float, target: float, tolerance: float = 0.1) -> bool:
    return abs(value / target - 1.0) < tolerance


def _degrees(channel: str, largest: float, ratio: float) -> Finding:
    unit = "degrees" if channel == "q" else "degrees per second"
    message = (
        f"{channel} is in {unit}: it reaches {largest:.4g}, and q changes {ratio:.3g} times the integral of dq; "
        "it was turned into radians"
    )
    return Finding(code="degrees", message=message, amount=largest)


def _suspected(largest_q: float, largest_dq: float) -> Finding:
    message = (
        f"q reaches {largest_q:.4g} and dq {largest_dq:.4g}: a rig that turns without end, or degrees; read as "
        "rad and rad/s; if it is degrees, say so in the names of the columns (q_1_deg, dq_1_deg_s)"
    )
    return Finding(code="degrees_suspected", message=message, amount=largest_q)


def _mend_unit(recording: Recording, ratio: float) -> Recording:
    """A factor of a thousand between motion and clock is a unit misjudged from the time step, and mended."""
    factor = next((factor for factor in _UNIT_FACTORS if _near(ratio, factor, 0.3)), None)
    if factor is None:
        return recording
    message = (
        f"the motion runs {ratio:.4g} times too fast for the clock ({recording.mapping.get('t', recording.clock)}): "
        f"its unit was misjudged; time was multiplied by {factor:g}"
    )
    finding = Finding(code="time_unit", message=message, amount=factor)
    return with_findings(replace(recording, t=recording.t * factor), finding)


def _mismatches(recording: Recording, ratios: MotionRatio) -> list[Finding]:
    """Name the joints whose q does not follow their own dq while that of others does."""
    reference = ratios.common
    judged = np.isfinite(ratios.ratio)
    if np.count_nonzero(judged) >= _MAJORITY and np.isfinite(reference):
        wrong = judged & (np.abs(ratios.ratio / reference - 1.0) > _DISAGREES)
    else:
        wrong = judged & (ratios.determination < _TRUSTED_R2)
    return [
        Finding(
            code="position_mismatch",
            message=(
                f"{recording.joint_names[joint]}: q changes {ratios.ratio[joint]:.3g} times the integral of dq, which "
                f"explains {max(ratios.determination[joint], 0.0):.0%} of it; check that both columns are of this joint"
            ),
            joint=int(joint) + 1,
            amount=float(ratios.ratio[joint]),
        )
        for joint in np.flatnonzero(wrong)
    ]


def _stretch(ratio: float, path: str, *, scaled: bool) -> Finding | None:
    """Notice a clock that runs at another speed than the motion."""
    if not np.isfinite(ratio) or abs(ratio - 1.0) <= _STRETCHED:
        return None
    if not 1.0 / _STRETCHED_TOO_FAR < ratio < _STRETCHED_TOO_FAR and not scaled:
        clock = (
            f"either the clock is wrong by that factor (then --time-scale {ratio:.4g}), or " if ratio > _TINY else ""
        )
        raise InputError(
            f"{path}: q changes {ratio:.3g} times the integral of dq over time; expected 1; {clock}q and dq are not of "
            "the same joints, or of opposite sign (then --map other columns)"
        )
    message = (
        f"the clock is stretched: q changes {ratio:.4g} times the integral of dq, so the log seems to last "
        f"{1.0 / ratio:.4g} times as long as the motion did; time is kept as it is; times are off by that factor, and "
        f"with them viscous coefficients and inertial torques, Coulomb coefficients are not; "
        f"--time-scale {ratio:.4g} mends it"
    )
    return Finding(code="clock_stretched", message=message, amount=ratio)
