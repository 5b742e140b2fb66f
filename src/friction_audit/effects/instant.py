"""Effects of the motion at an instant: those of one column, the nominal terms of a model among them, and of the speed.

Friction that differs between the directions acts, by half of its difference, the same way in both: in motion Coulomb
friction that differs is a constant torque, which a sensor without a zero reads at rest too.
"""

from collections.abc import Iterable, Sequence
from functools import lru_cache, partial
from itertools import product
from typing import ClassVar

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Each, Effect, Points, SpeedFriction
from friction_audit.effects.joint_data import JointData, Nominal, both_directions, speed_range
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Caution


class OneColumn(Effect):
    """An effect that is a coefficient times ``of`` the motion, shape (n,)."""

    of: "ClassVar[staticmethod[[Motion], Float]]"

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        return self.of(motion)[:, None]


class Inertia(OneColumn):
    label = "inertia"
    axis = "acceleration"
    coefficients = (Parameter("inertia_kg_m2", "kg m^2", "reflected inertia", lower=0.0),)
    of = staticmethod(lambda motion: motion.ddq)


class Coulomb(SpeedFriction, OneColumn):
    label = "Coulomb friction"
    coefficients = (Parameter("coulomb_nm", "N m", "friction at any speed", lower=0.0),)
    of = staticmethod(lambda motion: motion.direction)  # 0 at rest, where friction is what holds the joint
    cpp = "{0!r} * direction"


class Viscous(SpeedFriction, OneColumn):
    label = "viscous friction"
    coefficients = (Parameter("viscous_nms_per_rad", "N m s/rad", "friction per velocity", lower=0.0),)
    of = staticmethod(lambda motion: motion.dq)
    cpp = "{0!r} * dq"


class Offset(OneColumn):
    label = "constant torque"
    axis = "time"
    coefficients = (Parameter("offset_nm", "N m", "torque offset"),)
    of = staticmethod(lambda motion: np.ones(len(motion.t)))


NOMINAL = (Inertia(), Coulomb(), Viscous(), Offset())


class AsymmetricCoulomb(OneColumn):
    label = "friction differs by direction"
    axis = "speed"
    coefficients = (Parameter("coulomb_half_difference_nm", "N m", "half of the difference, forward minus backward"),)
    requires = staticmethod(both_directions)
    record = "pass the same places in both directions, with rests"
    separate = {
        "torque_bias": "let the joint rest unloaded for 2 s: a bias is read at rest too, friction is not",
        "gravity_error": "move through at least 1.5 rad both ways, with rests at several places",
        "asymmetric_viscous": "pass the same places slowly and fast in both directions",
        "torque_drift": "let the joint rest unloaded for 2 s early and late: a drift is read at rest too, "
        "friction is not",
    }
    misses = "nothing"
    like_gravity = True
    of = staticmethod(lambda motion: np.abs(np.sign(motion.dq)))


class AsymmetricViscous(OneColumn):
    label = "viscous friction differs by direction"
    axis = "speed"
    coefficients = (
        Parameter("viscous_half_difference_nms_per_rad", "N m s/rad", "half of the difference, forward minus backward"),
    )
    requires = staticmethod(both_directions)
    record = "pass the same places slowly and fast in both directions"
    separate = {
        "torque_bias": "pass the same places slowly and fast in both directions",
        "gravity_error": "pass every place slowly and fast in both directions",
    }
    of = staticmethod(lambda motion: np.abs(motion.dq))


class TorqueBias(OneColumn):
    label = "offset of the torque sensor"
    axis = "time"
    coefficients = (Parameter("torque_bias_nm", "N m", "interaction torque as read without a load"),)
    requires = staticmethod(both_directions)
    record = "let the joint rest unloaded for 2 s"
    separate = {
        "torque_drift": "zero the sensor and let the joint rest unloaded for 2 s early and late: a drift comes back"
    }
    misses = "nothing"
    like_gravity = True
    of = staticmethod(lambda motion: np.ones(len(motion.t)))  # at rest too


class InertiaError(Inertia):
    label = "the stated inertia is wrong"
    coefficients = (Parameter("extra_inertia_kg_m2", "kg m^2", "true minus stated inertia"),)
    record = "repeat the motions at two or more clearly different speeds"
    separate = {"inertial_coupling": "move one joint at a time"}

    @staticmethod
    def requires(data: JointData, nominal: Nominal) -> Caution | None:
        """Return the number or the motion that is lacking; at one frequency gravity is its alternative."""
        return None if "inertia_kg_m2" in nominal.declared else Caution("fitted_inertia")


