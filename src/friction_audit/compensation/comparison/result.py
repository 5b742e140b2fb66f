"""Measures of a trial (one method, one tuning, one person), and their means and medians over persons."""

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from math import isfinite, isinf, nan, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.comparison.methods import Tuning
from friction_audit.errors import AnalysisError
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.friction.weighted import CONFIDENCE, t_quantile
from friction_audit.joint_log import Bool, Float
from friction_audit.simulation.settings import CONTROL_RATE_HZ, Simulation, TrueMotion

VIBRATION_S = 0.1  # moving average over this time: the difference from it is vibration, too fast for a person. [s]
RINGING_SHARE = 0.5  # share of a second with vibration at which a loop counts as unstable
# Speed above which a joint counts as moving: the paper's threshold for the end of a cycle. [rad/s]
MOVING_RAD_S = 0.05
# Standstill is measured in the last ``SETTLED_S`` of rests that last ``REST_S`` without compensation. [s]
REST_S, SETTLED_S = 0.3, 0.1
SECOND = 1  # row of the second cycle
DRAWN_HZ = 10.0  # low-pass of torques as in Figs 8, 11 and 14, above the motion of a person. [Hz]
FEWEST = 4  # cycles needed for a slope after the second one


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Reference:
    """The trial without compensation, the reference of all trials of a seed."""

    ends: NDArray[np.intp]  # ticks at which cycles end, shape (m,)
    resting: Bool  # ticks at the end of long rests of a joint, shape (n + 1, j)
    rms_torque_nm: Float  # rms interaction torque after the second cycle, shape (j,) [N m]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Course:
    """Signals of a trial for figures; n samples, j joints."""

    t: Float  # time, shape (n,) [s]
    dq: Float  # velocity, shape (n, j) [rad/s]
    interaction_nm: Float  # interaction torque, shape (n, j) [N m]
    energy_j: Float  # net energy input of the person, all joints, shape (n,) [J]
    from_s: float  # end of the second cycle [s]


@dataclass(frozen=True, kw_only=True, slots=True)
class Outcome:
    """Measures of a trial after its second cycle; of an arm, the sum or the worst of its joints."""

    lost_s: float  # time at which the loop diverged or vibrated, infinity if it was stable [s]
    energy_slope_w: float  # slope of the net energy at the ends of the cycles, from the second on; all joints [W]
    peak_torque_nm: float  # largest interaction torque of any joint [N m]
    drawn_peak_nm: float  # the same as in the paper's figures: low-passed, of the joint with most torque [N m]
    rms_torque_nm: float  # root of the mean square of the interaction torque, summed over joints [N m]
    vibration_nm: float  # the same of its vibration [N m]
    standstill_rad_s: float  # rms speed at ticks where the joint rests without compensation [rad/s]
    chatter_nm: float  # rms change of the compensator's torque per tick there [N m]
    coulomb_left: float  # apparent over true Coulomb friction, mean of the joints
    viscous_left: float  # the same of viscous friction
    inertia_left: float  # the same of the motor's inertia


def find_reference(simulation: Simulation) -> Reference:
    """Return the reference of the trials of a seed, from a trial whose compensator only detects cycles."""
    from scipy.ndimage import find_objects, label

    motion, cycle = simulation.truth.motion, simulation.truth.compensators["cycle"][:, 0]
    ends = np.flatnonzero(np.diff(cycle)) + 1
    if len(ends) < FEWEST:
        raise AnalysisError(
            f"compare: seed {simulation.truth.seed}: {len(ends)} cycles in {motion.t[-1]:g} s, expected at least "
            f"{FEWEST}; choose a longer --duration"
        )
    resting = np.zeros(motion.inner_dq.shape, dtype=np.bool_)
    for joint, at_rest in enumerate((motion.inner_dq == 0.0).T):
        for (rest,) in find_objects(label(at_rest)[0]):
            if rest.stop - rest.start >= REST_S * CONTROL_RATE_HZ:
                resting[rest.stop - int(SETTLED_S * CONTROL_RATE_HZ) : rest.stop, joint] = True
    return Reference(ends=ends, resting=resting, rms_torque_nm=_rms(motion.interaction_nm[ends[SECOND] :]))


