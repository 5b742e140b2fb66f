"""Stamps without the jitter of the computer that wrote them.

A robot samples at even ticks; a stamp is that tick plus the time that some other computer took to notice. A stamp that
is 0.1 ms late moves a joint at 1 rad/s by 0.1 mrad, far more than its encoder's noise. Where stamps are ticks of one
clock, some of them lost, the clock's phase is followed, averaged over half a second, and every stamp goes to its tick.
"""

import numpy as np

from friction_audit.joint_log import Float, median_step

WINDOW_S = 0.5
FEWEST_STAMPS = 100
LEAST_COHERENCE = 0.5
"""Length of the mean phasor over a window, 1 for stamps exactly on ticks: below it, there is no tick to be seen."""


def steady_clock(t: Float) -> Float:
    """Return the stamps on ticks of a clock that drifts slowly, or as they are where there is none, shape (n,). [s]"""
    from scipy.ndimage import uniform_filter1d

    if len(t) < FEWEST_STAMPS:
        return t
    steps = np.maximum(np.round(np.diff(t) / median_step(t)), 1.0)
    period = float(np.polyfit(np.concatenate([[0.0], np.cumsum(steps)]), t, 1)[0])
    phasor = np.exp(2j * np.pi * t / period)
    window = min(int(WINDOW_S / period), len(t))
    mean = uniform_filter1d(phasor.real, window) + 1j * uniform_filter1d(phasor.imag, window)
    if np.abs(mean).min() < LEAST_COHERENCE:
        return t
    phase = np.unwrap(np.angle(mean)) / (2 * np.pi)
    steady = (np.round(t / period - phase) + phase) * period
    return steady if np.all(np.diff(steady) > 0) else t
