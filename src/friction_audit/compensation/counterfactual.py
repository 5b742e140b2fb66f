"""A compensator in the recorded motion, or with a joint that moves otherwise: what moves it, and its run.

The impedance of the person who moves it is fitted to the quick reversals of the recording.
"""

from dataclasses import astuple, dataclass
from math import isfinite, isnan, nan

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation import SAME_MOTION, SAME_OPERATOR, closed_loop
from friction_audit.compensation.competitors import Compensator, JointModelCompensation, feed_of, refuse, straighten
from friction_audit.compensation.controller import HOLE_S
from friction_audit.compensation.records import fresh_memory, pack
from friction_audit.compensation.result import FittedOperator, Signals
from friction_audit.compensation.settings import ReplaySettings
from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.torque_tables import Tables, steps_per_sample, tabulate
from friction_audit.effects.joint_model import JointModel, simple_model
from friction_audit.errors import AnalysisError
from friction_audit.friction.history import Coefficient, JointFriction, TorqueRegression
from friction_audit.joint_log import Float, median_step, read_only
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Caution, Interaction
from friction_audit.preprocessing.velocity import filter_velocity

CUTOFF_HZ = 20.0  # of the velocity, as in the torque regression
SHORTEST_CYCLE = 4  # samples
LEAST_INERTIA_KG_M2 = 1e-3  # no motor with its gear has less; what seems to was recorded without its inertia


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Scene:
    """One joint's recording or a part of it, n samples; and what moves otherwise than recorded, in all of it."""

    recorded: closed_loop.Recorded
    cuts: NDArray[np.int64]  # per sample FIND, or where cycles end, shape (n,) or (1,)
    motion: Motion | None = None  # the recording as a model reads it; None where no model does
    fitted: TorqueRegression | None = None  # the fit to the log that the joint is which moves otherwise, or None
    operator: FittedOperator | None = None  # the person's impedance, or None where the torque stays as recorded
    loop: closed_loop.Loop | None = None  # the joint that moves otherwise in the person's hand


