"""The sequential loops of the segmentation, compiled; joints run in parallel threads."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.joint_log import Float

WORK, COMPENSATION, PRINTED, PATH, RECTIFIED, SQUARE, HALF_SQUARE = range(7)
SUMS = 7


@compiled()
def find_borders(  # noqa: C901 - one pass over the samples, one state machine
    velocity: Float, initiation: float, termination: float, merge: bool
) -> NDArray[np.int64]:
    """Return the samples that separate energy cycles, shape (m + 1,); empty without a complete cycle.

    A cycle begins when the speed exceeds ``initiation`` and is over when it falls below ``termination``. The border
    lies where the joint then comes to rest, the first sample at which the velocity is zero or has changed its sign,
    or else the slowest sample before the next cycle begins: there the kinetic energy is gone and not merely small.
    With ``merge``, two humps between which the velocity never changes its sign are one stroke; a speed, which has no
    sign, is not merged.
    """
    borders = np.empty(len(velocity) + 1, np.int64)
    count = 0
    moving = abs(velocity[0]) > termination
    rested = not moving
    if rested:
        borders[0] = 0
        count = 1
    direction = velocity[0]
    for i in range(len(velocity)):
        v = velocity[i]
        if moving:
            if abs(v) < termination:
                moving, rested = False, False
                borders[count] = i
                count += 1
        elif abs(v) > initiation:
            if merge and not rested and v * direction > 0.0 and count > 1:
                count -= 1
            moving = True
        if moving:
            direction = v
        elif not rested:
            rested = v * direction <= 0.0
            if rested or abs(v) < abs(velocity[borders[count - 1]]):
                borders[count - 1] = i
    return borders[:count].copy() if count > 1 else np.empty(0, np.int64)


@compiled()
def cut_evenly(
    t: Float, speed: Float, borders: NDArray[np.int64], parts: int
) -> tuple[NDArray[np.int64], Float, Float]:
    """Cut each cycle into parts of equal path by the filtered velocity ``speed``.

    Returns:
        Border samples of the parts, shape (m, parts + 1), the last parts empty in a cycle of few samples; peak speed
        [rad/s] and longest time step [s] of each cycle, shape (m,).
    """
    cycles = len(borders) - 1
    edges = np.empty((cycles, parts + 1), np.int64)
    peak, longest = np.zeros(cycles), np.zeros(cycles)
    for c in range(cycles):
        start, stop = borders[c], borders[c + 1]
        total = 0.0
        for i in range(start, stop):
            step = t[i + 1] - t[i]
            total += 0.5 * (abs(speed[i]) + abs(speed[i + 1])) * step
            peak[c] = max(peak[c], abs(speed[i]))
            longest[c] = max(longest[c], step)
        k, gone = 0, 0.0
        edges[c, 0] = start
        for i in range(start, stop):
            gone += 0.5 * (abs(speed[i]) + abs(speed[i + 1])) * (t[i + 1] - t[i])
            if k < parts - 1 and gone >= total * (k + 1) / parts and stop - i > parts - k:
                k += 1
                edges[c, k] = i + 1
        edges[c, k + 1 :] = stop
    return edges, peak, longest


@compiled()
def add_up(
    t: Float,
    q: Float,
    dq: Float,
    filtered: Float,
    torque: Float,
    compensation: Float,
    edges: NDArray[np.int64],
) -> Float:
    """Add up energies between samples by the trapezoid rule: shape (m, parts, SUMS), indexed by the constants above.

    Work and path are summed over the increments of q: both then scale alike with any error of the clock, and the noise
    of the velocity enters neither. ``compensation`` has length 0 where there is none; ``edges`` are the border samples
    of the parts of each cycle, shape (m, parts + 1); all else has shape (n,).
    """
    cycles, parts = edges.shape[0], edges.shape[1] - 1
    sums = np.zeros((cycles, parts, SUMS))
    helped = len(compensation) > 0
    for c in range(cycles):
        for k in range(parts):
            total = sums[c, k]
            for i in range(edges[c, k], edges[c, k + 1]):
                step, moved = t[i + 1] - t[i], q[i + 1] - q[i]
                v0, v1 = dq[i], dq[i + 1]
                u0, u1 = (compensation[i], compensation[i + 1]) if helped else (0.0, 0.0)
                total[WORK] += 0.5 * (torque[i] + torque[i + 1]) * moved
                total[COMPENSATION] += 0.5 * (u0 + u1) * moved
                total[PRINTED] += 0.5 * ((torque[i] + u0) * v0 + (torque[i + 1] + u1) * v1) * step
                total[PATH] += 0.5 * (np.sign(filtered[i]) + np.sign(filtered[i + 1])) * moved
                total[RECTIFIED] += 0.5 * (abs(v0) + abs(v1)) * step
                total[SQUARE] += 0.5 * (v0 * v0 + v1 * v1) * step
            first, last = filtered[edges[c, k]], filtered[edges[c, k + 1]]
            total[HALF_SQUARE] = 0.5 * (last * last - first * first)
    return sums


# Typed, so that importing this module starts the compiler, which takes longer than all the loops of an hour of log.
@compiled("void(float64[::1], float64, float64, float64)")
def low_pass_both_ways(signal: Float, gain: float, a1: float, a2: float) -> None:
    """Run gain (1 + z)^2 / (z^2 + a1 z + a2), of unit gain at rest, over a signal in place, forwards and backwards.

    Each pass begins as if the signal had always been what it is at that end.
    """
    last = len(signal) - 1
    for backwards in (False, True):
        x1 = x2 = y1 = y2 = signal[last if backwards else 0]
        for i in range(len(signal)):
            k = last - i if backwards else i
            x = signal[k]
            y = gain * (x + 2.0 * x1 + x2) - a2 * y2 - a1 * y1
            signal[k] = y
            x2, x1, y2, y1 = x1, x, y1, y
