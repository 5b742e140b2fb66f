"""A cable or hose that pulls the joint back: a spring with a free stretch, linear and cubic, and its preload.

The free stretch makes it the slack of a cable; where it covers one end of the range, a tether that pulls at the other.
A linear spring about another centre is one about this centre with a preload.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return the stretch d = q - c less what is free of it, and its cube, and ones, as columns."""
    centre, free = shape
    off = motion.q - centre
    stretch = np.sign(off) * np.maximum(np.abs(off) - free, 0.0)
    # Written out, for a power in general takes ten times as long.
    return np.stack([stretch, stretch * stretch * stretch, np.ones(len(off))]).T


TERM = Term(
    name="cable_spring",
    label="a cable pulls the joint back",
    coefficients=(
        Parameter(
            name="cable_stiffness_nm_per_rad", unit="N m/rad", meaning="stiffness where it begins to pull", lower=0.0
        ),
        Parameter(name="cable_hardening_nm_per_rad3", unit="N m/rad^3", meaning="growth of the stiffness"),
        Parameter(name="cable_preload_nm", unit="N m", meaning="pull at the centre"),
    ),
    nonlinear=(
        Parameter(name="cable_centre_rad", unit="rad", meaning="position where it does not pull"),
        Parameter(name="cable_free_rad", unit="rad", meaning="way to either side without pull", lower=0.0),
    ),
    basis=basis,
)
