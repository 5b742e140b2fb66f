"""Contact: something touches the arm now and then, for stretches that stand out of all that the motion explains.

No motion tells when an arm is touched: the moments are found where the torque that inertia, friction and gravity leave
is out of the ordinary, and only they are taken from the torque; what is fitted there is a curve of time. Stretches that
come with every stroke are no contacts but a function of the motion.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.excitation import moves
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.mean_sign import mean_sign
from friction_audit.joint_log import Float

WINDOWS_S = (0.1, 0.3, 1.0)
"""Lengths of a touch that are looked for; a longer one is found by its beginning and its end."""
LEAST_SIGMAS = 6.0
"""How far a window's mean stands out: of thousands of windows of noise, none does."""
EDGE_SIGMAS = 2.5
"""How far the shortest window stands out at the beginning and the end of a contact."""
LEAST_FILLED = 0.5
"""Share of a window in which the joint must move."""
TURNING_S = 2.0
"""A shorter touch may drag at a reversal, and turn with it."""
TURN_S = 0.05
"""About a reversal, where the filter mixes both directions, nothing is looked for."""
APART_S = 0.1
"""Stretches that are closer belong to one contact."""
MOST_CYCLES = 0.6
"""Share of the cycles in which contacts may be."""
MOST_TIME = 0.2
"""Share of the time that contacts may take."""
LONGEST_S = 10.0
KNOTS = 5
"""Points of the curve through one contact, nothing at its ends."""
SPEEDS = 24
"""Knots of the friction's curve over the speed, a third apart over three decades."""
SIGMA_PER_MEDIAN = 1.4826


@dataclass(frozen=True, kw_only=True, slots=True)
class Contact:
    """One stretch of time.

    Attributes:
        start_s: Its beginning. [s]
        stop_s: Its end. [s]
    """

    start_s: float
    stop_s: float


def find_contacts(data: JointData) -> tuple[Contact, ...]:
    """Find the stretches of a log in which something touches the joint; none where they come with every stroke."""
    if not data.used.any():
        return ()
    clear = data.used & ~_widened(~data.moving | (np.diff(np.sign(data.dq), append=0.0) != 0), _samples(TURN_S, data))
    if not clear.any():
        return ()
    plain, any_law = _stand_out(data, clear, _plain(data)), _stand_out(data, clear, _any_law(data))
    return tuple(contact for contact in any_law if any(_overlap(contact, other) for other in plain))


def _stand_out(data: JointData, clear: NDArray[np.bool_], friction: Float) -> tuple[Contact, ...]:
    """Stretches that stand out of a friction's columns, shape (n, p); none where they come with every stroke."""
    left = _left(data, clear, friction)
    means = [_window_means(left, clear, _samples(length, data)) for length in WINDOWS_S]
    outlying = np.zeros(len(left), bool)
    for length, mean in zip(WINDOWS_S, means, strict=True):
        outlying |= _widened(np.abs(mean) > LEAST_SIGMAS, _samples(length, data))
    stretches = _stretches(data.t, outlying, np.abs(means[0]) > EDGE_SIGMAS)
    found = tuple(contact for contact in stretches if not _turns(data, left, contact))
    inside = np.zeros(len(left), bool)
    for contact in found:
        inside |= (data.t >= contact.start_s) & (data.t <= contact.stop_s)
    touched = len(np.unique(data.cycle[data.used & inside]))
    rare = touched <= MOST_CYCLES * len(np.unique(data.cycle[data.used])) and float(np.mean(inside)) <= MOST_TIME
    return found if rare and all(c.stop_s - c.start_s <= LONGEST_S for c in found) else ()


def _overlap(one: Contact, other: Contact) -> bool:
    return one.start_s <= other.stop_s and other.start_s <= one.stop_s


def _turns(data: JointData, left: Float, contact: Contact) -> bool:
    """Whether what is left in a long stretch turns with the direction: friction that has changed, and no touch."""
    inside = (data.t >= contact.start_s) & (data.t <= contact.stop_s) & (left != 0.0)
    both = [left[inside & (data.dq > 0.0)], left[inside & (data.dq < 0.0)]]
    if contact.stop_s - contact.start_s < TURNING_S or min(map(len, both)) < _samples(WINDOWS_S[0], data):
        return False
    return float(both[0].mean() * both[1].mean()) < 0.0


def _samples(length_s: float, data: JointData) -> int:
    return round(length_s / data.step_s)


