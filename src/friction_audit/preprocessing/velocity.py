"""Velocity: filtered for the detection of cycles, its lag after the position, its mean with the position's derivative.

The filtered velocity never enters an energy sum as the factor of a torque.
"""

import cmath
import math
from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Bool, Float, JointLog, LogInBlocks, Means
from friction_audit.parallel import ahead
from friction_audit.preprocessing.interaction import Caution
from friction_audit.preprocessing.sign import CoarseLog

RESTING_RAD = 0.05  # a joint without a cycle whose position stays within this does not move, and velocities are noise
HIGHEST_SHARE_OF_RATE = 0.396  # a corner closer to the Nyquist frequency filters nothing; for 20 Hz, 50 Hz is too low
PADDING = 9  # samples by which the signal is continued at each end, as scipy's sosfiltfilt does
MINIMUM_LENGTH = 16
FILTER_BLOCK = 32  # samples: a longer block costs more products, a shorter one more states
ROWS_AT_ONCE = 1 << 10  # blocks whose products stay in the processor's cache
SETTLED = 1e-24  # of a state: below the rounding of what came since
CERTAIN = 5.0  # standard errors that a lag must differ from zero
SHARE_OF_STEP = 0.5  # of the clock that it must exceed: channels of one message may be sampled in turn
LATEST_S, LATEST_STEPS = 0.02, 2.0  # a driver's filter delays by no more; beyond, dq is of another clock
TOLERANCE = 0.1  # by so much of itself may the lag be found too large
MOVED_RAD = 0.05  # the lag of a joint that moves less is that of its vibration
LOWEST_CROSSOVER_HZ = 2.0  # below the frequencies of the motion a derivative improves nothing
TIME_CONSTANTS = 9.0  # after which the exponential of the mean of two velocities ends
# Spectra of noise: length and least number of their segments; their band ends here, or at a share of the rate.
SEGMENT_S, FEWEST_SEGMENTS = 2.0, 5
NOISE_HZ, NOISE_SHARE, NOISE_SPAN = 25.0, 0.2, 5.0
# Median of white noise over its amplitude density times the root of the rate: 0.6745 / sqrt(2 pi), as noise_density.
MEDIAN_OF_DENSITY = 0.269
FINE = 0.01  # noise of a velocity from the position, of the rms speed, that is no loss
Complex = NDArray[np.complex128]


