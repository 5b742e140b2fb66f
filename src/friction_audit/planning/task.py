"""What is to be recorded next: what a diagnosis or an estimate leaves open in each joint of an arm."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import atan2, hypot, pi, sqrt
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from friction_audit.diagnosis.dictionary import Block, Dictionary
from friction_audit.diagnosis.prepare import Subject
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.diagnosis.result import CONTACT_EVENT, JointDiagnosis
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import CORNER_HZ, JointData, Nominal, reach
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.effects.registry import effect_of, motion_to_decide, same_as
from friction_audit.errors import AnalysisError, InputError, UsageError
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from friction_audit.pipeline import AuditSettings, diagnosis_subjects, estimate_log
from friction_audit.preprocessing.settings import CycleSettings
from friction_audit.presets import FRANKA, PRESETS
from friction_audit.simulation import PANDA_SENSORS, BenchSettings, JointParameters, Operator, simulate
from friction_audit.simulation.bench import READY_RAD
from friction_audit.simulation.periodic import MotionSettings
from friction_audit.simulation.strokes import StopAndGo

Purpose = Literal["decide", "diagnose", "estimate"]
RATE_HZ = 500.0  # of simulated logs: ten times the diagnosis' samples
LEAST_NOISE_NM = 1e-4
REACH_RAD = 0.8  # to either side of the start: room for gravity, which takes 1.5 rad, within most arms' ranges
FARTHEST_RAD = 2.0 * pi  # a turn shows every place of a joint, however many it has made in the log
COEFFICIENTS = ("inertia_kg_m2", "coulomb_nm", "viscous_nms_per_rad")  # of the nominal model
DID_NOT_MOVE = "did not move"  # how the reason of a joint at rest begins in a document
SERVO = {"stiffness_nm_per_rad": 2000.0, "damping_nms_per_rad": 60.0}  # of a position controller, as in joint-driven
AUTO = AuditSettings(cycles=CycleSettings(thresholds="auto"))  # slow strokes are no cycles at the usual thresholds


@dataclass(frozen=True, kw_only=True, slots=True)
class Joint:
    """A joint to plan for: its nominal model, noise, and who moves it. Two of which these are the same are equal."""

    number: int = field(default=1, compare=False)
    name: str = field(default="joint1", compare=False)
    parameters: JointParameters = field(default_factory=JointParameters)
    noise_nm: float = 0.02  # RMS of the torque's noise below the corner [N m]
    corner_hz: float = CORNER_HZ  # of the low-pass filter [Hz]
    hand: bool = True  # a person moves it
    reach_rad: tuple[float, float] = (-REACH_RAD, REACH_RAD)  # range of the motion, relative to its start [rad]
    gravity: tuple[float, float] = (0.0, 0.0)  # amplitude [N m] and phase [rad] over the angle from the start

    def settings(self, motion: MotionSettings, duration_s: float) -> BenchSettings:
        """Return the simulation of this joint along a motion: sensors of a Panda with the noise of the log."""
        usual = PANDA_SENSORS[0]
        passes = sqrt((1.0 - usual.slow_noise_share) * 2.0 * self.corner_hz / 1000.0 + usual.slow_noise_share)
        noise = max(self.noise_nm, LEAST_NOISE_NM) / passes
        step = usual.torque_step_nm * min(1.0, noise / usual.torque_noise_nm)
        return BenchSettings(
            joints=(self.parameters,),
            sensors=(replace(usual, torque_noise_nm=noise, torque_step_nm=step),),
            operator=Operator(motion=motion, **({} if self.hand else SERVO)),
            driven=not self.hand,
            gravity_nm=self.gravity[0],
            gravity_phase_rad=self.gravity[1],
            logs_sensor=not self.hand or self.gravity[0] > 0.0,
            duration_s=duration_s,
            rate_hz=RATE_HZ,
        )

    def nominal(self, data: JointData) -> Nominal:
        """Return the nominal model along a motion."""
        own = {name: getattr(self.parameters, name) for name in COEFFICIENTS}
        return Nominal(**own, torque=np.array([*own.values()]) @ np.stack([data.ddq, data.direction, data.dq]))


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Task:
    """What a joint needs."""

    joint: Joint
    purpose: Purpose | None = None  # None where nothing is left to decide
    why: str = ""  # what is open, or the answer that there is
    # To decide between, with their numbers: one effect of each set is there; a set of one is certain.
    sets: tuple[Mapping[str, FittedTerm], ...] = ()
    unknown: Mapping[str, str] = field(default_factory=dict)  # competing names that are not planned for, and why

    @property
    def at_rest(self) -> bool:
        """Whether the joint did not move in the recording."""
        return self.why == DID_NOT_MOVE


class Arm(NamedTuple):
    """The arm that is recorded, and where its motion starts."""

    names: tuple[str, ...]  # of its joints
    start_rad: tuple[float, ...]
    robot: str  # name of its preset, or another word where it has none
    known_start: bool  # whether a log or the user gave the start


def arm_of(robot: str, joints: int, start: Sequence[float] | None, names: Mapping[int, str]) -> Arm:
    """Return an arm by the names of its joints that are known; it starts in the Panda's ready pose, or at zero."""
    preset = PRESETS.get(robot)
    usual = READY_RAD if robot in FRANKA and joints == len(READY_RAD) else (0.0,) * joints
    start_rad = usual if start is None else tuple(map(float, start))
    if len(start_rad) != joints or not np.isfinite(start_rad).all():
        raise UsageError(f"--start: {len(start_rad)} positions; expected {joints}, one per joint [rad]")
    others = preset.joints if preset and len(preset.joints) == joints else [f"joint{k}" for k in range(1, joints + 1)]
    known = (names.get(k, name) for k, name in enumerate(others, 1))
    return Arm(tuple(known), start_rad, robot, known_start=start is not None)


