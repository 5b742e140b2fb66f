"""What one joint did and what drove it, on an even grid; measures for grids of effects; what a log lacks."""

from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from friction_audit.dynamics.motion import Motion, Others
from friction_audit.joint_log import Bool, Float, Int
from friction_audit.preprocessing.even_grid import filtered, windowed_sinc
from friction_audit.preprocessing.interaction import Caution

CORNER_HZ = 25.0  # highest corner of the low-pass before a regression
SIGMA_PER_MEDIAN = 1.4826
SMOOTH_S = 0.2  # reach to either side of the low-pass of a motion below a frequency
# Of noise that is white up to the corner, a fifth of the grid's rate, per RMS of its second and fourth difference.
SIGMA_PER_BEND = {2: 1.0 / 0.643, 4: 1.0 / 0.670}

FEWEST_SAMPLES = 100
FEWEST_REVERSALS = 8


def mean_sign(t: Float, dq: Float, ddq: Float) -> Float:
    """Return the mean sign of a velocity of slope ddq from half a sample before to half a sample after, shape (n,).

    A sharp sign changes at a sample, a reversal anywhere between two: at 400 Hz a millisecond of twice the Coulomb
    friction, more than the noise of a good sensor.
    """
    if len(t) < 2:  # noqa: PLR2004 - one sample has no cell
        return np.sign(dq)
    change = np.maximum(0.5 * (t[1] - t[0]) * np.abs(ddq), np.abs(dq))
    return np.asarray(np.divide(dq, change, out=np.zeros(len(dq)), where=change > 0.0))


def grid_noise(signal: Float, differences: int = 2) -> float:
    """Return the standard deviation of a signal's noise; ``differences`` are 4 of a position, else 2."""
    bend = np.abs(np.diff(signal, n=differences))
    return SIGMA_PER_BEND[differences] * SIGMA_PER_MEDIAN * float(np.median(bend)) if len(bend) else 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class JointData(Motion):
    """One joint on an even grid of n samples; j joints in the log: its motion, and what drove it.

    Torque and motion went through one and the same zero-phase low-pass, so that relations between them still hold.
    """

    joint: int  # which joint, column of the interaction
    others: Others  # all joints of the log, of which this one may be the only one
    torque: Float  # what drives the side on which friction acts: F_m plus a logged compensator, shape (n,) [N m]
    cycle: Int  # number of the energy cycle of each sample, -1 outside of any
    moving: Bool  # samples in which the direction of motion is certain
    valid: Bool  # samples that are not next to a hole, a stale stretch or an end of the filter
    dead_speed_rad_s: float  # below it the direction is not certain [rad/s]
    derived_from: str = "dq"  # what velocity and acceleration were taken from, "q" or "dq"
    logged_q: Float | None = None  # position as it was logged, through the same filter; ``q`` where None [rad]
    logged_dq: Float | None = None  # velocity as it was logged, through the same filter; ``dq`` where None [rad/s]
    weighs: bool = False  # True if gravity is in the torque: all of the load, where that is known
    unknown_gravity: bool = False  # True if gravity is in the torque and also depends on other joints
    sample_s: float = 0.0  # usual step of the log itself, 0 where a torque late by part of it is of no interest [s]
    rounding: float = 0.0  # standard deviation of the rounding of that [rad or rad/s]
    noise_density: float = 0.0  # amplitude density of the white noise of that [rad/sqrt(Hz) or rad/s/sqrt(Hz)]
    crossover_hz: float = 0.0  # below it a velocity from "dq" is mainly the derivative of the position [Hz]
    # the low-passed motion by corner, as far as it was asked for [Hz]
    smooth: dict[float, Motion] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def used(self) -> Bool:
        """Samples on which a model is fitted: moving, valid and in a cycle."""
        return self.moving & self.valid & (self.cycle >= 0)

    @cached_property
    def low_and_high_speed(self) -> tuple[float, float]:
        """25th and 95th percentile of the speed while the joint moves, never 0. [rad/s]"""
        speed = np.abs(self.dq[self.used] if self.used.any() else self.dq)
        low, high = np.maximum(np.percentile(speed, (25.0, 95.0)), self.dead_speed_rad_s).tolist()
        return low, high

    @cached_property
    def without_gravity(self) -> Float:
        """The torque less the gravity that it holds, as far as that is known, shape (n,). [N m]"""
        return self.torque - self.load if self.weighs and self.load is not None else self.torque

    @property
    def step_s(self) -> float:
        """Spacing of the grid. [s]"""
        return float(self.t[1] - self.t[0])

    @cached_property
    def direction(self) -> Float:
        """Mean sign of the velocity over the cell of each sample, shape (n,)."""
        return mean_sign(self.t, self.dq, self.ddq)

    def at(self, places: Int) -> "JointData":
        """The joint by itself at some of its samples, of which the first two follow each other."""
        pairs = ((one.name, getattr(self, one.name)) for one in fields(self))
        own: dict[str, Any] = {name: values[places] for name, values in pairs if isinstance(values, np.ndarray)}
        nothing = np.empty((len(places), 0))
        others = Others(joint=self.others.joint, q=nothing, dq=nothing, ddq=nothing, sensed=nothing)
        return replace(self, **own, others=others, rigid=None)

    def motion(self, rest: Float | None = None) -> Motion:
        """The input of an effect's columns; ``rest`` is the torque of the nominal model, shape (n,)."""
        own = {one.name: getattr(self, one.name) for one in fields(Motion)}
        return Motion(**own | {"rest": rest, "smooth_direction": self.direction})

    def motion_below(self, below_hz: float) -> Motion:
        """The motion below a frequency, at which half of the amplitude passes, without a torque."""
        if below_hz not in self.smooth:
            q, dq, ddq = signals = np.stack([self.q, self.dq, self.ddq])
            if below_hz < 0.5 / self.step_s:  # the log holds nothing above its Nyquist frequency
                kernel = windowed_sinc(2.0 * below_hz * self.step_s, np.hamming(2 * round(SMOOTH_S / self.step_s) + 1))
                # Symmetrically, the ends held; from the first values, so that rest is rest to the last digit.
                first = signals[:, :1]
                q, dq, ddq = first + filtered(signals - first, kernel, np.arange(len(self.t)))
            direction = mean_sign(self.t, dq, ddq)
            self.smooth[below_hz] = replace(self.motion(), q=q, dq=dq, ddq=ddq, smooth_direction=direction)
        return self.smooth[below_hz]


