"""What `diagnose` would answer after a planned motion: the simulator runs it with each competing effect in turn."""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, fields, replace

from friction_audit.diagnosis.diagnose_joint import diagnose_joint
from friction_audit.diagnosis.result import JointDiagnosis, Verdict
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.effects.registry import effect_of, effects
from friction_audit.errors import UsageError
from friction_audit.planning.candidates import Candidate
from friction_audit.planning.question import Joint, subject_of
from friction_audit.simulation import BenchSettings, Hidden
from friction_audit.simulation.effects import HiddenEffect
from friction_audit.simulation.effects.effect import FORM, NoEqualError, Setting
from friction_audit.simulation.from_model import EQUALS
from friction_audit.simulation.motion.prescribed import Prescribed, Stroke

END_S = 0.5  # rest after the last stroke


@dataclass(frozen=True, kw_only=True, slots=True)
class Answer:
    """What `diagnose` answers where one of the competing effects is there.

    Attributes:
        effect: The effect.
        numbers: As simulated: values by name; empty where it does nothing in this motion.
        verdict: The verdict.
        sets: Names of each effect that is named, with those that it may be instead.
        exact: Whether the simulator has these very numbers, of all effects that are there, and not only near ones.
        decided: Whether no wrong name is left but the effect and those that are there in any case.
    """

    effect: str
    numbers: dict[str, float | str]
    verdict: Verdict
    sets: tuple[tuple[str, ...], ...]
    exact: bool
    decided: bool


def recording(joint: Joint, runs: Sequence[Candidate], **changes: object) -> BenchSettings:
    """Return the simulation of a joint along the runs of a plan."""
    strokes = tuple(one for run in runs for one in run.strokes)
    return joint.settings(Prescribed(strokes=strokes), duration_of(strokes), **changes)


def duration_of(strokes: Sequence[Stroke]) -> float:
    """Return the length of a recording of some strokes, with a rest before and after. [s]"""
    return float(sum(one.moving_s + one.rest_s for one in strokes)) + Prescribed(strokes=()).start_s + END_S


def answer(joint: Joint, runs: Sequence[Candidate], name: str, terms: Sequence[FittedTerm], seed: int) -> Answer:
    """Simulate a joint with some effects along the runs and diagnose the log.

    Args:
        joint: The joint.
        runs: The motion.
        name: The effect in question.
        terms: It and the effects that are there in any case, with their numbers.
        seed: Of the noise.
    """
    settings = recording(joint, runs)
    pairs = [one for one in (hidden_effect(term, joint, settings) for term in terms) if one is not None]
    own = next((one for one, _ in pairs if one.name == EQUALS[name].name), None)
    settings = replace(settings, hidden=(Hidden().holding(*(one for one, _ in pairs)),))
    found = diagnose_joint(subject_of(joint, settings, seed), effects(), DiagnosisSettings())
    numbers = {} if own is None else own.values()
    sets = tuple((one.name, *one.alternatives) for one in found.effects)
    decided = _decided(found, name, {one.name for one in terms} - {name}, absent=own is None)
    exact = all(exactly for _, exactly in pairs)
    return Answer(effect=name, numbers=numbers, verdict=found.verdict, sets=sets, exact=exact, decided=decided)


def _decided(found: JointDiagnosis, name: str, certain: AbstractSet[str], *, absent: bool) -> bool:
    """Return whether no wrong name is left; what no motion separates from the effect counts as the same."""
    same = {name, *effect_of(name).indistinguishable}
    named = {one for effect in found.effects for one in (effect.name, *effect.alternatives)}
    return named <= same | certain and (bool(named & same) or absent)


def hidden_effect(term: FittedTerm, joint: Joint, settings: BenchSettings) -> tuple[HiddenEffect, bool] | None:
    """Return the simulator's effect and whether it equals a term; None for one that a joint alone does not show.

    Where the simulator has no equal, numbers that mean the same are taken over and the others are as usual.
    """
    kind = EQUALS[term.name]
    if kind.needs_neighbours:
        return None
    values = {p.name: value for p, value in zip(term.effect.parameters, term.values, strict=True)}
    setting = Setting(
        joint=joint.parameters,
        start_rad=0.0,
        driven=not joint.hand,
        duration_s=settings.duration_s,
        outer_kg_m2=settings.operator.inertia_kg_m2,
    )
    try:
        given = kind.from_parameters(values, setting)
        texts = {key: value if isinstance(value, str) else repr(float(value)) for key, value in given.items()}
        return kind.make(texts), True
    except (NoEqualError, UsageError):
        return _near(kind, values), False


def _near(kind: type[HiddenEffect], values: dict[str, float]) -> HiddenEffect:
    likes = {one.name: one.metadata.get("like", "") for one in fields(kind) if one.name != FORM}
    own = {one.name: one for one in kind.parameters()}
    near = {key: values[like] for key, like in likes.items() if like in values}
    return kind.make(
        {key: repr(min(max(v, own[key].lower), own[key].upper)) for key, v in near.items()} | _usual(kind, near)
    )


def _usual(kind: type[HiddenEffect], near: dict[str, float]) -> dict[str, str]:
    strength = kind.strength_name()
    usual = next(one.default for one in kind.parameters() if one.name == strength)
    return {} if near.get(strength) else {strength: repr(usual)}
