"""Stamps without the jitter of the computer that wrote them.

A robot samples at even ticks; a stamp is that tick plus the time that some other computer took to notice. A stamp that
is 0.1 ms late moves a joint at 1 rad/s by 0.1 mrad, far more than its encoder's noise. Where stamps are ticks of one
clock, some of them lost, the clock's phase is followed, averaged over half a second, and every stamp goes to its tick.
Where one is so late that it is nearer to the next tick, which has a stamp of its own, it goes to the one before; so
does one that would come far earlier than any other, where the next tick was lost.
"""

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float, median_step

WINDOW_S = 0.5
FEWEST_STAMPS = 100
LAGS = (8, 64)
"""Stamps over which the period is measured: over the first, the usual step may be off by six in a hundred."""
LEAST_COHERENCE = 0.5
"""Length of the mean phasor over a window, 1 for stamps exactly on ticks: below it, there is no tick to be seen."""
COMMON, EARLIEST = 0.99, 2.0
"""Nearly all stamps are early by less than this quantile; twice as early is none by chance, for computers are late."""
MOST_MOVED = 0.1
"""Of the stamps, those that are a tick too late: where there are more, they are no ticks of this clock."""


def steady_clock(t: Float) -> Float:
    """Return the stamps on ticks of a clock that drifts slowly, or as they are where there is none, shape (n,). [s]"""
    from scipy.ndimage import uniform_filter1d

    if len(t) < FEWEST_STAMPS:
        return t
    period = _period(t)
    phasor = np.exp(2j * np.pi * t / period)
    window = min(int(WINDOW_S / period), len(t))
    mean = uniform_filter1d(phasor.real, window) + 1j * uniform_filter1d(phasor.imag, window)
    if np.abs(mean).min() < LEAST_COHERENCE:
        return t
    phase = np.unwrap(np.angle(mean)) / (2 * np.pi)
    tick = np.round(t / period - phase)
    order = np.arange(len(t))
    own: Float = np.minimum.accumulate((tick - order)[::-1])[::-1] + order
    earliest = EARLIEST * np.quantile(own + phase - t / period, COMMON)
    while np.any(early := _may_be_late(own) & (own + phase - t / period > earliest)):
        own -= early
    return np.asarray((own + phase) * period) if np.mean(own < tick) <= MOST_MOVED else t


def _may_be_late(tick: Float) -> NDArray[np.bool_]:
    """Stamps that may as well be late ones of the ticks before: nobody has those."""
    return np.asarray(np.diff(tick, prepend=-np.inf) > 1.0)


def _period(t: Float) -> float:
    """Ticks' period: the usual step, mended by how far stamps gain on it over many steps, jitter taken away. [s]"""
    period = median_step(t)
    for far in LAGS:
        phasor = np.exp(2j * np.pi * t / period)
        gained = float(np.angle(np.mean(phasor[far:] * phasor[:-far].conj()))) / (2.0 * np.pi)
        period *= 1.0 + gained * period / float(np.mean(t[far:] - t[:-far]))
    return period