def reach(data: JointData) -> tuple[float, float]:
    """Lowest and highest position while the joint moves. [rad]"""
    q = data.q[data.used] if data.used.any() else data.q
    return float(q.min()), float(q.max())


def shares_of_span(data: JointData, shares: Float) -> list[float]:
    """Shares of the span of the position, of 1 rad where it never changes. [rad]"""
    return [float(width) for width in shares * (np.ptp(data.q) or 1.0)]


@dataclass(frozen=True, kw_only=True, slots=True)
class Nominal:
    """The nominal model as fitted to a joint: what columns may be built on, never the measured torque itself."""

    inertia_kg_m2: float
    coulomb_nm: float
    viscous_nms_per_rad: float
    torque: Float  # that the model predicts, shape (n,) [N m]
    declared: frozenset[str] = frozenset()  # names of the numbers above that were stated; all others were fitted


def displacement(data: JointData) -> Float:
    """Return the position less that at the last reversal, 0 before the first motion, shape (n,). [rad]

    A direction holds until the opposite one is certain (hysteresis); a stroke begins at the first sample from which the
    velocity has its sign up to there.
    """
    dq, samples = data.dq, np.arange(len(data.dq))
    sign = np.where(np.abs(dq) > data.dead_speed_rad_s, np.sign(dq), 0.0)
    last = np.maximum.accumulate(np.where(sign != 0, samples, -1))
    direction = np.where(last >= 0, sign[np.maximum(last, 0)], 0.0)
    turns = np.flatnonzero(np.diff(direction)) + 1
    not_up, not_down = (np.maximum.accumulate(np.where(side * dq <= 0.0, samples, -1)) for side in (1.0, -1.0))
    starts = np.where(direction[turns] > 0.0, not_up[turns - 1], not_down[turns - 1]) + 1
    since, still = np.zeros(len(dq), dtype=np.int64), direction == 0
    since[starts] = starts
    if len(starts):
        still[starts[0] :] = False
    return np.where(still, 0.0, data.q - data.q[np.maximum.accumulate(since)])


# What a log of a joint that moves must hold for an effect to be identifiable: None, or what it lacks.


def both_directions(data: JointData, _nominal: Nominal) -> Caution | None:
    """At least a tenth of the moving time in either direction."""
    mixed = 0.1 <= float(np.mean(data.dq[data.used] > 0)) <= 0.9  # noqa: PLR2004 - a tenth either way
    return None if mixed else Caution("one_direction")


def long_enough(
    data: JointData, nominal: Nominal, short: str, shortest_s: float = 0.0, fewest: int = 0
) -> Caution | None:
    """At least so many seconds and cycles, else a caution of the code ``short``; and both directions."""
    length, cycles = float(np.ptp(data.t)), len(np.unique(data.cycle[data.used]))
    if length >= shortest_s and cycles >= fewest:
        return both_directions(data, nominal)
    return Caution(short, numbers={"cycles": cycles, "length": length, "fewest": fewest, "shortest": shortest_s})


def speed_range(data: JointData, _nominal: Nominal, ratio: float) -> Caution | None:
    """95th over 5th percentile of speed at least the ratio."""
    slow, fast = np.percentile(np.abs(data.dq[data.used]), [5, 95])
    even = fast < ratio * slow
    return Caution("even_speed", numbers={"factor": fast / slow, "least": ratio}) if even else None


def span(data: JointData, _nominal: Nominal, least_rad: float) -> Caution | None:
    """Range of positions of the moving joint at least so many radians."""
    low, high = reach(data)
    small = high - low < least_rad
    return Caution("small_span", numbers={"span": high - low, "least": least_rad}) if small else None


def reversals(data: JointData, _nominal: Nominal) -> Caution | None:
    """Reversals among the training cycles and among the held-out ones; a direction holds until the other is certain."""
    found = np.count_nonzero(np.diff(np.sign(data.dq[np.abs(data.dq) > data.dead_speed_rad_s])))
    few = found < FEWEST_REVERSALS
    return Caution("few_reversals", numbers={"found": found, "fewest": FEWEST_REVERSALS}) if few else None
