"""The next recording of a joint: the motion, the answers that it leads to, and the trajectory."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from friction_audit.diagnosis.dictionary import Block, Dictionary
from friction_audit.diagnosis.problem import Index, RegressionProblem
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.effects.registry import effect_of, effects
from friction_audit.errors import AnalysisError
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from friction_audit.pipeline import estimate_log
from friction_audit.planning import design
from friction_audit.planning.candidates import Candidate, candidates_of
from friction_audit.planning.check import Answer, answer, duration_of, recording
from friction_audit.planning.limits import Limits
from friction_audit.planning.question import AUTO, Joint, Question, reference, term_of_block
from friction_audit.simulation import simulate
from friction_audit.simulation.from_model import EQUALS
from friction_audit.simulation.motion import intend
from friction_audit.simulation.motion.prescribed import Prescribed

Purpose = Literal["decide", "diagnose", "estimate"]
DURATION_S = 120.0
SEED = 7  # of the noise of the check
SIZE = 0.1  # of the friction torque: an effect of this size counts, where no log has one
FEWEST_RUNS = 3  # with fewer there are too few cycles for a diagnosis
RATE_HZ = 1000.0  # of a trajectory's samples before they are thinned out


@dataclass(frozen=True, kw_only=True, slots=True)
class Separated:
    """Expected 2 ln of the likelihood ratio of an effect, if it is there, against another one."""

    effect: str
    other: str
    two_ln_likelihood_ratio: float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointPlan:
    """The motion of one joint for one purpose.

    Attributes:
        joint: The joint.
        purpose: ``decide`` between names, ``diagnose`` or ``estimate``.
        why: What the log leaves open, in words.
        limits: Limits that it keeps.
        runs: Candidates in the order in which they are run.
        separated: What the design expects of each pair.
        answers: What `diagnose` would answer with each effect in turn; empty if not simulated.
        coefficients: What `estimate` would find, of one that is for it.
        unknown: Competing names that are left out, and why.
    """

    joint: Joint
    purpose: Purpose
    why: str
    limits: Limits
    runs: tuple[Candidate, ...]
    separated: tuple[Separated, ...] = ()
    answers: tuple[Answer, ...] = ()
    coefficients: Mapping[str, Coefficient] = field(default_factory=dict)
    unknown: Mapping[str, str] = field(default_factory=dict)

    @property
    def duration_s(self) -> float:
        """Length of the motion with a rest before and after. [s]"""
        return duration_of([one for run in self.runs for one in run.strokes])

    @property
    def undecided(self) -> tuple[str, ...]:
        """Effects that `diagnose` would not name alone."""
        return tuple(one.effect for one in self.answers if not one.decided)

    def trajectory(self, rate_hz: float) -> tuple[Float, Float, Float, Float]:
        """Return time, position, velocity and acceleration, shape (n,) each. [s], [rad], [rad/s], [rad/s^2]"""
        ticks = round(self.duration_s * RATE_HZ)
        motion = Prescribed(strokes=tuple(one for run in self.runs for one in run.strokes))
        found = intend(motion, ticks, 1.0 / RATE_HZ, np.random.default_rng(0))
        every = max(round(RATE_HZ / rate_hz), 1)
        t = np.arange(ticks + 1) / RATE_HZ
        rate = np.gradient(found.velocity, t)
        return t[::every], (self.limits.start_rad + found.position)[::every], found.velocity[::every], rate[::every]


def plan_to_decide(
    question: Question, limits: Limits, why: str, duration_s: float = DURATION_S, *, check: bool = True
) -> JointPlan:
    """Plan the motion that decides between the effects that compete in a joint.

    Raises:
        AnalysisError: If no two names are left, or the time is too short.
        UsageError: If no motion keeps the limits.
    """
    truths = {name: one[name] for one in question.sets if len(one) > 1 for name in one}
    if not truths:
        raise AnalysisError(f"joint {question.joint.number}: no two names are left to decide between")
    certain = [next(iter(one.values())) for one in question.sets if len(one) == 1]
    plan = _of_effects(question.joint, limits, truths, certain, duration_s)
    answers = [answer(question.joint, plan.runs, name, question.terms(name), SEED) for name in truths if check]
    return replace(plan, why=why, answers=tuple(answers), unknown=dict(question.unknown))


def plan_to_diagnose(
    joint: Joint, limits: Limits, why: str, duration_s: float = DURATION_S, *, check: bool = True
) -> JointPlan:
    """Plan the motion that shows and separates all effects that a joint alone can show, at a usual size.

    Raises as ``plan_to_decide`` does.
    """
    truths = usual_terms(joint)
    plan = _of_effects(joint, limits, truths, (), duration_s)
    answers = [answer(joint, plan.runs, name, [term], SEED) for name, term in truths.items() if check]
    return replace(plan, purpose="diagnose", why=why, answers=tuple(answers))


def plan_to_estimate(
    joint: Joint, limits: Limits, why: str, duration_s: float = DURATION_S, *, check: bool = True
) -> JointPlan:
    """Plan the motion that determines Coulomb and viscous friction best (D-optimal design).

    Raises as ``plan_to_decide`` does.
    """
    candidates = candidates_of(limits)
    about = design.information_of(joint, candidates, {}, choice=[effect_of("nonlinear_viscous")])
    counts = _filled(about, design.value_for_coefficients, duration_s)
    runs = tuple(design.in_order(candidates, counts))
    plan = JointPlan(joint=joint, purpose="estimate", why=why, limits=limits, runs=runs)
    if not check:
        return plan
    log = simulate(recording(joint, runs), SEED, path="planned motion").log
    found = estimate_log(log, AUTO).friction.joints[0]
    return replace(plan, coefficients={"coulomb_nm": found.coulomb, "viscous_nms_per_rad": found.viscous})


def _of_effects(
    joint: Joint, limits: Limits, truths: Mapping[str, FittedTerm], certain: Sequence[FittedTerm], duration_s: float
) -> JointPlan:
    candidates = candidates_of(limits)
    about = design.information_of(joint, candidates, truths, certain)
    counts = _filled(about, design.value_of_separation, duration_s)
    names, found = about.separation(counts.astype(float))
    expected = {name: dict(zip(names, row.tolist(), strict=True)) for name, row in zip(truths, found, strict=True)}
    pairs = [(one, other) for one in truths for other in truths if one != other and other in expected[one]]
    return JointPlan(
        joint=joint,
        purpose="decide",
        why="",
        limits=limits,
        runs=tuple(design.in_order(candidates, counts)),
        separated=tuple(Separated(effect=a, other=b, two_ln_likelihood_ratio=expected[a][b]) for a, b in pairs),
    )


def _filled(about: design.Information, criterion: design.Criterion, duration_s: float) -> Index:
    counts = design.exchange(about, criterion, duration_s - duration_of(()))
    if counts.sum() < FEWEST_RUNS:
        raise AnalysisError(
            f"{duration_s:g} s: room for {counts.sum()} candidate motions, the shortest of "
            f"{about.seconds.min():.1f} s; expected at least {FEWEST_RUNS}; give a longer --duration, or higher limits"
        )
    return counts


def usual_terms(joint: Joint) -> dict[str, FittedTerm]:
    """Return the effects that a joint alone can show, each of the usual size and in the middle of its grid."""
    alone = [one for one in effects() if one.coefficients and not EQUALS[one.name].needs_neighbours]
    data = reference(joint)
    problem, nominal = RegressionProblem.build(data, None), joint.nominal(data)
    dictionary, size = Dictionary.build(problem, alone, nominal), SIZE * joint.parameters.coulomb_nm
    terms = dict[str, FittedTerm]()
    for effect in alone:
        own = [one for one in dictionary.blocks if one.name == effect.name]
        found = [_of_size(one, problem, size) for one in own[len(own) // 2 :] + own[: len(own) // 2]]
        term = next((one for one in found if one is not None), None)
        terms |= {} if term is None else {effect.name: term}
    return terms


def _of_size(block: Block, problem: RegressionProblem, size_nm: float) -> FittedTerm | None:
    """Return a term whose torque free of the nominal model has a size; None if none may."""
    columns, X = block.columns, problem.X
    free = columns - (np.linalg.lstsq(X.T, columns.T)[0].T @ X)
    own = np.ones(len(columns)) * size_nm / max(float(np.sqrt(np.mean(free.sum(axis=0) ** 2))), 1e-12)
    if block.effect.follows:
        own = np.array([block.effect.coefficient_of(block.shape)])
    return term_of_block(block, block.whole(own)) if block.possible(own) else None