def tasks_of(
    document: Mapping[str, Any],
    path: Path,
    start: Sequence[float] | None,
    *,
    wanted: Sequence[int] | None = None,
    names: Sequence[str] = (),
    subjects: Sequence[tuple[Subject, JointDiagnosis]] = (),
) -> tuple[Arm, list[Task]]:
    """Return the arm of a document, and what each joint needs, or those wanted; with a log, subjects and all names.

    A joint that did not move needs nothing unless it is wanted: in a log of one joint the others hold still.
    """
    try:
        source, hand = document["source"], document["settings"]["torque_chosen"]["drive"] == "hand"
        found = {int(one["joint"]): one for one in document["joints"]}
        own = {k: str(one["name"]) for k, one in found.items()} | dict(enumerate(names, 1))
        arm = arm_of(str(source["robot"]), int(source["joints"]), start, own)
        prepared = {one[0].number: one for one in subjects}
        chosen = {k: one for k, one in found.items() if wanted is None or k in wanted}
        tasks = [task_of(one, hand, arm.start_rad[k - 1], prepared.get(k)) for k, one in chosen.items()]
        return arm, [one if wanted or not one.at_rest else replace(one, purpose=None) for one in tasks]
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"{path}: is no whole document of its schema ({error!r}); write it again") from error


def task_of(
    found: Mapping[str, Any], hand: bool, start_rad: float, subject: tuple[Subject, JointDiagnosis] | None = None
) -> Task:
    """Return what a joint of a document needs that a person or the robot moved; positions count from the start."""
    energy = found.get("from_energy", found)
    coefficients = {key: Coefficient.read(energy.get(key)).value for key in ("coulomb_nm", "viscous_nms_per_rad")}
    joint = replace(_joint(found, coefficients, start_rad, subject and subject[0]), hand=hand)
    verdict, reason = found.get("verdict", "estimate"), str(found.get("reason") or "")
    if verdict in ("not_testable", "data_fault"):
        reason = reason or str(found.get("message", ""))
    reason = DID_NOT_MOVE if DID_NOT_MOVE in reason else reason
    if verdict == "not_testable":
        return Task(joint=joint, purpose="diagnose", why=reason)
    if verdict == "ambiguous":
        effects = [(one["name"], one["alternatives"], one["parameters"]) for one in found["effects"]]
        if subject is not None:  # which knows the values that the document leaves out, as not identified, too
            values = ({key: n.value for key, n in one.parameters.items()} for one in subject[1].effects)
            effects = [(*one[:2], numbers) for one, numbers in zip(effects, values, strict=True)]
        sets, unknown = _sets(joint, effects, None if subject is None else subject[0].data, start_rad)
        names = [name for one in sets if len(one) > 1 for name in one]
        if names and set(names) <= same_as(names[0]):
            motion = motion_to_decide(names[0], names[1:])
            return Task(joint=joint, why=f"no motion of the joint separates {' from '.join(names)}: {motion}")
        if names:
            return Task(joint=joint, purpose="decide", why=" or ".join(names), sets=sets, unknown=unknown)
        reason = "no two of its names can be simulated apart from each other"
    named = zip(("Coulomb", "viscous"), coefficients.values(), strict=True)
    lacking = [name for name, value in named if not np.isfinite(value)]
    if lacking and verdict != "data_fault":
        why = reason if reason == DID_NOT_MOVE else f"{' and '.join(lacking)} friction is not determined"
        return Task(joint=joint, purpose="estimate", why=why)
    settled = "both coefficients are determined" if verdict == "estimate" else verdict.replace("_", " ")
    return Task(joint=joint, why=reason or settled)


