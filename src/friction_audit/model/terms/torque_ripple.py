"""Torque ripple: a torque that repeats with the position, whatever the direction: cogging, or a gear's teeth.

T. D. Tuttle, W. P. Seering, A nonlinear model of a harmonic drive gear transmission, IEEE Transactions on Robotics and
Automation 12 (1996) 368: periodic at the turns of the wave generator and twice that.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.model.term import Motion, Parameter, Term


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return cos(k q) and sin(k q) as columns."""
    angle = shape[0] * motion.q
    return np.column_stack([np.cos(angle), np.sin(angle)])


TERM = Term(
    name="torque_ripple",
    label="torque periodic in position",
    linear=(
        Parameter(name="ripple_cos_nm", unit="N m", meaning="ripple at q = 0"),
        Parameter(name="ripple_sin_nm", unit="N m", meaning="ripple a quarter of a wave further"),
    ),
    shape=(Parameter(name="ripple_order", unit="1", meaning="waves per revolution", lower=0.0, upper=1e5),),
    basis=basis,
)
