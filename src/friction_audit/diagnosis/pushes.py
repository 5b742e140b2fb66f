"""Pushes that stand out of noise: matched filters for the noise's own spectrum, one push after the other.

Noise that remembers long is large and slow, and a mean over a window tells little beside it; a push begins and ends
within tens of milliseconds, where such a noise is small. What is left of a torque is divided by the spectrum of its
noise and correlated with pushes of several lengths: no other linear statistic sees them better (Turin 1960). The
largest is taken out and the rest asked again, for the flank of one push is not another. What comes again with the
motion is none, nor is a single wild sample. A push may turn the joint, stop it or set it in motion: there a model errs
in ways of its own, and a push must be far larger than what other reversals and rests of the log show. Nor is any told
that shows only while friction may hold it: a joint at rest bears more than it rubs with once it slides.

References:
    G. L. Turin, An introduction to matched filters, IRE Transactions on Information Theory 6 (1960) 311.
    S. G. Mallat, Z. Zhang, Matching pursuits with time-frequency dictionaries, IEEE Transactions on Signal Processing
    41 (1993) 3397.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.recurrence import Passes, passes_of
from friction_audit.diagnosis.turns import Turns, nearest_turn
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float

Samples = NDArray[np.bool_]
Spectrum = NDArray[np.complex128]
RATE_HZ = 100.0
CORNER_HZ = 25.0
"""Above it inertia times acceleration is the encoder's noise, and nobody pushes."""
LENGTHS_S = (0.1, 0.14, 0.2, 0.28, 0.4, 0.56, 0.8)
"""Lengths of a push that are looked for; a longer one is several, and one much shorter no other than a wild sample."""
BY_CHANCE = 0.01
"""Probability that noise alone holds one."""
ABOUT_S = 0.05
"""Before and behind a push the direction of motion must be clear, or it is one at a reversal."""
LEAST_TIMES, FARTHER = 3.0, 1.5
"""At a reversal or a rest a push must be so many times what nine of ten of them show at most, and must stand out so
many times as far as elsewhere: what a model gets wrong there is different each time, and no noise."""
LEAST_CLEAR = 0.5
"""Share of a push in which the joint clearly moves: at rest friction holds whatever pushes."""
LEAST_FILLED = 0.5
"""Share of a segment of the spectrum that must be clear."""
LEAST_KIND_S, LEAST_PUSHES = 3.0, 16
"""Clear time is halved by speed, the slow half again, until one is shorter than this or than so many pushes; and by
acceleration, the fast half again: what the model lacks is more there, and a push must stand out of it."""
SHAKES_S = (0.1, 0.2, 0.4)
"""Lengths of what is no push but a sample that is out of place or time: it comes as inertia times its second
derivative, a hat. A push has an impulse. A whole sine is not looked for: a long push begins with a step, which is much
like one."""
SEGMENT_S = 2.56
"""Length over which the spectrum is taken."""
SMOOTHED = 5
"""Frequencies over which the spectrum is smoothed."""
MOST = 100
"""Pushes that are looked for: what comes more often is no event."""
REACH_S = 5.12
"""As far as a filter can reach from a push: twice the length over which the spectrum is taken."""
AFTER_WILD_S = 0.1
"""About a wild sample nothing is looked for."""
LEAST_SHARE = 0.2
"""Of what a filter sees of the torque of known effects: what is smaller may be what their formulas get wrong."""
LEAST_OF_MODEL = 0.05
"""Of what it sees of inertia and friction. A quiet sensor shows what no model gets right: of an inertia that is wrong
by a hundredth, or a motion that is logged a millisecond late, every brisk stroke."""
FEWEST_AGAIN, HALF = 2, 0.5
SIGMA_PER_MEDIAN, SIGMA_PER_NINTH_DECILE = 1.4826, 0.6080


@dataclass(frozen=True, kw_only=True, slots=True)
class Push:
    """One of them.

    Attributes:
        start_s: Its beginning, from the first sample on. [s]
        stop_s: Its end. [s]
        size: How far it stands out, with its sign, in standard deviations.
    """

    start_s: float
    stop_s: float
    size: float


