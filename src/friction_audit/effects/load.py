"""Effects of what the joint bears: friction that grows with the load, gravity that is wrong."""

from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache, partial
from itertools import product

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Each, Effect, Nonlinear, Points
from friction_audit.effects.joint_data import JointData, Nominal, both_directions, span
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Bool, Float
from friction_audit.preprocessing.interaction import Caution

EXPONENTS = (1.0, 1.5, 2.0)
LEAST_CHANGE = 0.1  # of a high load, what it must change by: a steady load's friction is Coulomb friction


class LoadDependentFriction(Effect):
    """Friction that grows with the torque that the gear transmits, perhaps more where the load drives the motor.

    A. C. Bittencourt, S. Gunnarsson, Static friction in a robot joint, Journal of Dynamic Systems, Measurement, and
    Control 134 (2012) 051013: proportional to |load|; M. Duclusaud et al., Extended friction models for the physics
    simulation of servo actuators (2025): quadratic; A. Wang, S. Kim, Directional efficiency in geared transmissions,
    ICRA 2015: the loss differs by the direction of the power, sgn(load dq), and sgn(dq) |load| sgn(load dq) is the
    load.
    """

    label = "friction grows with load"
    axis = "load"
    coefficients = (
        Parameter("load_friction_nm", "N m", "friction at a load of 1 N m, mean of both directions", lower=0.0),
        Parameter("load_friction_by_power_nm", "N m", "half of the difference, against minus with the load"),
    )
    nonlinear = (
        Parameter("load_exponent", "1", "exponent of the load", lower=0.5, upper=3.0),
        Parameter.choice("load_directed", "1 if friction depends on the direction of power", 0.0, 1.0),
        Parameter.choice(
            "load_static", "1 if the load is the weight alone, without inertial torque", 0.0, 1.0, optional=True
        ),
    )
    record = "pass the same places with loads that differ by a factor of 3"
    separate = {
        "position_dependent_friction": "pass the same places with another payload or posture",
        "asymmetric_coulomb": "let the motor and a hand drive the joint, each in both directions",
        "torque_crosstalk": "move one joint at a time, in both directions",
    }
    needs_nominal = True
    misses = "directed"

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return sgn(dq) |load|^p and, where the power's direction counts, sgn(load) |load|^p as columns."""
        exponent, directed, static = values
        load = np.zeros(len(motion.t)) if motion.load is None else motion.load
        if motion.rest is not None and not round(static):
            load = load + motion.rest
        size = np.abs(load) ** exponent
        return np.stack([motion.direction * size, np.sign(load) * size * round(directed)]).T

    def tries(self, data: JointData) -> Iterable[Sequence[float]]:
        # The load is all that goes through the gear, or what the link weighs: both are in the literature. With Coulomb
        # friction above the weight, all that goes through it in the direction of motion holds the weight itself.
        forms = ((1.0,),) if data.weighs else ((), (1.0,))
        yield from ((p, d, *static) for d, p, static in product((0.0, 1.0), EXPONENTS, forms))

    def possible(self, coefficients: Float, at: Points) -> Each:
        return (coefficients[0] > 0) & (abs(coefficients[1]) <= coefficients[0])  # resists, whichever way power flows

    @staticmethod
    def requires(data: JointData, nominal: Nominal) -> Caution | None:
        if lacking := both_directions(data, nominal):
            return lacking
        if data.load is None:
            return Caution("unknown_load")
        low, high = np.percentile(np.abs(data.load[data.used]), [5, 95])
        if high - low < max(LEAST_CHANGE * high, abs(nominal.coulomb_nm)):
            return Caution("even_load", numbers={"low": low, "high": high})
        return None


OWN_ANGLE, TILT, SEVERAL = 0, -1, -2  # values of the source; from 1 on, the number of a link
OF_ANGLE, OF_LINK, OF_TILT = slice(0, 2), slice(2, 6), slice(6, 8)  # columns of the sources
# Columns of the joint's own link, the next and the last where several are wrong.
OF_LINKS = (OF_LINK, slice(8, 12), slice(12, 16))
SOURCE = "gravity_error_source"
PLACES = np.concatenate([np.arange(where.start, where.stop) for where in OF_LINKS])  # columns of several links
# Of the largest column: what one must add to the others. A kg m, more than any arm's model is off, pulls with 10 N m;
# what a hundredth of that makes of a tenth of a kg m, the usual error, drowns in the noise of a good sensor.
LEAST_GAIN = 0.01
# What is less per kg or kg m is no weight. [N m]
ROUNDING = 1e-9
AT_ONCE = 8192  # samples
MOST_KG = 10.0  # and kg m: what columns that nearly cancel may make of a link is no body


def _of_another(link: str) -> Iterator[Parameter]:
    """Yield the numbers of another link, which files of earlier versions do not have."""
    for axis in "xyz":
        meaning = f"error of the first mass moment of the {link} link, {axis} in its joint's frame"
        yield Parameter(f"{link}_link_moment_{axis}_kg_m", "kg m", meaning, optional=True)
    yield Parameter(f"{link}_link_mass_kg", "kg", f"error of the mass of the {link} link", optional=True)


