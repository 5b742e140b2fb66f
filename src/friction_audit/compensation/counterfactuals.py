"""The motion of a recording as a model of the joint reads it, and what the model leaves of the recorded torque."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.closed_loop import Control, interval, tick, write_down
from friction_audit.compensation.compensators import Coefficients, Compensator, JointModelCompensation
from friction_audit.compensation.compensators.law import JOINT_MODEL
from friction_audit.compensation.feed_forward import tell_friction
from friction_audit.compensation.operator_fit import FittedOperator
from friction_audit.compensation.port import Port, empty_course
from friction_audit.compensation.records import Record, fresh_memory, pack
from friction_audit.compensation.result import Signals
from friction_audit.compensation.tabled_loop import MovedJoint, body_of, impedance, tabled_of
from friction_audit.compensation.tally import COLUMNS, count_energy, fresh_tally, largest_sample
from friction_audit.compiled import compiled
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.joint_model import JointModel
from friction_audit.joint_log import Float, median_step, read_only
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.velocity import filter_velocity

if TYPE_CHECKING:
    from friction_audit.compensation.closed_loop import Drive


CUTOFF_HZ = 20.0
"""Of the velocity, as in the torque regression."""


def recorded_motion(interaction: Interaction, column: int) -> Motion:
    """Return the motion of a joint (0-based), its velocity filtered without phase shift."""
    t, dq = interaction.t, interaction.dq[:, column]
    smooth = filter_velocity(dq, rate_hz=1.0 / median_step(t), cutoff_hz=CUTOFF_HZ)
    return Motion(t=t, q=np.ascontiguousarray(interaction.q[:, column]), dq=smooth, ddq=np.gradient(smooth, t))


def lacking_torque(motion: Motion, cycles: EnergyCycles, column: int, model: JointModel, total: Float) -> Float:
    """Return what a model leaves of the recorded torque, a constant for each cycle, shape (n,). [N m]

    Offsets and errors of gravity are about constant over a stroke, and would set the joint going by themselves.

    Args:
        motion: The recording, n samples.
        cycles: Its cycles.
        column: Joint, 0-based.
        model: Of the joint.
        total: Torque S = F_m + u, shape (n,). [N m]
    """
    left = total - model.torque(motion)
    moving = np.abs(motion.dq) > cycles.standstill_rad_s[column]
    lacking = np.full(len(motion.t), float(left[moving].mean()) if moving.any() else 0.0)
    own = cycles.of_joint(column)
    for start, stop in zip(own.start.tolist(), own.stop.tolist(), strict=True):
        piece = slice(start, stop)
        if moving[piece].any():
            lacking[piece] = left[piece][moving[piece]].mean()
    return lacking


SHORTEST_CYCLE = 4
"""Samples."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Run:
    """What came out.

    Attributes:
        signals: Up to where it diverged, if it did.
        rows: A row per cycle, shape (m, COLUMNS).
        tally: Record of TALLY.
        last: Coefficients applied at the end, after the last whole cycle.
    """

    signals: Signals
    rows: Float
    tally: Record
    last: Coefficients


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Scene:
    """One joint's recording, and what moves otherwise than recorded; None in the recorded motion.

    Attributes:
        port: The recording.
        cuts: Per sample FIND, or where cycles end, shape (n,) or (1,).
        motion: The recording as a model reads it; None where nobody does.
        joint: The joint that moves otherwise, or None.
        operator: The person's impedance, or None.
        lacking: Torque that its model lacks, shape (n,) or empty. [N m]
        restart: Where the joint starts again from the recording, shape (n,) or empty.
    """

    port: Port
    cuts: NDArray[np.int64]
    motion: Motion | None = None
    joint: MovedJoint | None = None
    operator: FittedOperator | None = None
    lacking: Float
    restart: NDArray[np.bool_]


def same_motion(port: Port, cuts: NDArray[np.int64], motion: Motion | None = None) -> Scene:
    """Return the scene of the recorded motion."""
    return Scene(port=port, cuts=cuts, motion=motion, lacking=np.empty(0), restart=np.empty(0, np.bool_))


def other_motion(
    cycles: EnergyCycles,
    column: int,
    port: Port,
    cuts: NDArray[np.int64],
    motion: Motion,
    joint: MovedJoint,
    operator: FittedOperator | None,
) -> Scene:
    """Return the scene of the recorded torque, cycle by cycle, or with an operator that of the recorded intention."""
    restart = np.zeros(len(port.t), np.bool_)
    if operator is None:
        own = cycles.of_joint(column)
        restart[own.start] = restart[own.stop] = True
        cuts = restart.astype(np.int64)
    return Scene(
        port=port,
        cuts=cuts,
        motion=motion,
        joint=joint,
        operator=operator,
        lacking=lacking_torque(motion, cycles, column, joint.model, port.total),
        restart=restart,
    )


