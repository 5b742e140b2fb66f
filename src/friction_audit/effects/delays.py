"""Effects that come late: friction after the speed, the reading after the torque."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from math import exp

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.transmission import fit_friction_side, simple_torque
from friction_audit.effects.effect import LARGEST_SHARE, Each, Effect, Points
from friction_audit.effects.joint_data import JointData, Nominal, reversals
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float
from friction_audit.preprocessing.even_grid import EvenSpline, first_order
from friction_audit.preprocessing.interaction import Caution

LAGS_S = np.geomspace(3e-3, 0.5, 8)
# Excess at rest over Coulomb friction, and the speed at which it fades as a share of the usual top speed.
STRIBECK = ((1e-3, 0.3), *((excess, float(share)) for excess in (0.2, 1.0) for share in np.geomspace(0.05, 0.5, 4)))


class FrictionalLag(Effect):
    """Frictional lag: friction follows the speed late, its direction does not.

    Of the torque of friction at a steady speed s, level + mu_v s + e mu_c exp(-s / v_s), all that depends on the speed
    is that of a speed behind a first-order delay (A. Ruina, J. Geophys. Res. 88 (1983) 10359; D. P. Hess, A. Soom, J.
    Tribol. 112 (1990) 147). The excess e at rest is 0 for viscous friction alone.
    """

    label = "friction follows speed late"
    axis = "acceleration"
    coefficients = (Parameter("lagging_share", "1", "share of friction that lags", lower=0.0, upper=LARGEST_SHARE),)
    nonlinear = (
        Parameter("friction_lag_s", "s", "lag of friction", lower=1e-4, upper=10.0),
        Parameter("lagging_excess", "1", "Stribeck friction at rest over Coulomb", lower=0.0, upper=5.0),
        Parameter("lag_speed_rad_s", "rad/s", "Stribeck velocity", lower=1e-4, upper=1e2),
    )
    record = "repeat motions of equal speed with different accelerations"
    separate = {"time_delay": "repeat motions of equal speed with different accelerations, and carry a load"}
    screened = 2
    needs_nominal = True

    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield friction at the lagged speed less that at the present one; equal lags have their speed in common."""
        far, speed, sign = fit_friction_side(motion), np.abs(motion.dq), motion.direction
        step = float(motion.t[1] - motion.t[0])
        now = {fading: np.exp(-speed / fading) for fading in {fading for _, _, fading in many}}
        for lag in dict.fromkeys(lag for lag, _, _ in many):
            seen = first_order(speed, exp(-step / lag), speed[0])
            viscous = far.viscous_nms_per_rad * (seen - speed)
            for place, (_, excess, fading) in enumerate(many):
                if many[place][0] != lag:
                    continue
                stribeck = excess * far.coulomb_nm * (np.exp(-seen / fading) - now[fading])
                yield place, (sign * (viscous + stribeck))[:, None]

    def tries(self, data: JointData) -> list[Sequence[float]]:
        """Return viscous friction, and Stribeck friction of several sizes and widths, by all lags."""
        usual = float(np.quantile(np.abs(data.dq), 0.95)) or 1.0
        return [(lag, excess, share * usual) for (excess, share), lag in product(STRIBECK, LAGS_S.tolist())]

    @staticmethod
    def requires(data: JointData, _nominal: Nominal) -> Caution | None:
        """Peak speeds of the cycles that differ by a tenth: one sinusoid cannot separate it from delay and inertia."""
        cycle, speed = data.cycle[data.used], np.abs(data.dq[data.used])
        peak = np.maximum.reduceat(speed, np.flatnonzero(np.diff(cycle, prepend=-1)))
        return Caution("equal_speeds") if peak.std() < 0.1 * peak.mean() else None


STEPS_S = np.geomspace(1e-3, 0.1, 13).tolist()
NO_DELAY_S = 1e-6  # for which the column is the derivative, as it is where the delay vanishes
STEP = "delay_step_s"
# Delay found over the delay for which jumps are right; a shorter delay than the shortest looks just like it.
LEAST_SHARE = 0.5


class TimeDelay(Effect):
    """Time delay: the torque reaches the log later than the motion, or earlier if the delay is below zero.

    The regressor is the torque of inertia and friction, read earlier by a step, less what it is now, per step: jumps at
    reversals stay jumps. It is exact where the delay is the step. It is read between samples by a cubic spline: a
    straight line damps the more the farther from a sample, so that delays of half a step would fit smoothed reversals
    (effects_time_delay_40001). Where a late sensor bears a load too, what was taken away for the load was taken too
    early.
    """

    label = "torque and velocity are not simultaneous"
    axis = "acceleration"
    coefficients = (Parameter("delay_s", "s", "delay of the torque", lower=-1.0, upper=1.0),)
    nonlinear = (
        Parameter(STEP, "s", "delay for which jumps are right", lower=-1.0, upper=1.0),
        Parameter.choice("delayed_load", "1 if the load is late too", 0.0, 1.0),
    )
    forward = "delay"
    requires = staticmethod(reversals)
    record = "reverse sharply at two or more clearly different speeds"
    separate = {
        "backlash": "reverse sharply with and without a load: a gap opens where the load changes its sign",
        "joint_elasticity": "reverse sharply, slowly and fast: a spring rings, a delay shifts",
    }
    needs_nominal = follows = True
    recorder = (
        "a low-pass filter in the recorder or the torque's electronics does the same: filter q and dq alike, or record "
        "the torque unfiltered"
    )

    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield (rest(t - s) - rest(t)) / s, first and last value held, of the torque with the load or without."""
        for loaded in {bool(round(with_load)) for _, with_load in many}:
            rest = simple_torque(motion)
            if loaded and motion.load is not None:
                rest = rest + motion.load
            spline, spacing = EvenSpline(rest, held=True), float(motion.t[1] - motion.t[0])
            for place, (step, with_load) in enumerate(many):
                if bool(round(with_load)) is loaded:
                    late = step or NO_DELAY_S
                    yield place, ((spline.ahead(-late / spacing) - rest) / late)[:, None]

    def tries(self, data: JointData) -> Iterable[Sequence[float]]:
        """Yield all delays, of friction and inertia alone and, where there is a load, of all that the sensor bears."""
        loads = (0.0,) if data.load is None else (0.0, 1.0)
        yield from ((sign * step, load) for load, sign, step in product(loads, (1.0, -1.0), STEPS_S))

    def possible(self, coefficients: Float, at: Points) -> Each:
        share, least = coefficients[0] / at[STEP], LEAST_SHARE * (abs(at[STEP]) > STEPS_S[0])
        return (least < share) & (share <= LARGEST_SHARE)

    def coefficient_of(self, at: Points) -> Each:
        return at[STEP]
