"""Interaction, EnergyCycles, FrictionHistory -> Replay."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.cycles.energy_cycles import EnergyCycles
from friction_audit.friction.history import FrictionHistory, JointFriction
from friction_audit.interaction.interaction import Interaction
from friction_audit.joint_log import Float, median_step
from friction_audit.per_joint import per_joint
from friction_audit.replay.cautions import cautions_of, gravity_caution, seems_compensated
from friction_audit.replay.compensators import Compensator, EnergyCompensator, Guard
from friction_audit.replay.counterfactual import COUNTERFACTUALS
from friction_audit.replay.friction_step import find_recovery
from friction_audit.replay.hand_cycles import hand_cuts
from friction_audit.replay.limits import Limits, limits_of
from friction_audit.replay.measures import measure, measure_passivity, read_history
from friction_audit.replay.reasons import missing_estimate
from friction_audit.replay.records import fresh_memory, pack
from friction_audit.replay.result import JointReplay, Replay, Signals
from friction_audit.replay.settings import ReplaySettings
from friction_audit.replay.tally import COLUMNS, fresh_tally

LONGEST_STEP = 3.5
"""A step of the clock of this many median steps is a hole, however low the rate."""

SHORTEST_CYCLE = 4
"""Samples."""


def replay(
    interaction: Interaction,
    cycles: EnergyCycles,
    friction: FrictionHistory,
    settings: ReplaySettings,
    *,
    robot: str = "unknown",
) -> Replay:
    """Run a compensator on the joints of a recording, as a controller would have.

    Args:
        interaction: Motion and torque at the friction port.
        cycles: Its energy cycles: their thresholds are the compensator's, and where the hand defines them, it ends the
            compensators' cycles too.
        friction: What the log says about friction.
        settings: Assumption, compensator, limits.
        robot: Whose limits hold unless the settings give others, as ``Source.robot`` names it.
    """
    cuts = _hand_cuts(interaction, cycles, settings.compensator)
    work = partial(_replay_joint, interaction, cycles, friction, settings, robot, cuts)
    joints = tuple(per_joint(work, len(interaction.joint_numbers)))
    found = [one for joint in joints for one in cautions_of(joint)]
    suspicions = [one for joint in friction.joints for one in seems_compensated(interaction, joint, robot)]
    return Replay(
        counterfactual=next(one for one in COUNTERFACTUALS if one.name == settings.assume),
        joints=joints,
        warnings=(*gravity_caution(interaction), *suspicions, *found),
    )


def _hand_cuts(interaction: Interaction, cycles: EnergyCycles, compensator: Compensator) -> NDArray[np.int64]:
    """Return where the hand ends the cycles; one entry, FIND, where each joint ends its own."""
    from friction_audit.replay.kernels import FIND

    if cycles.speed_unit == "rad/s":
        return np.full(1, FIND)
    assert interaction.hand_speed is not None, "cycles from the hand need its speed"
    energy = compensator if isinstance(compensator, EnergyCompensator) else EnergyCompensator()
    return hand_cuts(
        interaction.t,
        interaction.hand_speed,
        interaction.dq,
        thresholds=(float(cycles.initiation[0]), float(cycles.termination[0])),
        rest_rad_s=energy.dead_band_rad_s,
        minimum_path_rad=energy.minimum_path_rad,
    )


def _replay_joint(
    interaction: Interaction,
    cycles: EnergyCycles,
    friction: FrictionHistory,
    settings: ReplaySettings,
    robot: str,
    cuts: NDArray[np.int64],
    column: int,
) -> JointReplay:
    number = interaction.joint_numbers[column]
    limits = settings.limits(limits_of(robot, number))
    compensator = _in_force(settings.compensator, cycles, column, limits, median_step(interaction.t))
    return _same_motion(interaction, friction.joints[column], compensator, limits, cuts, column)


def _in_force(
    compensator: Compensator, cycles: EnergyCycles, column: int, limits: Limits, step_s: float
) -> Compensator:
    """Return the compensator with the limits, and the thresholds where it finds cycles itself."""
    kept: dict[str, Any] = {"max_torque_nm": limits.torque_nm, "max_torque_rate_nm_s": limits.rate_nm_s}
    if isinstance(compensator, EnergyCompensator):
        if cycles.speed_unit == "rad/s" and not compensator.zero_crossings:
            kept["initiation_rad_s"] = float(cycles.initiation[column])
            kept["termination_rad_s"] = float(cycles.termination[column])
        kept["maximum_gap_s"] = max(compensator.maximum_gap_s, LONGEST_STEP * step_s)
        return replace(compensator, **kept)
    guard = getattr(compensator, "guard", None)
    changed: Any = compensator
    return replace(changed, guard=replace(guard, **kept)) if isinstance(guard, Guard) else compensator


def _same_motion(
    interaction: Interaction,
    friction: JointFriction,
    compensator: Compensator,
    limits: Limits,
    cuts: NDArray[np.int64],
    column: int,
) -> JointReplay:
    from friction_audit.replay.same_motion import Course, Port, run_same_motion

    t, n = interaction.t, len(interaction.t)
    port = Port(t, *(np.ascontiguousarray(signal) for signal in _columns(interaction, column)))
    course = Course(np.empty(n), np.empty(n), np.empty(n))
    records, memory, tally = pack([compensator], 1.0 / median_step(t)), fresh_memory(1), fresh_tally()
    rows = np.empty((n // SHORTEST_CYCLE + 2, COLUMNS))
    samples = run_same_motion(records[0], memory[0], tally[0], port, cuts, course, rows)
    total = port.torque + port.logged if len(port.logged) else port.torque
    nothing = np.broadcast_to(0.0, n)
    without = Signals(t=t, dq=port.dq, interaction_nm=total, compensation_nm=nothing, passivity_nm=nothing)
    replayed = Signals(
        t=t[:samples],
        dq=port.dq[:samples],
        interaction_nm=course.interaction[:samples],
        compensation_nm=course.compensation[:samples],
        passivity_nm=course.passivity[:samples],
    )
    history = read_history(rows[: int(tally["cycles"][0])].copy(), t)
    reason = missing_estimate(history, friction, compensator)
    return JointReplay(
        joint=friction.joint,
        name=friction.name,
        compensator=compensator,
        limits=limits,
        without=without,
        replayed=replayed,
        history=history,
        numbers=None if reason else measure(without, replayed, history, tally[0], recorded_nm=port.torque),
        passivity=None if reason else measure_passivity(history, tally[0], replayed.t),
        recovery=None if reason else find_recovery(history),
        reason=reason,
    )


def _columns(interaction: Interaction, column: int) -> tuple[Float, Float, Float]:
    logged = interaction.compensation
    return (
        interaction.dq[:, column],
        interaction.torque[:, column],
        np.empty(0) if logged is None else logged[:, column],
    )
