"""Fewer points for long logs, without hiding anything."""

import numpy as np

from friction_audit.joint_log import Float

MOST_POINTS = 20_000
"""Points of one curve that a reader could still tell apart, and a file can still hold."""


def every_nth(samples: int, most: int = MOST_POINTS) -> slice:
    """Return the stride that leaves at most ``most`` of n samples."""
    return slice(None, None, max(1, -(-samples // most)))


def thin_extremes(t: Float, signal: Float, most: int = MOST_POINTS) -> tuple[Float, Float]:
    """Return at most ``most`` samples that hold the smallest and the largest of every stretch, in order of time.

    Args:
        t: Time, shape (n,). [s]
        signal: Shape (n,).
        most: Number of points wanted.
    """
    width = -(-2 * len(t) // most)
    if width <= 1 or len(t) <= most:
        return t, signal
    whole = len(t) // width * width
    stretches = signal[:whole].reshape(-1, width)
    first = np.arange(0, whole, width)
    places = np.concatenate([first + stretches.argmin(axis=1), first + stretches.argmax(axis=1), [len(t) - 1]])
    kept = np.unique(places)
    return t[kept], signal[kept]


def break_at_gaps(t: Float, signal: Float, longest_s: float) -> Float:
    """Return the signal with NaN after every step of time longer than ``longest_s``: no line is drawn over a hole."""
    broken = signal.copy()
    broken[:-1][np.diff(t) > longest_s] = np.nan
    return broken
