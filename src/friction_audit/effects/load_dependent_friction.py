"""Friction that grows with the torque that the gear transmits, perhaps more where the load drives the motor.

A. C. Bittencourt, S. Gunnarsson, Static friction in a robot joint, Journal of Dynamic Systems, Measurement, and
Control 134 (2012) 051013: proportional to |load|; M. Duclusaud et al., Extended friction models for the physics
simulation of servo actuators (2025): quadratic; A. Wang, S. Kim, Directional efficiency in geared transmissions,
ICRA 2015: the loss differs by the direction of the power, sgn(load dq), and sgn(dq) |load| sgn(load dq) is the load.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Nonlinear, Trait
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

EXPONENTS = (1.0, 1.5, 2.0)
WHOLE: Nonlinear = {}
# The load is all that goes through the gear, or what the link weighs: both are in the literature.
STATIC: Nonlinear = {"load_static": 1.0}
LEAST_CHANGE = 0.1  # of a high load, what it must change by: a steady load's friction is Coulomb friction


class LoadDependentFriction(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return sgn(dq) |load|^p and, where the power's direction counts, sgn(load) |load|^p as columns.

        The load is what the sensor is predicted to read: what the motion takes and what the link weighs; or the latter.
        """
        exponent, directed, static = values
        load = np.zeros(len(motion.t)) if motion.load is None else motion.load
        if motion.rest is not None and not round(static):
            load = load + motion.rest
        size = np.abs(load) ** exponent
        return np.stack([motion.direction * size, np.sign(load) * size * round(directed)]).T

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        lacking = both_directions(data, nominal)
        if lacking:
            return lacking
        if data.load is None:
            return "the load is not known: log gravity or name the arm, and carry different loads over the same motion"
        low, high = np.percentile(np.abs(data.load[data.used]), [5, 95])
        if high - low < max(LEAST_CHANGE * high, abs(nominal.coulomb_nm)):
            return f"the load varies from {low:.2g} to {high:.2g} N m only: change it threefold, by posture or payload"
        return None

    def admissible(self, coefficients: Float, at: Nonlinear) -> bool:
        """It resists motion, whichever way the power flows."""
        return bool(coefficients[0] > 0 and abs(coefficients[1]) <= coefficients[0])

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        return tuple(
            {"load_exponent": p, "load_directed": d, **of}
            for d in (0.0, 1.0)
            for p in EXPONENTS
            for of in (WHOLE, STATIC)
        )


EFFECT = LoadDependentFriction(
    name="load_dependent_friction",
    label="friction grows with load",
    family="load and place",
    axis="load",
    coefficients=(
        Parameter("load_friction_nm", "N m", "friction at a load of 1 N m, mean of both directions", lower=0.0),
        Parameter("load_friction_by_power_nm", "N m", "half of the difference, against minus with the load"),
    ),
    nonlinear=(
        Parameter("load_exponent", "1", "exponent of the load", lower=0.5, upper=3.0),
        Parameter(
            "load_directed", "1", "1 if friction depends on the direction of power", lower=0.0, upper=1.0, whole=True
        ),
        Parameter(
            "load_static",
            "1",
            "1 if the load is the weight alone, without inertial torque",
            lower=0.0,
            upper=1.0,
            whole=True,
            optional=True,
        ),
    ),
    traits=Trait.NEEDS_NOMINAL,
    record="pass the same places with loads that differ by a factor of 3",
    separate={
        "position_dependent_friction": "pass the same places with another payload or posture",
        "asymmetric_coulomb": "let the motor and a hand drive the joint, each in both directions",
        "torque_crosstalk": "move one joint at a time, in both directions",
    },
)