def _left(data: JointData, clear: NDArray[np.bool_], friction: Float) -> Float:
    """Torque that inertia, friction, gravity and a constant leave, 0 where the direction is not clear."""
    columns = np.column_stack([data.ddq, np.cos(data.q), np.sin(data.q), np.ones(len(data.t)), friction])
    columns /= np.maximum(np.sqrt(np.mean(columns**2, axis=0)), np.finfo(float).tiny)
    kept = clear
    left = data.torque
    for _ in range(3):  # what stands out must not bend the fit
        used, torque = columns[kept], data.torque[kept]
        left = data.torque - columns @ np.linalg.lstsq(used.T @ used, used.T @ torque)[0]
        kept = clear & (np.abs(left) < 2.0 * LEAST_SIGMAS * np.median(np.abs(left[clear])))
    return np.where(clear, left, 0.0)


def _plain(data: JointData) -> Float:
    """Coulomb and viscous friction: what comes with every stroke beside them is no touch, whatever else bends to it."""
    return np.column_stack([mean_sign(data.t, data.dq, data.ddq), data.dq])


def _any_law(data: JointData) -> Float:
    """Any friction that only the speed decides, a column a knot: what it does at a slow reversal is no touch."""
    speed = np.abs(data.dq)
    slow = data.dead_speed_rad_s
    knots = np.append(0.0, np.geomspace(slow, max(float(speed.max()), 2.0 * slow), SPEEDS))
    hats = np.column_stack([np.interp(speed, knots, hat) for hat in np.eye(len(knots))])
    return np.asarray(mean_sign(data.t, data.dq, data.ddq)[:, None] * hats)


def _window_means(left: Float, used: NDArray[np.bool_], samples: int) -> Float:
    """Means over raised cosines about each sample, in units of their usual size."""
    from scipy.signal import fftconvolve

    bell = np.hanning(max(samples, 1) + 2)[1:-1]
    if len(bell) >= len(left):
        return np.zeros(len(left))
    filled = fftconvolve(used.astype(np.float64), bell**2, mode="same") / np.sum(bell**2)
    enough = filled > LEAST_FILLED
    mean = np.where(enough, fftconvolve(left, bell, mode="same") / np.sqrt(np.where(enough, filled, 1.0)), 0.0)
    usual = SIGMA_PER_MEDIAN * float(np.median(np.abs(mean[enough]))) if enough.any() else np.inf
    return np.asarray(mean / usual) if usual > 0.0 else np.zeros(len(left))


def _widened(marks: NDArray[np.bool_], samples: int) -> NDArray[np.bool_]:
    """All samples within half a window of a marked one."""
    from scipy.ndimage import maximum_filter1d

    return np.asarray(maximum_filter1d(marks, max(samples, 1)), bool)


def _stretches(t: Float, outlying: NDArray[np.bool_], clear: NDArray[np.bool_]) -> tuple[Contact, ...]:
    """Runs of outlying samples, those that are close put together, from the first clear sample of each to its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], outlying, [False]])))
    starts, stops = t[edges[::2]], t[edges[1::2] - 1]
    far = np.append(True, starts[1:] - stops[:-1] > APART_S) if len(starts) else np.zeros(0, bool)
    last = np.append(np.flatnonzero(far)[1:] - 1, len(starts) - 1) if len(starts) else np.zeros(0, int)
    return tuple(_trimmed(t, clear, float(a), float(b)) for a, b in zip(starts[far], stops[last], strict=True))


def _trimmed(t: Float, clear: NDArray[np.bool_], start: float, stop: float) -> Contact:
    inside = t[clear & (t >= start) & (t <= stop)]
    half = 0.5 * WINDOWS_S[0]
    if not len(inside):
        return Contact(start_s=start, stop_s=stop)
    return Contact(start_s=max(start, float(inside[0]) - half), stop_s=min(stop, float(inside[-1]) + half))


def shapes(data: JointData) -> tuple[Shape, ...]:
    """One shape: where all contacts begin and end."""
    return (
        {
            name: value
            for k, contact in enumerate(find_contacts(data), start=1)
            for name, value in ((f"start_{k}_s", contact.start_s), (f"stop_{k}_s", contact.stop_s))
        },
    )


def columns(data: JointData, _baseline: Baseline, shape: Shape) -> Float:
    """Hats over each contact, shape (n, contacts * KNOTS); a column of zeros where there is none."""
    hats = [np.zeros((len(data.t), 1))] if not shape else []
    for k in range(1, len(shape) // 2 + 1):
        knots = np.linspace(shape[f"start_{k}_s"], shape[f"stop_{k}_s"], KNOTS + 2)
        hats += [
            np.interp(data.t, knots, np.eye(KNOTS + 2)[i], left=0.0, right=0.0)[:, None] for i in range(1, KNOTS + 1)
        ]
    return np.hstack(hats)


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    return moves(data, baseline)


def admissible(_factors: Float, shape: Shape) -> bool:
    """Any push, where there was one."""
    return bool(shape)


CANDIDATE = Candidate(
    name="contact_event",
    label="something touches the arm for a moment",
    shapes=shapes,
    columns=columns,
    column_units=("nm",),
    untestable=untestable,
    admissible=admissible,
    axis="time",
)