def _joint(
    found: Mapping[str, Any], coefficients: Mapping[str, float], start_rad: float, subject: Subject | None
) -> Joint:
    fitted = found.get("augmented") or found.get("nominal") or coefficients
    numbers = {key: Coefficient.read(number).value for key, number in fitted.items()}
    about: dict[str, Any] = {} if found.get("gap") is None else {"noise_nm": float(found["gap"]["noise_floor_rms_nm"])}
    if subject is not None:
        data = subject.data
        numbers["inertia_kg_m2"] = numbers.get("inertia_kg_m2", 0.0) + subject.known_inertia_kg_m2
        low, high = reach(data)
        ends = np.clip((start_rad - low, high - start_rad), REACH_RAD, FARTHEST_RAD)
        about["reach_rad"] = (-float(ends[0]), float(ends[1]))
        if data.load is not None and data.used.any():
            angle = data.q[data.used] - start_rad
            sine, cosine = np.linalg.lstsq(np.column_stack([np.sin(angle), np.cos(angle)]), data.load[data.used])[0]
            about["gravity"] = (float(hypot(sine, cosine)), float(atan2(cosine, sine)))
        if found.get("gap") is not None:
            about["corner_hz"] = RegressionProblem.build(data, None).samples.corner_hz
    known: dict[str, Any] = {key: numbers[key] for key in COEFFICIENTS if numbers.get(key, 0.0) > 0.0}  # else usual
    return Joint(number=int(found["joint"]), name=str(found["name"]), parameters=JointParameters(**known), **about)


def _sets(
    joint: Joint,
    effects: Sequence[tuple[str, Sequence[str], Mapping[str, float | None]]],
    data: JointData | None,
    start_rad: float,
) -> tuple[tuple[Mapping[str, FittedTerm], ...], dict[str, str]]:
    """Fit every name that competes with a named effect to that effect's torque, or return why it cannot be."""
    data, named = subject_of(joint).data if data is None else data, {name for name, *_ in effects}
    sets, unknown = [], dict[str, str]()
    for name, alternatives, numbers in effects:
        names = [name, *(other for other in alternatives if other not in named)]
        if CONTACT_EVENT in names or not effect_of(name).coefficients:
            unknown |= dict.fromkeys(names, "an event is in no motion")
            continue
        found = _fitted(joint, numbers, names, data, start_rad)
        unknown |= {other: "cannot be fitted to this log" for other in names if other not in found}
        sets += [found] if found else []
    return tuple(sets), unknown


def _fitted(
    joint: Joint, numbers: Mapping[str, float | None], names: Sequence[str], data: JointData, start_rad: float
) -> dict[str, FittedTerm]:
    nominal, effect = joint.nominal(data), effect_of(names[0])
    problem = RegressionProblem.build(replace(data, q=data.q - start_rad, rigid=None), None)
    blocks = Dictionary.build(problem, [effect_of(one) for one in names], nominal).blocks
    grid = [block.shape for block in blocks if block.name == effect.name] or [{}]
    usual = grid[len(grid) // 2]  # of a number that is not identified and has no default
    lacking = {p.name: usual.get(p.name) for p in effect.parameters if not p.allows(p.default)}
    given = {key: value for key, value in numbers.items() if value is not None}
    term = _term_of(effect, [(lacking | given).get(p.name) for p in effect.parameters])
    if term is None:
        return {}
    target = problem.samples.of(term.torque(data.motion(nominal.torque)))
    found = dict[str, tuple[float, FittedTerm]]()
    for block in blocks:
        rows = np.vstack([problem.X, block.columns])
        fit: Float = np.asarray(np.linalg.lstsq(rows.T, target)[0], np.float64)
        fitted = term_of_block(block, fit[len(problem.X) :])
        left = float(np.sum((target - fit @ rows) ** 2))
        if fitted is not None and (block.name not in found or left < found[block.name][0]):
            found[block.name] = (left, fitted)
    terms = {one: found[one][1] for one in names if one in found}
    return {effect.name: term} | terms if effect.axis != "position" else terms


def _term_of(effect: Effect, values: Sequence[float | None]) -> FittedTerm | None:
    """Return a term, None where its numbers are beyond their bounds; what is not known is as usual."""
    pairs = zip(effect.parameters, values, strict=True)
    known = [p.default if v is None or not np.isfinite(v) else float(np.clip(v, p.lower, p.upper)) for p, v in pairs]
    try:
        return FittedTerm(effect.name, tuple(known))
    except AnalysisError:
        return None


def term_of_block(block: Block, coefficients: Float) -> FittedTerm | None:
    """Return the term of a block with all its effect's coefficients, None where they are beyond their bounds."""
    if not block.possible(coefficients):
        return None
    nonlinear = [block.shape.get(one.name, one.default) for one in block.effect.nonlinear]
    whole = block.whole(coefficients)
    missing = [0.0] * (len(block.effect.coefficients) - len(whole))
    return _term_of(block.effect, [*whole, *missing, *nonlinear])


@lru_cache(maxsize=4)  # both purposes of a joint need its candidates, and joints without a log are equal
def subject_of(joint: Joint, settings: BenchSettings | None = None, seed: int = 0) -> Subject:
    """Simulate a joint and prepare it for the diagnosis; without settings, a person who stops and goes."""
    settings = joint.settings(StopAndGo(), 60.0) if settings is None else settings
    log = simulate(settings, seed, path="planned motion").log
    audit = replace(AUTO, torque=replace(AUTO.torque, drive="hand" if joint.hand else "robot"))
    return diagnosis_subjects(estimate_log(log, audit), DiagnosisSettings(at_most_s=settings.duration_s))[0]
