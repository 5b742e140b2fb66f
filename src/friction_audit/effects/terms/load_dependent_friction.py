"""Friction that grows with the torque that the gear transmits, perhaps more where the load drives the motor.

A. C. Bittencourt, S. Gunnarsson, Static friction in a robot joint, Journal of Dynamic Systems, Measurement, and
Control 134 (2012) 051013: proportional to |load|; M. Duclusaud et al., Extended friction models for the physics
simulation of servo actuators (2025): quadratic; A. Wang, S. Kim, Directional efficiency in geared transmissions,
ICRA 2015: the loss differs by the direction of the power, sgn(load dq), and sgn(dq) |load| sgn(load dq) is the load.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float


def basis(motion: Motion, shape: Sequence[float]) -> Float:
    """Return sgn(dq) |load|^p and, where the power's direction counts, sgn(load) |load|^p as columns.

    The load is what the sensor is predicted to read: what the motion takes and what the link weighs; or the latter.
    """
    exponent, directed, static = shape
    load = np.zeros(len(motion.t)) if motion.load is None else motion.load
    if motion.rest is not None and not round(static):
        load = load + motion.rest
    size = np.abs(load) ** exponent
    return np.stack([motion.direction * size, np.sign(load) * size * round(directed)]).T


TERM = Term(
    name="load_dependent_friction",
    label="friction grows with load",
    coefficients=(
        Parameter(name="load_friction_nm", unit="N m", meaning="friction at a load of 1 N m, mean of both", lower=0.0),
        Parameter(name="load_friction_by_power_nm", unit="N m", meaning="that against less that with the load, halved"),
    ),
    nonlinear=(
        Parameter(name="load_exponent", unit="1", meaning="exponent of the load", lower=0.5, upper=3.0),
        Parameter(
            name="load_directed",
            unit="1",
            meaning="1 if the power's direction counts",
            lower=0.0,
            upper=1.0,
            whole=True,
        ),
        Parameter(
            name="load_static",
            unit="1",
            meaning="1 if the load is what the link weighs, and not what the motion takes",
            lower=0.0,
            upper=1.0,
            whole=True,
            optional=True,
        ),
    ),
    basis=basis,
)
