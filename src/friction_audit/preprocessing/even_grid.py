"""A log on an even grid: stamps without jitter, gaps, and one symmetric low-pass for torque, position and velocity.

The low-pass delays nothing: a linear relation between filtered signals holds as between the signals. Its kernel is
finite, so a gap in the log spoils a stretch of known length. The grid is fine (400 Hz, corner 80 Hz), because columns
of a regression that are not linear in the motion are built on it before they are filtered. Slower logs keep their own
rate, and a quarter of it as corner.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.joint_log import MINIMUM_SAMPLES, Bool, Float, Int, JointLog, median_step

GRID_HZ = 400.0
CORNER_HZ = 80.0
STOPBAND_DB = 60.0
LEAST_OVERSAMPLING = 4  # fine samples per grid sample: the difference quotient of the kernel is its derivative to 3 %
# A gap is longer than both; shorter ones are bridged.
GAP_S = 0.02
GAP_STEPS = 3.5
# After a longer step a sample is lost, and the position needs a curve: within 8 ms at 10 rad/s^2 it bends by 0.1 mrad.
LOST_STEPS = 1.5
CLOCK_WINDOW_S = 0.5  # over which the phase of a clock is averaged
FEWEST_STAMPS = 100  # for a clock to be seen
CLOCK_LAGS = (8, 64)  # stamps over which the period is measured: over the first, the usual step may be off by 6 %
LEAST_COHERENCE = 0.5  # length of the mean phasor over a window, 1 for stamps exactly on ticks
# Nearly all stamps are early by less than this quantile; twice as early happens only by a wrong tick. Without the rule
# late stamps before a lost tick are contacts or a delay (rows stranger_none 30001 and 30007).
COMMON_EARLINESS, EARLIEST = 0.99, 2.0
STEP_ERROR = 0.01  # of a period: ticks are even, and stamps on ticks, to this share
HELD = 20  # samples beyond both ends of a spline, of which 0.27^20 is felt
LOST_AT_ONCE = 2000  # samples: a spline takes twenty times the memory of what it passes through
MOST_MOVED = 0.1  # share of stamps that are a tick late: where there are more, they are no ticks of this clock
# A position is of an earlier moment from this share of a step on, and this many standard deviations of the delay.
BELATED_STEPS, BELATED_SIGMAS = 0.25, 6.0
MOVING_RAD_S = 0.02  # below it a position shows no delay


def kaiser_low_pass(corner_hz: float, rate_hz: float) -> Float:
    """Return an odd number of weights, sum 1: half of the amplitude passes at the corner, none from twice it on."""
    share = 2.0 * corner_hz / rate_hz
    taps = int(np.ceil((STOPBAND_DB - 7.95) / (2.285 * np.pi * share) + 1.0)) | 1
    return windowed_sinc(share, np.kaiser(taps, 0.1102 * (STOPBAND_DB - 8.7)))


def windowed_sinc(share: float, window: Float) -> Float:
    """Return the weights of a symmetric low-pass, sum 1; half of the amplitude passes at a share of half the rate."""
    # scipy.signal has this and the next one, but takes 0.5 s to load, an eighth of the diagnosis of a short log.
    weights = np.sinc(share * (np.arange(len(window)) - 0.5 * (len(window) - 1))) * window
    return np.asarray(weights / weights.sum())


def first_order(signal: NDArray[Any], pole: complex, before: complex) -> NDArray[Any]:
    """Return y_k = pole y_(k-1) + (1 - pole) x_k of a signal x, as real as the pole, from a value before it on."""
    driven = (1.0 - pole) * signal
    driven[0] += pole * before
    return _remembered(driven, pole)


@compiled()
def _remembered(driven: NDArray[Any], pole: complex) -> NDArray[Any]:
    for k in range(1, len(driven)):
        driven[k] += pole * driven[k - 1]
    return driven


@compiled(any_order=True)
def filtered(rows: Float, kernel: Float, centre: Int) -> Float:
    """Weighted sums of an odd number of samples about some, ascending, (m,), the ends held; rows (p, n): (p, m)."""
    half, n = len(kernel) // 2, rows.shape[1]
    out = np.zeros((len(rows), len(centre)))
    # Up to a whole number of what a processor takes at once: the rest, one by one, takes as long as all of them.
    weights = np.zeros((len(kernel) + 15) // 16 * 16)
    for j in range(len(kernel)):  # one by one: for a slice, numba compiles a message for seconds
        weights[j] = kernel[j]
    for k in range(len(rows)):
        row, i = rows[k], 0
        if not row.any():  # of effects with many columns most are zero
            continue
        while i < len(centre):
            if i + 3 < len(centre) and centre[i] >= half and centre[i + 3] - half + len(weights) <= n:
                # Four at a time read each weight once, which takes two thirds of the time.
                one, two = row[centre[i] - half :], row[centre[i + 1] - half :]
                three, four = row[centre[i + 2] - half :], row[centre[i + 3] - half :]
                a, b, c, d = 0.0, 0.0, 0.0, 0.0
                for j in range(len(weights)):
                    weight = weights[j]
                    a += weight * one[j]
                    b += weight * two[j]
                    c += weight * three[j]
                    d += weight * four[j]
                out[k, i], out[k, i + 1], out[k, i + 2], out[k, i + 3] = a, b, c, d
                i += 4
            else:
                total, first = 0.0, centre[i] - half
                for j in range(len(kernel)):
                    total += kernel[j] * row[min(max(first + j, 0), n - 1)]
                out[k, i] = total
                i += 1
    return out


class EvenSpline:
    """The cubic B-spline through even samples, all read at once (M. Unser, IEEE Signal Proc. Mag. 16(6), 1999)."""

    def __init__(self, values: NDArray[np.floating[Any]], *, held: bool) -> None:
        """Find the coefficients of values, shape (n, ...), that are held beyond the ends, or go on as they end."""
        from scipy.ndimage import spline_filter1d

        n, beyond = len(values), np.arange(1, min(HELD, len(values) - 1) + 1)
        before, after = (np.repeat(values[[end]], HELD, axis=0).astype(np.float64) for end in (0, -1))
        if not held:  # turned about the last value: as a natural spline ends
            before[HELD - beyond] = 2.0 * values[0] - values[beyond]
            after[beyond - 1] = 2.0 * values[-1] - values[n - 1 - beyond]
        self.coefficients = spline_filter1d(np.concatenate([before, values, after]), 3, axis=0, mode="mirror")

    def ahead(self, samples: float) -> Float:
        """Values so many samples later, or earlier if below zero, shape (n, ...)."""
        n, whole = len(self.coefficients) - 2 * HELD, int(np.floor(samples))
        x = samples - whole
        near = np.take(self.coefficients, np.arange(n + 3) + (whole + HELD - 1), axis=0, mode="clip")
        weights = (
            np.array([(1.0 - x) ** 3, 4.0 + 3.0 * x**2 * (x - 2.0), 1.0 + 3.0 * x * (1.0 + x * (1.0 - x)), x**3]) / 6
        )
        if near.ndim == 1:
            return np.asarray(np.correlate(near, weights, "valid"))
        out = weights[0] * near[:n]
        for k in (1, 2, 3):
            out += weights[k] * near[k : n + k]
        return np.asarray(out)


def natural_spline(x: Float, y: Float, at: Float) -> Float:
    """Values at some places of the cubic spline through y at x that is straight at both ends, by its curvatures."""
    from scipy.linalg.lapack import dptsv  # scipy.interpolate takes 0.2 s to load

    step = np.diff(x)
    slope = np.diff(y) / step
    diagonal = np.concatenate([[1.0], 2.0 * (step[:-1] + step[1:]), [1.0]])
    next_to_it = np.append(np.append(0.0, step[1:-1]), 0.0)[: len(step)]
    bend = dptsv(diagonal, next_to_it, np.concatenate([[0.0], 6.0 * np.diff(slope), [0.0]]))[2]
    k = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(step) - 1)
    after, before, h = at - x[k], x[k + 1] - at, step[k]
    curved = bend[k] * (before**2 / h - h) * before + bend[k + 1] * (after**2 / h - h) * after
    return np.asarray((y[k] * before + y[k + 1] * after) / h + curved / 6.0)


def on_finer_grid(values: NDArray[np.floating[Any]], every: int, n: int) -> Float:
    """Return values at n samples, shape (n, ...), from those at every so many of them, by a cubic spline."""
    if every == 1:
        return np.asarray(values, np.float64)
    spline, out = EvenSpline(values, held=False), np.empty((n, *values.shape[1:]))
    for k in range(every):
        out[k::every] = spline.ahead(k / every)[: len(out[k::every])]
    return out


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class LowPass:
    """A symmetric low-pass that reads an even fine clock and writes every so many samples."""

    t: Float  # times of the grid, shape (n,) [s]
    fine: Float  # times of the fine clock, half a kernel longer at both ends [s]
    every: int  # fine samples per grid sample
    kernel: Float  # weights, shape (2 h + 1,), sum 1
    slope: Float  # weights that give the derivative [1/s]
    corner_hz: float  # half of the amplitude passes here [Hz]

    @classmethod
    def for_stamps(cls, t: Float) -> "LowPass":
        """Choose grid and corner from the rate of a log, stamps strictly increasing, shape (m,). [s]"""
        rate = 1.0 / median_step(t)
        grid_hz = min(GRID_HZ, rate)
        corner = min(CORNER_HZ, grid_hz / 4)
        every = max(round(rate / grid_hz), LEAST_OVERSAMPLING)
        fine_hz = grid_hz * every
        kernel = kaiser_low_pass(corner, fine_hz)
        slope = np.convolve(kernel, [0.5, 0.0, -0.5]) * fine_hz
        samples = max(int(np.floor((t[-1] - t[0]) * grid_hz * (1 + 1e-12))) + 1, 2)
        half = len(slope) // 2
        fine = t[0] + np.arange(-half, (samples - 1) * every + half + 1) / fine_hz
        grid = t[0] + np.arange(samples) / grid_hz
        return cls(t=grid, fine=fine, every=every, kernel=kernel, slope=slope, corner_hz=corner)

    @property
    def step_s(self) -> float:
        """Spacing of the grid. [s]"""
        return float(self.t[1] - self.t[0])

    def of(self, t: Float, signal: Float) -> Float:
        """Filter a signal, shape (m,) at times t, onto the grid, shape (n,)."""
        return self._apply(np.interp(self.fine, t, signal), self.kernel)

    def all_of(self, t: Float, signals: Float, some: Bool | slice) -> Float:
        """Filter columns of some of the samples of signals, shape (m, j), onto the grid, shape (n, j)."""
        return np.stack([self.of(t, column[some]) for column in signals.T], axis=1)

    def with_slope(self, t: Float, position: Float) -> tuple[Float, Float]:
        """Filter a position, with a cubic spline over lost samples, and return it and its derivative, shape (n,)."""
        even = np.interp(self.fine, t, position)
        lost = np.flatnonzero(np.diff(t) > LOST_STEPS * median_step(t))
        for first in range(0, len(lost), LOST_AT_ONCE):
            self._curve(even, t, position, lost[first : first + LOST_AT_ONCE])
        return self._apply(even, self.kernel), self._apply(even, self.slope)

    def _curve(self, even: Float, t: Float, position: Float, lost: Int) -> None:
        """Replace straight lines over lost samples by a cubic spline through the samples that it feels."""
        first, stop = max(lost[0] - HELD, 0), min(lost[-1] + HELD + 2, len(t))
        t, position, lost = t[first:stop], position[first:stop], lost - first
        begins, ends = np.searchsorted(self.fine, t[np.stack([lost, lost + 1])], side="right")
        n = len(t)
        near = within(np.maximum(lost - HELD, 0), np.minimum(lost + HELD + 2, n), n)
        inside = begins[0] + within(begins - begins[0], ends - begins[0], ends[-1] - begins[0])
        even[inside] = natural_spline(t[near], position[near], self.fine[inside])

    def away_from_gaps(self, t: Float) -> Bool:
        """Samples of the grid whose kernel reaches neither a gap in the stamps t nor beyond the ends, shape (n,)."""
        after, reach_s = gaps(t), float(self.fine[1] - self.fine[0]) * (len(self.slope) // 2)
        begins = np.concatenate([[-np.inf], t[after], [t[-1]]])
        ends = np.concatenate([[t[0]], t[after + 1], [np.inf]])
        place = np.searchsorted(begins, self.t + reach_s, side="left") - 1
        # The last gap that begins before the kernel ends must have ended before the kernel begins.
        return np.asarray(ends[place] <= self.t - reach_s + 1e-9, bool)

    def _apply(self, even: Float, kernel: Float) -> Float:
        centre = len(self.slope) // 2 + self.every * np.arange(len(self.t))
        # Convolution: the weights backwards.
        return np.asarray(filtered(even[None], np.ascontiguousarray(kernel[::-1]), centre)[0])


def within(starts: Int, stops: Int, n: int) -> Int:
    """Places 0..n-1 within any of some ranges."""
    change = np.bincount(starts, minlength=n + 1) - np.bincount(stops, minlength=n + 1)
    return np.flatnonzero(np.cumsum(change[:n]))


def gaps(t: Float) -> Int:
    """Return the samples after which a gap begins, shape (g,)."""
    return np.flatnonzero(np.diff(t) > max(GAP_S, GAP_STEPS * median_step(t)))


def fresh_samples(log: JointLog) -> Bool:
    """Samples that do not repeat the state before them while a joint moves, shape (n,).

    A velocity that mostly stays the same while the position changes is read in coarse steps. It says nothing then, and
    a joint moves where it passes a step of its position between two samples.
    """
    moved, dq = np.abs(np.diff(log.q, axis=0)), np.abs(log.dq[1:])
    changed, same = moved > 0, np.diff(log.dq, axis=0) == 0
    coarse = np.sum(same & changed, axis=0) > 0.5 * np.sum(changed, axis=0)
    step = np.where(coarse, np.min(moved, axis=0, where=changed, initial=np.inf), 0.0)
    moving = np.any((dq > 0) & (dq * np.diff(log.t)[:, None] >= step), axis=1)
    fresh = np.append(True, ~(np.all(same & ~changed, axis=1) & moving))
    if fresh.sum() < MINIMUM_SAMPLES:
        fresh[-1] = True  # a log that never changes still has a beginning and an end
    return fresh


def steady_clock(t: Float) -> Float:
    """Return stamps on the ticks of a clock that drifts slowly, or as they are where there is none, shape (n,). [s]

    A robot samples at even ticks; a stamp is late by the time that some other computer took to notice. A stamp that is
    0.1 ms late moves a joint at 1 rad/s by 0.1 mrad, far more than the noise of its encoder. The phase of the clock is
    averaged over half a second. A stamp so late that it is nearer to the next tick goes to its own tick where the next
    one has a stamp of its own, or where it would be far earlier than any other.
    """
    from scipy.ndimage import uniform_filter1d

    if len(t) < FEWEST_STAMPS:
        return t
    period = _period(t)
    phasor = np.exp(2j * np.pi * t / period)
    window = min(max(int(CLOCK_WINDOW_S / period), 1), len(t))
    mean = uniform_filter1d(phasor.real, window) + 1j * uniform_filter1d(phasor.imag, window)
    if np.abs(mean).min() < LEAST_COHERENCE:
        return t
    phase = np.unwrap(np.angle(mean)) / (2 * np.pi)
    tick = np.round(t / period - phase)
    order = np.arange(len(t))
    own: Float = np.minimum.accumulate((tick - order)[::-1])[::-1] + order
    earliest = EARLIEST * np.quantile(own + phase - t / period, COMMON_EARLINESS)
    while np.any(early := (np.diff(own, prepend=-np.inf) > 1.0) & (own + phase - t / period > earliest)):
        own -= early
    return np.asarray((own + phase) * period) if np.mean(own < tick) <= MOST_MOVED else t


def times_of_samples(t: Float, q: Float, dq: Float) -> Float:
    """Return when the samples of positions and velocities, shape (n, j), were taken, shape (n,). [s]

    On the ticks of a steady clock whose stamps are late; at the stamps where the samples are late with them. Then the
    position has moved by the velocity times the delay, and a regression of its second difference on that has a slope of
    1, else of 0. On shifted ticks 16 rows more of stranger_40033 have a contact.
    """
    ticks = steady_clock(t)
    step, usual = np.diff(ticks), median_step(ticks)
    even = np.abs(step - usual) < STEP_ERROR * usual
    late = t - ticks
    if np.ptp(late) < STEP_ERROR * usual or not np.any(even[1:] & even[:-1]):
        return ticks
    inside = even[1:] & even[:-1]
    bend, along, squared = np.where(inside, np.diff(late, 2), 0.0), 0.0, float(np.finfo(float).tiny)
    for position, speed in zip(q.T, dq.T, strict=True):  # one by one: a long log takes little memory
        bent, moved = np.where(inside, np.diff(position, 2), 0.0), speed[1:-1] * bend
        noise = max(float(bent @ bent), float(np.finfo(float).tiny))  # each joint counts by its own
        along, squared = along + float(bent @ moved) / noise, squared + float(moved @ moved) / noise
    return t if along / squared > 0.5 else ticks  # noqa: PLR2004 - between 0 and 1


def belated_samples(t: Float, q: Float, dq: Float) -> Bool:
    """Samples whose positions, shape (n, j), are those of an earlier moment, shape (n,).

    A sample that is repeated where it is lost itself, or that is interpolated to other stamps, repeats none before it.
    One per second is a structure in the residual of a clean log. A Hampel identifier (F. R. Hampel, J. Am. Stat. Assoc.
    69 (1974) 383) on the delay: by how much the position lags the cubic through both neighbours and their velocities.
    """
    belated, span, tiny = np.zeros(len(t), bool), t[2:] - t[:-2], np.finfo(float).tiny
    x, along, squared = (t[1:-1] - t[:-2]) / span, np.zeros(len(span)), np.zeros(len(span))
    for position, speed in zip(q.T, dq.T, strict=True):  # one by one: a long log takes little memory
        moves = np.abs(v := speed[1:-1]) > MOVING_RAD_S
        if not moves.any():
            continue
        lag = position[:-2] * (1.0 + 2.0 * x) * (1.0 - x) ** 2 + position[2:] * x**2 * (3.0 - 2.0 * x) - position[1:-1]
        lag += span * x * (1.0 - x) * (speed[:-2] * (1.0 - x) - speed[2:] * x)
        variance = max(float(np.median(np.abs(lag[moves]))) ** 2, tiny)  # each joint counts by its own
        along += np.where(moves, lag * v, 0.0) / variance
        squared += np.where(moves, v**2, 0.0) / variance
    delay, known = along / np.maximum(squared, tiny), squared > 0.0
    if known.any():
        usual = np.maximum(1.4826 * np.median(np.abs(delay[known])), 1.0 / np.sqrt(np.maximum(squared, tiny)))
        belated[1:-1] = delay > np.maximum(BELATED_SIGMAS * usual, BELATED_STEPS * median_step(t))
    return belated


def _period(t: Float) -> float:
    """Period of the ticks: the usual step, corrected by the mean phase that stamps gain over many steps. [s]"""
    period = median_step(t)
    for lag in CLOCK_LAGS:
        phasor = np.exp(2j * np.pi * t / period)
        gained = float(np.angle(np.mean(phasor[lag:] * phasor[:-lag].conj()))) / (2.0 * np.pi)
        period *= 1.0 + gained * period / float(np.mean(t[lag:] - t[:-lag]))
    return period
