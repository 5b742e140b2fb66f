"""Presliding: friction builds up like a spring over the path since a reversal, and gives way as Coulomb friction.

After a reversal from steady sliding, with z the share of the level that is borne and x the path,

    dz/dx = (1 - z sgn(dx))^n / reach

n = 0 is one stop (Prandtl's element). For n < 1 the reach is finite, and stops in parallel that slip one after the
other have this curve; they remember every reversal until a larger loop closes (W. D. Iwan, J. Appl. Mech. 33 (1966)
893: n = 1/2 is a uniform spread; F. Al-Bender et al., IEEE Trans. Autom. Control 50 (2005) 1883: Maxwell slip). For
n >= 1 the equation holds at all times (P. R. Dahl, A solid friction model, 1968); n = 1 is LuGre at constant level (C.
Canudas de Wit et al., IEEE Trans. Autom. Control 40 (1995) 419, eq. (1)-(3)), whose damping sigma_1 dz/dt is the
stiffness times a time. Without that damping nothing depends on the rate.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from math import exp

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import JointData, reversals, shares_of_span
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

EVEN = 1e-6  # scatter of the steps of a clock that is rounding, as a share of the step
STOPS = 16  # stops in parallel that stand for any number of them
# Reaches as shares of the span of the motion, from friction that is hardly rounded: a stiff spring rounds it too, and
# would take its name.
SPAN_SHARES = np.append(np.geomspace(1e-5, 1e-4, 3)[:-1], np.geomspace(1e-4, 0.3, 18))
# Exponents with times of damping: one stop, a row of stops, Dahl's, a slow one, and LuGre's with its damping.
KINDS = ((0.02, 1e-4), (0.5, 1e-4), (1.0, 1e-4), (2.0, 1e-4), (1.0, 0.01))


class Presliding(Effect):
    label = "friction builds up after a reversal"
    axis = "displacement"
    coefficients = (Parameter("bristle_nm", "N m", "Coulomb friction of the bristles", lower=0.0),)
    nonlinear = (
        Parameter("reach_rad", "rad", "Coulomb friction over stiffness at rest", lower=1e-6, upper=1.0),
        Parameter("yielding_exponent", "1", "exponent of yielding", lower=0.0, upper=3.0),
        Parameter("bristle_damping_s", "s", "damping over stiffness", lower=0.0, upper=1.0),
    )
    forward = "bristle"
    requires = staticmethod(reversals)
    record = "reverse at least 20 times, over short and long ways"
    separate = {
        "backlash": "reverse slowly with hardly any load: a gap gives no torque at all, then an impact",
        "frictional_lag": "reverse at different accelerations: presliding goes by the path, a lag by the time",
        "time_delay": "reverse at different accelerations: presliding goes by the path, a delay by the time",
        "joint_elasticity": "reverse fast and slowly: a spring rings after a fast reversal",
    }
    screened = 3

    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield what bristles in the place of Coulomb friction add, z + T dz/dt - sgn(dq); equal bristles are one."""
        steps = np.diff(motion.t)
        # The step of even times, of which a derivative takes a tenth of the work, or the times themselves.
        even = len(steps) > 1 and np.ptp(steps) <= EVEN * np.mean(steps)
        spacing = float(np.mean(steps)) if even else motion.t
        for bend in dict.fromkeys((reach, exponent) for reach, exponent, _ in many):
            z = bristle(motion.q, *bend)
            rate = np.gradient(z, spacing) if len(z) > 1 else np.zeros(len(z))
            alike = (place for place, (*own, _) in enumerate(many) if tuple(own) == bend)
            yield from ((place, (z + many[place][2] * rate - motion.direction)[:, None]) for place in alike)

    def tries(self, data: JointData) -> Iterable[Sequence[float]]:
        return ((reach, *kind) for kind, reach in product(KINDS, shares_of_span(data, SPAN_SHARES)))


def bristle(q: Float, reach_rad: float, exponent: float) -> Float:
    """Return the state z along a path, exact for a path straight between its samples, 0 at the start, shape (n,)."""
    path = np.ascontiguousarray(q, dtype=np.float64) / reach_rad
    if exponent < 1.0:
        return np.asarray(_stops(path, *spread(exponent)))
    return np.asarray(_dahl(path, float(exponent)))


def spread(exponent: float) -> tuple[Float, Float]:
    """Return where stops in parallel slip, in reaches, and their stiffnesses, such that they have the curve, (k,) each.

    Pulled from zero they rise as half of the curve after a reversal does at twice the path (G. Masing, 1926).
    """
    bend = 1.0 - exponent
    missing = np.linspace(1.0, 0.0, STOPS + 1) ** 2
    gone = np.append(-np.expm1(bend * np.log(missing[:-1])), 1.0)  # 1 - missing^bend, also where n is all but 1
    slips = 2.0**bend * gone / (2.0 * bend)
    return slips[1:], -np.diff(np.append(-np.diff(missing) / np.diff(slips), 0.0))


@compiled(any_order=True)
def _stops(path: Float, slips: Float, stiffness: Float) -> Float:
    z = np.zeros(len(path))
    bent = np.zeros(len(slips))
    for i in range(1, len(path)):
        step, total = path[i] - path[i - 1], 0.0
        for k in range(len(slips)):
            bent[k] = min(slips[k], max(-slips[k], bent[k] + step))
            total += stiffness[k] * bent[k]
        z[i] = total
    return z


@compiled()
def _dahl(path: Float, exponent: float) -> Float:
    z = np.zeros(len(path))
    missing, sign, bend = 1.0, 1.0, exponent - 1.0
    for i in range(1, len(path)):
        step = path[i] - path[i - 1]
        if step * sign < 0.0:
            sign, missing = -sign, 2.0 - missing
        # 1 - z sgn(dx) along a path in one direction, dm/dx = -m^n, solved exactly.
        if bend == 0.0:
            missing *= exp(-abs(step))
        elif bend == 1.0:
            missing /= 1.0 + abs(step) * missing
        elif missing > 0.0:
            missing *= (1.0 + bend * abs(step) * missing**bend) ** (-1.0 / bend)
        z[i] = sign * (1.0 - missing)
    return z