class Run:
    """A compensator, or none, on its way through the scenes of a recording."""

    def __init__(self, compensator: Compensator | None, step_s: float, peak_power_w: float) -> None:
        """Take what runs, the step of the clock, and the largest power of the total torque in the recording."""
        self._compensator, self._settings = compensator, pack([compensator], 1.0 / step_s)[0]
        self._feed = feed_of((), Motion(t=np.arange(2.0), q=np.zeros(2), dq=np.zeros(2), ddq=np.zeros(2)))
        self.memory, self.rows = fresh_memory(1)[0], [np.zeros(0, closed_loop.CYCLE)]
        self.tally, self.felt = np.zeros(1, closed_loop.TALLY)[0], np.zeros(1, closed_loop.SUMS)[0]
        self.tally["activation_s"] = self.tally["diverged_s"] = nan
        payback_s = compensator.payback_s if compensator is not None and compensator.passivity else 0.0
        self.tally["tolerance_j"] = peak_power_w * (closed_loop.SAMPLES * step_s + payback_s)

    def take(self, scene: Scene) -> Signals:
        """Run on through a scene; return what happens in it, up to where it diverges."""
        recorded, motion, samples = scene.recorded, scene.motion, 0
        dq, torques = recorded.dq, np.zeros((4, len(recorded.t)))
        rows = np.empty(len(recorded.t) // SHORTEST_CYCLE + 2, closed_loop.CYCLE)
        if motion is not None and isinstance(self._compensator, JointModelCompensation):
            self._feed = feed_of(self._compensator.terms, motion)
        control = closed_loop.Control(self._settings, self.memory, self.tally, self._feed, scene.cuts, torques, rows)
        if isnan(self.tally["diverged_s"]):
            if scene.loop is None:
                samples = closed_loop.run_same_motion(
                    control, recorded, read_only(np.empty(0) if motion is None else motion.q)
                )
            else:
                dq = np.empty(len(recorded.t))
                samples = closed_loop.run_closed_loop(control, recorded, scene.loop, dq)
            if samples < len(recorded.t):
                self.tally["diverged_s"] = recorded.t[samples]
        self.rows.append(rows[: int(self.tally["cycles"])].copy())
        self.tally["cycles"] = 0
        signals = Signals(recorded.t[:samples], *map(read_only, (dq[:samples], *torques[:, :samples])))
        closed_loop.add_torque(self.felt, signals.t, signals.dq, signals.interaction_nm)
        return signals


def recording_of(interaction: Interaction, column: int) -> closed_loop.Recorded:
    """Return the recording of a joint (0-based), column after column in memory."""
    logged = np.empty(0) if interaction.compensation is None else interaction.compensation[:, column]
    return closed_loop.Recorded(
        *map(read_only, (interaction.t, interaction.dq[:, column], interaction.torque[:, column], logged))
    )


def recorded_motion(interaction: Interaction, column: int) -> Motion:
    """Return the motion of a joint (0-based), its velocity filtered without phase shift."""
    t, dq = interaction.t, interaction.dq[:, column]
    smooth = filter_velocity(dq, rate_hz=1.0 / median_step(t), cutoff_hz=CUTOFF_HZ)
    return Motion(t=t, q=np.ascontiguousarray(interaction.q[:, column]), dq=smooth, ddq=np.gradient(smooth, t))


def fitted_joint(friction: JointFriction, motion: Motion) -> tuple[TorqueRegression, JointModel, Tables]:
    """Return inertia and friction as the torque regression of the log found them, as a model and its tables."""
    found = friction.regression
    if friction.reason:
        raise AnalysisError(friction.reason)
    if found is None:
        raise AnalysisError((Caution("too_few_to_fit"),))
    if not (found.inertia.low > 0.0 and found.inertia.value > LEAST_INERTIA_KG_M2):
        numbers = {"inertia": found.inertia, "case": "some" if isfinite(found.inertia.value) else "none"}
        raise AnalysisError((Caution("inertia_not_determined", numbers=numbers),))
    pushing = [name for name, one in (("Coulomb", found.coulomb), ("viscous", found.viscous)) if not one.high > 0.0]
    if pushing:
        raise AnalysisError((Caution("fit_pushes", numbers={"names": " and ".join(pushing)}),))
    model = simple_model(
        inertia_kg_m2=found.inertia.value,
        coulomb_nm=max(0.0, found.coulomb.value),
        viscous_nms_per_rad=max(0.0, found.viscous.value),
    )
    return found, model, tables_of(model, motion)


def tables_of(model: JointModel, motion: Motion) -> Tables:
    """Tabulate a model; Coulomb and viscous friction need no more of the recording than its limits."""
    if {term.name for term in model.terms} <= {"coulomb", "viscous"}:
        few = np.unique([0, 1, np.argmin(motion.q), np.argmax(motion.q), np.argmax(np.abs(motion.dq))])
        motion = Motion(t=motion.t[few], q=motion.q[few], dq=motion.dq[few], ddq=motion.ddq[few])
    tables, past = tabulate(model.inertia_kg_m2, model.terms, motion)
    refuse((), past)
    return tables


def tables_of_file(model: JointModel | None, motion: Motion) -> Tables:
    """Return the tables of a joint of a model file."""
    if model is None:
        raise AnalysisError((Caution("not_in_model_file"),))
    refuse(model.terms)
    tables = tables_of(model, motion)
    if not tables.inertia_kg_m2 > LEAST_INERTIA_KG_M2:
        raise AnalysisError((Caution("inertia_taken_out", numbers={"inertia": tables.inertia_kg_m2}),))
    friction = [term for term in model.terms if term.effect.axis == "speed"]
    forwards, backwards = tabulate(0.0, friction, motion)[0].speed
    if min(forwards.min(), -backwards.max()) < 0.0:
        raise AnalysisError((Caution("model_pushes"),))
    return tables


def make_scene(
    interaction: Interaction,
    cycles: EnergyCycles,
    friction: JointFriction,
    settings: ReplaySettings,
    cuts: NDArray[np.int64],
    *,
    modelled: bool,
) -> Scene:
    """Return what the compensator meets in a recording or a part of it.

    ``modelled``: whether the compensator goes by the joint's model. The torque is the recorded one, cycle by cycle, or
    with an operator that of the recorded intention. What the model lacks of it is a constant for each cycle: offsets
    and errors of gravity are about constant over a stroke, and would set the joint going by themselves.
    """
    column = interaction.joint_numbers.index(friction.joint)
    recorded, fitted = recording_of(interaction, column), None
    if settings.assume == SAME_MOTION:
        return Scene(recorded=recorded, cuts=cuts, motion=recorded_motion(interaction, column) if modelled else None)
    motion = recorded_motion(interaction, column)
    model = None if settings.joint_model is None else settings.joint_model.joint(friction.joint)
    if settings.joint_model is None:
        fitted, model, tables = fitted_joint(friction, motion)
    else:
        tables = tables_of_file(model, motion)
    operator = _operator(interaction, settings, recorded, motion)
    restart = np.zeros(len(recorded.t), np.bool_)
    if operator is None:
        restart[cycles.start] = restart[cycles.stop] = True
        cuts = restart.astype(np.int64)
    restart |= np.diff(recorded.t, prepend=recorded.t[:1]) > HOLE_S
    assert model is not None
    left = recorded.total - model.torque(motion)
    moving = np.abs(motion.dq) > cycles.standstill_rad_s
    lacking = np.full(len(motion.t), float(left[moving].mean()) if moving.any() else 0.0)
    for start, stop in zip(cycles.start.tolist(), cycles.stop.tolist(), strict=True):
        piece = slice(start, stop)
        if moving[piece].any():
            lacking[piece] = left[piece][moving[piece]].mean()
    loop = _loop(recorded, motion, tables, operator, lacking, restart)
    return Scene(recorded=recorded, cuts=cuts, motion=motion, fitted=fitted, operator=operator, loop=loop)


def _operator(
    interaction: Interaction, settings: ReplaySettings, recorded: closed_loop.Recorded, motion: Motion
) -> FittedOperator | None:
    if settings.assume != SAME_OPERATOR:
        return None
    if settings.operator is not None:
        known = [Coefficient(value=one, low=nan, high=nan) for one in astuple(settings.operator)]
        return FittedOperator._make([*known, 0])
    if interaction.choice.drive != "hand":
        raise AnalysisError((Caution("drive_not_fitted"),))
    return fit_operator(recorded, motion.q)


def _loop(
    recorded: closed_loop.Recorded,
    motion: Motion,
    own: Tables,
    held: FittedOperator | None,
    lacking: Float,
    restart: NDArray[np.bool_],
) -> closed_loop.Loop:
    """Return the joint in the hand of its operator, driven by the recorded torque or the intention."""
    mass, damping, stiffness = (one.value for one in held[:3]) if held else (0.0, 0.0, 0.0)
    starts, step_s = np.append(0, np.flatnonzero(restart[1:]) + 1), median_step(recorded.t)
    tables = straighten(own._replace(inertia_kg_m2=own.inertia_kg_m2 + mass), damping_nms_per_rad=damping)
    return closed_loop.Loop(
        tables=tables,
        own_kg_m2=own.inertia_kg_m2,
        inertia_kg_m2=mass,
        damping_nms_per_rad=damping,
        stiffness_nm_per_rad=stiffness,
        longest_s=step_s / steps_per_sample(step_s, tables),
        push=recorded.torque - lacking + mass * motion.ddq + damping * recorded.dq + stiffness * motion.q,
        lacking=lacking,
        q=motion.q,
        restart=restart,
        bent=np.ascontiguousarray(own.bristles.states_along(motion.q)[starts]),
    )


BAND_HZ = (3.0, 15.0)  # above what a person intends, below where sensors show noise only
ORDER = 2
BEFORE_S, AFTER_S = 0.1, 0.25  # window around a reversal
DEFINITE_RAD_S = 0.05  # speed at which the direction is certain
LONGEST_TURN_S = 0.12  # a reversal that takes longer is a pause
FEWEST_REVERSALS = 20
WIDEST = 0.3  # relative half-width of the interval from the reversals alone, beyond which a number is not determined
# Error of inertia, damping and stiffness over their values that 95 % of persons stay below whose log has no noise, by
# what they intend above the lower end of the band: 47 simulated persons, none of whom is in ``bench_operator_fit``.
INTENTION = (0.06, 0.07, 0.21)
# The rate must be above the band by this, and above twice the 20 Hz that reversals are found below.
LEAST_PERIODS = 2.75
NORMAL_95 = 1.96


def fit_operator(recorded: closed_loop.Recorded, q: Float) -> FittedOperator:
    """Fit the person's impedance at one joint, of position q."""
    from scipy.signal import butter, sosfiltfilt

    step = median_step(recorded.t)
    if step * LEAST_PERIODS * BAND_HZ[1] > 1.0:
        raise AnalysisError((Caution("rate_hides_operator", numbers={"rate": 1.0 / step}),))
    t = np.arange(recorded.t[0], recorded.t[-1], step)
    dq = np.interp(t, recorded.t, recorded.dq)
    turns, direction = _reversals(dq, step)
    before, after = int(BEFORE_S / step), int(AFTER_S / step)
    inside = (turns >= before) & (turns + after <= len(t))
    turns, direction = turns[inside], direction[inside]
    if len(turns) < FEWEST_REVERSALS:
        numbers = {"found": len(turns), "fewest": FEWEST_REVERSALS}
        raise AnalysisError((Caution("few_quick_reversals", numbers=numbers),))
    rows = turns[:, None] + np.arange(-before, after)
    torque, position = (np.interp(t, recorded.t, one) for one in (recorded.torque, q))
    band = butter(ORDER, BAND_HZ, "band", fs=1.0 / step, output="sos")
    signals = (np.gradient(dq, step), dq, position, -torque)
    windows = np.stack([sosfiltfilt(band, signal)[rows] * direction[:, None] for signal in signals], axis=2)
    return _solve(windows)


def _reversals(dq: Float, step: float) -> tuple[NDArray[np.int64], Float]:
    """Return the samples at which motion is under way again after a quick reversal, and its direction then."""
    from scipy.signal import butter, sosfiltfilt

    smooth = sosfiltfilt(butter(ORDER, 20.0, fs=1.0 / step, output="sos"), dq)
    definite = np.flatnonzero(np.abs(smooth) > DEFINITE_RAD_S)
    direction = np.sign(smooth[definite])
    turned = np.flatnonzero(np.diff(direction) != 0.0)
    quick = np.diff(definite)[turned] * step < LONGEST_TURN_S
    return definite[turned + 1][quick], direction[turned + 1][quick]


def _solve(windows: Float) -> FittedOperator:
    """Solve acceleration, velocity, position and minus torque around reversals, shape (r, w, 4), with a jackknife."""
    count, total = len(windows), windows.sum(axis=0)
    means = [total / count, *((total - one) / (count - 1) for one in windows)]
    value, *others = (np.linalg.lstsq(mean[:, :3], mean[:, 3], rcond=None)[0] for mean in means)
    spread = (count - 1) / count * np.sum((others - np.mean(others, axis=0)) ** 2, axis=0)
    unsure = NORMAL_95 * np.sqrt(spread)
    half = np.hypot(unsure, np.array(INTENTION) * value)
    ends = zip(value.tolist(), (value - half).tolist(), (value + half).tolist(), strict=True)
    found = FittedOperator._make([*(Coefficient(value=v, low=low, high=high) for v, low, high in ends), count])
    known = zip(found._fields, found[:3], unsure < WIDEST * value, strict=False)
    loose = {name: one for name, one, sure in known if not sure}
    if loose:
        raise AnalysisError((Caution("operator_not_determined", numbers={"loose": loose}),))
    return found
