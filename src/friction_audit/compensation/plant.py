"""Plant of a replay: the recorded motion, or a simulated joint with its operator's impedance fitted to reversals."""

from dataclasses import astuple, dataclass
from math import isfinite, isnan, nan

import numpy as np

from friction_audit.compensation import SAME_MOTION, SAME_OPERATOR, competitors, replay_loops as loops
from friction_audit.compensation.competitors import Compensator
from friction_audit.compensation.controller import HOLE_S
from friction_audit.compensation.records import initial_states, settings_records
from friction_audit.compensation.result import FittedOperator, Signals
from friction_audit.compensation.settings import ReplaySettings
from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.torque_tables import Tables, steps_per_sample, tabulate
from friction_audit.effects.joint_model import JointModel, simple_model
from friction_audit.errors import AnalysisError
from friction_audit.friction.history import Coefficient, JointFriction, TorqueRegression
from friction_audit.friction.torque_regression import CUTOFF_HZ
from friction_audit.joint_log import Bool, Float, Int, median_step, read_only
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Caution, Interaction
from friction_audit.preprocessing.velocity import filter_velocity

SHORTEST_CYCLE = 4  # samples
LEAST_INERTIA_KG_M2 = 1e-3  # of a motor with its gear; where less is fitted, the torque was recorded without inertia


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class ReplayPart:
    """One joint's recording or a part of it, n samples; and the plant that is simulated in its place, if any."""

    recorded: loops.RecordedJoint
    cycle_ends: Int  # per sample DETECT, or where cycles end, shape (n,) or (1,)
    motion: Motion | None = None  # the recorded motion for a joint's model; None without a model
    fitted: TorqueRegression | None = None  # the fit to the log that the plant is made of, or None
    operator: FittedOperator | None = None  # the operator's impedance, or None where the torque stays as recorded
    plant: loops.Plant | None = None  # None along the recorded motion


