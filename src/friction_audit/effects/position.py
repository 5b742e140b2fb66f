"""Effects of the position: waves and patches of friction, ripple of the torque, a cable, stops."""

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import NDArray

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.effect import Each, Effect, Nonlinear, Points
from friction_audit.effects.joint_data import CORNER_HZ, JointData, Nominal, both_directions, reach, span
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float

WAVES = 10
PATCHES = (8, 16)  # half widths of patches, as how many of them the range takes
ORDER, CENTRE, WIDTH = "position_friction_order", "position_friction_centre_rad", "position_friction_width_rad"
EVERYWHERE = 1e6  # width of a bell that does not matter
SAME_STEP = 1e-12  # differences of the spacing of orders that are rounding, as a share of an order


def waves(q: Float, orders: Iterable[float]) -> Iterator[NDArray[np.complex128]]:
    """Yield exp(i k q), shape (n,), for one order k after the other: of evenly spaced ones by turning by one angle.

    That takes four products where cosine and sine take many; a turn is right to rounding, and so are a hundred.
    """
    turn = wave = none = np.ones(len(q), np.complex128)
    before, step = 0.0, 0.0
    for order in orders:
        if order not in (0.0, before):
            if abs(order - before - step) > SAME_STEP * abs(order):
                step, turn = order - before, np.exp(1j * (order - before) * q)
            before, wave = order, wave * turn
        yield wave if order else none


