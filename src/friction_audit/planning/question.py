"""What a diagnosis leaves open in a joint: the competing effects at their estimated sizes, and the joint."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import atan2, hypot, sqrt
from typing import Any

import numpy as np

from friction_audit.diagnosis.diagnose_joint import Subject
from friction_audit.diagnosis.dictionary import Block, Dictionary
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.diagnosis.result import CONTACT_EVENT, JointDiagnosis
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import CORNER_HZ, JointData, Nominal, reach
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.effects.registry import effect_of
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float
from friction_audit.pipeline import AuditSettings, diagnosis_subjects, estimate_log
from friction_audit.planning.limits import REACH_RAD
from friction_audit.preprocessing.settings import CycleSettings
from friction_audit.simulation import PANDA_SENSORS, BenchSettings, JointParameters, Operator, Sensors, simulate
from friction_audit.simulation.motion import MotionSettings
from friction_audit.simulation.motion.stop_and_go import StopAndGo

RATE_HZ = 500.0  # of simulated logs: ten times the diagnosis' samples
LEAST_NOISE_NM = 1e-4
SERVO = {"stiffness_nm_per_rad": 2000.0, "damping_nms_per_rad": 60.0}  # of a position controller, as in joint-driven
AUTO = AuditSettings(cycles=CycleSettings(thresholds="auto"))  # slow strokes are no cycles at the usual thresholds


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Joint:
    """A joint to plan for: its nominal model, noise, and who moves it.

    Attributes:
        number: From 1.
        name: In the log.
        parameters: Inertia, Coulomb and viscous friction.
        noise_nm: RMS of the torque's noise below ``corner_hz``. [N m]
        corner_hz: Corner of the low-pass filter. [Hz]
        hand: Whether a person moves it.
        reach_rad: Lowest and highest position of the log relative to the start, at least REACH_RAD either way. [rad]
        gravity: Amplitude [N m] and phase [rad] of its gravity load over its own angle from the start.
    """

    number: int = 1
    name: str = "joint1"
    parameters: JointParameters = field(default_factory=JointParameters)
    noise_nm: float = 0.02
    corner_hz: float = CORNER_HZ
    hand: bool = True
    reach_rad: tuple[float, float] = (-REACH_RAD, REACH_RAD)
    gravity: tuple[float, float] = (0.0, 0.0)

    @property
    def sensors(self) -> Sensors:
        """Those of a Panda with the noise of the log."""
        usual = PANDA_SENSORS[0]
        passes = sqrt((1.0 - usual.slow_noise_share) * 2.0 * self.corner_hz / 1000.0 + usual.slow_noise_share)
        noise = max(self.noise_nm, LEAST_NOISE_NM) / passes
        step = usual.torque_step_nm * min(1.0, noise / usual.torque_noise_nm)
        return replace(usual, torque_noise_nm=noise, torque_step_nm=step)

    def settings(self, motion: MotionSettings, duration_s: float, **changes: Any) -> BenchSettings:  # noqa: ANN401 - of settings
        """Return the simulation of this joint along a motion."""
        operator = Operator(motion=motion) if self.hand else Operator(motion=motion, **SERVO)
        given: dict[str, Any] = {
            "joints": (self.parameters,),
            "sensors": (self.sensors,),
            "operator": operator,
            "driven": not self.hand,
            "gravity_nm": self.gravity[0],
            "gravity_phase_rad": self.gravity[1],
            "logs_sensor": not self.hand or self.gravity[0] > 0.0,
            "duration_s": duration_s,
            "rate_hz": RATE_HZ,
        }
        return BenchSettings(**(given | changes))

    def nominal(self, data: JointData) -> Nominal:
        """Return the nominal model along a motion."""
        own = self.parameters
        torque = own.inertia_kg_m2 * data.ddq + own.coulomb_nm * data.way + own.viscous_nms_per_rad * data.dq
        return Nominal(
            inertia_kg_m2=own.inertia_kg_m2,
            coulomb_nm=own.coulomb_nm,
            viscous_nms_per_rad=own.viscous_nms_per_rad,
            torque=torque,
        )


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Question:
    """What is to be decided on a joint.

    Attributes:
        joint: The joint.
        sets: Effects of which one is there, by name with their numbers; a set of one is certain.
        unknown: Competing names that cannot be simulated or planned for, and why.
    """

    joint: Joint
    sets: tuple[Mapping[str, FittedTerm], ...]
    unknown: Mapping[str, str]

    @property
    def names(self) -> tuple[str, ...]:
        """Names that compete."""
        return tuple(name for one in self.sets if len(one) > 1 for name in one)

    def terms(self, name: str) -> tuple[FittedTerm, ...]:
        """Return all effects of the joint if the one of this name is there."""
        return tuple(one.get(name, next(iter(one.values()))) for one in self.sets)


def joint_of(numbers: Mapping[str, float], **about: Any) -> Joint:  # noqa: ANN401 - attributes of a joint
    """Return a joint with the coefficients of a result; what is not known there is as usual."""
    usual, own = JointParameters(), dict[str, Any]()
    for key in ("inertia_kg_m2", "coulomb_nm", "viscous_nms_per_rad"):
        value = numbers.get(key, float("nan"))
        own[key] = float(value) if np.isfinite(value) and value > 0.0 else getattr(usual, key)
    return Joint(parameters=JointParameters(**own), **about)


def gravity_of(data: JointData, start_rad: float) -> tuple[float, float]:
    """Return amplitude and phase of the gravity load over the joint's own angle. [N m], [rad]"""
    if data.load is None or not data.used.any():
        return 0.0, 0.0
    angle = data.q[data.used] - start_rad
    columns = np.column_stack([np.sin(angle), np.cos(angle)])
    sine, cosine = np.linalg.lstsq(columns, data.load[data.used])[0]
    return float(hypot(sine, cosine)), float(atan2(cosine, sine))


