"""A compensator in the recorded motion, or with a joint that moves otherwise: what moves it, and its run."""

from dataclasses import dataclass
from math import isnan, nan

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.closed_loop import (
    CYCLE,
    SAMPLES,
    SUMS,
    TALLY,
    Control,
    Drive,
    Joint,
    Recorded,
    add_torque,
    run_closed_loop,
    run_same_motion,
)
from friction_audit.compensation.compensators import Coefficients, Compensator, JointModelCompensation, guard_of
from friction_audit.compensation.feed_forward import NO_MODEL, feed_of, refusal, straighten
from friction_audit.compensation.operator_fit import (
    LEAST_INERTIA_KG_M2,
    FittedOperator,
    fit_joint,
    fit_operator,
    given_operator,
)
from friction_audit.compensation.records import fresh_memory, pack
from friction_audit.compensation.result import Signals
from friction_audit.compensation.settings import SAME_MOTION, SAME_OPERATOR, ReplaySettings
from friction_audit.compiled import Record
from friction_audit.dynamics.motion import Motion, Term
from friction_audit.dynamics.torque_tables import Tables, steps_per_sample, tabulate
from friction_audit.effects.joint_model import JointModel, simple_model
from friction_audit.friction.history import JointFriction, TorqueRegression
from friction_audit.joint_log import Float, median_step, read_only
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.velocity import filter_velocity

CUTOFF_HZ = 20.0  # of the velocity, as in the torque regression
SHORTEST_CYCLE = 4  # samples
CONSTANT = ("offset", "torque_bias")  # terms of a constant torque


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class MovedJoint:
    """A joint that can be simulated in a compensator's loop."""

    model: JointModel  # its model
    fitted: TorqueRegression | None = None  # the fit to the log that the model is; None where it is of a file
    tables: Tables  # what its terms take along the recording


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Scene:
    """One joint's recording or a part of it, n samples; and what moves otherwise than recorded, in all of it."""

    recorded: Recorded
    cuts: NDArray[np.int64]  # per sample FIND, or where cycles end, shape (n,) or (1,)
    motion: Motion | None = None  # the recording as a model reads it; None where no model does
    joint: MovedJoint | None = None  # the joint that moves otherwise, or None
    operator: FittedOperator | None = None  # the person's impedance, or None where the torque stays as recorded
    loop: tuple[Joint, Drive] | None = None  # that joint in the person's hand, and what drives it; or None


