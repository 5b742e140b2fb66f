"""Drift of the torque sensor's zero during a recording, nothing at its start.

The waves are the principal components of a random walk (K. Karhunen, 1947; M. Loeve, Probability Theory, 1955): no
others catch more of one with as many numbers, and a ramp or a settling needs only the first of them.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float

WAVES = 4


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return sin((i - 1/2) pi x) for i = 1..4 as columns, x the share of the recording that is over.

    Those of waves that are faster than the slowest few, which the shape counts, are zero.
    """
    length = motion.t[-1] - motion.t[0]
    share = (motion.t - motion.t[0]) / (length if length > 0.0 else 1.0)
    waves = np.sin(np.pi * share[:, None] * (np.arange(WAVES) + 0.5))
    waves[:, round(shape[0]) or WAVES :] = 0.0
    return np.asarray(waves)


TERM = Term(
    name="torque_drift",
    label="the torque drifts slowly",
    coefficients=tuple(
        Parameter(name=f"drift_{i}_nm", unit="N m", meaning=f"wave of {i - 0.5:g} half turns over the recording")
        for i in range(1, WAVES + 1)
    ),
    nonlinear=(
        # Files of earlier versions have all waves and do not say so.
        Parameter(
            name="drift_waves",
            unit="1",
            meaning="0 all waves, 1 the slowest wave alone, else number of the slowest waves",
            lower=0.0,
            upper=WAVES,
            whole=True,
            optional=True,
        ),
    ),
    basis=basis,
)