def question_of(
    joint: Joint, effects: Sequence[Mapping[str, Any]], data: JointData | None, start_rad: float
) -> Question:
    """Fit every name that competes with a named effect to that effect's torque.

    Args:
        joint: The joint.
        effects: Of the result: ``name``, ``alternatives`` and ``parameters`` (values by name) of each.
        data: The motion of the log; None where there is only its result.
        start_rad: Where the planned motion starts, from which positions are counted. [rad]
    """
    data = reference(joint) if data is None else data
    sets, unknown = [], dict[str, str]()
    for one in effects:
        names = [one["name"], *(n for n in one["alternatives"] if n not in {other["name"] for other in effects})]
        if CONTACT_EVENT in names or not effect_of(one["name"]).coefficients:
            unknown |= dict.fromkeys(names, "an event is in no motion")
            continue
        found = _fitted(joint, one["name"], one["parameters"], names, data, start_rad)
        unknown |= {name: "cannot be fitted to this log" for name in names if name not in found}
        sets += [found] if found else []
    return Question(joint=joint, sets=tuple(sets), unknown=unknown)


def question_of_log(found: JointDiagnosis, subject: Subject, *, hand: bool, start_rad: float) -> Question:
    """Return what the diagnosis of a log leaves open in a joint.

    Args:
        found: The diagnosis.
        subject: The joint as it was prepared.
        hand: Whether a person moved it.
        start_rad: Where the planned motion starts. [rad]
    """
    fitted = {name: number.value for name, number in (found.augmented or found.nominal).items()}
    low, high = reach(subject.data)
    fitted["inertia_kg_m2"] = fitted.get("inertia_kg_m2", 0.0) + subject.known_inertia_kg_m2
    joint = joint_of(
        fitted,
        number=found.joint,
        name=found.name,
        noise_nm=Joint().noise_nm if found.gap is None else found.gap.floor,
        corner_hz=CORNER_HZ if found.traces is None else found.traces.corner_hz,
        hand=hand,
        reach_rad=(min(-REACH_RAD, low - start_rad), max(REACH_RAD, high - start_rad)),
        gravity=gravity_of(subject.data, start_rad),
    )
    return question_of(joint, effects_of(found), subject.data, start_rad)


