"""Contact: something touches the arm now and then, for stretches that stand out of all that the motion explains.

No motion tells when an arm is touched: the moments are found where the torque that inertia, friction and gravity leave
is out of the ordinary, and only they are taken from the torque; what is fitted there is a curve of time. Stretches that
come with every stroke are no contacts but a function of the motion.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.pushes import ABOUT_S, CORNER_HZ, HALF, Push, bridged, find_pushes
from friction_audit.diagnosis.rows import filter_rows, row_filter
from friction_audit.effects.breakaway import STANDSTILL_S
from friction_audit.effects.contact_event import Contact, overlap
from friction_audit.effects.effect import Nonlinear
from friction_audit.effects.joint_data import JointData, mean_sign
from friction_audit.joint_log import Float

OUTLYING = 12.0
"""What is so many times the median does not bend the fit."""
TURNING_S = 2.0
"""A shorter touch may drag at a reversal, and turn with it."""
TURN_S = 0.05
"""About a reversal, where the filter mixes both directions, nothing is looked for."""
WINDING_RAD = 1e-3
"""So far behind a reversal or a rest a gear may still wind up before friction has turned: three arc minutes, the most
that makers of strain wave gears state as hysteresis."""
APART_S = 0.2
"""Pushes between which less time is clear belong to one contact."""
HIDDEN_S = 0.2
"""So far a contact may reach over a reversal that is next to it, where nothing is looked for."""
WHOLE_S = 1.0
"""A contact begins and ends so long within the log: what does not may settle, or have changed for good."""
LEAST_SIDE_S = 0.1
"""Of either direction, that a contact may be asked whether it turns."""
MOST_CYCLES = 0.6
"""Share of the cycles in which contacts may be."""
MOST_TIME = 0.2
"""Share of the time that contacts may take."""
LONGEST_S = 10.0
MOST_FRICTION = 0.95
"""Quantile of what the joint rubs with, which holds it at rest and turns at a reversal."""
SPEEDS = 24
"""Knots of the friction's curve over the speed, a third apart over three decades."""


def find_contacts(data: JointData, explained: Float | None = None) -> tuple[Contact, ...]:
    """Find the stretches of a log in which something touches the joint; none where they come with every stroke.

    Args:
        data: The joint.
        explained: Torque of effects that are known already, shape (n,); None where there are none. [N m]
    """
    if not data.used.any():
        return ()
    clear = data.used & ~_near_rest(data)
    if not clear.any():
        return ()
    known = np.zeros(len(data.t)) if explained is None else explained
    plain = _stand_out(data, clear, _plain(data), known)
    if not plain:
        return ()
    any_law = _stand_out(data, clear, _any_law(data), known)
    return tuple(contact for contact in any_law if any(overlap(contact, other) for other in plain))


def _stand_out(data: JointData, clear: NDArray[np.bool_], friction: Float, known: Float) -> tuple[Contact, ...]:
    """Stretches that stand out of a friction's columns, shape (n, p), and of what is known, shape (n,)."""
    turning = data.valid & _near_rest(data)
    left = _left(replace(data, torque=data.torque - known), clear, turning, friction)
    pushes = find_pushes(data, left, known, clear, turning, _winding(data))
    left = np.where(clear, left, 0.0)
    changed = [c for c in _stretches(data.t, clear, pushes, TURNING_S) if _turns(data, left, c)]
    found = tuple(
        contact
        for contact in _stretches(data.t, clear, pushes, APART_S)
        if _whole(data, contact) and not any(overlap(contact, other) for other in changed)
    )
    inside = np.zeros(len(left), bool)
    for contact in found:
        inside |= (data.t >= contact.start_s) & (data.t <= contact.stop_s)
    touched = len(np.unique(data.cycle[data.used & inside]))
    rare = touched <= MOST_CYCLES * len(np.unique(data.cycle[data.used])) and float(np.mean(inside)) <= MOST_TIME
    return found if rare and all(c.stop_s - c.start_s <= LONGEST_S for c in found) else ()


def _whole(data: JointData, contact: Contact) -> bool:
    return bool(contact.start_s >= data.t[0] + WHOLE_S and contact.stop_s <= data.t[-1] - WHOLE_S)


def _turns(data: JointData, left: Float, stretch: Contact) -> bool:
    """Whether what is left in a long stretch turns with the direction: friction that has changed, and no touch."""
    inside = (data.t >= stretch.start_s) & (data.t <= stretch.stop_s) & (left != 0.0)
    both = [left[inside & (data.dq > 0.0)], left[inside & (data.dq < 0.0)]]
    if stretch.stop_s - stretch.start_s < TURNING_S or min(map(len, both)) < _samples(LEAST_SIDE_S, data):
        return False
    one, other = (float(np.median(side)) for side in both)
    return one * other < 0.0 and min(abs(one), abs(other)) > HALF * float(np.median(np.abs(left[inside])))


def _samples(length_s: float, data: JointData) -> int:
    return round(length_s / data.step_s)


def _near_rest(data: JointData) -> NDArray[np.bool_]:
    """Samples about a reversal or a rest, in which friction may have either sign."""
    return _widened(_at_rest(data), _samples(TURN_S, data))


def _winding(data: JointData) -> NDArray[np.bool_]:
    """Samples in which friction may be anything: rests, and behind them and reversals while the gear may wind up."""
    from scipy.ndimage import binary_opening, binary_propagation

    near = _near_rest(data)
    rests = binary_opening(~data.moving, np.ones(max(_samples(STANDSTILL_S, data), 1), bool))
    winds = _hardly_gone(data.q, rests) | (_hardly_gone(data.q, _at_rest(data)) & ~near)
    return np.asarray(binary_propagation(rests, mask=near) | winds, bool)


