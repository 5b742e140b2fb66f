"""Viscous friction that is no straight line: it thins, saturates or grows with the speed.

P. J. Carreau, Rheological equations from molecular network theories, Transactions of the Society of Rheology 16 (1972)
99: viscosity in proportion to (1 + (v / v_0)^2)^((n - 1) / 2). Well above v_0 the friction is |v|^n, well below a line:
n = 2 or 3 is drag, n between 0 and 1 a lubricant that thins, n = 0 a friction that saturates.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.model.term import Motion, Parameter, Term


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return dq ((v_0^2 + dq^2) / (v_0^2 + 1))^((n - 1) / 2) as a column: 1 at 1 rad/s."""
    exponent, speed = shape
    thinning = ((speed**2 + motion.dq**2) / (speed**2 + 1.0)) ** ((exponent - 1.0) / 2.0)
    return np.asarray(motion.dq * thinning)[:, None]


TERM = Term(
    name="nonlinear_viscous",
    label="friction curved in speed",
    linear=(Parameter(name="curved_viscous_nm", unit="N m", meaning="curved friction at 1 rad/s"),),
    shape=(
        Parameter(name="curved_viscous_exponent", unit="1", meaning="exponent at high speed", lower=-1.0, upper=5.0),
        Parameter(name="curved_viscous_speed_rad_s", unit="rad/s", meaning="speed of the bend", lower=1e-6, upper=1e3),
    ),
    basis=basis,
    friction=True,
    speed_only=True,
)