def effects_of(found: JointDiagnosis) -> list[dict[str, Any]]:
    """Return the effects of a diagnosis as its document has them, as far as they matter here."""
    return [
        {
            "name": one.name,
            "alternatives": one.alternatives,
            "parameters": {key: number.value for key, number in one.parameters.items()},
        }
        for one in found.effects
    ]


def _fitted(
    joint: Joint, name: str, numbers: Mapping[str, float | None], names: Sequence[str], data: JointData, start: float
) -> dict[str, FittedTerm]:
    nominal = joint.nominal(data)
    term = term_of_values(effect_of(name), [numbers.get(p.name) for p in effect_of(name).parameters])
    if term is None:
        return {}
    torque = term.torque(data.motion(nominal.torque))
    moved = replace(data, q=data.q - start, rigid=None)
    problem = RegressionProblem.build(moved, None)
    dictionary = Dictionary.build(problem, [effect_of(one) for one in names], nominal)
    target, found = problem.samples.of(torque), dict[str, tuple[float, FittedTerm]]()
    for block in dictionary.blocks:
        rows = np.vstack([problem.X, block.columns])
        fit: Float = np.asarray(np.linalg.lstsq(rows.T, target)[0], np.float64)
        own = block.whole(fit[len(problem.X) :])
        fitted = term_of_block(block, own)
        if fitted is None or not block.possible(fit[len(problem.X) :]):
            continue
        left = float(np.sum((target - fit @ rows) ** 2))
        if block.name not in found or left < found[block.name][0]:
            found[block.name] = (left, fitted)
    terms = {one: found[one][1] for one in names if one in found}
    return {name: term} | terms if effect_of(name).axis != "position" else terms


def term_of_values(effect: Effect, values: Sequence[float | None]) -> FittedTerm | None:
    """Return a term, None where its numbers are beyond their bounds; what is not known is as usual."""
    pairs = zip(effect.parameters, values, strict=True)
    known = [p.default if v is None or not np.isfinite(v) else float(np.clip(v, p.lower, p.upper)) for p, v in pairs]
    try:
        return FittedTerm(effect.name, tuple(known))
    except AnalysisError:
        return None


def term_of_block(block: Block, coefficients: Float) -> FittedTerm | None:
    """Return the term of a block with all its effect's coefficients, None where they are beyond their bounds."""
    nonlinear = [block.shape.get(one.name, one.default) for one in block.effect.nonlinear]
    missing = [0.0] * (len(block.effect.coefficients) - len(coefficients))
    return term_of_values(block.effect, [*coefficients, *missing, *nonlinear])


def reference(joint: Joint) -> JointData:
    """Return the motion of a person who stops and goes, for a result without its log."""
    return subject_of(joint, joint.settings(StopAndGo(), 60.0), seed=0).data


def subject_of(joint: Joint, settings: BenchSettings, seed: int) -> Subject:
    """Simulate a joint and prepare it for the diagnosis."""
    from friction_audit.diagnosis.settings import DiagnosisSettings

    log = simulate(settings, seed, path="planned motion").log
    drive = "hand" if joint.hand else "robot"
    settings_ = replace(AUTO, torque=replace(AUTO.torque, drive=drive))
    return diagnosis_subjects(estimate_log(log, settings_), DiagnosisSettings())[0]


def torque_on(terms: Sequence[FittedTerm], data: JointData, nominal: Nominal) -> Float:
    """Return what some effects add along a motion, shape (n,). [N m]"""
    motion = data.motion(nominal.torque)
    return np.asarray(sum((term.torque(motion) for term in terms), np.zeros(len(data.t))))
