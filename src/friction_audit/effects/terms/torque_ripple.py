"""Torque ripple: a torque that repeats with the position, whatever the direction: cogging, or a gear's teeth.

T. D. Tuttle, W. P. Seering, A nonlinear model of a harmonic drive gear transmission, IEEE Transactions on Robotics and
Automation 12 (1996) 368: periodic at the turns of the wave generator and twice that.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float

SAME_STEP = 1e-12
"""Differences of the spacing of orders that are rounding, as a share of the largest."""


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return cos(k q) and sin(k q) as columns."""
    angle = shape[0] * motion.q
    return np.stack([np.cos(angle), np.sin(angle)]).T


def bases(motion: Motion, shapes: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
    """Yield cos(k q) and sin(k q): those of evenly spaced orders by turning the phase on, by the same angle each time.

    That takes a product where cosine and sine take many; a turn is right to rounding, and so are a hundred of them.
    """
    orders = np.array([order for (order,) in shapes])
    steps = np.diff(orders)
    if len(steps) == 0 or np.ptp(steps) > SAME_STEP * np.abs(orders).max():
        yield from ((place, basis(motion, shape)) for place, shape in enumerate(shapes))
        return
    phase, turn = np.exp(1j * orders[0] * motion.q), np.exp(1j * np.mean(steps) * motion.q)
    for place in range(len(orders)):
        yield place, np.stack([phase.real, phase.imag]).T
        phase *= turn


TERM = Term(
    name="torque_ripple",
    label="torque periodic in position",
    coefficients=(
        Parameter(name="ripple_cos_nm", unit="N m", meaning="ripple at q = 0"),
        Parameter(name="ripple_sin_nm", unit="N m", meaning="ripple a quarter of a wave further"),
    ),
    nonlinear=(Parameter(name="ripple_order", unit="1", meaning="waves per revolution", lower=0.0, upper=1e5),),
    basis=basis,
    bases=bases,
)
