"""Viscous friction that is no straight line: it thins, saturates or grows with the speed.

P. J. Carreau, Rheological equations from molecular network theories, Transactions of the Society of Rheology 16 (1972)
99: viscosity in proportion to (1 + (v / v_0)^2)^((n - 1) / 2). Well above v_0 the friction is |v|^n, well below a line:
n = 2 or 3 is drag, n between 0 and 1 a lubricant that thins, n = 0 a friction that saturates.

How sharply it bends is one number more. Carreau's v / sqrt(v_0^2 + v^2) is the distribution of Student's t with two
degrees of freedom, from -1 to 1. With one it is the arc tangent, with about eight tanh but for 0.0003 of it (G. S.
Mudholkar, E. O. George, A remark on the shape of the logistic distribution, Biometrika 65 (1978) 667), with many the
error function: all by which a sign is usually smoothed.
"""

from collections.abc import Sequence

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Effect, Nonlinear, Trait
from friction_audit.effects.excitation import speed_range
from friction_audit.effects.joint_data import JointData, Nominal, speeds
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

CARREAU = 2.0  # degrees of freedom of Carreau's bend, whose sharpness is 0
TABLE = 4097  # angles between which the bend is a straight line, to 1e-6 of it
POWERS = (0.5, 1.5, 2.0, 3.0)  # exponents of plain powers: the bend lies below all speeds of the log
BENDS = 9
LOWEST, HIGHEST = 0.001, 1.0  # shares of the log's high speed between which a friction may saturate
SHARPNESSES = (-0.7, 0.0, 1.5)  # of saturation: as the arc tangent, a root and tanh
NO_BEND = 1e-3


class NonlinearViscous(Effect):
    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return sgn(dq) S(|dq| / v_0) (v_0^2 + dq^2)^(n / 2) as a column, over its value at 1 rad/s.

        S is the bend; with sharpness 0 that is dq (v_0^2 + dq^2)^((n - 1) / 2).
        """
        exponent, speed, sharpness = values
        pace = np.append(np.abs(motion.dq), 1.0)
        if sharpness == 0.0:
            friction = pace * ((speed**2 + pace**2) / (speed**2 + 1.0)) ** ((exponent - 1.0) / 2.0)
        else:
            friction = bend(pace / speed, CARREAU * np.exp(sharpness))
            friction = friction * ((speed**2 + pace**2) / (speed**2 + 1.0)) ** (exponent / 2.0)
        return np.asarray(motion.direction * friction[:-1] / friction[-1])[:, None]

    def in_cpp(self, values: Sequence[float], table: str) -> str:
        torque, exponent, speed, sharpness = values
        squares = f"({speed * speed!r} + pace * pace) / {speed * speed + 1.0!r}"
        if sharpness == 0.0:
            return f"{torque!r} * way * pace * std::pow({squares}, {(exponent - 1.0) / 2.0!r})"
        steep, per_angle = float(np.exp(-0.5 * sharpness)) / speed, (TABLE - 1) / (np.pi / 2.0)
        here, at_one = (f"between({table}, std::atan({x} * {steep!r}) * {per_angle!r})" for x in ("pace", "1.0"))
        return f"{torque!r} * way * {here} / {at_one} * std::pow({squares}, {exponent / 2.0!r})"

    def cpp_table(self, values: Sequence[float]) -> Float | None:
        return bend_table(CARREAU * np.exp(values[-1])) if values[-1] else None

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """Plain powers, and saturation at several speeds."""
        (fast,) = speeds(data, 95.0)
        powers = [_curve(exponent, NO_BEND * float(fast)) for exponent in POWERS]
        bends = [float(share * fast) for share in np.geomspace(LOWEST, HIGHEST, BENDS)]
        return *powers, *(_curve(0.0, v) | {"curved_viscous_sharpness": s} for v in bends for s in SHARPNESSES)

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        return speed_range(data, nominal, 5.0)

    def admissible(self, coefficients: Float, at: Nonlinear) -> bool:
        """A curve that flattens must rise: if it fell, friction would fall steeply with speed, which is Stribeck's."""
        return bool(coefficients[0] > 0 or at["curved_viscous_exponent"] > 1.0)


def bend(pace: Float, freedom: float) -> Float:
    """Return the distribution of Student's t, from 0 at 0 to 1, at sqrt(2) times a pace >= 0.

    From a table over the angle whose tangent is t / sqrt(freedom): the function itself takes a microsecond a sample.
    """
    # The table is even, so that the place follows from the angle without a search.
    place = np.arctan(pace * np.sqrt(CARREAU / freedom))
    place *= (TABLE - 1) / (np.pi / 2.0)
    return np.asarray(_between(bend_table(freedom), place))


def bend_table(freedom: float) -> Float:
    """Return the bend at TABLE even angles from 0 to pi / 2, shape (TABLE,)."""
    from scipy.special import betainc

    return np.asarray(betainc(0.5, freedom / 2.0, np.sin(np.linspace(0.0, np.pi / 2.0, TABLE)) ** 2))


@compiled()
def _between(table: Float, place: Float) -> Float:
    """Return what lies between the entries of a table, at places counted from its first one, shape (n,)."""
    out = np.empty(len(place))
    for i in range(len(place)):
        k = max(min(int(place[i]), len(table) - 2), 0)  # a place that is no number is nowhere, and gives none
        out[i] = table[k] + (place[i] - k) * (table[k + 1] - table[k])
    return out


def _curve(exponent: float, speed: float) -> dict[str, float]:
    return {"curved_viscous_exponent": exponent, "curved_viscous_speed_rad_s": speed}


EFFECT = NonlinearViscous(
    name="nonlinear_viscous",
    label="friction curved in speed",
    family="velocity",
    axis="speed",
    coefficients=(Parameter("curved_viscous_nm", "N m", "curved friction at 1 rad/s"),),
    nonlinear=(
        Parameter("curved_viscous_exponent", "1", "exponent at high speed", lower=-1.0, upper=5.0),
        Parameter("curved_viscous_speed_rad_s", "rad/s", "velocity of the bend", lower=1e-6, upper=1e3),
        Parameter(
            "curved_viscous_sharpness",
            "1",
            "sharpness of the bend: -0.7 as arctan, 0 as a root, 1.5 as tanh",
            lower=-0.7,
            upper=4.0,
            optional=True,
        ),
    ),
    traits=Trait.FRICTION | Trait.SPEED_ONLY,
    record="move at speeds that differ by a factor of 5 and more",
    separate={
        "time_delay": "repeat motions of equal speed with different accelerations",
        "warm_up": "repeat the same slow and fast motions early and late",
        "unlogged_compensation": "log the commanded torque, or record again without compensation",
    },
)
