"""Warm-up: friction that fades as the joint gets warm, with the time or with a logged temperature.

A body that is heated evenly approaches its temperature exponentially (Newton's law of cooling), and a lubricant's
viscosity falls exponentially with the temperature (O. Reynolds, Philosophical Transactions 177 (1886) 157).
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Nonlinear, Trait
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.joint_data import JointData, Nominal, duration
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

REFERENCE_DEGC = 25.0
SHORTEST_S = 30.0
# Time constants as shares of the log's length; beyond, an exponential is a straight line.
TIMES = (0.08, 0.2, 0.5, 1.5)
FOREVER = 1e4
UNFELT_PER_K = 1e-6
DECAYS = (0.3, 1.5, 5.0)  # how far friction fades over the range of the temperature, as exponents
LEAST_K = 0.5  # least range of a temperature


class WarmUp(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return sgn(dq) and dq times exp(-t / T - k (temperature - 25 degC)) as columns, t from the start."""
        time_constant, per_kelvin = values
        fading = -(motion.t - motion.t[0]) / time_constant
        if motion.temperature is not None:
            fading = fading - per_kelvin * (motion.temperature - REFERENCE_DEGC)
        cold = np.exp(fading)
        return np.stack([motion.direction * cold, motion.dq * cold]).T

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """Time constants by the length of the log; rates by the range of the temperature, where there is one."""
        length = duration(data)
        tried: list[Nonlinear] = [{"warm_up_time_s": share * length, "warm_up_per_k": UNFELT_PER_K} for share in TIMES]
        rise = 0.0 if data.temperature is None else float(np.ptp(data.temperature))
        if rise >= LEAST_K:
            tried += [{"warm_up_time_s": FOREVER * length, "warm_up_per_k": decay / rise} for decay in DECAYS]
        return tuple(tried)

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        length = duration(data)
        if length < SHORTEST_S:
            return f"{length:.0f} s are too short: record at least {SHORTEST_S:g} s from a cold start, slow and fast"
        return both_directions(data, nominal)

    def admissible(self, coefficients: Float, at: Nonlinear) -> bool:
        """A cold joint has more friction of one kind at least."""
        return bool(np.any(coefficients > 0))


EFFECT = WarmUp(
    name="warm_up",
    label="friction falls as the joint warms",
    family="slow and events",
    axis="time",
    coefficients=(
        Parameter("cold_coulomb_nm", "N m", "extra Coulomb friction when cold"),
        Parameter("cold_viscous_nms_per_rad", "N m s/rad", "extra viscous friction when cold"),
    ),
    nonlinear=(
        Parameter("warm_up_time_s", "s", "time constant", lower=1e-2, upper=1e9),
        Parameter("warm_up_per_k", "1/K", "share lost per kelvin", lower=0.0, upper=100.0),
    ),
    traits=Trait.FRICTION,
    record="record from a cold start, slow and fast motions early and late",
    separate={
        "friction_step": "record on for one and a half times as long: warming slows down, a step is over",
        "unlogged_compensation": "log the commanded torque, and repeat the same motions early and late",
    },
)
