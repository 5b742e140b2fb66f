"""Which waves over the position a residual holds: a periodogram over all orders, at the cost of one transform.

Columns for all the orders that a long range tells apart would be thousands. The product of the rows' residual with a
wave that is filtered like the rows is that of the wave itself with the residual filtered back: one sum over the samples
for all orders, a Fourier transform over the position. What the filter leaves of a wave follows from the speed.
"""

import numpy as np

from friction_audit.joint_log import Float

PER_WAVE = 16
"""Places on which the position is rounded, per wave of the highest order."""
OVERSAMPLED = 8
"""Orders per wave over the range."""
SPEEDS, ORDERS = 200, 200
"""Classes of speed, and orders in between which what the filter leaves is a line."""
LEAST_LEFT = 0.02
"""Share of a wave's square that the filter must leave on the rows: of less nothing can be learned."""


def scan_orders(
    residual: Float, q: Float, speed: Float, first: float, last: float, kernel: Float, step_s: float
) -> tuple[Float, Float]:
    """Tell by how much each order, alone, would lower the residual sum of squares.

    Args:
        residual: Residual of the rows, filtered back onto the fine grid, shape (n,).
        q: Position on the fine grid, shape (n,). [rad]
        speed: Speed at each row, shape (m,). [rad/s]
        first: Lowest order.
        last: Highest order.
        kernel: Weights of the rows' filter, shape (k,).
        step_s: Spacing of the fine grid. [s]

    Returns:
        Orders, evenly spaced, shape (o,), and by how much each would lower the sum of squares, shape (o,).
    """
    from scipy.fft import next_fast_len

    low, length = float(q.min()), OVERSAMPLED * max(float(np.ptp(q)), 1e-3)
    bins = next_fast_len(int(np.ceil(length * last * PER_WAVE / (2.0 * np.pi))) + 1, real=True)
    place = np.minimum(((q - low) / length * bins).astype(np.int64), bins - 1)
    order = np.asarray(2.0 * np.pi / length * np.arange(bins // 2 + 1), np.float64)
    inside = (order >= first) & (order <= last)
    power = np.abs(np.fft.rfft(np.bincount(place, weights=residual, minlength=bins))[inside]) ** 2
    left = _left(order[inside], speed, kernel, step_s)
    enough = left > LEAST_LEFT * len(speed)
    return order[inside], np.where(enough, 2.0 * power / np.where(enough, left, 1.0), 0.0)


def _left(order: Float, speed: Float, kernel: Float, step_s: float) -> Float:
    """Sum over the rows of what the filter leaves of a wave's square, over its mean square, shape (o,)."""
    count, edges = np.histogram(speed, SPEEDS)
    padded = 8 * len(kernel)
    gain = np.abs(np.fft.rfft(kernel, padded)) ** 2
    frequency = np.fft.rfftfreq(padded, step_s)
    usual = 0.5 * (edges[1:] + edges[:-1])
    some = np.linspace(order[0], order[-1], ORDERS) if len(order) else np.zeros(1)
    passed = np.interp(some[:, None] * usual / (2.0 * np.pi), frequency, gain, right=0.0)
    return np.asarray(np.interp(order, some, passed @ count))
