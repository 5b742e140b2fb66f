"""The stages on one log: estimate, replay, diagnose. Each imports what it needs when it is called."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numpy as np

from friction_audit.errors import FrictionAuditError
from friction_audit.friction.history import FrictionHistory
from friction_audit.friction.settings import FrictionSettings
from friction_audit.io.recording import WholeLogError
from friction_audit.joint_log import Float, JointLog, LogInBlocks, LogPart, Recording
from friction_audit.parallel import per_joint, release_memory, sparing_memory
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Interaction
from friction_audit.preprocessing.interaction_torque import PortTorque, choose_torque
from friction_audit.preprocessing.settings import CycleSettings, TorqueSettings
from friction_audit.preprocessing.torque_source import arm_for_hand, known_arm

if TYPE_CHECKING:
    from collections.abc import Iterator

    from friction_audit.compensation.result import Replay
    from friction_audit.compensation.settings import ReplaySettings
    from friction_audit.diagnosis.data_audit import DataFinding
    from friction_audit.diagnosis.prepare import Subject
    from friction_audit.diagnosis.result import JointDiagnosis
    from friction_audit.diagnosis.settings import DiagnosisSettings
    from friction_audit.io.checks import Take


LARGE_PRODUCTS = 1 << 20  # bytes of one joint: those of a day would take most of the memory
ENOUGH_MEANS = 50  # of the first block of a log, a second at least, that may show how its torque is made


@dataclass(frozen=True, kw_only=True, slots=True)
class AuditSettings:
    """All settings of the chain."""

    joints: tuple[int, ...] | None = None  # numbers (1..n) of the joints to look at, or None for all
    t_start_s: float | None = None  # start of the window [s]
    t_stop_s: float | None = None  # end of the window [s]
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


@dataclass(frozen=True, eq=False, slots=True)
class Estimate(Shown):
    """The result of ``estimate``: every step of the chain and the settings that made it."""

    log: JointLog
    interaction: Interaction
    cycles: tuple[EnergyCycles, ...]  # of each joint of the interaction
    friction: FrictionHistory
    settings: AuditSettings
    port: PortTorque | None = None  # of a log that is read in blocks, whose ``interaction`` has no samples

    def __repr__(self) -> str:
        unit = f"torque in {self.log.source.torque_unit}, velocity in rad/s, 95 % intervals"
        return "\n  ".join((f"Estimate({self.log.source.path}: {unit})", *map(repr, self.friction.joints)))


def estimate_log(log: JointLog, settings: AuditSettings) -> Estimate:
    """Estimate the friction of the joints of a log; InputError if it lacks a channel that the settings ask for."""
    from friction_audit.friction.estimate import friction_of
    from friction_audit.preprocessing.segmentation import without_small

    log, by_hand = log.take_window(settings.t_start_s, settings.t_stop_s), settings.cycles.cycles_from == "hand"
    if isinstance(log, LogInBlocks):
        log = log.read_whole() if by_hand else log
        release_memory()  # what the checks needed
    port = choose_torque(log, settings.torque, joints=settings.joints, hand=by_hand)
    in_blocks = isinstance(port.log, LogInBlocks)
    done = log.listener if isinstance(log, LogInBlocks) and port.log is log else None
    if not (isinstance(done, _Pass) and done.is_of(port, settings)):
        if in_blocks:  # what the model of the arm needed, before the blocks ask for more
            release_memory()
        done = _Pass(port, settings)
        for block in port.log.blocks():
            done.take(block)
    assert done.part is not None
    joints, part = done.joints, replace(done.part, choice=port.choice, warnings=port.warnings)
    done.joints, done.part = [], None  # what they have found is taken from them once, and not kept by the log
    every = without_small([one.search.cycles() for one in joints], settings.cycles) if by_hand else []
    found = dict(enumerate(every))

    def cycles_of(column: int) -> EnergyCycles:
        own = found[column] = found.get(column) or joints[column].search.cycles()
        if in_blocks and own.products.nbytes > LARGE_PRODUCTS:
            release_memory()
            found[column] = replace(own, products=own.products[:0].copy())
        return own

    friction = friction_of(part, joints, cycles_of, settings.friction, log.source.dead_torque)
    interaction = part.rows(part.first, part.first) if in_blocks else part
    cycles = tuple(found[column] for column in range(len(joints)))
    return Estimate(log, interaction, cycles, friction, settings, port if in_blocks else None)


def while_read(settings: AuditSettings) -> "Callable[[JointLog], Take | None]":
    """Return what estimates a log in blocks while its checks look at them, to decode them once and not twice.

    It takes the torque for what the first block shows: where the whole log says otherwise, ``estimate_log`` reads anew.
    """

    def listen(log: JointLog) -> "Take | None":
        if not isinstance(log, LogInBlocks) or len(log.t) < ENOUGH_MEANS or settings.cycles.cycles_from == "hand":
            return None
        with suppress(FrictionAuditError, WholeLogError):  # refused, if it is, when all is known
            port = choose_torque(replace(log, read=_not_yet), settings.torque, joints=settings.joints)
            return _Pass(port, settings)
        return None

    return listen


def _not_yet(_: object) -> "Iterator[tuple[Float, dict[str, Float]]]":
    raise WholeLogError


class _Pass:
    """The joints of a log on their way through its blocks."""

    def __init__(self, port: PortTorque, settings: AuditSettings) -> None:
        from friction_audit.friction.estimate import JointPass
        from friction_audit.preprocessing.segmentation import of_hand, thresholds_in_blocks

        log, speed, cycles = port.log, port.hand_speed, settings.cycles
        hand = None if speed is None else of_hand(speed, log.rate_hz, cycles)
        own = enumerate(thresholds_in_blocks(log, port.columns, cycles))
        self.port, self._settings, self.part = port, settings, cast("Interaction | None", None)
        self.joints = [JointPass(log, column, cycles, thresholds, hand) for column, thresholds in own]
        # So many samples on, filters have forgotten, and the direction of gravity is known on both sides.
        self._done, self._margin = 0, max(self.joints[0].margin, 2 * port.stride)

    def take(self, block: LogPart) -> None:
        """Take the samples of the next block."""
        new = self.port.interaction(block)
        needed = max(min(self._done, *(one.search.first for one in self.joints)) - self._margin, 0)
        part = self.part = new if self.part is None else self.part.followed_by(new, needed)
        # The filtered values of those at its end may still change.
        end, more = part.first + len(part.t), part.first + len(part.t) < self.port.log.samples
        start, self._done = self._done, max(end - self._margin, self._done) if more else end
        if self._done > start:
            own, around = part.rows(start, self._done), part.rows(max(start - self._margin, part.first), end)
            per_joint(lambda column: self.joints[column].take(part, own, around, more=more), len(self.joints))

    def __call__(self, first: int, t: Float, channels: dict[str, Float]) -> None:
        """Take the samples of a block that is being checked."""
        log = self.port.log
        self.take(LogPart(t=t, **channels, joint_names=log.joint_names, source=log.source, first=first))

    def is_of(self, port: PortTorque, settings: AuditSettings) -> bool:
        """Return True if the torque was made as is now known to be right."""
        mine, right = self.port.balance, port.balance
        same = all(getattr(mine.plan, name) == getattr(right.plan, name) for name in ("source", "gravity", "inertia"))
        same = same and (mine.plan.arm is None) == (right.plan.arm is None)
        return same and mine.sign == right.sign and settings == self._settings and self.part is not None


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class LogReplay(Shown):
    """The result of ``replay``: what a compensator would have done, and its estimate."""

    estimate: Estimate
    replay: "Replay"
    settings: "ReplaySettings"

    def __repr__(self) -> str:
        path, assume = self.estimate.log.source.path, self.replay.counterfactual.code
        return "\n  ".join((f"LogReplay({path}: {assume})", *map(repr, self.replay.joints)))


def replay_estimate(
    estimate: Estimate, settings: "ReplaySettings", *, joints: tuple[int, ...] | None = None
) -> LogReplay:
    """Run a friction compensator on a log that was estimated before, on some of its joints (by number) or on all."""
    from friction_audit.compensation.replay import replay

    log, hand_speed = estimate.log, None
    if estimate.settings.cycles.cycles_from == "hand":
        # As a controller saw it: from each sample alone. The smooth one of the interaction torque knows the future.
        hand_speed = arm_for_hand(log, estimate.settings.torque).hand_speed(log.q, log.dq)
    if isinstance(log, LogInBlocks):
        release_memory()
    if settings.needs_whole and isinstance(log, LogInBlocks):
        return replay_estimate(estimate_log(log.read_whole(), estimate.settings), settings, joints=joints)
    driving = iter([estimate.interaction]) if estimate.port is None else estimate.port.driving()
    parts = estimate.interaction, driving, estimate.cycles, estimate.friction
    found = replay(log, *parts, settings, joints=joints, hand_speed=hand_speed)
    return LogReplay(estimate=estimate, replay=found, settings=settings)


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Diagnosis(Shown):
    """The result of ``diagnose``: what the nominal model misses, and its estimate."""

    estimate: Estimate
    joints: "tuple[JointDiagnosis, ...]"  # those that were asked for
    settings: "DiagnosisSettings"

    def __repr__(self) -> str:
        source, joints = self.estimate.log.source, map(repr, self.joints)
        head = f"Diagnosis({source.path}: residual RMS on held-out cycles in {source.torque_unit})"
        return "\n  ".join((head, *joints))


def diagnose_estimate(
    estimate: Estimate, settings: "DiagnosisSettings", report: "Callable[[float], None] | None" = None
) -> Diagnosis:
    """Find what the nominal model misses on the joints of a log that was estimated before; report the share done."""
    from friction_audit.diagnosis.diagnose import diagnose_subjects

    found = diagnose_subjects(diagnosis_subjects(estimate, settings), settings, report)
    return Diagnosis(estimate=estimate, joints=found, settings=settings)


def diagnosis_subjects(estimate: Estimate, settings: "DiagnosisSettings") -> "tuple[Subject, ...]":
    """Prepare the joints of a log that was estimated before, or of the part of a long one that tells most."""
    from friction_audit.diagnosis.data_audit import judged
    from friction_audit.diagnosis.prepare import PREPARED, best_window, parts_of, subjects_of

    part, whole_s = estimate, estimate.log.duration_s
    findings: tuple[DataFinding, ...] = ()
    if parts_of(whole_s, settings.at_most_s) > 1:
        part_s = 0.0, whole_s
        if whole_s > (longest_s := PREPARED * settings.at_most_s):
            part_s = best_window(estimate.cycles, whole_s, longest_s)
            part = estimate_log(estimate.log, replace(estimate.settings, t_start_s=part_s[0], t_stop_s=part_s[1]))
        words = {"start": part_s[0], "stop": part_s[1], "minutes": np.ceil(whole_s / 60.0)}
        findings = (judged("part", whole_s, settings.at_most_s, **words),)
    arm = known_arm(part.log, part.settings.torque, part.interaction.choice)
    with sparing_memory():
        subjects = subjects_of(part.log, part.interaction, part.cycles, estimate.friction, settings, arm)
    return tuple(replace(subject, findings=findings + subject.findings) for subject in subjects)


def without_samples(estimate: Estimate) -> Estimate:
    """An estimate for a report alone: its log has no channels, its interaction no samples. Their memory is freed."""
    log, seen = estimate.log, estimate.interaction
    bare = Recording(t=log.t, joint_names=log.joint_names, source=log.source)
    nothing = np.zeros((0, len(seen.joint_names)))
    interaction = replace(seen, t=np.zeros(0), q=nothing, dq=nothing, torque=nothing, compensation=None)
    return replace(estimate, log=cast("JointLog", bare), interaction=interaction, port=None)
