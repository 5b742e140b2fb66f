"""The next recording of a joint: the motion, what `diagnose` would answer after it, and the trajectory."""

from collections.abc import Callable, Mapping, Sequence, Set as AbstractSet
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from friction_audit import parallel
from friction_audit.diagnosis.diagnose import diagnose_joint
from friction_audit.diagnosis.dictionary import Block, Dictionary
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.diagnosis.result import Verdict
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.effects.registry import effect_of, effects, same_as
from friction_audit.errors import AnalysisError, UsageError
from friction_audit.friction.history import Coefficient
from friction_audit.io.writers.tables import Trajectory
from friction_audit.joint_log import Int
from friction_audit.pipeline import estimate_log
from friction_audit.planning import design
from friction_audit.planning.design import Candidate, Limits, candidates_of
from friction_audit.planning.task import AUTO, Arm, Joint, Task, subject_of, term_of_block
from friction_audit.simulation import BenchSettings, Hidden, simulate
from friction_audit.simulation.effects.effect import HiddenEffect, NoEqualError, Setting
from friction_audit.simulation.hide import EQUALS, near_of
from friction_audit.simulation.strokes import Prescribed, start_times

DURATION_S = 120.0
END_S = 0.5  # rest after the last stroke
AROUND_S = Prescribed(strokes=()).start_s + END_S  # rests before and after the motion
SEED = 7  # of the noise of the check
SIZE = 0.1  # of the friction torque: an effect of this size counts, where no log has one
FEWEST_RUNS = 3  # with fewer there are too few cycles for a diagnosis
AT_AN_END = (0.15, 2)  # share of the time, and least number of runs, at either end where a drift is to be seen
WORKING_BYTES = 500_000_000  # for all candidates of a joint at once
RATE_HZ = 1000.0  # of a trajectory's samples before they are thinned out


class Separated(NamedTuple):
    """Expected 2 ln of the likelihood ratio of an effect, if it is there, against another one."""

    effect: str
    other: str
    two_ln_likelihood_ratio: float


class Answer(NamedTuple):
    """What `diagnose` answers where one of the competing effects is there."""

    effect: str
    numbers: Mapping[str, float | str]  # as simulated: values by name; empty where it does nothing in this motion
    verdict: Verdict
    sets: tuple[tuple[str, ...], ...]  # names of each effect that is named, with those that it may be instead
    exact: bool  # whether the simulator has these very numbers, of all effects that are there, and not only near ones
    decided: bool  # whether no wrong name is left but the effect and those that are there in any case


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointPlan:
    """The motion of one joint for one purpose."""

    task: Task
    limits: Limits  # limits that it keeps
    runs: tuple[Candidate, ...]  # in the order in which they are run
    # if above zero, the same runs follow once more after this rest: at both ends of a time a trend shows most
    # (D-optimal), and a drift that settles while a joint moves all the time is a constant for most samples
    rest_s: float = 0.0
    separated: tuple[Separated, ...] = ()  # what the design expects of each pair
    answers: tuple[Answer, ...] = ()  # with each effect in turn; empty if not simulated
    coefficients: Mapping[str, Coefficient] = field(default_factory=dict)  # what `estimate` would find

    @property
    def motion(self) -> Prescribed:
        """All strokes, one after the other."""
        once = tuple(one for run in self.runs for one in run.strokes)
        if not self.rest_s:
            return Prescribed(strokes=once)
        rested = once[-1]._replace(rest_s=once[-1].rest_s + self.rest_s)
        return Prescribed(strokes=(*once[:-1], rested, *once))

    @property
    def duration_s(self) -> float:
        """Length of the motion with a rest before and after. [s]"""
        return float(start_times(self.motion)[-1]) + END_S


