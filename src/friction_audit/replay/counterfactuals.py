"""One joint under one assumption: what is run, on what, and what comes out."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.cycles.energy_cycles import EnergyCycles
from friction_audit.friction.history import JointFriction
from friction_audit.interaction.interaction import Interaction
from friction_audit.joint_log import Float, median_step
from friction_audit.replay.compensators import Coefficients, Compensator
from friction_audit.replay.fitted_joint import FittedJoint, acceleration, lacking_torque
from friction_audit.replay.operator_fit import FittedOperator
from friction_audit.replay.port import Port, empty_course
from friction_audit.replay.records import Record, fresh_memory, pack
from friction_audit.replay.result import Signals
from friction_audit.replay.tally import COLUMNS, fresh_tally, largest_sample

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
        q: Position, shape (n,). [rad]
        cuts: Per sample FIND, or where cycles end, shape (n,) or (1,).
        joint: The fitted joint, or None.
        operator: The person's impedance, or None.
        lacking: Torque that the fitted joint lacks, shape (n,) or empty. [N m]
        restart: Where the joint starts again from the recording, shape (n,) or empty.
    """

    port: Port
    q: Float
    cuts: NDArray[np.int64]
    joint: FittedJoint | None = None
    operator: FittedOperator | None = None
    lacking: Float
    restart: NDArray[np.bool_]


def same_motion(port: Port, q: Float, cuts: NDArray[np.int64]) -> Scene:
    """Return the scene of the recorded motion."""
    return Scene(port=port, q=q, cuts=cuts, lacking=np.empty(0), restart=np.empty(0, np.bool_))


def other_motion(
    interaction: Interaction,
    cycles: EnergyCycles,
    friction: JointFriction,
    port: Port,
    cuts: NDArray[np.int64],
    joint: FittedJoint,
    operator: FittedOperator | None,
) -> Scene:
    """Return the scene of the recorded torque, cycle by cycle, or with an operator that of the recorded intention."""
    column = interaction.joint_numbers.index(friction.joint)
    restart = np.zeros(len(port.t), np.bool_)
    if operator is None:
        own = cycles.of_joint(column)
        restart[own.start] = restart[own.stop] = True
        cuts = restart.astype(np.int64)
    return Scene(
        port=port,
        q=np.ascontiguousarray(interaction.q[:, column]),
        cuts=cuts,
        joint=joint,
        operator=operator,
        lacking=lacking_torque(interaction, cycles, column, joint, port.total),
        restart=restart,
    )


def run_scene(scene: Scene, compensator: Compensator | None) -> Run:
    """Run a compensator in a scene."""
    t = scene.port.t
    records, memory, tally = pack([compensator], 1.0 / median_step(t)), fresh_memory(1), fresh_tally()
    tally["sample_j"] = largest_sample(scene.port)
    rows = np.empty((len(t) // SHORTEST_CYCLE + 2, COLUMNS))
    signals = (_along if scene.joint is None else _closed)(scene, records[0], memory[0], tally[0], rows)
    tally["diverged"] = len(signals.t) < len(t)
    last = Coefficients(
        coulomb_nm=float(memory["coulomb_nm"][0]), viscous_nms_per_rad=float(memory["viscous_nms_per_rad"][0])
    )
    return Run(signals=signals, rows=rows[: int(tally["cycles"][0])].copy(), tally=tally[0], last=last)


def _along(scene: Scene, settings: Record, memory: Record, tally: Record, rows: Float) -> Signals:
    from friction_audit.replay.same_motion import run_same_motion

    course = empty_course(len(scene.port.t))
    samples = run_same_motion(settings, memory, tally, scene.port, scene.cuts, course, rows)
    return _signals(scene.port.t, scene.port.dq, course, samples)


def _closed(scene: Scene, settings: Record, memory: Record, tally: Record, rows: Float) -> Signals:
    from friction_audit.model.body import make_body
    from friction_audit.replay.closed_loop import Drive, run_closed_loop

    assert scene.joint is not None
    port, hand = scene.port, scene.operator
    m, b, k = (0.0, 0.0, 0.0) if hand is None else (hand.inertia.value, hand.damping.value, hand.stiffness.value)
    push = port.torque - scene.lacking
    if hand is not None:
        push += m * acceleration(port.t, port.dq) + b * port.dq + k * scene.q
    body = make_body(scene.joint.model, mass_kg_m2=m, damping_nms_per_rad=b, stiffness_nm_per_rad=k)
    drive = Drive(port.t, push, scene.lacking, scene.q, port.dq, scene.restart)
    course, dq = empty_course(len(port.t)), np.empty(len(port.t))
    inertia = scene.joint.inertia.value
    samples = run_closed_loop(settings, memory, tally, body, inertia, drive, scene.cuts, course, dq, rows)
    return _signals(port.t, dq, course, samples)


def _signals(t: Float, dq: Float, course: tuple[Float, Float, Float], samples: int) -> Signals:
    interaction, compensation, passivity = (signal[:samples] for signal in course)
    return Signals(
        t=t[:samples],
        dq=dq[:samples],
        interaction_nm=interaction,
        compensation_nm=compensation,
        passivity_nm=passivity,
    )