class PositionDependentFriction(Effect):
    """Coulomb friction that depends on the position: a wave over the whole range, or over a stretch of it.

    B. Armstrong-Helouvry, Control of Machines with Friction, 1991, section 4.4: friction of geared joints repeats with
    the position. A wave under a bell is a patch where the bell is narrower than the wave is long.
    """

    label = "friction changes with position"
    axis = "position"
    coefficients = (
        Parameter("position_friction_cos_nm", "N m", "cosine amplitude"),
        Parameter("position_friction_sin_nm", "N m", "sine amplitude"),
    )
    nonlinear = (
        Parameter(ORDER, "1", "waves per revolution", lower=0.0, upper=1e4, optional=True),
        Parameter(CENTRE, "rad", "centre of the stretch", optional=True),
        Parameter(WIDTH, "rad", "half width of the stretch", lower=1e-4, default=EVERYWHERE, optional=True),
    )
    friction = True
    requires = staticmethod(lambda data, nominal: both_directions(data, nominal) or span(data, nominal, 0.5))
    record = "pass every place four times in each direction"
    separate = dict.fromkeys(("torque_ripple", "gravity_error"), record)

    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield sgn(dq) exp(-((q - c) / w)^2 / 2) times cos and sin of k (q - c), two columns."""
        for place, wave in enumerate(waves(motion.q, (order for order, _, _ in many))):
            order, centre, width = many[place]
            bell = motion.direction
            if width < EVERYWHERE:
                bell = bell * np.exp(-0.5 * ((motion.q - centre) / width) ** 2)
            about_centre = wave * np.exp(-1j * order * centre)
            yield place, np.stack([bell * about_centre.real, bell * about_centre.imag]).T

    def tries(self, data: JointData) -> list[Nonlinear]:
        """Return waves from half a period over the range on, half a period apart; bells and waves in them, 1.5."""
        low, high = reach(data)
        length = max(high - low, 1e-3)
        wide = [{ORDER: float(np.pi / length * k)} for k in range(1, WAVES + 1)]
        bells = [
            {CENTRE: float(low + (k + 0.5) * 1.5 * length / parts), WIDTH: float(length / parts)}
            for parts in PATCHES
            for k in range(int(parts / 1.5))
        ]
        return [*wide, *bells, *({ORDER: 1.0 / bell[WIDTH], **bell} for bell in bells)]


# Distance of orders times the standard deviation of the position: a phase is off by half of it, rms, at most.
FINEST, COARSEST = 1.0, 1.4
# As many as the time of a search allows; where they do not reach, they lie as far apart as they may. The others are
# scanned (``ripple_scan``).
MOST_ORDERS = 120


class TorqueRipple(Effect):
    """Torque ripple: a torque that repeats with the position in both directions: cogging, or a gear's teeth.

    T. D. Tuttle, W. P. Seering, A nonlinear model of a harmonic drive gear transmission, IEEE Transactions on Robotics
    and Automation 12 (1996) 368: periodic at the turns of the wave generator and twice that.

    Every order tried is a trial: R. B. Davies, Hypothesis testing when a nuisance parameter is present only under the
    alternative, Biometrika 74 (1987) 33.
    """

    label = "torque periodic in position"
    axis = "position"
    coefficients = (
        Parameter("ripple_cos_nm", "N m", "cosine amplitude"),
        Parameter("ripple_sin_nm", "N m", "sine amplitude"),
    )
    nonlinear = (Parameter("ripple_order", "1", "waves per revolution", lower=0.0, upper=1e5),)
    requires = staticmethod(partial(span, least_rad=0.5))
    record = "pass slowly and steadily over five periods of the ripple"
    separate = {"joint_elasticity": "repeat slow, steady motions at two speeds: a ripple's frequency goes with speed"}

    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        for place, wave in enumerate(waves(motion.q, (order for (order,) in many))):
            yield place, np.stack([wave.real, wave.imag]).T

    def tries(self, data: JointData) -> list[tuple[float]]:
        """Return orders so close to each other that none between two is missed, where the time of a search allows."""
        first, last = order_range(data)
        # Of the position while the joint moves: orders that differ by one over it are others.
        spread = max(float(np.std(data.q[data.used])) if data.used.any() else 0.0, 1e-3)
        step = np.clip((last - first) / MOST_ORDERS, FINEST / spread, COARSEST / spread)
        return [(order,) for order in np.arange(first, last, step)[:MOST_ORDERS].tolist() or [first]]


def order_range(data: JointData) -> tuple[float, float]:
    """From two periods over the range up to where a slow motion leaves the band."""
    low, high = reach(data)
    first = 4.0 * np.pi / max(high - low, 1e-3)
    return first, max(2.0 * np.pi * min(CORNER_HZ, 0.25 / data.step_s) / data.low_and_high_speed[0], first)


PARTS = 12  # of the range, between which it may begin to pull; the first and the last for a side on which it does not
# Free stretches are so many parts long: their middles lie closer to each other than their lengths. From no free
# stretch there is no way downhill to a short one, which therefore has to be on the grid.
STEP = 2
NONE = 1e-4  # half of a free stretch that is none to speak of, as a share of the range
# A spring without a free stretch that does not harden: nothing but stiffness and preload, wherever its centre is.
STRAIGHT: Nonlinear = {}


class CableSpring(Effect):
    """A cable or hose that pulls the joint back: a spring with a free stretch, linear and cubic, and its preload.

    The free stretch makes it the slack of a cable; where it covers one end of the range, a tether that pulls at the
    other. A linear spring about another centre is one about this centre with a preload.
    """

    label = "a cable pulls the joint back"
    axis = "position"
    coefficients = (
        Parameter("cable_stiffness_nm_per_rad", "N m/rad", "stiffness", lower=0.0),
        Parameter("cable_hardening_nm_per_rad3", "N m/rad^3", "cubic stiffness"),
        Parameter("cable_preload_nm", "N m", "preload"),
    )
    nonlinear = (
        Parameter("cable_centre_rad", "rad", "neutral position"),
        Parameter("cable_free_rad", "rad", "slack to either side", lower=0.0),
    )
    requires = staticmethod(partial(span, least_rad=0.8))
    record = "move through all of the range"
    separate = {
        "joint_limit_stop": "move through all of the range: a stop is there at its ends only",
        "torque_bias": "rest at both ends of the range: a bias is the same there",
        "inertia_error": "move at two frequencies: on one sinusoid a spring and inertia are the same",
    }
    screened = 3
    misses = "even"
    like_gravity = True

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return the stretch d = q - c less what is free of it, and its cube, and ones, as columns."""
        centre, free = values
        off, columns = motion.q - centre, np.ones((3, len(motion.q)))
        columns[0] = off - np.clip(off, -free, free)
        columns[1] = columns[0] * columns[0] * columns[0]  # a power in general takes ten times as long
        return columns.T

    def regressors(self, data: JointData, nominal: Nominal, grid: Sequence[Nonlinear]) -> Iterator[tuple[int, Float]]:
        """Yield those of the term; of the straight spring position and preload only."""
        motion, n = data.motion(nominal.torque), len(data.q)
        straight = (data.q, np.zeros(n), np.ones(n))
        for place, at in enumerate(grid):
            yield place, self.columns(motion, self.values(at)) if at else np.column_stack(straight)

    def tries(self, data: JointData) -> list[Sequence[float] | Nonlinear]:
        """Return no free stretch, then all between edges but the one that leaves nothing, and the straight spring."""
        low, high = reach(data)
        # Whole numbers, for neighbours on a grid must not differ by rounding only.
        pairs = [(a, b) for a in range(PARTS) for b in range(a + STEP, PARTS + 1, STEP) if b - a < PARTS]
        places = [(PARTS, NONE), *((a + b, 0.5 * (b - a) / PARTS) for a, b in pairs)]
        length = high - low
        return [*((low + 0.5 * twice / PARTS * length, free * length) for twice, free in places), STRAIGHT]

    def possible(self, coefficients: Float, at: Points) -> Each:
        return (coefficients[0] > 0) & (coefficients[0] + coefficients[1] > 0)  # pulls back, also stretched by a radian


