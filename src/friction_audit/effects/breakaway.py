"""Stiction: a joint that rested rubs more until it has slid a little.

Contacts age at rest and are renewed by sliding (J. H. Dieterich, J. Geophys. Res. 77 (1972) 3690; A. Ruina, J. Geophys.
Res. 88 (1983) 10359): after a rest of length T the excess is F_e (1 - exp(-T / T_a)), and it falls by exp(-x / x_c)
over the path x since the onset. What a joint at rest could have borne is in this torque only where its velocity,
however small, already has the sign of the motion that follows: at break-away. Before, it bears what it is asked to.

At rest, friction balances the applied torque; at the last moment of rest it is at its limit, in the direction of the
motion that follows. That moment is found from the position: without stiction a torque that rises steadily moves the
joint as the cube of the time since. With stiction it starts faster, and the moment is found too early, so that the
torque, still rising, is too low; a smooth start never gives too high a torque.

A joint that creeps before it moves, on bristles or on a spring, has no such moment. Where the torque jumps, as where a
controller starts the joint, some milliseconds make it another: it tells nothing, unless it falls behind the start by
more than that. Then the joint had been loaded with more than sliding takes.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import SIGMA_PER_MEDIAN, JointData, Nominal, grid_noise, shares_of_span
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Bool, Float, Int
from friction_audit.preprocessing.interaction import Caution

STANDSTILL_S = 0.06  # so long a joint stands still before it breaks away; its torque is followed over this time
# Samples between standstill and break-away: half a period of the grid's corner, by which the low-pass smears.
APART = 2
DEGREE = 2  # of the polynomial that carries the torque on to the break-away: a hand's torque bends over such a time
SETTLED = 4  # samples after the last certain motion, in which the joint may still come to rest
LONGEST_S = 0.3  # the start is looked for so long before the motion is certain
# Share of the dead speed below which a joint stands still: positions tell so much slower a motion than velocities.
CREEP = 0.1
CERTAIN = 2.0  # the start is fitted up to so many times the dead speed
SOON_S = 0.1  # a joint that does not reach it in this time has not left its rest for good
# The onset is known to so much: two samples by the low-pass, and two by a start that is not quite cubic.
ONSET_S = 0.01
# What the torque changes in that time is nothing if it is below its noise, or below this share of the torque.
SMALL_SHARE = 0.05
# If the torque rises by more than both behind a start, this share of it and so many standard deviations of its changes
# at rest, the joint had not been loaded up to its friction.
CARRIED_SHARE, CARRIED_SIGMAS = 0.25, 2.0
# If it falls behind a start by more than it rose before and so many standard deviations, sliding takes less.
FALL_SIGMAS = 4.0
# To the dead speed a joint takes 2.4 times as long as from there to twice that; if longer, it moved by one count.
SLOWEST = 3.0


@dataclass(frozen=True, eq=False, slots=True)
class Breakaways:
    """Moments at which a joint leaves a standstill, k of them, on the fine grid."""

    samples: Int  # samples of the standstill whose torque is followed, shape (k, w)
    onset: Int  # sample at which the joint starts, shape (k,)
    certain: Int  # first sample whose direction is certain, shape (k,)
    direction: Float  # -1 or 1, shape (k,)
    weights: Float  # what carries them on to the onset, sum 1, shape (w,)

    def of(self, columns: Float) -> Float:
        """Columns, shape (n,) or (n, p), carried on to the onsets, shape (k,) or (k, p)."""
        return np.asarray((columns.T[..., self.samples] @ self.weights).T, np.float64)

    def take(self, which: Bool) -> "Breakaways":
        """Some of them, by a mask of shape (k,)."""
        kept = {name: getattr(self, name)[which] for name in ("samples", "onset", "certain", "direction")}
        return replace(self, **kept)


def find_breakaways(q: Float, dq: Float, dead_speed: float, step_s: float) -> Breakaways:
    """Find the moments at which a joint leaves a standstill, from signals (n,) on an even grid."""
    still = max(round(STANDSTILL_S / step_s), DEGREE + 1)
    before = still + APART
    going = np.abs(dq) > dead_speed
    starts = np.flatnonzero(~going[:-1] & going[1:]) + 1
    stops = np.append(0, np.flatnonzero(going[:-1] & ~going[1:]) + 1)
    rests = stops[np.searchsorted(stops, starts) - 1]  # first sample of the rest before each start
    found: list[tuple[int, int, int]] = []
    for certain, rest in zip(starts.tolist(), rests.tolist(), strict=True):
        begin = max(rest + SETTLED, certain - round(LONGEST_S / step_s))
        stop = _certain_for_good(dq, certain, dead_speed, round(SOON_S / step_s))
        if stop is None or certain - begin <= before:
            continue
        onset = begin + _start_of(q[begin:stop], before, certain - begin)
        creep = abs(q[onset - APART] - q[onset - before]) / (still * step_s)
        sudden = certain - onset <= SLOWEST * (stop - certain) + APART
        if onset > begin + before and creep <= CREEP * dead_speed and sudden:
            found.append((onset - before, onset, certain))
    first, onsets, certains = np.asarray(found, np.int64).reshape(-1, 3).T
    back = np.arange(-still, 1) - float(APART)  # from where a polynomial is read, behind the samples it is fitted to
    weights = np.linalg.pinv(np.vander(back / still, DEGREE + 1))[-1]
    return Breakaways(first[:, None] + np.arange(still + 1), onsets, certains, np.sign(dq[certains]), weights)


@lru_cache(maxsize=1)
def breakaways_of(data: JointData) -> Breakaways:
    """The break-aways of a joint, whose rests the position alone shows (resampled: none 130001 held)."""
    q = data.q if data.logged_q is None else data.logged_q
    return find_breakaways(q, data.dq, data.dead_speed_rad_s, data.step_s)


def torque_known(torque: Float, breakaways: Breakaways, step_s: float) -> Bool:
    """Whether the torque of each break-away is known, although its moment is to some milliseconds only, shape (k,).

    It is where it is the same earlier or later, or falls behind the start by more than it differs there: friction is
    less once the joint moves, and whoever pushes gives way.
    """
    if not len(breakaways.onset):
        return np.zeros(0, np.bool_)
    windows = torque[breakaways.samples]
    still, apart = windows.shape[1] - 1, max(round(ONSET_S / step_s), 1)
    powers = np.vander(np.arange(-still, 1) - float(APART), DEGREE + 1)
    fitted = windows @ np.linalg.pinv(powers).T
    change, noise = np.abs(fitted[:, -2]) * ONSET_S / step_s, grid_noise(torque)
    usual = float(np.median(np.abs(fitted[:, -1])))
    steady = change <= max(noise, SMALL_SHARE * usual)
    at_rest = SIGMA_PER_MEDIAN * float(np.median(np.abs(windows[:, apart:] - windows[:, :-apart])))
    behind = torque[np.minimum(breakaways.onset + APART + apart, len(torque) - 1)]
    rise = (behind - fitted[:, -1]) * breakaways.direction
    carried = rise > max(CARRIED_SIGMAS * at_rest, CARRIED_SHARE * usual)
    falls = -rise > np.maximum(change, FALL_SIGMAS * noise)
    return np.asarray((steady & ~carried) | falls)


def signed_rest(dq: Float, ddq: Float, breakaways: Breakaways, dead_speed: float) -> tuple[Float, Float]:
    """Give the standstill before a break-away the direction of the motion that follows, and no acceleration."""
    dq, ddq = dq.copy(), ddq.copy()  # what is built on the sign of the velocity then holds as it does in motion
    for k, first in enumerate(breakaways.samples[:, 0]):
        dq[first : breakaways.certain[k]] = breakaways.direction[k] * dead_speed
        ddq[first : breakaways.onset[k]] = 0.0
    return dq, ddq


def _certain_for_good(dq: Float, certain: int, dead_speed: float, most: int) -> int | None:
    """Sample after the first that is clearly faster than the dead speed, None if the joint slows down before."""
    speed = dq[certain : certain + most] * np.sign(dq[certain])
    fast = np.flatnonzero(speed >= CERTAIN * dead_speed)
    if not len(fast) or speed[: fast[0]].min(initial=np.inf) < 0.5 * dead_speed:
        return None
    return certain + int(fast[0]) + 1


def _start_of(q: Float, earliest: int, latest: int) -> int:
    """Sample from which a path that was constant grows as the cube of the time, by least squares."""
    tried, cubes = slice(earliest, latest), np.arange(float(len(q))) ** 3
    # Of the cubes since each sample: products with the path less its mean, sum, and sum of squares.
    along = np.convolve((q - q.mean())[::-1], cubes)[len(q) - 1 :: -1][tried]
    grown, squares = np.cumsum(cubes)[::-1][tried], np.cumsum(cubes**2)[::-1][tried]
    return earliest + int(np.argmax(along**2 / (squares - grown**2 / len(q))))


SHORTEST_REST_S = 0.02  # A rest is at least so long: a reversal is none
REST_SHARE = 1e-2  # A joint rests below this share of its usual speed
AGEINGS_S = (0.01, 0.3, 3.0)  # at once, within a pause between strokes, and over many
AT_ONCE_RAD = 1e-5  # A path of renewal that is over before the direction of motion is certain
SPAN_SHARES = np.geomspace(3e-4, 0.03, 6)  # longer ones as shares of the span of the motion
# As many as the cycles that a diagnosis takes; whether they are enough, price of entry and locked cycles say.
FEWEST_BREAKAWAYS = 6


class Stiction(Effect):
    label = "higher torque at breakaway"
    axis = "displacement"
    coefficients = (Parameter("breakaway_excess_nm", "N m", "break-away minus sliding friction", lower=0.0),)
    nonlinear = (
        Parameter("ageing_s", "s", "time constant at rest", lower=1e-4, upper=1e3),
        Parameter("renewal_rad", "rad", "path of the decay", lower=1e-7, upper=1.0),
    )
    record = "start slowly at least 15 times after rests from 0.1 to 10 s"
    separate = {
        "presliding": "start after rests from 0.1 to 10 s and reverse without any: only stiction needs the rest",
        "contact_event": "start 15 times after a rest: stiction comes at every start, a contact does not",
        "backlash": "start again in the same direction after a rest: without a reversal no gap opens",
    }
    screened = 2

    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield the excess after every onset per unit of that after a long rest, each as a column."""
        slow = REST_SHARE * float(np.sqrt(np.mean(motion.dq**2)))
        direction = np.sign(motion.dq)
        q, step = np.ascontiguousarray(motion.q), float(motion.t[1] - motion.t[0])
        rest, slid = since_onset(q, direction, np.abs(motion.dq) > slow, step)
        aged = {ageing: direction * -np.expm1(-rest / ageing) for ageing in {ageing for ageing, _ in many}}
        for path in dict.fromkeys(path for _, path in many):
            left = np.exp(-slid / path)
            yield from ((k, (aged[age] * left)[:, None]) for k, (age, own) in enumerate(many) if own == path)

    def tries(self, data: JointData) -> Iterable[Sequence[float]]:
        return product(AGEINGS_S, (AT_ONCE_RAD, *shares_of_span(data, SPAN_SHARES)))

    def identifiable_part(self, data: JointData) -> tuple[Nonlinear, ...]:
        """Return what any starts show: an excess that fades over a path, however the torque rose at break-away."""
        enough = _starts(data)[0] >= FEWEST_BREAKAWAYS
        return tuple(at for at in self.grid(data) if enough and at["renewal_rad"] != AT_ONCE_RAD)

    @staticmethod
    def requires(data: JointData, _nominal: Nominal) -> Caution | None:
        """The motion that is lacking for an excess that is gone at once."""
        starts, telling = _starts(data)
        numbers = {"starts": starts, "telling": telling, "fewest": FEWEST_BREAKAWAYS}
        return None if telling >= FEWEST_BREAKAWAYS else Caution("few_breakaways", numbers=numbers)