class CompensatorRun:
    """A compensator, or none, that runs through the parts of a recording."""

    def __init__(self, compensator: Compensator | None, step_s: float, peak_power_w: float) -> None:
        """Prepare a run for a clock's step and the largest power of the total torque in the recording."""
        self._compensator, self._settings = compensator, settings_records([compensator], 1.0 / step_s)[0]
        rest = np.zeros(2)
        self._feedforward = competitors.make_feedforward((), Motion(t=np.arange(2.0), q=rest, dq=rest, ddq=rest))
        self.state, self.cycles = initial_states(1)[0], [np.zeros(0, loops.CYCLE)]
        self.statistics, self.torque_sums = np.zeros(1, loops.STATISTICS)[0], np.zeros(1, loops.TORQUE_SUMS)[0]
        self.statistics["activation_s"] = self.statistics["diverged_s"] = nan
        payback_s = compensator.payback_s if compensator is not None and compensator.passivity else 0.0
        self.statistics["tolerance_j"] = peak_power_w * (loops.TOLERATED_SAMPLES * step_s + payback_s)

    def run(self, part: ReplayPart) -> Signals:
        """Run through the next part; return its signals, up to where the loop diverges."""
        recorded, motion, samples = part.recorded, part.motion, 0
        dq, torques = recorded.dq, np.zeros((4, len(recorded.t)))
        cycles = np.empty(len(recorded.t) // SHORTEST_CYCLE + 2, loops.CYCLE)
        if motion is not None and isinstance(self._compensator, competitors.JointModelCompensation):
            self._feedforward = competitors.make_feedforward(self._compensator.terms, motion)
        controller = loops.Controller(
            self._settings, self.state, self.statistics, self._feedforward, part.cycle_ends, torques, cycles
        )
        if isnan(self.statistics["diverged_s"]):
            if part.plant is None:
                samples = loops.run_same_motion(controller, recorded)
            else:
                dq = np.empty(len(recorded.t))
                samples = loops.run_closed_loop(controller, recorded, part.plant, dq)
            if samples < len(recorded.t):
                self.statistics["diverged_s"] = recorded.t[samples]
        self.cycles.append(cycles[: int(self.statistics["cycles"])].copy())
        self.statistics["cycles"] = 0
        signals = Signals(recorded.t[:samples], *map(read_only, (dq[:samples], *torques[:, :samples])))
        loops.add_torque(self.torque_sums, signals.t, signals.dq, signals.interaction_nm)
        return signals


def recording_of(interaction: Interaction, column: int) -> loops.RecordedJoint:
    """Return the recording of a joint (0-based), each signal contiguous in memory."""
    channels, logged = (interaction.q, interaction.dq, interaction.torque), interaction.compensation
    q, dq, torque = (read_only(channel[:, column]) for channel in channels)
    total = torque if logged is None else read_only(torque + logged[:, column])
    return loops.RecordedJoint(read_only(interaction.t), q, dq, torque, total)


def fitted_joint(friction: JointFriction) -> tuple[TorqueRegression, JointModel]:
    """Return the torque regression of the log, and its inertia and friction as a joint's model."""
    found = friction.regression
    if friction.reason:
        raise AnalysisError(friction.reason)
    if found is None:
        raise AnalysisError((Caution("too_few_to_fit"),))
    if not (found.inertia.low > 0.0 and found.inertia.value > LEAST_INERTIA_KG_M2):
        numbers = {"inertia": found.inertia, "case": "some" if isfinite(found.inertia.value) else "none"}
        raise AnalysisError((Caution("inertia_not_determined", numbers=numbers),))
    negative = [name for name, one in (("Coulomb", found.coulomb), ("viscous", found.viscous)) if not one.high > 0.0]
    if negative:
        raise AnalysisError((Caution("fit_pushes", numbers={"names": " and ".join(negative)}),))
    return found, simple_model(
        inertia_kg_m2=found.inertia.value,
        coulomb_nm=max(0.0, found.coulomb.value),
        viscous_nms_per_rad=max(0.0, found.viscous.value),
    )


def tabulate_model(model: JointModel, motion: Motion) -> Tables:
    """Tabulate a joint's model along a motion; AnalysisError if it cannot be simulated."""
    competitors.check_runnable(model.terms)
    if {term.name for term in model.terms} <= {"coulomb", "viscous"}:  # the limits of the motion are enough
        few = np.unique([0, 1, np.argmin(motion.q), np.argmax(motion.q), np.argmax(np.abs(motion.dq))])
        motion = Motion(t=motion.t[few], q=motion.q[few], dq=motion.dq[few], ddq=motion.ddq[few])
    tables, past = tabulate(model.inertia_kg_m2, model.terms, motion)
    competitors.check_runnable((), past)
    if not tables.inertia_kg_m2 > LEAST_INERTIA_KG_M2:
        raise AnalysisError((Caution("inertia_taken_out", numbers={"inertia": tables.inertia_kg_m2}),))
    friction = [term for term in model.terms if term.effect.axis == "speed"]
    forwards, backwards = tabulate(0.0, friction, motion)[0].speed
    if min(forwards.min(), -backwards.max()) < 0.0:
        raise AnalysisError((Caution("model_pushes"),))
    return tables


def make_part(
    interaction: Interaction,
    cycles: EnergyCycles,
    friction: JointFriction,
    settings: ReplaySettings,
    cycle_ends: Int,
    *,
    modelled: bool,
) -> ReplayPart:
    """Return a recording or a part of it for a compensator, with the plant where one is simulated.

    ``modelled``: whether the compensator applies a joint's model. A plant without an operator is driven by the recorded
    torque, and restarts with every cycle; a plant with one by the operator's intention.
    """
    recorded, fitted = recording_of(interaction, interaction.joint_numbers.index(friction.joint)), None
    same_motion = settings.assume == SAME_MOTION
    if same_motion and not modelled:
        return ReplayPart(recorded=recorded, cycle_ends=cycle_ends)
    smooth = filter_velocity(recorded.dq, rate_hz=1.0 / median_step(recorded.t), cutoff_hz=CUTOFF_HZ)
    motion = Motion(t=recorded.t, q=recorded.q, dq=smooth, ddq=np.gradient(smooth, recorded.t))
    if same_motion:
        return ReplayPart(recorded=recorded, cycle_ends=cycle_ends, motion=motion)
    if settings.joint_model is None:
        fitted, model = fitted_joint(friction)
    else:
        model = settings.joint_model.joint(friction.joint)
    tables = tabulate_model(model, motion)
    operator = _operator_impedance(interaction, settings, recorded)
    restart = np.zeros(len(recorded.t), np.bool_)
    if operator is None:
        restart[cycles.start] = restart[cycles.stop] = True
        cycle_ends = restart.astype(np.int64)
    restart |= np.diff(recorded.t, prepend=recorded.t[:1]) > HOLE_S
    unmodelled = mean_over_cycles(recorded.total - model.torque(motion), motion, cycles)
    plant = _make_plant(recorded, motion, tables, operator, unmodelled, restart)
    return ReplayPart(
        recorded=recorded, cycle_ends=cycle_ends, motion=motion, fitted=fitted, operator=operator, plant=plant
    )


def mean_over_cycles(residual: Float, motion: Motion, cycles: EnergyCycles) -> Float:
    """Return the mean of a torque residual while the joint moves: of its cycle, or of all; shape (n,). [N m]

    Offsets and errors of gravity are about constant over a cycle, and would set the simulated joint in motion.
    """
    moving = np.abs(motion.dq) > cycles.standstill_rad_s
    mean = np.full(len(motion.t), float(residual[moving].mean()) if moving.any() else 0.0)
    for start, stop in zip(cycles.start.tolist(), cycles.stop.tolist(), strict=True):
        piece = slice(start, stop)
        if moving[piece].any():
            mean[piece] = residual[piece][moving[piece]].mean()
    return mean


def _operator_impedance(
    interaction: Interaction, settings: ReplaySettings, recorded: loops.RecordedJoint
) -> FittedOperator | None:
    if settings.assume != SAME_OPERATOR:
        return None
    if settings.operator is not None:
        known = map(Coefficient.around, astuple(settings.operator))
        return FittedOperator._make([*known, 0])
    if interaction.choice.drive != "hand":
        raise AnalysisError((Caution("drive_not_fitted"),))
    return fit_operator(recorded)


def _make_plant(
    recorded: loops.RecordedJoint,
    motion: Motion,
    joint: Tables,
    operator: FittedOperator | None,
    unmodelled: Float,
    restart: Bool,
) -> loops.Plant:
    """Return the joint with its operator, driven by the recorded torque or by the operator's intention."""
    inertia, damping, stiffness = (one.value for one in operator[:3]) if operator else (0.0, 0.0, 0.0)
    starts, step_s = np.append(0, np.flatnonzero(restart[1:]) + 1), median_step(recorded.t)
    both = joint._replace(inertia_kg_m2=joint.inertia_kg_m2 + inertia)
    tables = competitors.extrapolate_speed(both, damping_nms_per_rad=damping)
    return loops.Plant(
        tables=tables,
        joint_inertia_kg_m2=joint.inertia_kg_m2,
        inertia_kg_m2=inertia,
        damping_nms_per_rad=damping,
        stiffness_nm_per_rad=stiffness,
        longest_step_s=step_s / steps_per_sample(step_s, tables),
        drive=recorded.torque - unmodelled + inertia * motion.ddq + damping * recorded.dq + stiffness * motion.q,
        unmodelled=unmodelled,
        restart=restart,
        deflections=np.ascontiguousarray(joint.bristles.states_along(motion.q)[starts]),
    )


BAND_HZ = (3.0, 15.0)  # above the intended motion, below the frequencies where the signals are noise
ORDER = 2
BEFORE_S, AFTER_S = 0.1, 0.25  # window around a reversal
DEFINITE_RAD_S = 0.05  # speed above which the direction is certain
LONGEST_REVERSAL_S = 0.12  # a longer reversal is a pause
FEWEST_REVERSALS = 20
WIDEST = 0.3  # relative half-width of the jackknife interval beyond which a number is not determined
# Relative errors of inertia, damping and stiffness by intended motion in the band, on logs without noise: 95 % of
# persons are below. From 47 simulated persons, none of whom is in ``bench_operator_fit``.
INTENTION = (0.06, 0.07, 0.21)
# Samples per period of the band's upper end: also above twice CUTOFF_HZ.
LEAST_PERIODS = 2.75
NORMAL_95 = 1.96


def fit_operator(recorded: loops.RecordedJoint) -> FittedOperator:
    """Fit the operator's impedance at a joint, around its quick reversals."""
    from scipy.signal import butter, sosfiltfilt

    step = median_step(recorded.t)
    if step * LEAST_PERIODS * BAND_HZ[1] > 1.0:
        raise AnalysisError((Caution("rate_hides_operator", numbers={"rate": 1.0 / step}),))
    t = np.arange(recorded.t[0], recorded.t[-1], step)
    dq = np.interp(t, recorded.t, recorded.dq)
    smooth = sosfiltfilt(butter(ORDER, CUTOFF_HZ, fs=1.0 / step, output="sos"), dq)
    definite = np.flatnonzero(np.abs(smooth) > DEFINITE_RAD_S)
    signs = np.sign(smooth[definite])
    turns = np.flatnonzero((np.diff(signs) != 0.0) & (np.diff(definite) * step < LONGEST_REVERSAL_S)) + 1
    before, after = int(BEFORE_S / step), int(AFTER_S / step)
    turns = turns[(definite[turns] >= before) & (definite[turns] + after <= len(t))]
    if len(turns) < FEWEST_REVERSALS:
        numbers = {"found": len(turns), "fewest": FEWEST_REVERSALS}
        raise AnalysisError((Caution("few_quick_reversals", numbers=numbers),))
    rows, direction = definite[turns][:, None] + np.arange(-before, after), signs[turns][:, None]
    torque, position = (np.interp(t, recorded.t, one) for one in (recorded.torque, recorded.q))
    band = butter(ORDER, BAND_HZ, "band", fs=1.0 / step, output="sos")
    signals = (np.gradient(dq, step), dq, position, -torque)
    return _fit_impedance(np.stack([sosfiltfilt(band, one)[rows] * direction for one in signals], axis=2))


def _fit_impedance(windows: Float) -> FittedOperator:
    """Fit acceleration, velocity and position to minus the torque around reversals, (r, w, 4), with a jackknife."""
    count, total = len(windows), windows.sum(axis=0)
    means = [total / count, *((total - one) / (count - 1) for one in windows)]
    value, *others = (np.linalg.lstsq(mean[:, :3], mean[:, 3], rcond=None)[0] for mean in means)
    variance = (count - 1) / count * np.sum((others - np.mean(others, axis=0)) ** 2, axis=0)
    jackknife = NORMAL_95 * np.sqrt(variance)
    half = np.hypot(jackknife, np.array(INTENTION) * value)
    ends = zip(value.tolist(), (value - half).tolist(), (value + half).tolist(), strict=True)
    found = FittedOperator._make([*(Coefficient(value=v, low=low, high=high) for v, low, high in ends), count])
    determined = zip(found._fields, found[:3], jackknife < WIDEST * value, strict=False)
    loose = {name: one for name, one, sure in determined if not sure}
    if loose:
        raise AnalysisError((Caution("operator_not_determined", numbers={"loose": loose}),))
    return found
