"""Warm-up: friction that fades as the joint gets warm, with the time or with a logged temperature.

A body that is heated evenly approaches its temperature exponentially (Newton's law of cooling), and a lubricant's
viscosity falls exponentially with the temperature (O. Reynolds, Philosophical Transactions 177 (1886) 157).
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float

REFERENCE_DEGC = 25.0


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return sgn(dq) and dq times exp(-t / T - k (temperature - 25 degC)) as columns, t from the start of the log."""
    time_constant, per_kelvin = shape
    fading = -(motion.t - motion.t[0]) / time_constant
    if motion.temperature is not None:
        fading = fading - per_kelvin * (motion.temperature - REFERENCE_DEGC)
    cold = np.exp(fading)
    return np.stack([motion.direction * cold, motion.dq * cold]).T


TERM = Term(
    name="warm_up",
    label="friction falls as the joint warms",
    coefficients=(
        Parameter(name="cold_coulomb_nm", unit="N m", meaning="Coulomb friction that a cold joint has more"),
        Parameter(name="cold_viscous_nms_per_rad", unit="N m s/rad", meaning="viscous friction that it has more"),
    ),
    nonlinear=(
        Parameter(name="warm_up_time_s", unit="s", meaning="time constant", lower=1e-2, upper=1e9),
        Parameter(name="warm_up_per_k", unit="1/K", meaning="share lost per kelvin", lower=0.0, upper=100.0),
    ),
    basis=basis,
    friction=True,
)
