"""Interaction, EnergyCycles, FrictionHistory -> Replay."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.cautions import cautions_of, log_cautions, seems_compensated
from friction_audit.compensation.compensators import Compensator, EnergyCompensator, JointModelCompensation, guard_of
from friction_audit.compensation.counterfactuals import (
    Run,
    Scene,
    other_motion,
    recorded_motion,
    run_scene,
    same_motion,
)
from friction_audit.compensation.friction_step import find_recovery
from friction_audit.compensation.hand_cycles import hand_cuts
from friction_audit.compensation.limits import (
    COUNTERFACTUALS,
    SAME_MOTION,
    SAME_OPERATOR,
    Counterfactual,
    Limits,
    limits_of,
    of_a_model,
)
from friction_audit.compensation.measures import measure, measure_passivity, model_error, read_history
from friction_audit.compensation.operator_fit import FittedOperator, fit_operator, given_operator
from friction_audit.compensation.port import Port, port_of
from friction_audit.compensation.records import TRACE, fresh_memory, pack
from friction_audit.compensation.result import JointReplay, Replay, ReplayHistory, Signals, missing_estimate
from friction_audit.compensation.rivals import tune
from friction_audit.compensation.settings import ReplaySettings
from friction_audit.compensation.tabled_loop import MovedJoint, fitted_joint, modelled_joint
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.joint_model import JointModel
from friction_audit.friction.history import FrictionHistory, JointFriction
from friction_audit.joint_log import Float, median_step
from friction_audit.parallel import per_joint
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction

FEWEST_SAMPLES = 2
DIVERGED_AT_ONCE = "the compensated loop diverges within a sample; lower its gain"
LONGEST_STEP = 3.5
"""A step of the clock of this many median steps is a hole, however low the rate."""


def replay(
    interaction: Interaction,
    cycles: EnergyCycles,
    friction: FrictionHistory,
    settings: ReplaySettings,
    *,
    robot: str = "unknown",
    joints: tuple[int, ...] | None = None,
    hand_speed: Float | None = None,
) -> Replay:
    """Run a compensator on the joints of a recording, as a controller would have.

    Args:
        interaction: Motion and torque at the friction port.
        cycles: Its energy cycles, whose thresholds are the compensator's.
        friction: What the log says about friction.
        settings: Assumption, compensator, limits.
        robot: Whose limits hold unless the settings give others, as ``Source.robot`` names it.
        joints: Numbers of the joints to replay, or None for all.
        hand_speed: Speed of the end effector as a controller sees it, from what is measured at each sample, shape (n,);
            it then ends the cycles of all joints. None where each joint ends its own. [m/s]
    """
    cuts = _cuts(interaction, cycles, settings.compensator, hand_speed)
    work = partial(_replay_joint, interaction, cycles, friction, settings, robot, cuts)
    numbers = interaction.joint_numbers
    columns = [column for column, number in enumerate(numbers) if joints is None or number in joints]
    replays = tuple(per_joint(lambda place: work(columns[place]), len(columns)))
    found = [one for joint in replays for one in cautions_of(joint)]
    several = [friction.joints[column] for column in columns]
    suspicions = [one for joint in several for one in seems_compensated(interaction, cycles, joint, robot)]
    return Replay(
        counterfactual=_counterfactual(settings),
        joints=replays,
        warnings=(*log_cautions(interaction), *suspicions, *found),
    )


def _counterfactual(settings: ReplaySettings) -> Counterfactual:
    one = next(one for one in COUNTERFACTUALS if one.name == settings.assume)
    return one if settings.joint_model is None else of_a_model(one)


def _cuts(
    interaction: Interaction, cycles: EnergyCycles, compensator: Compensator, hand_speed: Float | None
) -> NDArray[np.int64]:
    """Return where the hand ends the cycles; one entry, FIND, where each joint ends its own."""
    from friction_audit.compensation.kernels import FIND

    if hand_speed is None:
        return np.full(1, FIND)
    energy = compensator if isinstance(compensator, EnergyCompensator) else EnergyCompensator()
    return hand_cuts(
        interaction.t,
        hand_speed,
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
    found, port = friction.joints[column], port_of(interaction, column)
    limits = settings.limits(limits_of(robot, found.joint))
    model = None if settings.joint_model is None else settings.joint_model.joint(found.joint)
    refused = partial(_not_replayed, port, found, limits, model)
    wanted = settings.compensator if settings.rival is None else tune(settings.rival, found, robot, model)
    if isinstance(wanted, str):
        return refused(settings.compensator, wanted)
    chosen = _in_force(wanted, cycles, column, limits, median_step(port.t))
    scene = _scene(interaction, cycles, found, settings, port, cuts, isinstance(chosen, JointModelCompensation))
    if isinstance(scene, str):
        return refused(chosen, scene)
    run = run_scene(scene, chosen)
    history = read_history(run.rows, port.t)
    reason = _reason(run, history, found, chosen)
    if reason:
        return refused(chosen, reason)
    without = _without(port) if scene.joint is None else run_scene(scene, None).signals
    return JointReplay(
        joint=found.joint,
        name=found.name,
        compensator=chosen,
        limits=limits,
        model=model,
        fitted=None if scene.joint is None else scene.joint.fitted,
        operator=scene.operator,
        simulated=scene.joint is not None,
        model_error=model_error(scene, port, without),
        without=without,
        replayed=run.signals,
        history=history,
        last=run.last,
        numbers=measure(port, without, run.signals, history, run.tally),
        passivity=measure_passivity(history, run.tally, run.signals.t),
        recovery=find_recovery(history),
    )


def _reason(run: Run, history: ReplayHistory, friction: JointFriction, compensator: Compensator) -> str:
    """Say why the run means nothing; empty if it does, or if it diverged before there was any estimate."""
    samples = len(run.signals.t)
    if samples < FEWEST_SAMPLES:
        return DIVERGED_AT_ONCE
    return "" if run.tally["diverged"] else missing_estimate(history, friction, compensator)


def _scene(
    interaction: Interaction,
    cycles: EnergyCycles,
    friction: JointFriction,
    settings: ReplaySettings,
    port: Port,
    cuts: NDArray[np.int64],
    modelled: bool,
) -> Scene | str:
    """Return what the compensator meets, which may go by the joint's model, or why nobody knows."""
    column = interaction.joint_numbers.index(friction.joint)
    if settings.assume == SAME_MOTION.name:
        return same_motion(port, cuts, recorded_motion(interaction, column) if modelled else None)
    motion = recorded_motion(interaction, column)
    joint = _moved(friction, settings, motion)
    if isinstance(joint, str):
        return joint
    operator = _operator(settings, port, motion.q)
    if isinstance(operator, str):
        return operator
    return other_motion(cycles, column, port, cuts, motion, joint, operator)


