"""Coulomb friction that depends on the position: a wave over the whole range, or over a stretch of it.

B. Armstrong-Helouvry, Control of Machines with Friction, 1991, section 4.4: friction of geared joints repeats with the
position. A wave under a bell is a patch where the bell is narrower than the wave is long.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return sgn(dq) exp(-((q - c) / w)^2 / 2) times cos and sin of k (q - c), two columns."""
    order, centre, width = shape
    off = motion.q - centre
    bell = motion.direction * np.exp(-0.5 * (off / width) ** 2)
    return np.stack([bell * np.cos(order * off), bell * np.sin(order * off)]).T


TERM = Term(
    name="position_dependent_friction",
    label="friction changes with position",
    coefficients=(
        Parameter(name="position_friction_cos_nm", unit="N m", meaning="change at the centre"),
        Parameter(name="position_friction_sin_nm", unit="N m", meaning="change a quarter of a wave further"),
    ),
    nonlinear=(
        Parameter(name="position_friction_order", unit="1", meaning="waves per revolution", lower=0.0, upper=1e4),
        Parameter(name="position_friction_centre_rad", unit="rad", meaning="centre of the stretch"),
        Parameter(name="position_friction_width_rad", unit="rad", meaning="half width of the stretch", lower=1e-4),
    ),
    basis=basis,
    friction=True,
)
