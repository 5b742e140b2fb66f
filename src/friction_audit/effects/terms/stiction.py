"""Stiction: a joint that rested rubs more until it has slid a little.

Contacts age at rest and are renewed by sliding (J. H. Dieterich, J. Geophys. Res. 77 (1972) 3690; A. Ruina, J. Geophys.
Res. 88 (1983) 10359): after a rest of length T the excess is F_e (1 - exp(-T / T_a)), and it falls by exp(-x / x_c)
over the path x since the onset. What a joint at rest could have borne is in this torque only where its velocity,
however small, already has the sign of the motion that follows: at break-away. Before, it bears what it is asked to.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float

SHORTEST_REST_S = 0.02
"""A rest is at least so long: a reversal is none."""
REST_SHARE = 1e-2
"""A joint rests below this share of its usual speed."""


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return the excess after every onset per unit of that after a long rest, as a column."""
    ageing, path = shape
    slow = REST_SHARE * float(np.sqrt(np.mean(motion.dq**2)))
    way = np.sign(motion.dq)
    rest, slid = since_onset(motion.q, way, np.abs(motion.dq) > slow, float(motion.t[1] - motion.t[0]))
    aged = -np.expm1(-rest / ageing)
    return np.asarray(way * aged * np.exp(-slid / path))[:, None]


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


TERM = Term(
    name="stiction",
    label="higher torque at breakaway",
    coefficients=(
        Parameter(name="breakaway_excess_nm", unit="N m", meaning="friction above sliding after a rest", lower=0.0),
    ),
    nonlinear=(
        Parameter(name="ageing_s", unit="s", meaning="rest over which it grows", lower=1e-4, upper=1e3),
        Parameter(name="renewal_rad", unit="rad", meaning="path over which it goes", lower=1e-7, upper=1.0),
    ),
    basis=basis,
)