# Shares of the log's high speed between which friction may fade: beyond, no film has built up within the log.
LOWEST, HIGHEST = 0.01, 0.4
SLOWEST, NARROW, FASTEST = 1e-6, 1e-4, 10.0  # bounds of those speeds [rad/s]
EXPONENTS = (0.5, 1.0, 2.0)

CARREAU = 2.0  # degrees of freedom of Carreau's bend, whose sharpness is 0
TABLE = 4097  # angles between which the bend is a straight line, to 1e-6 of it
POWERS = (0.5, 1.5, 2.0, 3.0)  # exponents of plain powers: the bend lies below all speeds of the log
NO_BEND = 1e-3
BENDS = np.geomspace(0.001, 1.0, 9)  # shares of the log's high speed at which a friction may saturate
SHARPNESSES = (-0.7, 0.0, 1.5)  # of saturation: as the arc tangent, a root and tanh

SMOOTH, DEAD_BAND = 0.0, 1.0
FORMS = ((-0.3, SMOOTH), (0.0, SMOOTH), (0.3, SMOOTH), (0.0, DEAD_BAND))  # skews with forms


def low_speeds(data: JointData, count: int, slowest: float) -> list[float]:
    """Return speeds below which friction may fade, by those of the log, within bounds."""
    fast = data.low_and_high_speed[1]
    tried = np.geomspace(LOWEST * fast, HIGHEST * fast, count)
    return [float(speed) for speed in np.clip(tried, slowest, FASTEST)]


class Stribeck(SpeedFriction):
    """More friction at low speed, which fades as the lubricant's film builds up.

    Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994, eq. (5): the excess falls as
    exp(-|dq / v_s|^delta).
    """

    label = "more friction at low speed"
    coefficients = (Parameter("stribeck_excess_nm", "N m", "static minus Coulomb friction", lower=0.0),)
    nonlinear = (
        Parameter("stribeck_speed_rad_s", "rad/s", "Stribeck velocity", lower=SLOWEST, upper=FASTEST),
        Parameter("stribeck_exponent", "1", "Stribeck exponent", lower=0.2, upper=5.0),
    )
    cpp = "{0!r} * direction * std::exp(-std::pow(speed / {1!r}, {2!r}))"
    requires = staticmethod(partial(speed_range, ratio=8.0))
    record = "move steadily at speeds that differ by a factor of 8, very slow to fast"
    separate = {
        "nonlinear_viscous": "move steadily at speeds that differ by a factor of 8 and more, very slow to fast",
        "presliding": "reverse slowly and fast at the same places: presliding goes by the path, not the speed",
        "stiction": "start slowly and go on slowly for some seconds: stiction is over once the joint moves",
        "frictional_lag": "move slowly at constant speed: without acceleration there is no lag",
        "unlogged_compensation": "log the commanded torque, or record again without compensation",
        "torque_ripple": "pass slowly and steadily over five periods of the ripple in both directions",
    }
    screened = 2

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        speed, exponent = values
        return np.asarray(motion.direction * np.exp(-(np.abs(motion.dq / speed) ** exponent)))[:, None]

    def tries(self, data: JointData) -> Iterable[Sequence[float]]:
        return product(low_speeds(data, 8, SLOWEST), EXPONENTS)