def trajectory_of(plans: Sequence[JointPlan], arm: Arm, rate_hz: float) -> Trajectory:
    """Return the motions of the joints one after the other, all other joints held at the start."""
    parts, begin = [], 0.0
    for plan in plans:
        ticks, every = round(plan.duration_s * RATE_HZ), max(round(RATE_HZ / rate_hz), 1)
        found, t = plan.motion.reference(ticks, 1.0 / RATE_HZ, np.random.default_rng(0)), np.arange(ticks + 1) / RATE_HZ
        moved = plan.limits.start_rad + found.position, found.velocity, np.gradient(found.velocity, t)
        whole = np.zeros((3, len(t), len(arm.names)))
        whole[0] = arm.start_rad
        whole[:, :, plan.task.joint.number - 1] = moved
        parts.append((begin + t[::every], *whole[:, ::every]))
        begin = float(parts[-1][0][-1]) + 1.0 / rate_hz
    return Trajectory(arm.names, *(np.concatenate(one) for one in zip(*parts, strict=True)))


def plan_tasks(
    tasks: Sequence[tuple[Task, Limits]],
    duration_s: float = DURATION_S,
    *,
    check: bool | None = None,
    report: Callable[[float], None] | None = None,
) -> list[JointPlan]:
    """Plan what joints need within their limits, joints side by side; ``report`` takes the share that is done."""
    groups = dict[int, list[tuple[Task, Limits]]]()
    for one in tasks:
        groups.setdefault(one[0].joint.number, []).append(one)

    def work(k: int) -> list[JointPlan]:
        with parallel.one_joint_at_a_time() if len(groups) > 1 else nullcontext():
            return [plan_task(*one, duration_s, check=check) for one in [*groups.values()][k]]

    plans = list[JointPlan]()
    # Half of the work is in the interpreter, for which threads would wait.
    for own in parallel.in_processes(work, len(groups), parallel.workers_for(len(groups), WORKING_BYTES)):
        plans += own
        if report is not None:
            report(len(plans) / len(tasks))
    return plans


def plan_task(task: Task, limits: Limits, duration_s: float = DURATION_S, *, check: bool | None = None) -> JointPlan:
    """Plan the motion that a joint needs.

    To decide between effects and to diagnose it is T-optimal, there for all effects that a joint alone can show at a
    usual size; for Coulomb and viscous friction it is D-optimal.

    The check simulates the motion and what `diagnose` or `estimate` would answer. None: unless it is to diagnose, which
    takes a diagnosis of each effect of the catalogue.
    """
    joint, candidates = task.joint, candidates_of(limits)
    check = task.purpose != "diagnose" if check is None else check
    if task.purpose == "estimate":
        about = design.information_of(joint, candidates, {}, (), [effect_of("nonlinear_viscous")])
        counts = _filled(about, design.value_for_coefficients, duration_s)
        plan = JointPlan(task=task, limits=limits, runs=design.in_order(candidates, counts))
        if not check:
            return plan
        log = simulate(joint.settings(plan.motion, plan.duration_s), SEED, path="planned motion").log
        found = estimate_log(log, AUTO).friction.joints[0]
        return replace(plan, coefficients={"coulomb_nm": found.coulomb, "viscous_nms_per_rad": found.viscous})
    sets = task.sets if task.purpose == "decide" else (usual_terms(joint),)
    truths = {name: one[name] for one in sets if len(one) > 1 for name in one}
    certain = [next(iter(one.values())) for one in sets if len(one) == 1]
    about = design.information_of(joint, candidates, truths, certain, effects())
    counts, at_both_ends = _designed(about, duration_s)
    runs = design.in_order(candidates, counts)
    names, values = about.separation(counts.astype(float) * (2.0 if at_both_ends else 1.0))
    expected = {name: dict(zip(names, row.tolist(), strict=True)) for name, row in zip(truths, values, strict=True)}
    pairs = [(one, other) for one in truths for other in truths if one != other and other in expected[one]]
    separated = tuple(Separated(one, other, expected[one][other]) for one, other in pairs)
    plan = JointPlan(task=task, limits=limits, runs=runs, separated=separated)
    if at_both_ends:
        plan = replace(plan, rest_s=duration_s - plan.duration_s - sum(one.duration_s for one in runs))
    there = {name: [one.get(name, next(iter(one.values()))) for one in sets] for name in truths}
    return replace(plan, answers=tuple(answer(plan, name, terms) for name, terms in there.items() if check))


