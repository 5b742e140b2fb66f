"""Interaction, EnergyCycles, FrictionHistory -> Replay."""

from collections.abc import Iterable
from dataclasses import replace
from math import isnan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_audit.compensation.cautions import cautions_of, log_cautions, seems_compensated, square_in_cycles
from friction_audit.compensation.closed_loop import CYCLE, SUMS, add_torque
from friction_audit.compensation.compensators import (
    Coefficients,
    Compensator,
    DisturbanceObserver,
    EnergyCompensator,
    JointModelCompensation,
    LugreCompensation,
    TorqueRegulation,
    guard_of,
)
from friction_audit.compensation.compensators.model_based import PUBLISHED, fit_sigmoid
from friction_audit.compensation.controller import FIND, step
from friction_audit.compensation.counterfactual import Run, make_scene, recording_of
from friction_audit.compensation.feed_forward import NO_MODEL, friction_terms, refusal
from friction_audit.compensation.hand_cycles import hand_cuts
from friction_audit.compensation.measures import find_recovery, measure, measure_passivity, model_error
from friction_audit.compensation.records import FIELDS, TRACE, fresh_memory, pack
from friction_audit.compensation.result import JointReplay, Replay, ReplayHistory, Signals, missing_estimate
from friction_audit.compensation.settings import (
    FEED_BACK,
    MODEL,
    PANDAS,
    Competitor,
    Limits,
    ReplaySettings,
    limits_of,
)
from friction_audit.effects.joint_model import JointModel
from friction_audit.friction.history import FrictionHistory, JointFriction
from friction_audit.joint_log import Float, Recording, read_only
from friction_audit.parallel import per_joint
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction

LONGEST_STEP = 3.5  # a step of the clock of this many median steps is a gap, at any rate


def replay(
    log: Recording,
    interaction: Interaction,
    parts: Iterable[Interaction],
    cycles: EnergyCycles,
    friction: FrictionHistory,
    settings: ReplaySettings,
    *,
    joints: tuple[int, ...] | None = None,
    hand_speed: Float | None = None,
) -> Replay:
    """Run a compensator on the joints of a recording, as a controller would have.

    Args:
        log: Its clock, and the robot whose limits hold unless the settings give others.
        interaction: Motion and torque at the friction port; without samples where these are not to be kept.
        parts: The same, in parts that follow each other.
        cycles: Its energy cycles, whose thresholds are the compensator's.
        friction: What the log says about friction.
        settings: Assumption, compensator, limits; where they say ``needs_whole``, there is one part.
        joints: Numbers of the joints to replay, or None for all.
        hand_speed: Speed of the end effector as a controller sees it, from what is measured at each sample, shape (n,);
            it then ends the cycles of all joints, and there is one part. None where each joint ends its own. [m/s]
    """
    cuts = np.full(1, FIND)
    if hand_speed is not None:
        energy = settings.compensator
        energy = energy if isinstance(energy, EnergyCompensator) else EnergyCompensator()
        t, hand, dq = map(read_only, (interaction.t, hand_speed, interaction.dq))
        thresholds = (float(cycles.initiation[0]), float(cycles.termination[0]))
        cuts = hand_cuts(t, hand, dq, thresholds, energy.dead_band_rad_s, energy.minimum_path_rad)
    chosen = [one for one in friction.joints if joints is None or one.joint in joints]
    runs = [_JointRun(log, interaction, cycles, one, settings) for one in chosen]
    for part in parts:

        def advance(place: int, part: Interaction = part) -> None:
            runs[place].take(part, cuts)

        per_joint(advance, len(runs))
    replays = tuple(run.result() for run in runs)
    suspicions = [
        one
        for run in runs
        for one in seems_compensated(interaction, cycles, run.friction, log.source.robot, run.square)
    ]
    found = [one for joint in replays for one in cautions_of(joint)]
    assumed = settings.counterfactual
    if interaction.choice.drive != "hand":
        assumed = replace(assumed, assumes=assumed.assumes.replace("the person", "the arm's drive"))
    return Replay(
        counterfactual=assumed,
        joints=replays,
        warnings=(*log_cautions(interaction), *suspicions, *found),
    )