def _starts(data: JointData) -> tuple[int, int]:
    """How often the joint breaks away from a standstill, and how often the torque at that moment is known."""
    seen = breakaways_of(data)
    counted = data.valid[seen.onset] & (data.cycle[seen.onset] >= 0)
    return int(counted.sum()), int(np.sum(counted & torque_known(data.without_gravity, seen, data.step_s)))


@compiled()
def since_onset(q: Float, direction: Float, moving: Bool, step_s: float) -> tuple[Float, Float]:
    """Return how long the latest rest was and the path since, shape (n,) each. [s], [rad]

    Both are 0 before and during a rest; in its last samples whose velocity already has the ``direction`` of the
    onset, the rest counts and the path is 0.
    """
    rest, slid = np.zeros(len(q)), np.zeros(len(q))
    still, latest, path = 0.0, 0.0, 0.0
    for k in range(1, len(q)):
        if moving[k]:
            if still >= SHORTEST_REST_S:
                latest, path = still, 0.0
                back = k - 1
                while back >= 0 and not moving[back] and direction[back] == direction[k]:
                    rest[back] = latest
                    back -= 1
            still = 0.0
            path += abs(q[k] - q[k - 1])
            rest[k], slid[k] = latest, path
        else:
            still += step_s
    return rest, slid
