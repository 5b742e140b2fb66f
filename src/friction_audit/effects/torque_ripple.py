"""Torque ripple: a torque that repeats with the position in both directions: cogging, or a gear's teeth.

T. D. Tuttle, W. P. Seering, A nonlinear model of a harmonic drive gear transmission, IEEE Transactions on Robotics and
Automation 12 (1996) 368: periodic at the turns of the wave generator and twice that.

Every order tried is a trial: R. B. Davies, Hypothesis testing when a nuisance parameter is present only under the
alternative, Biometrika 74 (1987) 33.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import BatchedEffect, Nonlinear
from friction_audit.effects.excitation import span
from friction_audit.effects.joint_data import CORNER_HZ, JointData, Nominal, reach, speeds
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

SAME_STEP = 1e-12  # differences of the spacing of orders that are rounding, as a share of the largest
# Distance of orders times the standard deviation of the position: a phase is off by half of it, rms, at most.
FINEST, COARSEST = 1.0, 1.4
# As many as the time of a search allows; where they do not reach, they lie as far apart as they may. The others are
# scanned (``ripple_scan``).
MOST_ORDERS = 120


class TorqueRipple(BatchedEffect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return cos(k q) and sin(k q) as columns."""
        angle = values[0] * motion.q
        return np.stack([np.cos(angle), np.sin(angle)]).T

    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield cos(k q) and sin(k q): those of evenly spaced orders by turning the phase by the same angle.

        That takes four products where cosine and sine take many; a turn is right to rounding, and so are a hundred.
        """
        orders = np.array([order for (order,) in many])
        steps = np.diff(orders)
        if len(steps) == 0 or np.ptp(steps) > SAME_STEP * np.abs(orders).max():
            yield from ((place, self.columns(motion, values)) for place, values in enumerate(many))
            return
        turn, wave = self.columns(motion, [float(np.mean(steps))]).T, self.columns(motion, many[0]).T
        for place in range(len(orders)):
            yield place, wave.T
            wave = _turned(wave, turn)

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """Orders of the range, as far as they reach."""
        (first, last), spread = order_range(data), spread_of(data)
        step = np.clip((last - first) / MOST_ORDERS, FINEST / spread, COARSEST / spread)
        orders = np.arange(first, last, step)[:MOST_ORDERS]
        return tuple({"ripple_order": float(order)} for order in orders) or ({"ripple_order": first},)

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        return span(data, nominal, 0.5)


@compiled()
def _turned(wave: Float, turn: Float) -> Float:
    """Cosine and sine of the sum of two angles, shape (2, n) each."""
    out = np.empty_like(wave)
    for i in range(wave.shape[1]):
        out[0, i] = wave[0, i] * turn[0, i] - wave[1, i] * turn[1, i]
        out[1, i] = wave[0, i] * turn[1, i] + wave[1, i] * turn[0, i]
    return out


def order_range(data: JointData) -> tuple[float, float]:
    """From two periods over the range up to where a slow motion leaves the band."""
    low, high = reach(data)
    (slow,) = speeds(data, 25.0)
    first = 4.0 * np.pi / max(high - low, 1e-3)
    return first, max(2.0 * np.pi * CORNER_HZ / float(slow), first)


def spread_of(data: JointData) -> float:
    """Standard deviation of the position while the joint moves; orders that differ by one over it are others. [rad]"""
    return max(float(np.std(data.q[data.used])) if data.used.any() else 0.0, 1e-3)


EFFECT = TorqueRipple(
    name="torque_ripple",
    label="torque periodic in position",
    family="load and place",
    axis="position",
    coefficients=(
        Parameter("ripple_cos_nm", "N m", "cosine amplitude"),
        Parameter("ripple_sin_nm", "N m", "sine amplitude"),
    ),
    nonlinear=(Parameter("ripple_order", "1", "waves per revolution", lower=0.0, upper=1e5),),
    record="pass slowly and steadily over five periods of the ripple",
    separate={"joint_elasticity": "repeat slow, steady motions at two speeds: a ripple's frequency goes with speed"},
)