def measure(simulation: Simulation, reference: Reference) -> Outcome:
    """Return the measures of a trial."""
    from scipy.signal import butter, sosfiltfilt

    low_pass = butter(2, DRAWN_HZ, fs=CONTROL_RATE_HZ, output="sos")
    motion, after, resting = simulation.truth.motion, reference.ends[SECOND], reference.resting
    torque, lost, ends = motion.interaction_nm, find_instability(simulation, reference), reference.ends[SECOND:]
    apparent = np.array([apparent_parameters(motion, joint, after) for joint in range(torque.shape[1])])
    true = np.array([astuple(one.at_link)[:3] for one in simulation.truth.settings.joints])
    changes = np.diff(motion.compensation_nm + motion.passivity_nm, axis=0, prepend=0.0)
    inertia_left, coulomb_left, viscous_left = np.mean(apparent / true, 0).tolist()
    return Outcome(
        lost_s=lost,
        energy_slope_w=float(np.polyfit(motion.t[ends], net_energy_j(motion)[ends], 1)[0]),
        peak_torque_nm=float(np.abs(torque[after:]).max()),
        drawn_peak_nm=float(np.abs(sosfiltfilt(low_pass, torque[:, np.argmax(reference.rms_torque_nm)])[after:]).max()),
        rms_torque_nm=float(np.hypot.reduce(_rms(torque[after:]))),
        vibration_nm=float(np.hypot.reduce(_rms(vibration_nm(torque)[after:]))),
        standstill_rad_s=float(_rms(motion.inner_dq[resting])),
        chatter_nm=float(_rms(changes[resting])),
        inertia_left=inertia_left,
        coulomb_left=coulomb_left,
        viscous_left=viscous_left,
    )


def net_energy_j(motion: TrueMotion) -> Float:
    """Return the net energy input of the person, all joints, shape (n + 1,). [J]"""
    from scipy.integrate import cumulative_trapezoid

    power = np.einsum("ij,ij->i", motion.interaction_nm, motion.dq)
    return np.asarray(cumulative_trapezoid(power, motion.t, initial=0))


def vibration_nm(torque_nm: Float) -> Float:
    """Return the vibration of a torque, its difference from a moving average, shape (n, j) as given. [N m]"""
    from scipy.ndimage import uniform_filter1d

    return np.asarray(torque_nm - uniform_filter1d(torque_nm, int(VIBRATION_S * CONTROL_RATE_HZ) + 1, axis=0))


def apparent_parameters(motion: TrueMotion, joint: int, after: int) -> Float:
    """Return apparent inertia, Coulomb and viscous friction of a moving joint, shape (3,), by least squares."""
    dq = motion.inner_dq[after:, joint]
    rows = np.abs(dq) > MOVING_RAD_S
    dq, ddq, torque = dq[rows], motion.inner_ddq[after:, joint][rows], motion.interaction_nm[after:, joint][rows]
    columns = np.stack([ddq, np.sign(dq), dq, np.ones_like(dq)], axis=1)
    return np.asarray(np.linalg.lstsq(columns, torque, rcond=None)[0][:3])


def find_instability(simulation: Simulation, reference: Reference) -> float:
    """Return when a loop became unstable, or infinity: its compensator switched off, or it vibrates. [s]

    It vibrates where, for half of a second in total, the vibration of a torque is above the joint's rms torque without
    compensation; this is the case for a sinusoid of this rms.
    """
    motion, second = simulation.truth.motion, int(CONTROL_RATE_HZ)
    unstable = simulation.truth.compensators["unstable"].any(axis=1)
    vibrating = np.abs(vibration_nm(motion.interaction_nm)) > reference.rms_torque_nm
    counts = np.cumsum(vibrating, axis=0, dtype=np.float64)
    counts[second:] -= counts[:-second].copy()
    rings = (counts > RINGING_SHARE * second).any(axis=1)
    lost = np.flatnonzero(unstable | rings)
    return float(motion.t[lost[0]]) if len(lost) else np.inf