class NonlinearViscous(SpeedFriction):
    """Viscous friction that is no straight line: it thins, saturates or grows with the speed.

    P. J. Carreau, Rheological equations from molecular network theories, Transactions of the Society of Rheology 16
    (1972) 99: viscosity in proportion to (1 + (v / v_0)^2)^((n - 1) / 2). Well above v_0 the friction is |v|^n, well
    below a line: n = 2 or 3 is drag, n between 0 and 1 a lubricant that thins, n = 0 a friction that saturates.

    How sharply it bends is one number more. Carreau's v / sqrt(v_0^2 + v^2) is the distribution of Student's t with two
    degrees of freedom, from -1 to 1. With one it is the arc tangent, with about eight tanh but for 0.0003 of it (G. S.
    Mudholkar, E. O. George, A remark on the shape of the logistic distribution, Biometrika 65 (1978) 667), with many
    the error function: all by which a sign is usually smoothed.
    """

    label = "friction curved in speed"
    coefficients = (Parameter("curved_viscous_nm", "N m", "curved friction at 1 rad/s"),)
    nonlinear = (
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
    )
    requires = staticmethod(partial(speed_range, ratio=5.0))
    record = "move at speeds that differ by a factor of 5 and more"
    separate = {
        "time_delay": "repeat motions of equal speed with different accelerations",
        "warm_up": "repeat the same slow and fast motions early and late",
        "unlogged_compensation": "log the commanded torque, or record again without compensation",
    }

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return sgn(dq) S(|dq| / v_0) (v_0^2 + dq^2)^(n / 2), S the bend, over its value at 1 rad/s."""
        exponent, v_0, sharpness = values
        speed = np.append(np.abs(motion.dq), 1.0)
        if sharpness == 0.0:
            friction = speed * ((v_0**2 + speed**2) / (v_0**2 + 1.0)) ** ((exponent - 1.0) / 2.0)
        else:
            friction = bend(speed / v_0, CARREAU * np.exp(sharpness))
            friction = friction * ((v_0**2 + speed**2) / (v_0**2 + 1.0)) ** (exponent / 2.0)
        return np.asarray(motion.direction * friction[:-1] / friction[-1])[:, None]

    def in_cpp(self, values: Sequence[float], table: str) -> tuple[str, Float | None]:
        torque, exponent, v_0, sharpness = values
        squares = f"({v_0 * v_0!r} + speed * speed) / {v_0 * v_0 + 1.0!r}"
        if sharpness == 0.0:
            return f"{torque!r} * direction * speed * std::pow({squares}, {(exponent - 1.0) / 2.0!r})", None
        steep, per_angle = float(np.exp(-0.5 * sharpness)) / v_0, (TABLE - 1) / (np.pi / 2.0)
        here, at_one = (f"between({table}, std::atan({x} * {steep!r}) * {per_angle!r})" for x in ("speed", "1.0"))
        formula = f"{torque!r} * direction * {here} / {at_one} * std::pow({squares}, {exponent / 2.0!r})"
        return formula, bend_table(CARREAU * np.exp(sharpness))

    def tries(self, data: JointData) -> list[Sequence[float]]:
        """Return plain powers, and friction that saturates at some speeds of the log."""
        fast = data.low_and_high_speed[1]
        return [*((n, NO_BEND * fast) for n in POWERS), *product([0.0], (BENDS * fast).tolist(), SHARPNESSES)]

    def possible(self, coefficients: Float, at: Points) -> Each:
        # A curve that flattens must rise: if it fell, friction would fall steeply with speed, which is Stribeck's.
        return (coefficients[0] > 0) | (at["curved_viscous_exponent"] > 1.0)


def bend(x: Float, freedom: float) -> Float:
    """Return the distribution of Student's t, from 0 at 0 to 1, at sqrt(2) times x >= 0; from a fast table."""
    place = np.arctan(x * np.sqrt(CARREAU / freedom)) * ((TABLE - 1) / (np.pi / 2.0))
    return np.asarray(np.interp(place, np.arange(TABLE), bend_table(freedom)))


@lru_cache(maxsize=8)  # of the grid, for all joints and all points next to one
def bend_table(freedom: float) -> Float:
    """Return the bend at TABLE even angles from 0 to pi / 2, shape (TABLE,)."""
    from scipy.special import betainc

    return np.asarray(betainc(0.5, freedom / 2.0, np.sin(np.linspace(0.0, np.pi / 2.0, TABLE)) ** 2))


class UnloggedCompensation(Effect):
    """A friction compensator that is not in the log helps the motion, less at low speed.

    Smooth compensators hold back below a speed w, as tanh(dq / w), others have a dead band; that of C. Gaz et al.,
    Dynamic identification of the Franka Emika Panda robot, RA-L 4 (2019) 4147, is a sigmoid shifted through the origin.
    """

    label = "less friction than stated: an unlogged compensator"
    axis = "speed"
    coefficients = (Parameter("unlogged_nm", "N m", "compensator torque at high speed", lower=0.0),)
    nonlinear = (
        Parameter("unlogged_width_rad_s", "rad/s", "velocity scale near zero", lower=NARROW, upper=FASTEST, jumps=True),
        Parameter("unlogged_skew", "1", "shift of its sigmoid", lower=-2.0, upper=2.0),
        Parameter.choice("unlogged_form", "0 smooth, 1 dead band", 0.0, 1.0),
    )
    record = "log the commanded torque"

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return what the joint then takes less, -tanh(dq / w + k) + tanh(k) or -sgn(dq) beyond a dead band."""
        width, skew, form = values
        speed = motion.dq / width
        if round(form) == DEAD_BAND:
            return -(np.sign(speed) * (np.abs(speed) > 1.0))[:, None]
        return np.asarray(np.tanh(skew) - np.tanh(speed + skew))[:, None]

    def tries(self, data: JointData) -> Iterable[Sequence[float]]:
        return ((width, *form) for width, form in product(low_speeds(data, 6, NARROW), FORMS))

    @staticmethod
    def requires(data: JointData, nominal: Nominal) -> Caution | None:
        """The numbers or the motion that are lacking: less of a fitted friction is all that a compensator leaves."""
        return both_directions(data, nominal) if "coulomb_nm" in nominal.declared else Caution("fitted_friction")