def filter_velocity(dq: Float, *, rate_hz: float, cutoff_hz: float) -> Float:
    """Low-pass a velocity (n,) by a second-order Butterworth, both ways; as it is where the rate is too low."""
    if cutoff_hz >= HIGHEST_SHARE_OF_RATE * rate_hz or len(dq) < MINIMUM_LENGTH:
        return dq
    # Point reflections at both ends. scipy.signal would do the same, but loading it takes longer than this.
    blocks = np.empty((-(-(len(dq) + 2 * PADDING) // FILTER_BLOCK), FILTER_BLOCK))
    signal, own = blocks.ravel(), slice(blocks.size - PADDING - len(dq), blocks.size - PADDING)
    signal[own], signal[own.stop :] = dq, 2 * dq[-1] - dq[-2 : -PADDING - 2 : -1]
    signal[own.start - PADDING : own.start] = 2 * dq[0] - dq[PADDING:0:-1]
    signal[: own.start - PADDING] = signal[own.start - PADDING]
    return _low_pass(blocks, rate_hz, cutoff_hz).ravel()[own]


def settling_samples(rate_hz: float, cutoff_hz: float) -> int:
    """Return after how many samples the filtered velocity has forgotten what came before: 1e-18 of it is left."""
    if cutoff_hz >= HIGHEST_SHARE_OF_RATE * rate_hz:
        return MINIMUM_LENGTH
    _, pole = _poles(rate_hz, cutoff_hz)
    return PADDING + MINIMUM_LENGTH + math.ceil(0.75 * math.log(SETTLED) / math.log(abs(pole)))


def _poles(rate_hz: float, cutoff_hz: float) -> tuple[complex, complex]:
    """Return a pole of the analog filter with its corner prewarped, and that of the digital one (Tustin's method)."""
    analog = math.tan(math.pi * cutoff_hz / rate_hz) * cmath.exp(0.75j * math.pi)
    return analog, (1.0 + analog) / (1.0 - analog)


def _low_pass(blocks: Float, rate_hz: float, cutoff_hz: float) -> Float:
    """Run the filter forwards and backwards over blocks of a signal, which before and behind is as at its end.

    Partial fractions of |H|^2 = k^4 / (k^4 + s^4), k the corner and s = (z - 1) / (z + 1): what lies outside a block
    reaches it through two states, which a pole carries on. Products of matrices are as fast as a compiled loop, without
    the compiler's 140 MB.
    """
    analog, pole = _poles(rate_hz, cutoff_hz)
    order, weight, fourth = np.arange(FILTER_BLOCK), analog / (analog**2 - 1.0), abs(analog) ** 4
    inside = (weight * pole ** np.abs(order - order[:, None])).real + fourth / (1.0 + fourth) * np.eye(FILTER_BLOCK)
    left = (blocks @ (pole ** np.stack([FILTER_BLOCK - order, order + 1], axis=1)).view(np.float64)).view(np.complex128)
    forwards = _states(left[:, 0], blocks[0, 0] * pole / (1.0 - pole), pole)
    # At the end the output of the first direction, not its input, is held: its partial fraction, and what is then left.
    first = 2.0 * (analog - analog.conjugate()) / (analog**2 - 1.0)
    last = first * (left[-1, 0] + forwards[-1] * pole**FILTER_BLOCK)
    held = (last / pole).real + (abs(analog / (1.0 - analog)) ** 2 - first.real) * blocks[-1, -1]
    rest = held / (1.0 - pole) - 0.5 * (last / (1.0 - pole**2) + last.conjugate() / (1.0 - abs(pole) ** 2))
    backwards = _states(left[::-1, 1], first * rest * pole / weight, pole)[::-1]
    states = np.stack([forwards, backwards], axis=1).view(np.float64)
    free = (weight * pole ** np.stack([order, order[::-1]], axis=1)).conj().view(np.float64).T
    found = np.empty_like(blocks)
    for begin in range(0, len(blocks), ROWS_AT_ONCE):
        rows = slice(begin, begin + ROWS_AT_ONCE)
        np.matmul(blocks[rows], inside, out=found[rows])
        found[rows] += states[rows] @ free
    return found


def _states(left: Complex, before: complex, pole: complex) -> Complex:
    """Return the states at the begin of blocks, given what each block alone leaves and the state before the first."""
    states = np.append(before, left[:-1])
    # Each state holds the inputs of the block before; of the blocks before that by doubling, until those have died out.
    reach, power = 1, pole**FILTER_BLOCK
    while reach < len(states) and abs(power) > SETTLED:
        states[reach:] += states[:-reach] * power
        reach, power = 2 * reach, power * power
    return states


def find_lag(coarse: CoarseLog, step_s: float) -> Float:
    """Return by how much each joint's velocity comes late, shape (j,); 0 where that is not significant. [s]

    The noise of the position is in its second derivative, and least squares would find too small a lag; the change of
    the logged velocity has independent noise, and is the instrumental variable. A joint that never accelerates has no
    lag.
    """
    step = np.diff(coarse.t)[:, None]
    slope = np.diff(coarse.q, axis=0) / step
    whole = coarse.whole[:-2] & coarse.whole[1:-1] & coarse.whole[2:]
    middle, reach = 0.5 * (slope[1:] + slope[:-1]), 0.5 * (step[1:] + step[:-1])
    bend, change = np.diff(slope, axis=0) / reach, (coarse.dq[2:] - coarse.dq[:-2]) / (2.0 * reach)
    late, bend, change = (one[whole] for one in (middle - coarse.dq[1:-1], bend, change))
    if not len(late):
        return np.zeros(coarse.q.shape[1])
    power = np.sum(change * bend, axis=0)
    moves = power > 0.0
    power = np.where(moves, power, 1.0)
    lag = np.sum(change * late, axis=0) / power
    error = np.sqrt(np.mean((late - lag * bend) ** 2, axis=0) * np.sum(change**2, axis=0)) / power
    return np.where(moves & (lag > CERTAIN * error) & (lag > SHARE_OF_STEP * step_s), lag, 0.0)


def read_on_time(log: JointLog, lag: Float) -> JointLog:
    """Return a log whose velocities, late by a lag of shape (j,), belong to its positions.

    A filter that delays also flattens, so a late velocity is replaced by the central difference of the position over
    the lag, (q(t + d) - q(t - d)) / 2 d. Where the position is too coarse for that, the velocity is read earlier.
    """
    fine = _is_fine(log, lag)
    if not isinstance(log, LogInBlocks):
        return replace(log, dq=_velocity_on_time(log.t, log.q, log.dq, lag, fine, (log.t[0], log.t[-1])))

    def read(names: Collection[str]) -> Iterator[tuple[Float, dict[str, Float]]]:
        """Read blocks, each of which waits until the positions that its velocities need are there."""
        if "dq" not in names:
            yield from log.read(names)
            return
        blocks = iter(log.read({*names, "q"}))
        following, done = next(blocks, None), 0
        t, kept = np.empty(0), dict[str, Float]()
        while following is not None:
            t = np.append(t, following[0])
            kept = {name: np.concatenate([kept[name], a]) if kept else a for name, a in following[1].items()}
            following = next(blocks, None)
            stop = len(t) if following is None else max(int(np.searchsorted(t, t[-1] - lag.max())), done)
            dq = _velocity_on_time(t, kept["q"], kept["dq"], lag, fine, (0.0, log.duration_s))
            if stop > done:
                yield t[done:stop], {name: (dq if name == "dq" else kept[name])[done:stop] for name in names}
            start = max(int(np.searchsorted(t, t[min(stop, len(t) - 1)] - lag.max())) - 1, 0)
            done, t, kept = stop - start, t[start:], {name: array[start:] for name, array in kept.items()}

    means = Means(log.clock[2], log.samples, ("dq",), len(log.joint_names))
    for t, channels in ahead(read(("dq",))):
        means.take(t, channels)
    return replace(log, dq=means.channels["dq"], read=read)


def _velocity_on_time(t: Float, q: Float, dq: Float, lag: Float, fine: Bool, ends: tuple[float, float]) -> Float:
    dq = np.array(dq, order="F")
    for joint in np.flatnonzero(lag):
        position, late = q[:, joint], lag[joint]
        after, before = np.minimum(t + late, ends[1]), np.maximum(t - late, ends[0])
        change = np.interp(after, t, position) - np.interp(before, t, position)
        dq[:, joint] = change / (after - before) if fine[joint] else np.interp(after, t, dq[:, joint].copy())
    return dq


def _is_fine(log: JointLog, lag: Float) -> Bool:
    """Return whose positions have noise and resolution that are small enough for a difference over the lag."""
    square, rough, before = np.zeros(len(lag)), np.zeros(len(lag)), np.empty((0, len(lag)))
    for part in log.blocks(("q", "dq")):
        square += [np.sum(column**2) for column in part.dq.T]
        near = np.concatenate([before, part.q])
        rough += [np.sum(np.diff(column, n=2) ** 2) for column in near.T]
        before = near[-2:].copy()
    roughness = np.sqrt(rough / max(log.samples - 2, 1) / 6.0)  # rms noise and resolution of the position
    late = np.where(lag > 0.0, lag, np.inf)
    return np.asarray(roughness / (np.sqrt(2.0) * late) < FINE * np.sqrt(square / log.samples))


def on_time(log: JointLog, coarse: CoarseLog) -> tuple[JointLog, tuple[Caution, ...]]:
    """Return the log with its velocities on time, but those later than any filter's, and what the user must know."""
    step_s = 1.0 / log.rate_hz
    lag = find_lag(coarse, step_s)
    for joint in map(int, np.flatnonzero(lag)):
        lag[joint] *= np.ptp(log.q[:, joint]) > MOVED_RAD
    foreign = lag > max(LATEST_S * (1.0 + TOLERANCE), LATEST_STEPS * step_s)
    late = np.where(foreign, 0.0, lag)
    cautions = tuple(
        Caution(code=code, numbers={"joints": (np.flatnonzero(lags) + 1).tolist(), "lags_s": lags[lags > 0.0].tolist()})
        for code, lags in (("dq_late", late), ("dq_other_clock", np.where(foreign, lag, 0.0)))
        if lags.any()
    )
    if not late.any():
        return log, cautions
    return read_on_time(log, late), cautions


def noise_density(signal: Float, step_s: float, order: int) -> float:
    """Return D of noise of the amplitude density D f^order, to a fifth of the rate; order 0 is white noise."""
    w = np.linspace(0.0, 0.4 * np.pi, 400)
    gain = float(np.sqrt(np.trapezoid((w / (2 * np.pi * step_s)) ** (2 * order) * (2 - 2 * np.cos(w)) ** 2, w)))
    return float(np.median(np.abs(np.diff(signal, n=2)))) / gain


def noise_of_both(slope: Float, logged: Float, valid: Bool, step_s: float, lag_s: float) -> Float:
    """Amplitude densities of the noise of a position [rad/sqrt(Hz)] and of a velocity that lags it [rad/s/sqrt(Hz)].

    What two measurements of the same motion do not have in common is noise (J. S. Bendat, A. G. Piersol, Random Data
    (2010), section 7.2): spectrum less cross-spectrum, by Welch's method, where both noises are white. Second
    differences and their median do not show noise that comes and goes with the motion, as of interpolated samples.
    """
    samples = max(round(SEGMENT_S / step_s), 1)
    window, hertz = np.hanning(samples), np.fft.rfftfreq(samples, step_s)
    high = min(NOISE_HZ, NOISE_SHARE / step_s)
    band = (hertz >= high / NOISE_SPAN) & (hertz <= high)
    even = slice(len(slope) // samples * samples)
    slope, logged = (one[even].reshape(-1, samples) for one in (slope, logged))
    whole = valid[even].reshape(-1, samples).all(axis=1)
    if np.count_nonzero(whole) < FEWEST_SEGMENTS or not band.any():
        return np.zeros(2)
    # As scipy.signal.csd, which takes 0.5 s to load.
    kept = (one[whole] - one[whole].mean(axis=1, keepdims=True) for one in (slope, logged))
    first, second = (np.fft.rfft(one * window) for one in kept)
    second *= np.exp(2j * np.pi * hertz * lag_s)
    apart = first - second
    of_q, of_dq = (np.mean(one * apart.conj(), axis=0).real[band] for one in (first, -second))
    found = np.median([of_q / (2.0 * np.pi * hertz[band]) ** 2, of_dq], axis=1)
    return np.asarray(np.sqrt(np.maximum(found, 0.0) * 2.0 * step_s / float(window @ window)))


def crossover_of(slope: Float, logged: Float, step_s: float, least: Float | tuple[float, float] = (0.0, 0.0)) -> float:
    """Frequency at which the position's derivative and the logged velocity are equally noisy, 0 where too low. [Hz]

    Their noise is at least that of the position, and of the velocity, that is given as an amplitude density.
    """
    of_q, of_dq = MEDIAN_OF_DENSITY / np.sqrt(step_s) * np.asarray(least)
    rising = max(noise_density(slope, step_s, 1), 2.0 * np.pi * of_q)
    crossing = max(noise_density(logged, step_s, 0), of_dq) / rising if rising > 0 else 0.0
    return crossing if crossing >= LOWEST_CROSSOVER_HZ else 0.0


def complementary_mean(slope: Float, logged: Float, valid: Bool, step_s: float, crossover_hz: float) -> Float:
    """Return the mean of two velocities, weighted by the inverse of their noise densities, shape (n,).

    The noise of a position's derivative grows with the frequency f, that of a logged velocity does not. The derivative
    counts by w(f) = 1 / (1 + (f / f_x)^2), a symmetric exponential in time (N. Wiener, Extrapolation of Stationary Time
    Series, 1949), not at all next to a gap; f_x is that of :func:`crossover_of`.
    """
    from scipy.signal import oaconvolve

    rate = 2.0 * np.pi * crossover_hz * step_s
    half = int(np.ceil(TIME_CONSTANTS / rate))
    kernel = np.exp(-rate * np.abs(np.arange(-half, half + 1)))
    apart = np.pad(np.where(valid, slope - logged, 0.0), half, mode="edge")
    return np.asarray(logged + oaconvolve(apart, kernel / kernel.sum(), "valid"))


def position_of(q: Float, dq: Float, ddq: Float, valid: Bool, step_s: float, crossover_hz: float) -> Float:
    """Return the same mean of a position and of the integral of a velocity, of the position alone over other samples.

    Next to the noise of a position alone gaps and springs are presliding (resampled: backlash 140003).
    """
    steps = 0.5 * step_s * (dq[1:] + dq[:-1]) - step_s**2 / 12.0 * np.diff(ddq)  # Euler-Maclaurin
    along = q[0] + np.append(0.0, np.cumsum(np.where(valid[1:] & valid[:-1], steps, np.diff(q))))
    return complementary_mean(q, along, np.ones(len(q), bool), step_s, max(crossover_hz, LOWEST_CROSSOVER_HZ))
