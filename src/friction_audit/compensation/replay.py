"""Interaction, EnergyCycles, FrictionHistory -> Replay."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields, replace
from math import isfinite, isnan
from typing import Any

import numpy as np

from friction_audit.compensation import FEEDBACK, MODEL, competitors, result
from friction_audit.compensation.competitors import Compensator
from friction_audit.compensation.controller import DETECT, detect_hand_cycles
from friction_audit.compensation.law import Coefficients, EnergyCompensator
from friction_audit.compensation.plant import CompensatorRun, make_part, recording_of
from friction_audit.compensation.replay_loops import TORQUE_SUMS, add_torque
from friction_audit.compensation.result import JointReplay, Replay, Signals
from friction_audit.compensation.settings import Competitor, Limits, ReplaySettings, limits_of
from friction_audit.effects.joint_model import JointModel
from friction_audit.errors import AnalysisError
from friction_audit.friction.history import FrictionHistory, JointFriction
from friction_audit.joint_log import Float, Int, Recording, read_only
from friction_audit.parallel import per_joint
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Caution, Interaction, Reason, reason_of
from friction_audit.preprocessing.segmentation import LONGEST_STEP
from friction_audit.presets import FRANKA

LEAST_OF_PUBLISHED = 0.25  # share of the published Coulomb friction that joints of a Panda have at least
LEAST_OF_TORQUE = 0.03  # mean friction torque over rms torque, at least; a geared joint moved fast by hand has 0.3
LEAST_OF_BEGINNING = 0.1  # friction in the later half of a log over that at its beginning; warming up keeps half of it
UNCOMPENSATED = 2  # cycles before the compensator of the paper has an estimate
FEWEST_CYCLES = 4


def replay(
    log: Recording,
    interaction: Interaction,
    parts: Iterable[Interaction],
    cycles: Sequence[EnergyCycles],
    friction: FrictionHistory,
    settings: ReplaySettings,
    *,
    joints: tuple[int, ...] | None = None,
    hand_speed: Float | None = None,
) -> Replay:
    """Run a compensator on the joints of a recording, or on some by their numbers, as a controller would have.

    ``parts`` holds the samples of the interaction, one part after the other; there is one part where the settings say
    ``needs_whole``. ``interaction`` has samples only where the result is to keep its signals. The compensator uses the
    thresholds of the cycles. With a hand speed, that of the end effector at each sample without smoothing, shape (n,)
    [m/s], the hand ends the cycles of all joints, and there is one part.
    """
    cycle_ends = np.full(1, DETECT)
    if hand_speed is not None:
        energy = settings.compensator
        energy = energy if isinstance(energy, EnergyCompensator) else EnergyCompensator()
        t, hand, dq = map(read_only, (interaction.t, hand_speed, interaction.dq))
        thresholds = cycles[0].initiation, cycles[0].termination
        cycle_ends = detect_hand_cycles(t, hand, dq, thresholds, energy.dead_band_rad_s, energy.minimum_path_rad)
    chosen = [one for one in friction.joints if joints is None or one.joint in joints]
    runs = [_JointRun(log, interaction, cycles, one, settings) for one in chosen]
    for part in parts:
        per_joint(lambda place: runs[place].add(part, cycle_ends), len(runs))  # noqa: B023 - it runs at once
    replays = tuple(run.result() for run in runs)
    warnings = [] if interaction.choice.drive == "hand" else [Caution(code="arm_moves_itself")]
    if interaction.choice.gravity == "in-torque":
        warnings.append(Caution(code="gravity_in_replay"))
    for run in runs:
        found = seems_compensated(interaction, run.cycles, run.friction, log.source.robot, run.square)
        if found:
            warnings.append(Caution("seems_compensated", run.friction.joint, found))
    warnings += [caution for joint in replays for caution in _cautions(joint)]
    moved = {"person": interaction.choice.drive, "joint": "file" if settings.joint_model else "fitted"}
    counterfactual = Caution(settings.assume, numbers=moved)
    return Replay(counterfactual=counterfactual, joints=replays, warnings=tuple(warnings))


class _JointRun:
    """The replay of one joint, through the parts of a recording."""

    def __init__(
        self,
        log: Recording,
        interaction: Interaction,
        cycles: Sequence[EnergyCycles],
        friction: JointFriction,
        settings: ReplaySettings,
    ) -> None:
        step_s, robot = 1.0 / log.rate_hz, log.source.robot
        self.friction, self._kept = friction, len(interaction.t) > 0
        self.square = 0.0  # sum of the squared torque over the samples of all cycles [N^2 m^2]
        self._settings, self._column = settings, interaction.joint_numbers.index(friction.joint)
        self.cycles = cycles[self._column]
        recorded = recording_of(interaction, self._column)
        limits, zeros = settings.limits(limits_of(robot, friction.joint)), np.broadcast_to(0.0, len(recorded.t))
        self._joint = JointReplay(
            joint=friction.joint,
            name=friction.name,
            compensator=settings.compensator,
            limits=limits,
            # Without a compensator the operator gives the total torque of the recorded motion.
            without=Signals(recorded.t, recorded.dq, recorded.total, zeros, zeros, zeros),
        )
        try:
            model = None if settings.joint_model is None else settings.joint_model.joint(friction.joint)
            self._joint = replace(self._joint, model=model)
            wanted = tune(settings.competitor, friction, robot, model) if settings.competitor else settings.compensator
        except AnalysisError as reason:
            self._joint = replace(self._joint, reason=reason_of(reason))
            return
        chosen = _with_limits(wanted, self.cycles, limits, step_s)
        self._joint = self._replayed = replace(self._joint, compensator=chosen)
        self._run, self._idle = (CompensatorRun(one, step_s, self.cycles.peak_power_w) for one in (chosen, None))
        self._recorded_sums, self._total_sums = np.zeros(2, TORQUE_SUMS)

    def add(self, interaction: Interaction, cycle_ends: Int) -> None:
        """Run through the next part of the recording."""
        torque = interaction.torque[:, self._column]
        borders = np.clip(np.stack([self.cycles.start, self.cycles.stop], axis=1) - interaction.first, 0, len(torque))
        for start, stop in borders[borders[:, 0] < borders[:, 1]].tolist():
            self.square += float(torque[start:stop] @ torque[start:stop])
        if self._joint.reason:
            return
        modelled = isinstance(self._joint.compensator, competitors.JointModelCompensation)
        try:
            part = make_part(interaction, self.cycles, self.friction, self._settings, cycle_ends, modelled=modelled)
            replayed = self._run.run(part)
        except AnalysisError as reason:
            self._joint = replace(self._joint, reason=reason_of(reason))
            return
        recorded = part.recorded
        for sums, torque in ((self._recorded_sums, recorded.torque), (self._total_sums, recorded.total)):
            add_torque(sums, recorded.t, recorded.dq, torque)
        self._replayed = replace(self._joint, replayed=replayed if self._kept else self._joint.without)
        if part.plant is not None:
            without = self._idle.run(part)
            self._replayed = replace(
                self._replayed,
                without=without,
                fitted=part.fitted,
                operator=part.operator,
                simulated=True,
                model_error=result.model_error(recorded, without),
            )

    def result(self) -> JointReplay:
        """Return the result, after the last part."""
        if self._joint.reason:
            return self._joint
        run, history = self._run, np.concatenate(self._run.cycles).view(np.recarray)
        history.start_s[:1], history.start_s[1:] = 0.0, history.stop_s[:-1]
        reason: Reason = ()
        if run.torque_sums["samples"] <= 1:
            reason = (Caution("diverges_at_once"),)
        elif isnan(run.statistics["diverged_s"]):
            reason = result.missing_estimate(history, self.friction, self._joint.compensator)
        if reason:
            return replace(self._joint, reason=reason)
        without = self._idle.torque_sums if self._replayed.simulated else self._total_sums
        numbers, passivity = result.summarise(self._recorded_sums, without, run.torque_sums, run.statistics, history)
        return replace(
            self._replayed,
            history=history,
            last=Coefficients(**{one.name: float(run.state[one.name]) for one in fields(Coefficients)}),
            numbers=numbers,
            passivity=passivity,
            recovery=result.find_recovery(history),
        )


def tune(competitor: Competitor, friction: JointFriction, robot: str, model: JointModel | None) -> Compensator:
    """Return a competitor for one joint, with its numbers from the log, the published ones, or the model."""
    if competitor.name in FEEDBACK:
        return _tune_feedback(competitor, friction)
    if competitor.name == MODEL and model is not None:
        terms = tuple(one for one in model.terms if one.effect.friction or one.name in competitors.FRICTION_TERMS)
        if not terms:
            raise AnalysisError((Caution("nothing_to_apply"),))
        competitors.check_runnable(terms)
        return competitors.JointModelCompensation(terms=terms)
    if competitor.name == "sigmoid" and robot in FRANKA and friction.joint <= len(competitors.PANDA_SIGMOIDS):
        return competitors.PANDA_SIGMOIDS[friction.joint - 1]
    coulomb, viscous = friction.coulomb.value, friction.viscous.value
    if friction.reason or not (coulomb >= 0.0 and viscous >= 0.0 and coulomb + viscous > 0.0):
        raise AnalysisError(friction.reason or (Caution("log_pushes"),))
    if competitor.name == "sigmoid":
        return competitors.fit_sigmoid(coulomb, viscous)
    if competitor.name == "lugre":
        return competitors.LugreCompensation(coulomb_nm=coulomb, breakaway_nm=coulomb, viscous_nms_per_rad=viscous)
    forced = Coefficients(coulomb_nm=coulomb, viscous_nms_per_rad=viscous)
    return EnergyCompensator(forced=forced, forced_from_cycle=1, forced_until_acted=False, passivity=False)


def _tune_feedback(competitor: Competitor, friction: JointFriction) -> Compensator:
    found, inertia = friction.regression, competitor.motor_inertia_kg_m2
    if inertia is None and found is not None and found.inertia.low > 0.0:
        inertia = found.inertia.value
    if inertia is None:
        raise AnalysisError(friction.reason or (Caution("no_motor_inertia"),))
    if competitor.name == "disturbance_observer":
        return competitors.DisturbanceObserver(
            inertia_kg_m2=inertia, observer_gain_per_s=competitor.observer_gain_per_s
        )
    desired = 0.5 * inertia if competitor.desired_inertia_kg_m2 is None else competitor.desired_inertia_kg_m2
    return competitors.TorqueRegulation(inertia_kg_m2=inertia, desired_inertia_kg_m2=desired)


def _with_limits(compensator: Compensator, cycles: EnergyCycles, limits: Limits, step_s: float) -> Compensator:
    """Return the compensator within the limits, and with the cycle thresholds of the log where it detects cycles."""
    kept: dict[str, Any] = {
        "max_torque_nm": min(compensator.max_torque_nm, limits.torque_nm),
        "max_torque_rate_nm_s": min(compensator.max_torque_rate_nm_s, limits.rate_nm_s),
    }
    if isinstance(compensator, EnergyCompensator):
        if cycles.speed_unit == "rad/s" and not compensator.zero_crossings:
            kept |= {"initiation_rad_s": cycles.initiation, "termination_rad_s": cycles.termination}
        kept["maximum_gap_s"] = max(compensator.maximum_gap_s, LONGEST_STEP * step_s)
    return replace(compensator, **kept)


def _cautions(joint: JointReplay) -> Iterator[Caution]:
    numbers, passivity, limits = joint.numbers, joint.passivity, joint.limits
    if numbers is None or passivity is None:
        yield Caution("not_replayed", joint.joint, {"reason": joint.reason})
        return
    if not isnan(numbers.diverged_s):
        yield Caution("diverged", joint.joint, {"at_s": numbers.diverged_s})
    if passivity.hidden:
        energies = {"reserve": passivity.reserve_j, "hidden": -passivity.lowest_since_activation_j}
        yield Caution("over_compensation_hidden", joint.joint, energies)
    if numbers.limited_fraction > 0:
        of = ((limits.torque_nm, "N m"), (limits.rate_nm_s, "N m/s"))
        held = [f"{limit:g} {unit}" for limit, unit in of if isfinite(limit)]
        found = {"limits": held, "percent": 100 * numbers.limited_fraction}
        yield Caution("torque_limited", joint.joint, found)


def seems_compensated(
    interaction: Interaction, cycles: EnergyCycles, friction: JointFriction, robot: str, square: float
) -> dict[str, object]:
    """Return evidence of an active compensator that is not logged; ``square`` sums the squared torque of all cycles."""
    if interaction.compensation is not None or interaction.choice.drive != "hand" or friction.reason:
        return {}
    negative = [name for name, one in (("Coulomb", friction.coulomb), ("viscous", friction.viscous)) if one.high < 0]
    if negative:
        return {"case": "negative", "names": " and ".join(negative)}
    if interaction.choice.sign_turned and interaction.choice.source == "interaction":
        return {"case": "sign"}
    if found := _vanishing_friction(interaction, cycles, square):
        return found
    if robot in FRANKA and friction.joint <= len(competitors.PANDA_SIGMOIDS):
        usual = min(competitors.PANDA_SIGMOIDS[friction.joint - 1].plateaus_nm)
        if friction.coulomb.high < LEAST_OF_PUBLISHED * usual:
            return {"case": "far_below", "coulomb": friction.coulomb.value, "usual": usual}
    return {}


def _vanishing_friction(interaction: Interaction, cycles: EnergyCycles, square: float) -> dict[str, object]:
    """Return evidence that friction is negligible, from the start or after the first cycles; empty without any."""
    work, path, samples = cycles.sums.work_j, cycles.sums.path_rad, cycles.stop - cycles.start
    if len(work) < FEWEST_CYCLES or interaction.choice.gravity == "in-torque":
        return {}
    negligible = LEAST_OF_TORQUE * np.sqrt(square / samples.sum())
    half = len(work) // 2
    before = float(work[:UNCOMPENSATED].sum() / path[:UNCOMPENSATED].sum())
    after = float(work[half:].sum() / path[half:].sum())
    if before > negligible and after < -LEAST_OF_BEGINNING * before:
        return {"case": "gives_out", "after": after}
    if before > negligible and after < LEAST_OF_BEGINNING * before:
        return {"case": "vanishes", "before": before, "after": after}
    return {"case": "nothing"} if abs(work.sum()) < negligible * path.sum() else {}