def make_course(simulation: Simulation, reference: Reference) -> Course:
    """Return the signals of a trial for figures, as long as it was stable."""
    motion = simulation.truth.motion
    shown = motion.t <= find_instability(simulation, reference)
    return Course(
        t=motion.t[shown],
        dq=motion.dq[shown],
        interaction_nm=motion.interaction_nm[shown],
        energy_j=net_energy_j(motion)[shown],
        from_s=float(motion.t[reference.ends[SECOND]]),
    )


def _rms(values: Float) -> Float:
    """Return the root of the mean square along the first axis, NaN of none."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sqrt(np.divide(np.sum(values**2, axis=0), len(values))))


# Over persons.


def mean_interval(values: Sequence[float]) -> Coefficient:
    """Return the mean of independent values and its 95 % interval (Student's t)."""
    known = [value for value in values if isfinite(value)]
    if len(known) < 2:  # noqa: PLR2004
        return Coefficient(value=known[0] if known else nan, low=nan, high=nan)
    mean = float(np.mean(known))
    half = t_quantile(len(known) - 1) * float(np.std(known, ddof=1)) / sqrt(len(known))
    return Coefficient(value=mean, low=mean - half, high=mean + half)


def median_interval(values: Sequence[float]) -> Coefficient:
    """Return the lower median of values, infinite ones too, and its 95 % interval by order statistics, from six on."""
    from scipy.stats import quantile_test

    if not values:
        return UNDETERMINED
    found: Any = quantile_test(values, p=0.5).confidence_interval(CONFIDENCE)
    return Coefficient(value=sorted(values)[(len(values) - 1) // 2], low=float(found.low), high=float(found.high))


@dataclass(frozen=True, eq=False, kw_only=True)
class TuningResult:
    """Outcomes of a tuning."""

    tuning: Tuning
    outcomes: tuple[Outcome, ...]  # one per seed

    @property
    def stable_share(self) -> float:
        """Share of the seeds with a stable loop."""
        return 1.0 - len(self.lost_s) / len(self.outcomes)

    @property
    def lost_s(self) -> tuple[float, ...]:
        """Times at which the loop became unstable, of the seeds where it did. [s]"""
        return tuple(one.lost_s for one in self.outcomes if isfinite(one.lost_s))

    def interval(self, measure: str) -> Coefficient:
        """Return mean and interval of a measure, by its name, over the seeds with a stable loop."""
        return mean_interval([getattr(outcome, measure) for outcome in self.outcomes if isinf(outcome.lost_s)])


@dataclass(frozen=True, eq=False, kw_only=True)
class Point(TuningResult):
    """One value of a sweep, with persons who are not reported."""

    value: float


@dataclass(frozen=True, eq=False, slots=True)
class Curve:
    """Results of a sweep."""

    method: str  # name of the method
    label: str  # its label
    name: str  # name of the sweep
    axis: str  # the parameter
    points: tuple[Point, ...]  # in the order of rising gain
    boldest_stable: float | None  # the last value before the first unstable one; None if the first is unstable


@dataclass(frozen=True, eq=False, kw_only=True)
class Row(TuningResult):
    """A method with a tuning, and its outcomes for the reported persons."""

    method: str  # name of the method
    label: str  # its label
    role: str  # ``"paper"``, ``"full"``, ``"best"`` or ``"other"``
    # number of persons of the sweeps with an unstable loop; None if the tuning was not chosen from a sweep
    tuning_losses: int | None
    # largest stable factor of the gain, one per seed with a margin; 0 if unstable at 1, infinite beyond the search
    margins: tuple[float, ...]
    margin: Coefficient  # median of the stability margins; NaN without any
    course: Course  # signals of the first seed


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Comparison:
    """Comparison of methods on one setup."""

    setup: str  # its name
    duration_s: float  # length of a trial [s]
    seeds: tuple[int, ...]  # seeds that are reported
    tuning_seeds: tuple[int, ...]  # seeds of the sweeps
    margin_seeds: tuple[int, ...]  # seeds with stability margins
    rows: tuple[Row, ...]  # methods and tunings, in the order of the methods
    curves: tuple[Curve, ...]  # the sweeps

    def row(self, method: str, role: str) -> Row | None:
        """Return the row of a method with a role; a method with one row has it for every role."""
        mine = [row for row in self.rows if row.method == method]
        return next((row for row in mine if row.role == role), mine[0] if len(mine) == 1 else None)
