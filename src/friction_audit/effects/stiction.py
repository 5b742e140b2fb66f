"""Stiction: a joint that rested rubs more until it has slid a little.

Contacts age at rest and are renewed by sliding (J. H. Dieterich, J. Geophys. Res. 77 (1972) 3690; A. Ruina, J. Geophys.
Res. 88 (1983) 10359): after a rest of length T the excess is F_e (1 - exp(-T / T_a)), and it falls by exp(-x / x_c)
over the path x since the onset. What a joint at rest could have borne is in this torque only where its velocity,
however small, already has the sign of the motion that follows: at break-away. Before, it bears what it is asked to.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.breakaway import breakaways_of, torque_known
from friction_audit.effects.effect import BatchedEffect, Nonlinear
from friction_audit.effects.excitation import moves
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

SHORTEST_REST_S = 0.02  # A rest is at least so long: a reversal is none
REST_SHARE = 1e-2  # A joint rests below this share of its usual speed
AGEINGS_S = (0.01, 0.3, 3.0)  # at once, within a pause between strokes, and over many
AT_ONCE_RAD = 1e-5  # A path of renewal that is over before the direction of motion is certain
SPAN_SHARES = np.geomspace(3e-4, 0.03, 6)  # longer ones as shares of the span of the motion
# As many as the cycles that a diagnosis takes; whether they are enough, price of entry and locked cycles say.
FEWEST_BREAKAWAYS = 6


class Stiction(BatchedEffect):
    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield the excess after every onset per unit of that after a long rest, each as a column."""
        slow = REST_SHARE * float(np.sqrt(np.mean(motion.dq**2)))
        way = np.sign(motion.dq)
        rest, slid = since_onset(motion.q, way, np.abs(motion.dq) > slow, float(motion.t[1] - motion.t[0]))
        aged = {ageing: way * -np.expm1(-rest / ageing) for ageing in {ageing for ageing, _ in many}}
        for path in dict.fromkeys(path for _, path in many):
            left = np.exp(-slid / path)
            yield from ((k, (aged[age] * left)[:, None]) for k, (age, own) in enumerate(many) if own == path)

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """All ageings with all paths of renewal."""
        return _points(AT_ONCE_RAD, *_paths(data))

    def identifiable_part(self, data: JointData) -> tuple[Nonlinear, ...]:
        """An excess that fades over a path shows after the start, however the torque rose at break-away."""
        starts, _ = _starts(data)
        return _points(*_paths(data)) if starts >= FEWEST_BREAKAWAYS else ()

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        """The motion that is lacking for an excess that is gone at once."""
        starts, telling = _starts(data)
        if telling >= FEWEST_BREAKAWAYS:
            return moves(data, nominal)
        return (
            f"the joint breaks away from a standstill {starts} times, {telling} of them under a torque that rises "
            "slowly or falls after the start: let it stand still for a tenth of a second or more, then raise the "
            f"torque slowly until it moves, at least {FEWEST_BREAKAWAYS} times"
        )


def _points(*paths: float) -> tuple[Nonlinear, ...]:
    return tuple({"ageing_s": age, "renewal_rad": path} for age in AGEINGS_S for path in paths)


def _paths(data: JointData) -> list[float]:
    span = float(np.ptp(data.q)) or 1.0
    return [float(share) * span for share in SPAN_SHARES]


def _starts(data: JointData) -> tuple[int, int]:
    """How often the joint breaks away from a standstill, and how often the torque at that moment is known."""
    seen = breakaways_of(data)
    counted = data.valid[seen.onset] & (data.cycle[seen.onset] >= 0)
    return int(counted.sum()), int(np.sum(counted & torque_known(data.torque, seen, data.step_s)))


def since_onset(q: Float, way: Float, moving: NDArray[np.bool_], step_s: float) -> tuple[Float, Float]:
    """Return how long the latest rest was and the path since, shape (n,) each. [s], [rad]

    Both are 0 before and during a rest; in its last samples that already have the direction of the onset the rest
    counts and the path is 0.

    Args:
        q: Positions, shape (n,). [rad]
        way: Signs of the velocity.
        moving: Samples in which the joint does not rest.
        step_s: Spacing of the samples. [s]
    """
    rest, slid = _since_onset(np.ascontiguousarray(q), np.ascontiguousarray(way), moving, step_s)
    return np.asarray(rest), np.asarray(slid)


@compiled()
def _since_onset(q: Float, way: Float, moving: NDArray[np.bool_], step_s: float) -> tuple[Float, Float]:
    rest, slid = np.zeros(len(q)), np.zeros(len(q))
    still, latest, path = 0.0, 0.0, 0.0
    for k in range(1, len(q)):
        if moving[k]:
            if still >= SHORTEST_REST_S:
                latest, path = still, 0.0
                back = k - 1
                while back >= 0 and not moving[back] and way[back] == way[k]:
                    rest[back] = latest
                    back -= 1
            still = 0.0
            path += abs(q[k] - q[k - 1])
            rest[k], slid[k] = latest, path
        else:
            still += step_s
    return rest, slid


EFFECT = Stiction(
    name="stiction",
    label="higher torque at breakaway",
    family="velocity",
    axis="displacement",
    coefficients=(Parameter("breakaway_excess_nm", "N m", "break-away minus sliding friction", lower=0.0),),
    nonlinear=(
        Parameter("ageing_s", "s", "time constant at rest", lower=1e-4, upper=1e3),
        Parameter("renewal_rad", "rad", "path of the decay", lower=1e-7, upper=1.0),
    ),
    record="start slowly at least 15 times after rests from 0.1 to 10 s",
    separate={
        "presliding": "start after rests from 0.1 to 10 s and reverse without any: only stiction needs the rest",
        "contact_event": "start 15 times after a rest: stiction comes at every start, a contact does not",
        "backlash": "start again in the same direction after a rest: without a reversal no gap opens",
    },
)