def run_scene(scene: Scene, compensator: Compensator | None) -> Run:
    """Run a compensator in a scene."""
    t = scene.port.t
    control = _control(scene, compensator)
    signals = _along(scene, control) if scene.joint is None else _closed(scene, control)
    control.tally["diverged"] = len(signals.t) < len(t)
    last = Coefficients(
        coulomb_nm=float(control.memory["coulomb_nm"]), viscous_nms_per_rad=float(control.memory["viscous_nms_per_rad"])
    )
    return Run(
        signals=signals, rows=control.rows[: int(control.tally["cycles"])].copy(), tally=control.tally, last=last
    )


def _control(scene: Scene, compensator: Compensator | None) -> "Control":
    from friction_audit.compensation.closed_loop import Control
    from friction_audit.compensation.feed_forward import feed_of, no_feed

    t = scene.port.t
    records, memory, tally = pack([compensator], 1.0 / median_step(t)), fresh_memory(1), fresh_tally()
    tally["sample_j"] = largest_sample(scene.port)
    feed = no_feed()
    if isinstance(compensator, JointModelCompensation):
        assert scene.motion is not None
        feed = feed_of(compensator.terms, scene.motion)
    rows = np.empty((len(t) // SHORTEST_CYCLE + 2, COLUMNS))
    return Control(records[0], memory[0], tally[0], feed, scene.cuts, empty_course(len(t)), rows)


def _along(scene: Scene, control: "Control") -> Signals:

    q = read_only(np.empty(0) if scene.motion is None else scene.motion.q)
    samples = run_same_motion(control, scene.port, q)
    return _signals(scene.port.t, scene.port.dq, control, samples)


def _closed(scene: Scene, control: "Control") -> Signals:
    from friction_audit.compensation.closed_loop import run_closed_loop
    from friction_audit.compensation.tabled_loop import run_tabled_loop

    assert scene.joint is not None
    assert scene.motion is not None
    port, joint, drive = scene.port, scene.joint, _drive(scene)
    dq = np.empty(len(port.t))
    if joint.tables is None:
        body = body_of(joint, scene.operator)
        samples = run_closed_loop(control, body, joint.model.inertia_kg_m2, drive, dq)
    else:
        starts = np.append(0, np.flatnonzero(scene.restart[1:]) + 1)
        tabled = tabled_of(joint.tables, scene.operator, scene.motion, starts, median_step(port.t))
        samples = run_tabled_loop(control, tabled, drive, dq)
    return _signals(port.t, dq, control, samples)


def _drive(scene: Scene) -> "Drive":
    """Return what drives the joint: the recorded torque, or what the person intended."""
    from friction_audit.compensation.closed_loop import Drive

    assert scene.motion is not None
    port, motion = scene.port, scene.motion
    push = port.torque - scene.lacking
    if scene.operator is not None:
        m, b, k = impedance(scene.operator)
        push += m * motion.ddq + b * port.dq + k * motion.q
    return Drive(port.t, push, scene.lacking, motion.q, port.dq, scene.restart)


def _signals(t: Float, dq: Float, control: "Control", samples: int) -> Signals:
    interaction, compensation, passivity = (signal[:samples] for signal in control.course)
    return Signals(
        t=t[:samples],
        dq=dq[:samples],
        interaction_nm=interaction,
        compensation_nm=compensation,
        passivity_nm=passivity,
    )


@compiled()
def run_same_motion(control: Control, port: Port, q: Float) -> int:
    """Run a compensator along a recording; return the number of samples, fewer than n once it has diverged.

    The total torque S = F_m + u that drives the inner side in the recording stays. A compensator that gives u' instead
    leaves F' = S - u' to the person, which is what the compensator then measures.

    Args:
        control: The compensator and what it is written into.
        port: The recording.
        q: Position, shape (n,), or empty where the compensator has no use for it. [rad]
    """
    settings, memory, tally, feed, cuts, course, rows = control
    t, dq, torque, logged = port
    before = needed_before = 0.0
    for i in range(len(t)):
        dt = interval(t, i)
        total = torque[i] + logged[i] if len(logged) > 0 else torque[i]
        needed = total - memory.u_nm
        write_down(course, i, needed, memory)
        if i > 0:
            moved = 0.5 * (dq[i - 1] + dq[i]) * dt
            friction, exchange = 0.5 * (before + total) * moved, 0.5 * (needed_before + needed) * moved
            count_energy(tally, settings, friction, exchange, moved, dt)
        if settings.kind == JOINT_MODEL:
            tell_friction(memory, feed, q[i], dq[i], i)
        if not tick(settings, memory, tally, i, dt, dq[i], needed, cuts[i] if len(cuts) > 1 else cuts[0], rows):
            return i
        before, needed_before = total, needed
    return len(t)
