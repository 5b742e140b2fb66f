"""Change of q over integral of dq, per joint, from a regression over many short windows of time.

The ratio is 1 if all is well, 57.3 if q is in degrees, 1000 if the clock was read in the wrong unit, 1.05 if it runs
5 % too short or dq reads 5 % too small.
"""

from dataclasses import dataclass

import numpy as np

from friction_audit.io.checks.sampling import gap_threshold_s
from friction_audit.joint_log import Float, median_step

TRAVELLED = 0.1  # range of q that no noise of a joint at rest makes [rad]
DISAGREES = 0.05
_WINDOWS_S = (0.5, 2.0, 8.0)  # the longer ones are for joints that move too slowly for the short ones
_WINDOW_SAMPLES = 15
_FEWEST_PARTS = 16
_MOST_SAMPLES = 1 << 18  # of longer logs, windows are spread evenly over the whole
_MOVED = 0.003  # change of q over a window from which on the joint counts as moving there [rad]
_SURELY_MOVED = 0.05  # integral of dq over a short window that no noise or offset of a joint at rest makes [rad]
_FEWEST_WINDOWS = 5
_TRUSTED_R2 = 0.8


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class MotionRatio:
    """Change of q over integral of dq."""

    ratio: Float  # one per joint, NaN where the joint hardly moves, shape (j,)
    determination: Float  # R^2, the share of the change of q that the integral explains, shape (j,)
    windows: np.ndarray  # windows of time in which the joint moved, 0 where it hardly moves, shape (j,)

    @property
    def trusted(self) -> np.ndarray:
        """True for the joints whose motion is explained: a wrong column and a joint at rest do not vote."""
        return self.determination > _TRUSTED_R2

    @property
    def common(self) -> float:
        """Median of the ratios that most joints agree on, of equal shares of the one nearest 1, or NaN."""
        votes = self.ratio[self.trusted]
        if not len(votes):
            return float("nan")
        agree = np.abs(votes[:, None] / votes[None, :] - 1.0) <= DISAGREES
        best = max(range(len(votes)), key=lambda one: (int(agree[:, one].sum()), -abs(votes[one] - 1.0)))
        return float(np.median(votes[agree[:, best]]))


def motion_ratios(t: Float, q: Float, dq: Float) -> MotionRatio:
    """Regress the change of q on the integral of dq, per joint.

    A second regressor, the change of dq over the window, takes up a delay between q and dq.
    """
    several = [_windows(t, longest_s) for longest_s in _WINDOWS_S]
    found = [_first_that_moves(t, q[:, joint], dq[:, joint], several) for joint in range(q.shape[1])]
    ratio, determination, windows = zip(*found, strict=True)
    return MotionRatio(ratio=np.array(ratio), determination=np.array(determination), windows=np.array(windows))


def _windows(t: Float, longest_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Return first and last sample of windows of one length of time without gaps, _MOST_SAMPLES together at most."""
    span, step = t[-1] - t[0], (t[-1] - t[0]) / (len(t) - 1)
    # The step is in doubt, its unit may be misjudged: a window never is a large part of the log.
    length = max(_WINDOW_SAMPLES * step, min(longest_s, span / _FEWEST_PARTS))
    begin = t[0] + length * np.arange(int(span / length))
    most = max(int(_MOST_SAMPLES * step / length), 1)
    if len(begin) > most:
        begin = begin[np.linspace(0, len(begin) - 1, most).astype(np.intp)]
    starts, stops = np.searchsorted(t, begin), np.minimum(np.searchsorted(t, begin + length), len(t) - 1)
    starts, stops = starts[stops > starts], stops[stops > starts]
    if len(starts) == 0:
        return starts, stops
    rows, heads = _rows_within(starts, stops)
    whole = np.maximum.reduceat(t[rows + 1] - t[rows], heads) <= gap_threshold_s(median_step(t))
    return starts[whole], stops[whole]


def _rows_within(starts: np.ndarray, stops: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows at which the steps of all windows begin, and where each window begins among them."""
    heads = np.cumsum(stops - starts) - (stops - starts)
    return np.arange((stops - starts).sum()) + np.repeat(starts - heads, stops - starts), heads


def _first_that_moves(
    t: Float, q: Float, dq: Float, several: list[tuple[np.ndarray, np.ndarray]]
) -> tuple[float, float, int]:
    """Return ratio, determination and number of windows for the shortest windows in which the joint moves."""
    for least, (starts, stops) in zip((_SURELY_MOVED, np.inf, np.inf), several, strict=True):
        if len(starts) < _FEWEST_WINDOWS:
            continue
        rows, heads = _rows_within(starts, stops)
        integral = np.add.reduceat(0.5 * (dq[rows] + dq[rows + 1]) * (t[rows + 1] - t[rows]), heads)
        change = q[stops] - q[starts]
        moved = (np.abs(change) > _MOVED) | (np.abs(integral) > least)
        if np.count_nonzero(moved) < _FEWEST_WINDOWS or not integral[moved].any():
            continue
        ratio, determination = _ratio(change[moved], integral[moved], (dq[stops] - dq[starts])[moved])
        # A coarse encoder flickers at rest by more than _MOVED, and a velocity has an offset.
        at_rest = np.abs(integral).max() <= _SURELY_MOVED and np.ptp(q[starts]) <= TRAVELLED
        if determination > _TRUSTED_R2 or not at_rest:
            return ratio, determination, int(moved.sum())
    return float("nan"), 0.0, 0


def _ratio(change: Float, integral: Float, dq_change: Float) -> tuple[float, float]:
    """Fit change = ratio * integral + delay * dq_change, twice: the second time without the outliers of the first."""
    columns = np.column_stack((integral, dq_change))
    kept = np.ones(len(change), dtype=np.bool_)
    for _ in range(2):
        solution = np.linalg.lstsq(columns[kept], change[kept], rcond=None)[0]
        residual = np.abs(change - columns @ solution)
        kept = residual <= max(6.0 * float(np.median(residual)), 1e-12)
    total = float(np.dot(change, change))
    return float(solution[0]), 1.0 - float(np.dot(residual, residual)) / total if total > 0.0 else 0.0
