"""Interaction -> JointData: torque and motion of each joint through one filter, on one even grid.

Torque, position and velocity go through the same symmetric low-pass, which delays nothing: a linear relation between
them holds after it as before. Its kernel has an end, so a hole in the log spoils a stretch that can be named, and a
cycle that is locked away is touched by its neighbour for no longer than half a kernel.

The grid is fine (400 Hz, corner 80 Hz), for what is not linear in the motion, the sign of the velocity above all, is
built on it and only then low-passed as far as a regression wants (``rows``): what a filter smears at a reversal of the
measured torque it smears in the column too. Slower logs keep their own rate, and a quarter of it as corner.

Velocity and acceleration are derivatives of the position where that errs less than the velocity that was logged: a
Panda's position is a hundred times quieter, and drivers log differences of the position behind a filter, which come
some milliseconds late. Where it errs more it is still quieter at low frequencies, and counts there. Position and torque
were sampled together; a velocity that lags them would pass for a delay.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.both_velocities import best_of_both, crossover_of
from friction_audit.diagnosis.certain_direction import certain_direction
from friction_audit.diagnosis.known_load import KnownLoad, know_load
from friction_audit.diagnosis.steady_clock import steady_clock
from friction_audit.effects.breakaway import find_breakaways, signed_rest
from friction_audit.effects.joint_data import JointData, grid_noise
from friction_audit.joint_log import MINIMUM_SAMPLES, Float, JointLog, median_step
from friction_audit.parallel import per_joint
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.sign import coarse_log
from friction_audit.preprocessing.torque_source import CHANNELS
from friction_audit.preprocessing.velocity import find_lag
from friction_audit.robot import Arm

CORNER_HZ = 80.0
GRID_HZ = 400.0
LEAST_OVERSAMPLING = 4
"""Fine samples per grid sample, so that the difference quotient of the kernel is its derivative to 3 %."""
STOPBAND_DB = 60.0
HOLE_S = 0.02
HOLE_STEPS = 3.5
"""A hole is longer than both: shorter ones are bridged."""
GAP_STEPS = 1.5
"""A longer step has lost a sample, and a position bends in there: within 8 ms at 10 rad/s^2 by 0.1 mrad, a push."""
DEAD_SIGMAS = 5.0
"""A speed of so many standard deviations of the filtered velocity's noise has a certain direction."""
DEAD_SHARE = 1e-3
"""And of so much of the usual speed, which is what the stop band lets through next to a standstill."""
TINY_SPEED = 1e-6


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class LowPass:
    """A symmetric low-pass that reads an even fine clock and writes every so many samples.

    Attributes:
        t: Times of the grid, shape (n,). [s]
        fine: Times of the fine clock, half a kernel longer at both ends. [s]
        every: Fine samples per grid sample.
        kernel: Weights, shape (2 h + 1,), sum 1.
        slope: Weights that give the derivative. [1/s]
        corner_hz: Half of the amplitude passes here. [Hz]
    """

    t: Float
    fine: Float
    every: int
    kernel: Float
    slope: Float
    corner_hz: float

    @property
    def reach_s(self) -> float:
        """Half of the kernel's length. [s]"""
        return float(self.fine[1] - self.fine[0]) * (len(self.slope) // 2)

    def of(self, t: Float, signal: Float) -> Float:
        """Filter a signal, shape (m,) at times t, onto the grid, shape (n,)."""
        return self._apply(np.interp(self.fine, t, signal), self.kernel)

    def all_of(self, t: Float, signals: Float) -> Float:
        """Filter the columns of signals, shape (m, j), onto the grid, shape (n, j)."""
        return np.stack([self.of(t, column) for column in signals.T], axis=1)

    def with_slope(self, t: Float, signal: Float) -> tuple[Float, Float]:
        """Filter a position, bent over lost samples as about them, and give the derivative of what comes out."""
        even = self._bridged(t, signal)
        return self._apply(even, self.kernel), self._apply(even, self.slope)

    def _bridged(self, t: Float, position: Float) -> Float:
        """A position on the fine clock; where samples are lost, a cubic spline."""
        even = np.interp(self.fine, t, position)
        lost = np.flatnonzero(np.diff(t) > GAP_STEPS * median_step(t))
        if len(lost):
            from scipy.interpolate import CubicSpline

            inside = np.isin(np.searchsorted(t, self.fine) - 1, lost)
            even[inside] = CubicSpline(t, position)(self.fine[inside])
        return even

    def _apply(self, even: Float, kernel: Float) -> Float:
        from scipy.signal import upfirdn

        # The full convolution at index start + i * every is centred on grid sample i; zeros in front make it decimable.
        start = (len(self.slope) + len(kernel)) // 2 - 1
        front = -start % self.every
        coarse = upfirdn(np.append(np.zeros(front), kernel), even, down=self.every)
        first = (start + front) // self.every
        return np.asarray(coarse[first : first + len(self.t)], np.float64)


def low_pass_for(t: Float) -> LowPass:
    """Choose grid and corner from the rate of a log and build the filter.

    Args:
        t: Stamps, strictly increasing, shape (m,). [s]
    """
    from scipy.signal import firwin, kaiserord

    rate = 1.0 / median_step(t)
    grid_hz = min(GRID_HZ, rate)
    corner = min(CORNER_HZ, grid_hz / 4)
    every = max(round(rate / grid_hz), LEAST_OVERSAMPLING)
    fine_hz = grid_hz * every
    taps, beta = kaiserord(STOPBAND_DB, corner / (fine_hz / 2))
    kernel = np.asarray(firwin(taps | 1, corner, window=("kaiser", beta), fs=fine_hz), np.float64)
    slope = np.convolve(kernel, [0.5, 0.0, -0.5]) * fine_hz
    samples = max(int(np.floor((t[-1] - t[0]) * grid_hz * (1 + 1e-12))) + 1, 2)
    half = len(slope) // 2
    fine = t[0] + np.arange(-half, (samples - 1) * every + half + 1) / fine_hz
    return LowPass(
        t=t[0] + np.arange(samples) / grid_hz, fine=fine, every=every, kernel=kernel, slope=slope, corner_hz=corner
    )


def prepare(
    interaction: Interaction, cycles: EnergyCycles, log: JointLog, arm: Arm | None = None
) -> tuple[JointData, ...]:
    """Bring every joint of an interaction onto an even grid.

    Args:
        interaction: Motion and torque at the friction port, n samples of j joints.
        cycles: Its energy cycles.
        log: The log it was made from, in the same window, with all its joints.
        arm: The model of the arm where it is known.

    Returns:
        One ``JointData`` per joint, in the order of the columns.
    """
    common = _common(interaction, log, arm)
    return tuple(per_joint(lambda joint: _one(common, cycles, joint), len(interaction.joint_numbers)))


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class _Common:
    """What all joints of a log share: samples that are news and their stamps, the grid, and all joints on it."""

    interaction: Interaction
    log: JointLog
    new: NDArray[np.bool_]
    t: Float
    low_pass: LowPass
    valid: NDArray[np.bool_]
    everyone: "_Everyone"
    known: KnownLoad
    gravity: Float | None
    load: Float | None
    better: Float


def _common(interaction: Interaction, log: JointLog, arm: Arm | None) -> _Common:
    new = fresh_samples(log)
    t = _stamps(log.t[new], log.q[new])
    low_pass = low_pass_for(t)
    valid = _valid(low_pass, t)
    everyone = _filter_everyone(interaction, log, low_pass, t, new, valid)
    known = know_load(log, interaction.choice, arm, low_pass.t, (everyone.q, everyone.dq, everyone.ddq))
    gravity = (
        known.gravity if log.gravity is None or known.gravity is not None else low_pass.all_of(t, log.gravity[new])
    )
    load = known.load(interaction.choice, gravity)
    better = _refined(interaction, everyone, low_pass, t, new, known.taken(interaction.choice, load))
    return _Common(
        interaction=interaction,
        log=log,
        new=new,
        t=t,
        low_pass=low_pass,
        valid=valid,
        everyone=everyone,
        known=known,
        gravity=gravity,
        load=load,
        better=better,
    )


def _one(common: _Common, cycles: EnergyCycles, joint: int) -> JointData:
    column = common.interaction.joint_numbers[joint] - 1
    # Copies, for what lies in a matrix of all joints is read at an eighth of the pace, a thousand times.
    q, own_dq = (np.ascontiguousarray(every[:, column]) for every in (common.everyone.q, common.everyone.dq))
    dead = _dead_speed(own_dq[common.valid])
    step = float(common.low_pass.t[1] - common.low_pass.t[0])
    breakaways = find_breakaways(q, own_dq, dead, step)
    dq, ddq = signed_rest(own_dq, common.everyone.ddq[:, column], breakaways, dead)
    return JointData(
        joint=joint,
        t=common.low_pass.t,
        q=q,
        dq=dq,
        ddq=ddq,
        torque=common.low_pass.of(common.t, _torque(common.interaction, joint)[common.new]) + common.better[:, joint],
        gravity=None if common.gravity is None else common.gravity[:, column],
        temperature=None
        if common.log.temperature is None
        else common.low_pass.of(common.t, common.log.temperature[common.new, column]),
        others_dq=common.everyone.dq,
        others_ddq=common.everyone.ddq,
        others_torque=common.everyone.sensed,
        cycle=_cycle_of(common.low_pass.t, cycles, joint),
        moving=certain_direction(own_dq, dead, step),
        valid=common.valid,
        dead_speed_rad_s=dead,
        derived_from=common.everyone.derived_from[column],
        logged_dq=common.everyone.logged[:, column],
        load=None if common.load is None else np.ascontiguousarray(common.load[:, column]),
        rigid=None if common.known.rigid is None else common.known.rigid[column],
        others_joint=column,
        sample_s=median_step(common.log.t),
        crossover_hz=common.everyone.crossover_hz[column],
    )


def fresh_samples(log: JointLog) -> NDArray[np.bool_]:
    """Tell samples that are news from those that repeat the state before them while a joint moves, shape (n,)."""
    same = np.ones(len(log.t) - 1, bool)
    moves = np.zeros(len(log.t) - 1, bool)
    for joint in range(log.q.shape[1]):
        q, dq = log.q[:, joint], log.dq[:, joint]
        same &= (q[1:] == q[:-1]) & (dq[1:] == dq[:-1])
        moves |= dq[1:] != 0
    new = np.append(True, ~(same & moves))
    if new.sum() < MINIMUM_SAMPLES:
        new[-1] = True  # a log that never changes still has a beginning and an end
    return new


def holes(t: Float) -> NDArray[np.int64]:
    """Return the samples after which a hole begins, shape (h,)."""
    step = np.diff(t)
    return np.flatnonzero(step > max(HOLE_S, HOLE_STEPS * median_step(t)))


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class _Everyone:
    """Motion of all joints of a log on the grid, what their sensors read, their velocities as logged, (n, j) each."""

    q: Float
    dq: Float
    ddq: Float
    sensed: Float
    logged: Float
    derived_from: tuple[str, ...]
    crossover_hz: tuple[float, ...]


def _filter_everyone(
    interaction: Interaction,
    log: JointLog,
    low_pass: LowPass,
    t: Float,
    new: NDArray[np.bool_],
    valid: NDArray[np.bool_],
) -> _Everyone:
    read: Float = getattr(log, CHANNELS[interaction.choice.source])
    coarse = coarse_log(log)
    lag = find_lag(coarse, median_step(log.t))
    brisk = np.sqrt(np.mean(np.gradient(coarse.dq, coarse.t, axis=0) ** 2, axis=0))

    step_s = float(low_pass.t[1] - low_pass.t[0])

    def one(column: int) -> tuple[Float, Float, Float, Float, Float, str, float]:
        q, slope = low_pass.with_slope(t, log.q[new, column])
        logged = low_pass.of(t, log.dq[new, column])
        sensed = interaction.choice.sign * low_pass.of(t, read[new, column])
        if grid_noise(slope) < np.hypot(grid_noise(logged), lag[column] * brisk[column]):
            return q, slope, np.gradient(slope, low_pass.t), sensed, logged, "q", 0.0
        dq, ddq = low_pass.with_slope(t - lag[column], log.dq[new, column])
        if crossover_hz := crossover_of(slope, dq, step_s):
            dq = best_of_both(slope, dq, valid, step_s, crossover_hz)
            ddq = np.gradient(dq, low_pass.t)
        return q, dq, ddq, sensed, logged, "dq", crossover_hz

    filtered = per_joint(one, log.q.shape[1])
    q, dq, ddq, sensed, logged = (np.stack([joint[k] for joint in filtered], axis=1) for k in range(5))
    sources, crossovers = tuple(joint[5] for joint in filtered), tuple(joint[6] for joint in filtered)
    return _Everyone(q=q, dq=dq, ddq=ddq, sensed=sensed, logged=logged, derived_from=sources, crossover_hz=crossovers)


def _torque(interaction: Interaction, joint: int) -> Float:
    """Everything that drives the side on which friction acts, shape (n,). [N m]"""
    torque = interaction.torque[:, joint]
    return torque if interaction.compensation is None else torque + interaction.compensation[:, joint]


def _refined(
    interaction: Interaction,
    everyone: _Everyone,
    low_pass: LowPass,
    t: Float,
    new: NDArray[np.bool_],
    taken: Float | None,
) -> Float:
    """What is to be added to the torque of each column because links' inertia is known better here, (n, j). [N m]

    The inertial torque in the interaction torque ends at 10 Hz, and what a reversal leaves above that would look like
    friction; the one from the motion on the grid holds all that the sensor saw.
    """
    columns = [number - 1 for number in interaction.joint_numbers]
    if taken is None:
        return np.zeros((len(low_pass.t), len(columns)))
    return everyone.sensed[:, columns] - taken[:, columns] - low_pass.all_of(t, interaction.torque[new])


def _valid(low_pass: LowPass, t: Float) -> NDArray[np.bool_]:
    """Leave out what the kernel mixes with a hole or with what lies beyond the ends."""
    after = holes(t)
    begins = np.concatenate([[-np.inf], t[after], [t[-1]]])
    ends = np.concatenate([[t[0]], t[after + 1], [np.inf]])
    place = np.searchsorted(begins, low_pass.t + low_pass.reach_s, side="left") - 1
    # The last hole that begins before the kernel ends must have ended before the kernel begins.
    return np.asarray(ends[place] <= low_pass.t - low_pass.reach_s + 1e-9, bool)


def _stamps(t: Float, q: Float) -> Float:
    """Stamps as they are, or without jitter if the joint that moves furthest runs more smoothly with those."""
    farthest = q[:, int(np.argmax(np.ptp(q, axis=0)))]
    steady = steady_clock(t)
    rough = [grid_noise(low_pass_for(stamps).with_slope(stamps, farthest)[1]) for stamps in (t, steady)]
    return steady if rough[1] < rough[0] else t


def _dead_speed(dq: Float) -> float:
    usual = float(np.quantile(np.abs(dq), 0.95)) if len(dq) else 0.0
    return max(DEAD_SIGMAS * grid_noise(dq), DEAD_SHARE * usual, TINY_SPEED)


def _cycle_of(t: Float, cycles: EnergyCycles, joint: int) -> NDArray[np.int64]:
    """Number of the joint's cycle, half-open in time, -1 outside of any."""
    rows = cycles.joint == joint
    start, stop = cycles.start_s[rows], cycles.stop_s[rows]
    if not len(start):
        return np.full(len(t), -1, np.int64)
    number = np.searchsorted(start, t, side="right") - 1
    inside = (number >= 0) & (t < stop[number])
    return np.where(inside, number, -1).astype(np.int64)
