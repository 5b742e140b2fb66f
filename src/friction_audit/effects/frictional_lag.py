"""Frictional lag: friction follows the speed late, its direction does not.

Of the torque of friction at a steady speed s, level + mu_v s + e mu_c exp(-s / v_s), all that depends on the speed is
that of a speed behind a first-order delay (A. Ruina, J. Geophys. Res. 88 (1983) 10359; D. P. Hess, A. Soom, J. Tribol.
112 (1990) 147). The excess e at rest is 0 for viscous friction alone.
"""

from collections.abc import Iterator, Sequence
from math import exp

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.transmission import far_side
from friction_audit.effects.effect import BatchedEffect, Nonlinear, Trait
from friction_audit.effects.excitation import several_speeds
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

LAGS_S = np.geomspace(3e-3, 0.5, 8)
# Excess at rest over Coulomb friction, and the speed at which it fades as a share of the usual top speed.
STRIBECK = ((1e-3, 0.3), *((excess, float(share)) for excess in (0.2, 1.0) for share in np.geomspace(0.05, 0.5, 4)))
# The coefficient is 1 but for the errors of a nominal model that was fitted without the lag.
LARGEST_SHARE = 1.6


class FrictionalLag(BatchedEffect):
    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield friction at the lagged speed less that at the present one; equal lags have their speed in common."""
        far, speed, sign = far_side(motion), np.abs(motion.dq), motion.direction
        step = float(motion.t[1] - motion.t[0])
        now = {fading: np.exp(-speed / fading) for fading in {fading for _, _, fading in many}}
        places: dict[float, list[int]] = {}
        for place, (lag, _, _) in enumerate(many):
            places.setdefault(lag, []).append(place)
        for lag, alike in places.items():
            seen = lagged(speed, step, lag)
            viscous = far.viscous_nms_per_rad * (seen - speed)
            for place in alike:
                _, excess, fading = many[place]
                stribeck = excess * far.coulomb_nm * (np.exp(-seen / fading) - now[fading])
                yield place, (sign * (viscous + stribeck))[:, None]

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """Viscous friction, and Stribeck friction of several sizes and widths, by all lags."""
        usual = float(np.quantile(np.abs(data.dq), 0.95)) or 1.0
        return tuple(
            {"friction_lag_s": float(lag), "lagging_excess": excess, "lag_speed_rad_s": share * usual}
            for excess, share in STRIBECK
            for lag in LAGS_S
        )

    def admissible(self, coefficients: Float, at: Nonlinear) -> bool:
        return bool(0.0 < coefficients[0] <= LARGEST_SHARE)

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        return several_speeds(data, nominal)


@compiled()
def lagged(signal: Float, step_s: float, lag_s: float) -> Float:
    """Return a signal behind a first-order delay, from its first value on, shape (n,)."""
    keep, last, out = exp(-step_s / lag_s), signal[0], np.empty(len(signal))
    for i in range(len(signal)):
        last = (1.0 - keep) * signal[i] + keep * last
        out[i] = last
    return out


EFFECT = FrictionalLag(
    name="frictional_lag",
    label="friction follows speed late",
    family="velocity",
    axis="acceleration",
    coefficients=(Parameter("lagging_share", "1", "share of friction that lags", lower=0.0, upper=2.0),),
    nonlinear=(
        Parameter("friction_lag_s", "s", "lag of friction", lower=1e-4, upper=10.0),
        Parameter("lagging_excess", "1", "Stribeck friction at rest over Coulomb", lower=0.0, upper=5.0),
        Parameter("lag_speed_rad_s", "rad/s", "Stribeck velocity", lower=1e-4, upper=1e2),
    ),
    traits=Trait.NEEDS_NOMINAL,
    record="repeat motions of equal speed with different accelerations",
    separate={"time_delay": "repeat motions of equal speed with different accelerations, and carry a load"},
)