def _hardly_gone(q: Float, marks: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Samples at which the joint is still where it was at the last marked one, up to what a gear winds up."""
    last = np.maximum.accumulate(np.where(marks, np.arange(len(q)), -1))
    return np.asarray((last >= 0) & (np.abs(q - q[last]) < WINDING_RAD), bool)


def _at_rest(data: JointData) -> NDArray[np.bool_]:
    return np.asarray(~data.moving | (np.diff(np.sign(data.dq), append=0.0) != 0), bool)


def _left(data: JointData, clear: NDArray[np.bool_], turning: NDArray[np.bool_], friction: Float) -> Float:
    """Torque that inertia, friction, gravity and a constant leave, 0 where that is not known.

    At a reversal or a rest friction is whatever is nearest to a straight line through what is left before and after
    it, as far as it can be: it holds with no more than it rubs with.
    """
    others = np.column_stack([np.cos(data.q), np.sin(data.q), np.ones(len(data.t))])
    columns = _even(np.column_stack([others, friction]))
    torque = data.torque - _inertia(data, clear, others) * data.ddq
    factors = _fitted(columns, torque, clear)
    left = torque - columns @ factors
    rubbed = columns[:, others.shape[1] :] @ factors[others.shape[1] :]
    most = float(np.quantile(np.abs(rubbed[clear]), MOST_FRICTION))
    line = bridged(left, clear, _samples(TURN_S, data))
    beyond = left + rubbed - line
    held = line + beyond - np.clip(beyond, -most, most)
    return np.where(clear, left, np.where(turning, held, 0.0))


def _inertia(data: JointData, clear: NDArray[np.bool_], others: Float) -> float:
    """Inertia beside friction and others, shape (n, p), fitted to what passes the corner. [kg m^2]

    Above it the acceleration is the encoder's noise: an inertia fitted there is too small, and what it leaves of every
    brisk stroke would be a touch.
    """
    kernel, every, _ = row_filter(1.0 / data.step_s, CORNER_HZ)
    columns = filter_rows(np.column_stack([data.ddq, others, _plain(data)]), kernel, every)
    size, rows = np.sqrt(np.mean(columns[:, 0] ** 2)), clear[::every]
    if size == 0.0 or not rows.any():
        return 0.0
    return float(_fitted(_even(columns), filter_rows(data.torque, kernel, every), rows)[0] / size)


def _even(columns: Float) -> Float:
    """Columns of a root mean square of one, shape (n, p)."""
    return np.asarray(columns / np.maximum(np.sqrt(np.mean(columns**2, axis=0)), np.finfo(float).tiny))


def _fitted(columns: Float, torque: Float, clear: NDArray[np.bool_]) -> Float:
    """Factors of columns, shape (n, p), on the clear samples of a torque, whatever stands out of it, shape (p,)."""
    kept = clear
    factors: Float = np.zeros(columns.shape[1])
    for _ in range(3):
        used = columns[kept]
        factors = np.asarray(np.linalg.lstsq(used.T @ used, used.T @ torque[kept])[0], np.float64)
        left = np.abs(torque - columns @ factors)
        kept = clear & (left < OUTLYING * np.median(left[clear]))
    return factors


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


def _widened(marks: NDArray[np.bool_], samples: int) -> NDArray[np.bool_]:
    """All samples within half a window of a marked one."""
    from scipy.ndimage import maximum_filter1d

    return np.asarray(maximum_filter1d(marks, max(samples, 1)), bool)


def _stretches(t: Float, clear: NDArray[np.bool_], pushes: Sequence[Push], apart_s: float) -> tuple[Contact, ...]:
    """Pushes in the order of time, those with little clear time in between put together."""
    clear_s = np.append(0.0, np.cumsum(clear) * (t[1] - t[0]))
    found: list[Contact] = []
    for push in sorted(pushes, key=lambda push: push.start_s):
        one = _reaching(t, clear, push)
        if found and _between(t, clear_s, found[-1].stop_s, one.start_s) <= apart_s:
            found[-1] = Contact(start_s=min(found[-1].start_s, one.start_s), stop_s=max(found[-1].stop_s, one.stop_s))
        else:
            found.append(one)
    return tuple(found)


def _between(t: Float, clear_s: Float, stop_s: float, start_s: float) -> float:
    """Clear time between two moments. [s]"""
    first, last = np.searchsorted(t, (stop_s, max(stop_s, start_s)))
    return float(clear_s[last] - clear_s[first])


def _reaching(t: Float, clear: NDArray[np.bool_], push: Push) -> Contact:
    """Where a push is, and over a reversal next to it."""
    start, stop = float(t[0]) + push.start_s, float(t[0]) + push.stop_s
    before, behind = (t >= start - 2.0 * ABOUT_S) & (t < start), (t > stop) & (t <= stop + 2.0 * ABOUT_S)
    return Contact(
        start_s=start if clear[before].all() else start - HIDDEN_S,
        stop_s=stop if clear[behind].all() else stop + HIDDEN_S,
    )


def contact_grid(data: JointData) -> tuple[Nonlinear, ...]:
    """Return one point: start and stop of all contacts of a joint."""
    moments = ((k, contact) for k, contact in enumerate(find_contacts(data), start=1))
    return (
        {name: value for k, c in moments for name, value in ((f"start_{k}_s", c.start_s), (f"stop_{k}_s", c.stop_s))},
    )
