"""The stages on one log: estimate, replay, diagnose. Each imports what it needs when it is called."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numpy as np

from friction_audit.columns_on_demand import is_on_demand
from friction_audit.friction.history import FrictionHistory
from friction_audit.friction.settings import FrictionSettings
from friction_audit.joint_log import JointLog, Recording
from friction_audit.parallel import per_joint, release_memory
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.interaction_torque import extract_interaction
from friction_audit.preprocessing.settings import CycleSettings, TorqueSettings
from friction_audit.preprocessing.torque_source import arm_for_hand, known_arm

if TYPE_CHECKING:
    from collections.abc import Iterable

    from friction_audit.compensation.result import Replay
    from friction_audit.compensation.settings import ReplaySettings
    from friction_audit.diagnosis.data_audit import DataFinding
    from friction_audit.diagnosis.diagnose_joint import Subject
    from friction_audit.diagnosis.result import Discrepancy
    from friction_audit.diagnosis.settings import DiagnosisSettings


@dataclass(frozen=True, kw_only=True, slots=True)
class AuditSettings:
    """All settings of the chain.

    Attributes:
        joints: Numbers (1..n) of the joints to look at, or None for all.
        t_start_s: Start of the window, or None. [s]
        t_stop_s: End of the window, or None. [s]
        torque: The interaction torque.
        cycles: The segmentation.
        friction: The estimate.
    """

    joints: tuple[int, ...] | None = None
    t_start_s: float | None = None
    t_stop_s: float | None = None
    torque: TorqueSettings = field(default_factory=TorqueSettings)
    cycles: CycleSettings = field(default_factory=CycleSettings)
    friction: FrictionSettings = field(default_factory=FrictionSettings)


class Shown:
    """A result that draws itself, and is a table in a notebook; ``api``, which knows how, sets both functions."""

    __slots__ = ()
    draw: ClassVar[Callable[..., object]]
    tables: ClassVar[Callable[..., dict[str, Any]]]

    def plot(self, kind: str | None = None, **options: object) -> object:
        """Draw the result; see ``friction_audit.plot``."""
        return type(self).draw(self, kind, **options)

    def _repr_html_(self) -> str:
        first, *_ = type(self).tables(self).values()
        return str(first.to_html(index=False, float_format="{:.4g}".format))


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Estimate(Shown):
    """The result of ``estimate``: every step of the chain and the settings that made it."""

    log: JointLog
    interaction: Interaction
    cycles: EnergyCycles
    friction: FrictionHistory
    settings: AuditSettings

    def __repr__(self) -> str:
        unit = f"torque in {self.log.source.torque_unit}, velocity in rad/s, 95 % intervals"
        return _repr("Estimate", self.log.source.path, unit, self.friction.joints)


def _repr(name: str, path: str, unit: str, joints: "Iterable[object]") -> str:
    return "\n  ".join((f"{name}({path}: {unit})", *map(repr, joints)))


def estimate_log(log: JointLog, settings: AuditSettings) -> Estimate:
    """Estimate the friction of the joints of a log.

    Raises:
        UsageError: If the settings contradict the log.
        InputError: If the log lacks a channel that the settings ask for.
    """
    from friction_audit.friction.estimate import Found, estimate_friction, estimate_joint, join_joints
    from friction_audit.friction.torque_regression import CUTOFF_HZ
    from friction_audit.preprocessing import segmentation

    log = log.take_window(settings.t_start_s, settings.t_stop_s)
    hand = settings.cycles.cycles_from == "hand"
    interaction = extract_interaction(log, settings.torque, joints=settings.joints, hand=hand)
    dead_torque = log.source.dead_torque
    if hand:
        cycles = segmentation.segment_cycles(interaction, settings.cycles)
        friction = estimate_friction(interaction, cycles, settings.friction, dead_torque)
        return Estimate(log=log, interaction=interaction, cycles=cycles, friction=friction, settings=settings)

    give_back: Callable[[], None] = release_memory if is_on_demand(log.q) else lambda: None
    give_back()

    def work(column: int) -> "tuple[EnergyCycles, Found]":
        """Find the cycles and the friction of a joint while its signals are in memory."""
        one = interaction.holding(column)
        velocity = segmentation.smooth_velocity(one, settings.cycles, column)
        own = segmentation.segment_joint(one, settings.cycles, column, velocity)
        same = velocity if settings.cycles.cutoff_hz == CUTOFF_HZ else None
        friction = estimate_joint(one, own, settings.friction, dead_torque, column, same)
        give_back()
        return own, friction

    every, found = zip(*per_joint(work, len(interaction.joint_numbers)), strict=True)
    cycles, friction = segmentation.join_cycles(every), join_joints(found, settings.friction)
    return Estimate(log=log, interaction=interaction, cycles=cycles, friction=friction, settings=settings)


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class LogReplay(Shown):
    """The result of ``replay``: what a compensator would have done, and its estimate."""

    estimate: Estimate
    replay: "Replay"
    settings: "ReplaySettings"

    def __repr__(self) -> str:
        return _repr("LogReplay", self.estimate.log.source.path, self.replay.counterfactual.title, self.replay.joints)


def replay_log(log: JointLog, settings: AuditSettings, replay_settings: "ReplaySettings") -> LogReplay:
    """Estimate a log, then run a friction compensator on its joints."""
    return replay_estimate(estimate_log(log, settings), replay_settings)


def replay_estimate(
    estimate: Estimate, settings: "ReplaySettings", *, joints: tuple[int, ...] | None = None
) -> LogReplay:
    """Run a friction compensator on a log that was estimated before, on some of its joints (by number) or on all."""
    from friction_audit.compensation.replay import replay

    log, hand_speed = estimate.log, None
    if estimate.settings.cycles.cycles_from == "hand":
        # As a controller saw it: from each sample alone. The smooth one of the interaction torque knows the future.
        hand_speed = arm_for_hand(log, estimate.settings.torque).hand_speed(log.q, log.dq)
    found = replay(
        estimate.interaction,
        estimate.cycles,
        estimate.friction,
        settings,
        robot=log.source.robot,
        joints=joints,
        hand_speed=hand_speed,
    )
    return LogReplay(estimate=estimate, replay=found, settings=settings)


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Diagnosis(Shown):
    """The result of ``diagnose``: what the nominal model misses, and its estimate."""

    estimate: Estimate
    discrepancy: "Discrepancy"
    settings: "DiagnosisSettings"

    def __repr__(self) -> str:
        unit = f"residual RMS on held-out cycles in {self.estimate.log.source.torque_unit}"
        return _repr("Diagnosis", self.estimate.log.source.path, unit, self.discrepancy.joints)


def diagnose_log(log: JointLog, settings: AuditSettings, diagnosis_settings: "DiagnosisSettings") -> Diagnosis:
    """Estimate a log, then find what the nominal model of every joint misses."""
    return diagnose_estimate(estimate_log(log, settings), diagnosis_settings)


def diagnose_estimate(
    estimate: Estimate, settings: "DiagnosisSettings", report: "Callable[[float], None] | None" = None
) -> Diagnosis:
    """Find what the nominal model misses on the joints of a log that was estimated before; report the share done."""
    from friction_audit.diagnosis.diagnose import diagnose_subjects

    found = diagnose_subjects(diagnosis_subjects(estimate, settings), settings, report)
    return Diagnosis(estimate=estimate, discrepancy=found, settings=settings)


def diagnosis_subjects(estimate: Estimate, settings: "DiagnosisSettings") -> "tuple[Subject, ...]":
    """Prepare the joints of a log that was estimated before, or of the part of a long one that tells most."""
    from friction_audit.diagnosis.data_audit import audit_part
    from friction_audit.diagnosis.diagnose import best_window, subjects_of

    part, whole_s = estimate, estimate.log.duration_s
    findings: tuple[DataFinding, ...] = ()
    if whole_s > settings.at_most_s:
        part_s = best_window(estimate.cycles, whole_s, settings.at_most_s)
        part = estimate_log(estimate.log, replace(estimate.settings, t_start_s=part_s[0], t_stop_s=part_s[1]))
        findings = (audit_part(part_s, whole_s),)
    arm = known_arm(part.log, part.settings.torque, part.interaction.choice)
    subjects = subjects_of(part.log, part.interaction, part.cycles, estimate.friction, settings, arm)
    return tuple(replace(subject, findings=findings + subject.findings) for subject in subjects)


def without_samples(estimate: Estimate) -> Estimate:
    """An estimate for a report alone: its log has no channels, its interaction no samples. Their memory is freed."""
    log, seen = estimate.log, estimate.interaction
    bare = Recording(t=log.t, joint_names=log.joint_names, source=log.source)
    nothing = np.zeros((0, len(seen.joint_names)))
    interaction = replace(
        seen, t=np.zeros(0), q=nothing, dq=nothing, torque=nothing, compensation=None, hand_speed=None
    )
    return replace(estimate, log=cast("JointLog", bare), interaction=interaction)