class _JointRun:
    """One joint on its way through the parts of a recording."""

    def __init__(
        self,
        log: Recording,
        interaction: Interaction,
        cycles: EnergyCycles,
        friction: JointFriction,
        settings: ReplaySettings,
    ) -> None:
        step_s, robot = 1.0 / log.rate_hz, log.source.robot
        self.friction, self.square, self._kept = friction, 0.0, len(interaction.t) > 0
        self._cycles, self._settings, self._column = cycles, settings, interaction.joint_numbers.index(friction.joint)
        recorded = recording_of(interaction, self._column)
        limits = settings.limits(limits_of(robot, friction.joint))
        model = None if settings.joint_model is None else settings.joint_model.joint(friction.joint)
        # Without a compensator the same motion takes all of the total torque from outside.
        nothing = np.broadcast_to(0.0, len(recorded.t))
        self._joint = JointReplay(
            joint=friction.joint,
            name=friction.name,
            compensator=settings.compensator,
            limits=limits,
            model=model,
            without=Signals(recorded.t, recorded.dq, recorded.total, nothing, nothing, nothing),
        )
        wanted = tune(settings.competitor, friction, robot, model) if settings.competitor else settings.compensator
        if isinstance(wanted, str):
            self._joint = replace(self._joint, reason=wanted)
            return
        chosen = _in_force(wanted, cycles, self._column, limits, step_s)
        self._joint = replace(self._joint, compensator=chosen)
        peak_power_w = float(cycles.peak_power_w[self._column])
        self._run, self._idle = Run(chosen, step_s, peak_power_w), Run(None, step_s, peak_power_w)
        self._recorded, self._total = np.zeros(2, SUMS)
        self._changes: dict[str, Any] = {}  # of the joint, where it was replayed

    def take(self, part: Interaction, cuts: NDArray[np.int64]) -> None:
        """Take the samples that follow."""
        self.square += square_in_cycles(part, self._cycles, self._column)
        if self._joint.reason:
            return
        modelled = isinstance(self._joint.compensator, JointModelCompensation)
        scene = make_scene(part, self._cycles, self.friction, self._settings, cuts, modelled=modelled)
        if isinstance(scene, str):
            self._joint = replace(self._joint, reason=scene)
            return
        recorded, found = scene.recorded, self._run.take(scene)
        add_torque(self._recorded, recorded.t, recorded.dq, recorded.torque)
        add_torque(self._total, recorded.t, recorded.dq, recorded.total)
        self._changes = {"replayed": found if self._kept else self._joint.without}
        if scene.joint is not None:
            without = self._idle.take(scene)
            self._changes |= {
                "without": without,
                "fitted": scene.joint.fitted,
                "operator": scene.operator,
                "simulated": True,
                "model_error": model_error(recorded, without),
            }

    def result(self) -> JointReplay:
        """Return the joint, after the last part."""
        joint = self._joint
        if joint.reason:
            return joint
        run, rows = self._run, self._run.rows
        columns = {name: rows[name] for name in CYCLE.names or ()} | {"acted": rows["acted"] == 1}
        history = ReplayHistory(start_s=np.append(0.0, rows["stop_s"])[: len(rows)], **columns)
        reason = missing_estimate(history, self.friction, joint.compensator) if isnan(run.diverged_s) else ""
        if run.felt["samples"] <= 1:
            reason = "the compensated loop diverges within a sample; lower its gain"
        if reason:
            return replace(joint, reason=reason)
        without = self._idle.felt if "without" in self._changes else self._total
        return replace(
            joint,
            **self._changes,
            history=history,
            last=run.last,
            numbers=measure(self._recorded, without, run, history),
            passivity=measure_passivity(history, run.tally),
            recovery=find_recovery(history),
        )


def tune(  # noqa: PLR0911 - one per compensator
    competitor: Competitor, friction: JointFriction, robot: str, model: JointModel | None
) -> Compensator | str:
    """Return a compensator for one joint, or why it cannot be tuned."""
    if competitor.name == MODEL:
        return _modelled(model)
    if competitor.name == "sigmoid" and robot in PANDAS and 1 <= friction.joint <= len(PUBLISHED):
        return PUBLISHED[friction.joint - 1]
    if competitor.name in FEED_BACK:
        return _feed_back(competitor, friction)
    coulomb, viscous = friction.coulomb.value, friction.viscous.value
    if friction.reason or not (coulomb >= 0.0 and viscous >= 0.0 and coulomb + viscous > 0.0):
        return friction.reason or "the log's friction is negative, and nothing can be tuned to it"
    if competitor.name == "sigmoid":
        return fit_sigmoid(coulomb, viscous)
    if competitor.name == "lugre":
        return LugreCompensation(coulomb_nm=coulomb, breakaway_nm=coulomb, viscous_nms_per_rad=viscous)
    forced = Coefficients(coulomb_nm=coulomb, viscous_nms_per_rad=viscous)
    return EnergyCompensator(forced=forced, forced_from_cycle=1, forced_until_acted=False, passivity=False)


def _modelled(model: JointModel | None) -> Compensator | str:
    if model is None:
        return NO_MODEL
    terms = friction_terms(model)
    if not terms:
        return "its model has no term of friction, and a compensator nothing to apply"
    return refusal(terms) or JointModelCompensation(terms=terms)


def _feed_back(competitor: Competitor, friction: JointFriction) -> Compensator | str:
    found, inertia = friction.regression, competitor.motor_inertia_kg_m2
    if inertia is None and found is not None and found.inertia.low > 0.0:
        inertia = found.inertia.value
    if inertia is None:
        return friction.reason or "its inertia is not determined by the log; give --motor-inertia"
    if competitor.name == "disturbance_observer":
        return DisturbanceObserver(inertia_kg_m2=inertia, observer_gain_per_s=competitor.observer_gain_per_s)
    desired = competitor.desired_inertia_kg_m2
    return TorqueRegulation(inertia_kg_m2=inertia, desired_inertia_kg_m2=0.5 * inertia if desired is None else desired)


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
) -> np.ndarray[tuple[int], np.dtype[np.void]]:
    """Run the compensator of one joint in open loop, on n samples, two at least.

    ``cuts`` is True where a cycle ends, or None to find the cycles from the velocity. Returns records of
    ``records.TRACE``, shape (n,); a torque at sample i acts from t[i] on.
    """
    rate = (len(t) - 1) / (t[-1] - t[0])
    settings, memory = pack([compensator], float(rate))[0], fresh_memory(1)
    cut = np.full(len(t), FIND) if cuts is None else cuts.astype(np.int64)
    seen, words = np.empty((len(t), FIELDS), np.int64), memory.view(np.int64)
    for i, dt in enumerate(np.diff(t, prepend=t[0])):
        step(settings, memory[0], dq[i], interaction_nm[i], dt, cut[i])
        seen[i] = words[:FIELDS]
    return seen.view(TRACE)[:, 0]