class Run:
    """A compensator, or none, on its way through the scenes of a recording."""

    def __init__(self, compensator: Compensator | None, step_s: float, peak_power_w: float) -> None:
        """Take what runs, the step of the clock, and the largest power of the total torque in the recording."""
        guard = guard_of(compensator)
        self._compensator, self._settings = compensator, pack([compensator], 1.0 / step_s)[0]
        self._feed = feed_of((), Motion(t=np.arange(2.0), q=np.zeros(2), dq=np.zeros(2), ddq=np.zeros(2)))
        self._memory, self._rows = fresh_memory(1)[0], [np.zeros(0, CYCLE)]
        self.tally, self.felt = np.zeros(1, TALLY)[0], np.zeros(1, SUMS)[0]
        self.tally["activation_s"] = nan
        self.tally["tolerance_j"] = peak_power_w * (SAMPLES * step_s + (guard.payback_s if guard.passivity else 0.0))
        self.diverged_s = nan

    def take(self, scene: Scene) -> Signals:
        """Run on through a scene; return what happens in it, up to where it diverges."""
        recorded, motion, samples = scene.recorded, scene.motion, 0
        dq, torques = recorded.dq, np.zeros((4, len(recorded.t)))
        rows = np.zeros(len(recorded.t) // SHORTEST_CYCLE + 2, CYCLE)
        if motion is not None and isinstance(self._compensator, JointModelCompensation):
            self._feed = feed_of(self._compensator.terms, motion)
        control = Control(self._settings, self._memory, self.tally, self._feed, scene.cuts, torques, rows)
        if isnan(self.diverged_s):
            if scene.loop is None:
                samples = run_same_motion(control, recorded, read_only(np.empty(0) if motion is None else motion.q))
            else:
                dq = np.empty(len(recorded.t))
                samples = run_closed_loop(control, *scene.loop, dq)
            if samples < len(recorded.t):
                self.diverged_s = float(recorded.t[samples])
        self._rows.append(rows[: int(self.tally["cycles"])].copy())
        self.tally["cycles"] = 0
        signals = Signals(recorded.t[:samples], *map(read_only, (dq[:samples], *torques[:, :samples])))
        add_torque(self.felt, signals.t, signals.dq, signals.interaction_nm)
        return signals

    @property
    def rows(self) -> Record:
        """Records of CYCLE of the cycles so far, shape (m,)."""
        return np.concatenate(self._rows)

    @property
    def last(self) -> Coefficients:
        """Coefficients applied now, after the last whole cycle."""
        coulomb, viscous = self._memory["coulomb_nm"], self._memory["viscous_nms_per_rad"]
        return Coefficients(coulomb_nm=float(coulomb), viscous_nms_per_rad=float(viscous))


def recording_of(interaction: Interaction, column: int) -> Recorded:
    """Return the recording of a joint (0-based), column after column in memory."""
    logged = np.empty(0) if interaction.compensation is None else interaction.compensation[:, column]
    return Recorded(*map(read_only, (interaction.t, interaction.dq[:, column], interaction.torque[:, column], logged)))


def recorded_motion(interaction: Interaction, column: int) -> Motion:
    """Return the motion of a joint (0-based), its velocity filtered without phase shift."""
    t, dq = interaction.t, interaction.dq[:, column]
    smooth = filter_velocity(dq, rate_hz=1.0 / median_step(t), cutoff_hz=CUTOFF_HZ)
    return Motion(t=t, q=np.ascontiguousarray(interaction.q[:, column]), dq=smooth, ddq=np.gradient(smooth, t))


def fitted_joint(friction: JointFriction, motion: Motion) -> MovedJoint | str:
    """Return the joint that the log shows, or why it cannot be simulated."""
    fitted = fit_joint(friction)
    if isinstance(fitted, str):
        return fitted
    model = simple_model(
        inertia_kg_m2=fitted.inertia.value,
        coulomb_nm=max(0.0, fitted.coulomb.value),
        viscous_nms_per_rad=max(0.0, fitted.viscous.value),
    )
    return MovedJoint(model=model, fitted=fitted, tables=_tables(model, motion)[0])


def _tables(model: JointModel, motion: Motion) -> tuple[Tables, tuple[Term, ...]]:
    """Tabulate a model; Coulomb and viscous friction need no more of the recording than its limits."""
    if {term.name for term in model.terms} <= {"coulomb", "viscous"}:
        few = np.unique([0, 1, np.argmin(motion.q), np.argmax(motion.q), np.argmax(np.abs(motion.dq))])
        motion = Motion(t=motion.t[few], q=motion.q[few], dq=motion.dq[few], ddq=motion.ddq[few])
    return tabulate(model.inertia_kg_m2, model.terms, motion)


def modelled_joint(model: JointModel | None, motion: Motion) -> MovedJoint | str:
    """Return the joint of a model file, or why it cannot be simulated."""
    if model is None:
        return NO_MODEL
    if unable := refusal(model.terms):
        return unable
    tables, past = _tables(model, motion)
    if past:
        return refusal((), past)
    inertia_kg_m2 = tables.inertia_kg_m2
    if not inertia_kg_m2 > LEAST_INERTIA_KG_M2:
        return (
            f"its model has an inertia of {inertia_kg_m2:.3g} kg m^2, of a torque from which the inertia was taken "
            "out; without it the motion cannot be predicted; put that of the joint into the file, or use "
            "--assume same-motion"
        )
    friction = [term for term in model.terms if term.effect.speed_only and term.name not in CONSTANT]
    forwards, backwards = tabulate(0.0, friction, motion)[0].speed
    if min(forwards.min(), -backwards.max()) < 0.0:
        return "its model's friction pushes at some speed, and a joint that pushes cannot be simulated"
    return MovedJoint(model=model, tables=tables)


def make_scene(
    interaction: Interaction,
    cycles: EnergyCycles,
    friction: JointFriction,
    settings: ReplaySettings,
    cuts: NDArray[np.int64],
    *,
    modelled: bool,
) -> Scene | str:
    """Return what the compensator meets in a recording or a part of it, or why it is not known.

    ``modelled``: whether the compensator goes by the joint's model. The torque is the recorded one, cycle by cycle, or
    with an operator that of the recorded intention. What the model lacks of it is a constant for each cycle: offsets
    and errors of gravity are about constant over a stroke, and would set the joint going by themselves.
    """
    column = interaction.joint_numbers.index(friction.joint)
    recorded, file = recording_of(interaction, column), settings.joint_model
    if settings.assume == SAME_MOTION.name:
        motion = recorded_motion(interaction, column) if modelled else None
        return Scene(recorded=recorded, cuts=cuts, motion=motion)
    motion = recorded_motion(interaction, column)
    joint = fitted_joint(friction, motion) if file is None else modelled_joint(file.joint(friction.joint), motion)
    if isinstance(joint, str):
        return joint
    operator = _operator(interaction, settings, recorded, motion)
    if isinstance(operator, str):
        return operator
    own, restart = cycles.of_joint(column), np.zeros(len(recorded.t), np.bool_)
    if operator is None:
        restart[own.start] = restart[own.stop] = True
        cuts = restart.astype(np.int64)
    left = recorded.total - joint.model.torque(motion)
    moving = np.abs(motion.dq) > cycles.standstill_rad_s[column]
    lacking = np.full(len(motion.t), float(left[moving].mean()) if moving.any() else 0.0)
    for start, stop in zip(own.start.tolist(), own.stop.tolist(), strict=True):
        piece = slice(start, stop)
        if moving[piece].any():
            lacking[piece] = left[piece][moving[piece]].mean()
    loop = _loop(recorded, motion, joint, operator, lacking, restart)
    return Scene(recorded=recorded, cuts=cuts, motion=motion, joint=joint, operator=operator, loop=loop)


def _operator(
    interaction: Interaction, settings: ReplaySettings, recorded: Recorded, motion: Motion
) -> FittedOperator | str | None:
    """Return the impedance of the person, None where the recorded torque stays, or why it is not known."""
    if settings.assume != SAME_OPERATOR.name:
        return None
    if settings.operator is not None:
        return given_operator(settings.operator)
    if interaction.choice.drive != "hand":
        return (
            "the arm moved by itself, and the impedance of its drive is not fitted; give it by --operator, or use "
            "--assume same-motion or same-torque"
        )
    return fit_operator(recorded, motion.q)


def _loop(
    recorded: Recorded,
    motion: Motion,
    moved: MovedJoint,
    held: FittedOperator | None,
    lacking: Float,
    restart: NDArray[np.bool_],
) -> tuple[Joint, Drive]:
    """Return the joint held by its operator, driven by the recorded torque or by what the person intended.

    Its model lacks some torque, and it starts again from the recording at some samples, shape (n,) each.
    """
    mass, damping, stiffness = 0.0, 0.0, 0.0
    push = recorded.torque - lacking
    if held is not None:
        mass, damping, stiffness = held.inertia.value, held.damping.value, held.stiffness.value
        push += mass * motion.ddq + damping * recorded.dq + stiffness * motion.q
    drive = Drive(recorded.t, push, lacking, motion.q, recorded.dq, restart)
    starts = np.append(0, np.flatnonzero(restart[1:]) + 1)
    step_s = median_step(recorded.t)
    tables = moved.tables._replace(inertia_kg_m2=moved.tables.inertia_kg_m2 + mass)
    tables = straighten(tables, damping_nms_per_rad=damping)
    return Joint(
        tables=tables,
        own_kg_m2=tables.inertia_kg_m2 - mass,
        longest_s=step_s / steps_per_sample(step_s, tables),
        bent=np.ascontiguousarray(moved.tables.bristles.states_along(motion.q)[starts]),
        inertia_kg_m2=mass,
        damping_nms_per_rad=damping,
        stiffness_nm_per_rad=stiffness,
    ), drive
