"""Friction that changes once, at a moment of the recording, at once or within some seconds."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return sgn(dq) and dq times a ramp from 0 to 1 about a moment, as columns; a step where its length is 0."""
    moment, length = shape
    later = motion.t - moment
    ramp = np.clip(0.5 + later / length, 0.0, 1.0) if length > 0.0 else (later >= 0.0).astype(np.float64)
    return np.stack([motion.direction * ramp, motion.dq * ramp]).T


TERM = Term(
    name="friction_step",
    label="friction changes at one moment",
    coefficients=(
        Parameter(name="step_coulomb_nm", unit="N m", meaning="Coulomb friction after less before"),
        Parameter(name="step_viscous_nms_per_rad", unit="N m s/rad", meaning="viscous friction after less before"),
    ),
    nonlinear=(
        Parameter(name="step_time_s", unit="s", meaning="when half of the change is over"),
        Parameter(name="step_length_s", unit="s", meaning="how long it takes", lower=0.0),
    ),
    basis=basis,
    friction=True,
)