class GravityError(Effect):
    """The gravity torque that was subtracted is wrong, by the joint's angle, by links, or by a tilted base.

    In one joint alone a wrong mass, a wrong centre of mass and a tilted base are the same: an amplitude and a phase of
    its angle. In an arm they differ: a link that is heavier than its model pulls at each joint as the pose says (the
    columns of gravity in the arm's regressor; Atkeson, An, Hollerbach, Int. J. Robotics Research 5(3), 1986).
    """

    label = "gravity not fully compensated"
    axis = "position"
    coefficients = (
        Parameter("gravity_cos_nm", "N m", "cosine amplitude"),
        Parameter("gravity_sin_nm", "N m", "sine amplitude"),
        Parameter("link_moment_x_kg_m", "kg m", "error of the first mass moment, x in the joint's frame"),
        Parameter("link_moment_y_kg_m", "kg m", "error of the first mass moment, y"),
        Parameter("link_moment_z_kg_m", "kg m", "error of the first mass moment, z"),
        Parameter("link_mass_kg", "kg", "error of the link's mass"),
        Parameter("gravity_across_1_m_s2", "m/s^2", "horizontal gravity of a tilted base"),
        Parameter("gravity_across_2_m_s2", "m/s^2", "horizontal gravity, at right angles"),
        *_of_another("next"),
        *_of_another("last"),
    )
    nonlinear = (Parameter.choice(SOURCE, "0 own angle, -1 base, -2 several links, else number of the link", SEVERAL),)
    requires = staticmethod(partial(span, least_rad=0.3))
    record = "move through at least 1.5 rad, with rests at several places"
    separate = {
        "torque_bias": "move through at least 1.5 rad, with rests at several places",
        "cable_spring": "move through at least 1.5 rad: gravity is a sine of the position, a spring a line",
        "inertia_error": "move at two frequencies: on one sinusoid gravity and inertia are the same",
        "joint_limit_stop": "move through all of the range: a stop is there at its ends only",
        "inertial_coupling": "hold several poses at rest: coupling needs acceleration, gravity does not",
        "torque_crosstalk": "push against a neighbour while the arm rests: gravity stays the same",
        "friction_step": "rest at the same place before and after the change, and move both ways",
    }
    memoryless = False  # the model of the arm knows it at other times

    misses = "even"

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return the columns of one source of the error; those of the others are zero."""
        source = round(values[0])
        columns = np.zeros((len(self.coefficients), len(motion.t))).T  # one behind the other in memory
        if source == OWN_ANGLE:
            columns[:, OF_ANGLE] = np.column_stack([np.cos(motion.q), np.sin(motion.q)])
        elif motion.rigid is not None:
            rigid = motion.rigid.on(motion.t)
            if source == TILT:
                columns[:, OF_TILT] = rigid.tilt
            elif source == SEVERAL:
                for k, where in enumerate(OF_LINKS[: len(rigid.links)]):
                    columns[:, where] = rigid.weight[:, k]
            elif source in rigid.links:
                columns[:, OF_LINK] = rigid.weight[:, rigid.links.index(source)]
        return columns

    def regressors(self, data: JointData, nominal: Nominal, grid: Sequence[Nonlinear]) -> Iterator[tuple[int, Float]]:
        """Yield the columns of one source; of several links the linearly independent ones, the others zero."""
        for place, found in super().regressors(data, nominal, grid):
            if round(grid[place][SOURCE]) == SEVERAL:
                found[:, PLACES[~independent(data)]] = 0.0
            yield place, found

    def tries(self, data: JointData) -> list[tuple[float]]:
        """Return the joint's angle, and what the model of the arm lets pull at it."""
        rigid = data.rigid
        links = () if rigid is None else tuple(k for n, k in enumerate(rigid.links) if rigid.weight[:, n].any())
        several = (SEVERAL,) if np.count_nonzero(independent(data).reshape(len(OF_LINKS), -1).any(axis=1)) > 1 else ()
        tilt = () if rigid is None else (TILT,)
        return [(float(source),) for source in (OWN_ANGLE, *links, *several, *tilt)]

    def possible(self, coefficients: Float, at: Points) -> Each:
        # Of either sign; of several links not what no arm carries.
        return (np.round(at[SOURCE]) != SEVERAL) | np.all(np.abs(coefficients) <= MOST_KG, axis=0)


@lru_cache(maxsize=1)
def independent(data: JointData) -> Bool:
    """Return which columns of several links are linearly independent, shape (12,); none without a model of the arm.

    By Cholesky decomposition with pivoting of their products: of columns that nearly depend on each other the larger
    one stays (N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2002, section 10.3).
    """
    from scipy.linalg.lapack import dpstrf

    found = np.zeros(len(PLACES), bool)
    if data.rigid is None or not data.used.any():
        return found
    pulls, used = data.rigid.on(data.t).weight.reshape(len(data.t), -1), np.flatnonzero(data.used)
    products = np.zeros((pulls.shape[1],) * 2)
    for some in np.array_split(used, len(used) // AT_ONCE + 1):  # one after the other, for that takes less memory
        few = pulls[some].astype(np.float64)
        products += few.T @ few / len(used)
    factor, order, rank, _ = dpstrf(products)
    adds = np.diag(factor)[:rank]
    found[order[:rank] - 1] = adds > max(LEAST_GAIN * adds.max(initial=0.0), ROUNDING)
    return found