def _designed(about: design.Information, duration_s: float) -> tuple[Int, bool]:
    """Return how often each candidate is run, and whether at both ends of the time, where an offset may drift."""
    share, fewest = AT_AN_END
    known = [effect_of(name) for name in about.truths]
    constant = [one.misses == "nothing" for one in known]
    slow = [one.axis == "time" and one.misses != "any" for one in known]
    if 0 < sum(constant) < len(known) and all(map(any, zip(constant, slow, strict=True))):
        counts = design.exchange(about, design.value_of_separation, share * duration_s - AROUND_S)
        if counts.sum() >= fewest:  # else there is no time for both
            return counts, True
    return _filled(about, design.value_of_separation, duration_s), False


def _filled(about: design.Information, criterion: design.Criterion, duration_s: float) -> Int:
    counts = design.exchange(about, criterion, duration_s - AROUND_S)
    if counts.sum() < FEWEST_RUNS:
        room = f"room for {counts.sum()} candidate motions, the shortest of {about.seconds.min():.1f} s"
        todo = f"expected at least {FEWEST_RUNS}; give a longer --duration, or higher limits"
        raise AnalysisError(f"{duration_s:g} s: {room}; {todo}")
    return counts


@lru_cache(maxsize=4)
def usual_terms(joint: Joint) -> Mapping[str, FittedTerm]:
    """Return the effects that a joint alone can show, each of the usual size and in the middle of its grid."""
    alone = [one for one in effects() if one.coefficients and not EQUALS[one.name].needs_neighbours]
    data = subject_of(joint).data
    problem, nominal = RegressionProblem.build(data, None), joint.nominal(data)
    blocks, size = Dictionary.build(problem, alone, nominal).blocks, SIZE * joint.parameters.coulomb_nm
    terms = dict[str, FittedTerm]()
    for effect in alone:
        own = [one for one in blocks if one.name == effect.name]
        found = (_of_size(one, problem, size) for one in own[len(own) // 2 :] + own[: len(own) // 2])
        if (term := next(filter(None, found), None)) is not None:
            terms[effect.name] = term
    return terms


def _of_size(block: Block, problem: RegressionProblem, size_nm: float) -> FittedTerm | None:
    columns, X = block.columns, problem.X
    free = columns - (np.linalg.lstsq(X.T, columns.T)[0].T @ X)
    own = np.ones(len(columns)) * size_nm / max(float(np.sqrt(np.mean(free.sum(axis=0) ** 2))), 1e-12)
    return term_of_block(block, np.array([block.effect.coefficient_of(block.shape)]) if block.effect.follows else own)


def answer(plan: JointPlan, name: str, terms: Sequence[FittedTerm]) -> Answer:
    """Simulate a joint along its plan with an effect and those that are there in any case, and diagnose the log."""
    joint = plan.task.joint
    settings = joint.settings(plan.motion, plan.duration_s)
    pairs = [one for one in (_hidden(term, joint, settings) for term in terms) if one is not None]
    own = next((one for one, _ in pairs if one.name == EQUALS[name].name), None)
    settings = replace(settings, hidden=(Hidden().holding(*(one for one, _ in pairs)),))
    found = diagnose_joint(subject_of(joint, settings, SEED), effects(), DiagnosisSettings(), simulated=False)
    sets = tuple((one.name, *one.alternatives) for one in found.effects)
    # What no motion separates from the effect counts as the same.
    same, named = same_as(name), {one for each in sets for one in each}
    certain: AbstractSet[str] = {one.name for one in terms} - {name}
    decided = named <= same | certain and (bool(named & same) or own is None)
    exact = all(exactly for _, exactly in pairs)
    return Answer(name, {} if own is None else own.values(), found.verdict, sets, exact, decided)


def _hidden(term: FittedTerm, joint: Joint, settings: BenchSettings) -> tuple[HiddenEffect, bool] | None:
    """Return the simulator's effect and whether it equals a term; None for one that a joint alone does not show."""
    effect, outer = EQUALS[term.name], settings.operator.inertia_kg_m2
    if effect.needs_neighbours:
        return None
    setting = Setting(joint.parameters, 0.0, not joint.hand, settings.duration_s, outer)
    try:
        return effect.make(effect.from_parameters(term.numbers, setting)), True
    except (NoEqualError, UsageError):
        return near_of(term), False