@dataclass(frozen=True, eq=False, kw_only=True)
class _Matched:
    """A filter for pushes of one length and form about each of n samples.

    Attributes:
        push: The push, shape (k,).
        pushes: Whether it is one, with an impulse, and not an error of the position or a wild sample.
        response: The filter, by frequency, shape (f,).
        norm: Root of the push's energy over the noise's spectrum.
        clear: Where the push and a little about it are clear, shape (n,).
        turns: Where the push or a little about it holds a reversal or a rest, and most of it is clear, shape (n,).
        kinds: Number of the pushes during which the joint was as fast, and of those in which it was accelerated as
            much, shape (n,) each.
    """

    push: Float
    pushes: bool
    response: Spectrum
    norm: float
    clear: Samples
    turns: Samples
    kinds: tuple[NDArray[np.int64], ...]

    def of(self, spectrum: Spectrum, length: int) -> Float:
        """Size of a push about each sample, in standard deviations of the noise's spectrum, shape (length,).

        Args:
            spectrum: Transform of a signal.
            length: Of the transform, a part of the filter's own.
        """
        from scipy.fft import irfft

        response = self.response[:: 2 * (len(self.response) - 1) // length]
        return np.asarray(irfft(spectrum * response, length) / self.norm)

    def usual(self, size: Float) -> Float:
        """What pushes of each kind in fact are, infinite where none is looked for, shape (n,)."""
        sigma = np.full(len(size), np.inf)
        if not self.clear.any():
            return sigma
        sigma[self.clear] = _sigma(np.abs(size[self.clear]))
        for kind in self.kinds:
            for number in np.unique(kind[self.clear]):
                which = self.clear & (kind == number)
                sigma[which] = np.maximum(sigma[which], _sigma(np.abs(size[which])))
        return sigma


def find_pushes(
    data: JointData, left: Float, known: Float, clear: Samples, turning: Samples, winding: Samples
) -> tuple[Push, ...]:
    """Find pushes in what is left of a torque, the largest first, at most ``MOST``.

    Args:
        data: The joint, n samples: what is left grows with its acceleration, or comes again with its motion.
        left: What is left, shape (n,). [N m]
        known: Torque of known effects that was taken off, shape (n,): what is far smaller may be what their formulas
            lack. [N m]
        clear: Samples in which the direction of motion is clear, shape (n,).
        turning: Samples about reversals and rests, in which only what friction cannot be is left, shape (n,). They
            count for a push that reaches into them; for any other a straight line leads over them, as over the rest.
        winding: Samples of rests, and behind rests and reversals, in which friction may be anything, shape (n,). With
            straight lines over them a push must still be half as large.
    """
    from scipy.fft import rfft

    slides = (clear | turning) & ~winding
    if slides.sum() * data.step_s < SEGMENT_S:
        return ()
    every = max(int(1.0 / (RATE_HZ * data.step_s) + 1e-9), 1)
    about = round(ABOUT_S / data.step_s)
    rest, over_turns = (_thinned(bridged(left, counts, about), every) for counts in (clear, clear | turning))
    hardness = (-np.abs(data.dq[::every]), _thinned(np.abs(data.ddq), every))
    step_s = data.step_s * every
    length = _length(len(rest), step_s)
    matched = _filters(rest, clear[::every], turning[::every], hardness, step_s, length)
    modelled = data.torque - known - left
    signals = rest, over_turns, *(_thinned(one, every) for one in (bridged(left, slides, about), known, modelled))
    plain, over, free, *taken_off = (rfft(one, length) for one in signals)
    sizes = np.stack(
        [np.where(m.turns, m.of(over, length)[: len(rest)], m.of(plain, length)[: len(rest)]) for m in matched]
    )
    held = np.stack([_held(size, m.of(free, length)) for m, size in zip(matched, sizes, strict=True)])
    sigma = np.stack([one.usual(size) for one, size in zip(matched, sizes, strict=True)])
    turns = Turns(number=nearest_turn(turning[::every]), seen=np.stack([one.turns for one in matched]))
    least = _least((clear | turning)[::every], step_s, len(matched))
    near = round(AFTER_WILD_S / step_s)
    return tuple(
        push
        for push, k, at, unit in _pursued(sizes, sigma, held, turns, matched, least, passes_of(data, every), step_s)
        if all(
            abs(push.size) > share * _largest(matched[k].of(off, length) / unit, at, near)
            for share, off in zip((LEAST_SHARE, LEAST_OF_MODEL), taken_off, strict=True)
        )
    )


def bridged(signal: Float, counts: Samples, about: int) -> Float:
    """A signal with straight lines over the samples that do not count, shape (n,).

    They lead from and to a median over a quarter of the gap, of so many samples at most: one may still be moved by what
    does not count, and a long line to it would be a push. It is that of tapered means of half as many: of an encoder's
    noise, as inertia times acceleration, a median alone leaves most.
    """
    place, step = np.flatnonzero(counts), np.arange(max(about, 1))
    values, gaps = _calm(signal, counts, about // 2)[place], np.flatnonzero(np.diff(place) > 1)
    ends, starts = np.append(gaps, len(place) - 1), np.append(0, gaps + 1)
    wide = np.maximum(np.diff(place)[gaps] // 4, 1)
    levels = [
        np.nanmedian(np.where(step < many[:, None], values[np.clip(near, 0, len(place) - 1)], np.nan), axis=1)
        for near, many in (
            (starts[:, None] + step, np.append(about, wide)),
            (ends[:, None] - step, np.append(wide, about)),
        )
    ]
    corners = np.ravel([place[starts], place[ends]], order="F")
    line = np.interp(np.arange(len(signal)), corners, np.ravel(levels, order="F"))
    return np.where(counts, signal, line)


def _calm(signal: Float, counts: Samples, samples: int) -> Float:
    """Means of the samples that count, weighted by the square of a sine so many samples long about each."""
    from scipy.ndimage import convolve1d

    weights = np.sin(np.pi * (np.arange(max(samples, 1)) + 0.5) / max(samples, 1)) ** 2
    sums, some = (convolve1d(one, weights, mode="constant") for one in (np.where(counts, signal, 0.0), 1.0 * counts))
    return np.asarray(sums / np.maximum(some, np.finfo(float).tiny))


def _held(size: Float, free: Float) -> Samples:
    """Where friction may be most of a push: what is free of it, shape (m,), is less than half of it, shape (n,)."""
    return np.asarray(free[: len(size)] * np.sign(size) < HALF * np.abs(size))


def _largest(size: Float, at: int, near: int) -> float:
    return float(np.max(np.abs(size[max(at - near, 0) : at + near + 1])))


def _length(samples: int, step_s: float) -> int:
    """Of a transform: more than the samples, and a multiple of what one push needs."""
    from scipy.fft import next_fast_len

    part = 2 * round(REACH_S / step_s)
    return part * int(next_fast_len(samples // part + 2))


def _thinned(signal: Float, every: int) -> Float:
    """Every so many samples, of frequencies below half the new rate."""
    from scipy.signal import resample_poly

    return np.asarray(resample_poly(signal, 1, every, padtype="line"))


def _pursued(
    sizes: Float,
    sigma: Float,
    held: Samples,
    turns: Turns,
    matched: list[_Matched],
    least: float,
    passes: Passes,
    step_s: float,
) -> Iterator[tuple[Push, int, int, float]]:
    """One push after the other, with the number of its filter, its sample, and what is usual there.

    Sizes, shape (filters, n), are changed on the way; ``sigma``, of the same shape, is what is usual where neither a
    reversal nor a rest is near, infinite where one is; ``held`` is where friction may be most of a push.
    """
    apart, reach = round(AFTER_WILD_S / step_s), round(REACH_S / step_s)
    touched = np.zeros(turns.number[-1] + 1, bool)
    inside, barred = np.zeros((2, sizes.shape[1]), bool)
    unit = _with_turns(sigma, sizes, turns, touched, least)
    first = sizes / unit
    for _ in range(MOST):
        there = np.where(barred | held, 0.0, np.abs(sizes) / unit)
        best, at = (int(k) for k in np.unravel_index(np.argmax(there), there.shape))
        if there[best, at] < least:
            break
        found, size, usual = matched[best], float(sizes[best, at] / unit[best, at]), float(unit[best, at])
        _take_out(sizes, matched, best, at, reach)
        again = [place for place in passes.like(at) if not inside[place]]
        if not found.pushes or _recurs(first[best] * np.sign(size), abs(size), again, apart, least):
            for place in (at, *again):
                barred[max(place - apart, 0) : place + apart + 1] = True
            continue
        start, stop = at - len(found.push) // 2, at - len(found.push) // 2 + len(found.push)
        about = slice(max(start - apart, 0), stop + apart)
        inside[about] = True
        if not touched[turns.number[about]].all():
            touched[turns.number[about]] = True
            unit = _with_turns(sigma, sizes, turns, touched, least)
        yield Push(start_s=start * step_s, stop_s=stop * step_s, size=size), best, at, usual


def _with_turns(sigma: Float, sizes: Float, turns: Turns, touched: Samples, least: float) -> Float:
    """What is usual, shape (filters, n), at reversals and rests too, of which those count that no push has touched."""
    at_turns = LEAST_TIMES / least * turns.usual(sizes, touched)
    asked = turns.seen & ~touched[turns.number]
    for k in np.flatnonzero(np.isfinite(at_turns)):
        usual = max(float(np.min(sigma[k])), _sigma(np.abs(sizes[k, asked[k]])))
        at_turns[k] = max(at_turns[k], FARTHER * usual)
    return np.where(turns.seen, at_turns[:, None], sigma)


def _take_out(sizes: Float, matched: list[_Matched], best: int, at: int, reach: int) -> None:
    """Take a push, fitted after its own filter, out of what all filters give about it."""
    from scipy.fft import rfft

    push, torque = matched[best].push, np.zeros(2 * reach)
    start = reach - len(push) // 2
    torque[start : start + len(push)] = sizes[best, at] / matched[best].norm * push
    first, last = max(at - reach, 0), min(at + reach, sizes.shape[1])
    spectrum = rfft(torque)
    for size, one in zip(sizes, matched, strict=True):
        size[first:last] -= one.of(spectrum, 2 * reach)[first - at + reach : last - at + reach]


def _recurs(size: Float, own: float, again: list[int], near: int, least: float) -> bool:
    """Whether half as much is near most moments at which the joint moves alike, or what stands out is little more."""
    if len(again) < FEWEST_AGAIN:
        return False
    there = [float(np.max(size[max(place - near, 0) : place + near + 1])) for place in again]
    return float(np.median(there)) > HALF * own or own - float(np.median(size[again])) < least


def _least(clear: Samples, step_s: float, filters: int) -> float:
    """How far a push must stand out: all moments and forms that are tried counted."""
    from scipy.special import ndtri

    tried = 2.0 * CORNER_HZ * step_s * float(clear.sum()) * filters
    return float(-ndtri(0.5 * BY_CHANCE / tried))


def _filters(
    rest: Float, clear: Samples, turning: Samples, hardness: tuple[Float, ...], step_s: float, length: int
) -> list[_Matched]:
    """Half a sine and a step of each length; what is no push: a wild sample, and hats."""
    from scipy.fft import rfft, rfftfreq
    from scipy.ndimage import minimum_filter1d, uniform_filter1d

    frequency = rfftfreq(length, step_s)
    weight = np.where(frequency < CORNER_HZ, 1.0 / _noise(rest, clear, step_s)(frequency), 0.0)
    matched = []
    forms = [(push, True) for push in _pushes(step_s)] + [(shake, False) for shake in _shakes(step_s)]
    for push, pushes in forms:
        about = np.zeros(length)
        about[(np.arange(len(push)) - len(push) // 2) % length] = push
        spectrum = rfft(about)
        about_it = len(push) + 2 * round(ABOUT_S / step_s) + 1
        whole = minimum_filter1d(clear, about_it, mode="constant")
        turns = minimum_filter1d(clear | turning, about_it, mode="constant") & ~whole
        turns &= uniform_filter1d(clear.astype(float), len(push), mode="constant") >= LEAST_CLEAR
        matched.append(
            _Matched(
                push=push,
                pushes=pushes,
                response=np.conj(spectrum) * weight,
                norm=float(np.sqrt(2.0 * np.sum(np.abs(spectrum) ** 2 * weight) / length)),
                clear=np.asarray(whole, bool),
                turns=np.asarray(turns, bool),
                kinds=tuple(_kinds(one, whole, len(push), step_s) for one in hardness),
            )
        )
    return matched


def _pushes(step_s: float) -> list[Float]:
    samples = [round(length_s / step_s) for length_s in LENGTHS_S]
    return [*(np.sin(np.pi * (np.arange(m) + 0.5) / m) for m in samples), *(np.ones(m) for m in samples)]


def _shakes(step_s: float) -> list[Float]:
    """A wild sample, and second derivatives of a bump, which have no impulse."""
    around = [(np.arange(m) + 0.5) / m for m in (round(length_s / step_s) for length_s in SHAKES_S)]
    hats = [np.sin(np.pi * x) - 2.0 * np.sin(np.pi * x).mean() * np.sin(np.pi * x) ** 2 for x in around]
    return [np.ones(1), *hats]


def _kinds(hardness: Float, clear: Samples, samples: int, step_s: float) -> NDArray[np.int64]:
    """Number of the kind of a push about each sample, shape (n,)."""
    from scipy.ndimage import uniform_filter1d

    least = max(LEAST_KIND_S / step_s, LEAST_PUSHES * samples)
    halvings = int(np.log2(max(float(clear.sum()) / least, 1.0)))
    hard = uniform_filter1d(hardness, samples)
    edges = np.quantile(hard[clear], 1.0 - 0.5 ** np.arange(1.0, halvings + 1.0)) if halvings else np.zeros(0)
    return np.searchsorted(edges, hard, side="right").astype(np.int64)


def _noise(rest: Float, clear: Samples, step_s: float) -> Callable[[Float], Float]:
    """Power spectrum per sample, as a function of frequency: medians over segments, which few pushes do not move."""
    from scipy.fft import rfft, rfftfreq
    from scipy.ndimage import uniform_filter1d

    samples = min(round(SEGMENT_S / step_s), len(rest))
    window = np.hanning(samples + 2)[1:-1]
    window /= np.linalg.norm(window)
    starts = np.arange(0, len(rest) - samples + 1, max(samples // 2, 1))[:, None] + np.arange(samples)
    filled = clear[starts] @ window**2
    power = np.abs(rfft(window * rest[starts], axis=1)) ** 2 / np.maximum(filled, LEAST_FILLED)[:, None]
    enough = filled >= min(LEAST_FILLED, float(np.max(filled)))
    usual = np.median(power[enough], axis=0) / np.log(2.0)
    floor = np.finfo(float).eps * max(float(usual.max()), np.finfo(float).tiny)
    smooth = uniform_filter1d(np.log(np.maximum(usual, floor)), SMOOTHED, mode="nearest")
    return lambda frequency: np.asarray(np.exp(np.interp(frequency, rfftfreq(samples, step_s), smooth)))


def _sigma(size: Float) -> float:
    """Robust, and no smaller than the tails say."""
    median, decile = np.quantile(size, (0.5, 0.9))
    return max(SIGMA_PER_MEDIAN * float(median), SIGMA_PER_NINTH_DECILE * float(decile), float(np.finfo(float).tiny))