DEPTH_RAD = 0.1  # depth at which a stop's torque is quoted, so that its unit does not depend on the exponent
DEPTHS = (0.02, 0.05, 0.08, 0.12, 0.2)  # how deep the joint goes into a stop, as shares of the range
EXPONENTS = (1.0, 2.0)


class JointLimitStop(Effect):
    """Stops near the ends of the range: springs that only push back, with a damper while they are touched.

    K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in vibroimpact, Journal of Applied
    Mechanics 42 (1975) 440: the torque grows with a power of the depth, and so does the damping; a plain damper too.
    """

    label = "a stop near the end of the range"
    axis = "position"
    coefficients = (
        Parameter("stop_upper_nm", "N m", "torque 0.1 rad into the upper stop", lower=0.0),
        Parameter("stop_lower_nm", "N m", "torque 0.1 rad into the lower stop", lower=0.0),
        Parameter("stop_damping_nms_per_rad", "N m s/rad", "damping in contact"),
        Parameter("stop_deep_damping_nms_per_rad", "N m s/rad", "damping 0.1 rad into a stop"),
    )
    nonlinear = (
        Parameter("stop_upper_rad", "rad", "position of the upper stop"),
        Parameter("stop_lower_rad", "rad", "position of the lower stop"),
        Parameter("stop_exponent", "1", "exponent of the depth", lower=0.5, upper=5.0),
    )
    requires = staticmethod(partial(span, least_rad=0.5))
    record = "move through all of the range"
    separate = {"contact_event": "go to the same place again: a stop is still there"}
    screened = 3
    misses = "even"
    like_gravity = True

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return (depth / 0.1 rad)^n at the upper and the lower stop, dq while one is touched, that times the power."""
        upper, lower, exponent = values
        columns = np.zeros((4, len(motion.q)))
        at = np.flatnonzero((motion.q > upper) | (motion.q < lower))  # at most samples no stop is touched
        q, dq = motion.q[at], motion.dq[at]
        up, down = (np.maximum(depth / DEPTH_RAD, 0.0) ** exponent for depth in (q - upper, lower - q))
        columns[:, at] = up, -down, dq, dq * (up + down)
        return columns.T

    def tries(self, data: JointData) -> list[Sequence[float]]:
        low, high = float(data.q.min()), float(data.q.max())
        length = high - low
        tried = product(((1.0, 0.0), (0.0, 1.0), (1.0, 1.0)), DEPTHS, EXPONENTS)
        return [(high - up * deep * length, low + down * deep * length, n) for (up, down), deep, n in tried]

    def possible(self, coefficients: Float, at: Points) -> Each:
        return np.all(coefficients[:2] >= 0, axis=0) & (coefficients[0] + coefficients[1] > 0)  # stops push back