def _moved(friction: JointFriction, settings: ReplaySettings, motion: Motion) -> MovedJoint | str:
    """Return the joint that moves otherwise than recorded, of the file if there is one, or why none can."""
    if settings.joint_model is None:
        return fitted_joint(friction)
    return modelled_joint(settings.joint_model.joint(friction.joint), motion)


def _operator(settings: ReplaySettings, port: Port, q: Float) -> FittedOperator | str | None:
    """Return the person's impedance where one is assumed, or why nobody knows it."""
    if settings.assume != SAME_OPERATOR.name:
        return None
    return fit_operator(port, q) if settings.operator is None else given_operator(settings.operator)


def _not_replayed(
    port: Port,
    friction: JointFriction,
    limits: Limits,
    model: JointModel | None,
    compensator: Compensator,
    reason: str,
) -> JointReplay:
    return JointReplay(
        joint=friction.joint,
        name=friction.name,
        compensator=compensator,
        limits=limits,
        model=model,
        without=_without(port),
        reason=reason,
    )


def _without(port: Port) -> Signals:
    """Return the recorded joint as it would have been without a compensator, moving the same."""
    nothing = np.broadcast_to(0.0, len(port.t))
    return Signals(t=port.t, dq=port.dq, interaction_nm=port.total, compensation_nm=nothing, passivity_nm=nothing)


def _in_force(
    compensator: Compensator, cycles: EnergyCycles, column: int, limits: Limits, step_s: float
) -> Compensator:
    """Return the compensator with the limits, and the thresholds where it finds cycles itself."""
    guard = guard_of(compensator)
    kept: dict[str, Any] = {
        "max_torque_nm": min(guard.max_torque_nm, limits.torque_nm),
        "max_torque_rate_nm_s": min(guard.max_torque_rate_nm_s, limits.rate_nm_s),
    }
    if isinstance(compensator, EnergyCompensator):
        if cycles.speed_unit == "rad/s" and not compensator.zero_crossings:
            kept["initiation_rad_s"] = float(cycles.initiation[column])
            kept["termination_rad_s"] = float(cycles.termination[column])
        kept["maximum_gap_s"] = max(compensator.maximum_gap_s, LONGEST_STEP * step_s)
        return replace(compensator, **kept)
    changed: Any = compensator
    return replace(changed, guard=replace(guard, **kept)) if hasattr(compensator, "guard") else compensator


def run(
    compensator: Compensator | None,
    t: Float,
    dq: Float,
    interaction_nm: Float,
    *,
    cuts: NDArray[np.bool_] | None = None,
) -> dict[str, Float]:
    """Run the compensator of one joint in open loop.

    Args:
        compensator: What runs.
        t: Time, shape (n,), n at least 2. [s]
        dq: Velocity as measured. [rad/s]
        interaction_nm: Interaction torque F_m. [N m]
        cuts: True where a cycle ends, as told from outside; None to find the cycles from ``dq``.

    Returns:
        By the names in ``records.TRACE``, arrays of shape (n,); a torque at sample i acts from t[i] on.
    """
    from friction_audit.compensation.kernels import FIND, run_records

    rate = (len(t) - 1) / (t[-1] - t[0])
    settings, memory = pack([compensator], float(rate)), fresh_memory(1)
    cut = np.full(len(t), FIND, np.int64) if cuts is None else cuts.astype(np.int64)
    out = np.empty((len(t), len(TRACE)))
    run_records(settings[0], memory[0], t, dq, interaction_nm, cut, out)
    return dict(zip(TRACE, out.T, strict=True))
