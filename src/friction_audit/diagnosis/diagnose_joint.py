"""One joint: from what was prepared to the result."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from friction_audit.diagnosis import intervals, profiles, screening
from friction_audit.diagnosis.conclusion import Conclusion, Named, conclude
from friction_audit.diagnosis.data_audit import DataFinding, faults
from friction_audit.diagnosis.forward_gap import gap_in_motion
from friction_audit.diagnosis.gram import Training
from friction_audit.diagnosis.procedure import State, nominal, select
from friction_audit.diagnosis.residual_checks import residual_of
from friction_audit.diagnosis.result import Evidence, JointDiagnosis, NamedEffect, Traces, Verdict
from friction_audit.diagnosis.samples import make_samples
from friction_audit.diagnosis.selection import split
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.diagnosis.validation import gap, held_out
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import JointData, displacement
from friction_audit.effects.joint_model import JointModel
from friction_audit.errors import AnalysisError
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

FEWEST_CYCLES = 6
ALPHA = 0.05  # family-wise error of the detection limit
POWER_Z = 1.28  # normal quantile of 90 % power
COMPETING_SHOWN = 6
SIMULATED = 5  # one of so many folds is simulated forward


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Subject:
    """A joint to diagnose.

    Attributes:
        data: The joint on the fine grid.
        number: Number for people.
        name: Its name.
        findings: What the audit of its data found.
        from_energy: What the energy method says of it.
        model: Its nominal model, None for the simple one.
        known_inertia_kg_m2: Inertia whose torque a rigid-body model took out of the log.
        lacking: Why the energy method has no estimate, with the motion that would help; empty where it has one.
    """

    data: JointData
    number: int
    name: str
    findings: tuple[DataFinding, ...]
    from_energy: dict[str, Coefficient]
    model: JointModel | None = None
    known_inertia_kg_m2: float = 0.0
    lacking: str = ""


def diagnose_joint(subject: Subject, effects: Sequence[Effect], settings: DiagnosisSettings) -> JointDiagnosis:
    """Say whether anything is missing in the nominal model of a joint, and what.

    Args:
        subject: The joint.
        effects: Effects that may be named.
        settings: Smallest effect that counts; its seed is that of the screening test alone.
    """
    # What is kept with a copy, columns of the arm's model above all, is freed with it.
    rigid = subject.data.rigid
    subject = replace(subject, data=replace(subject.data, rigid=None if rigid is None else replace(rigid)))
    wrong = faults(subject.findings)
    if wrong:
        return _unanswered(subject, "data_fault", "; ".join(one.message for one in wrong))
    cycles = len(np.unique(make_samples(subject.data).cycle))
    if cycles < FEWEST_CYCLES:
        lacking = subject.lacking or "move the joint back and forth, or count slower cycles with --thresholds auto"
        return _unanswered(
            subject,
            "not_testable",
            f"{cycles} energy {'cycle' if cycles == 1 else 'cycles'} with motion; "
            f"at least {FEWEST_CYCLES} are needed: {lacking}",
        )
    try:
        state = select(subject.data, subject.model, effects)
        if not state.gram.blocks:
            return _unanswered(
                subject, "not_testable", "; ".join(dict.fromkeys(state.dictionary.not_testable.values()))
            )
        found = _result(subject, state, conclude(state, settings.min_effect_nm), settings)
    except (AnalysisError, np.linalg.LinAlgError) as error:
        return _unanswered(subject, "not_testable", str(error))
    test = np.unique(state.problem.samples.cycle[SIMULATED * state.problem.fold < state.problem.folds])
    known = subject.known_inertia_kg_m2
    found = replace(
        found, simulation=gap_in_motion(found, subject.model, subject.data, test, known_inertia_kg_m2=known)
    )
    return profiles.with_own_axes(replace(found, contacts=profiles.contact_trace(state)))


def _unanswered(subject: Subject, verdict: Verdict, reason: str) -> JointDiagnosis:
    return JointDiagnosis(
        joint=subject.number,
        name=subject.name,
        verdict=verdict,
        reason=reason,
        from_energy=subject.from_energy,
        findings=subject.findings,
    )


def _result(subject: Subject, state: State, said: Conclusion, settings: DiagnosisSettings) -> JointDiagnosis:
    gram, problem, active = state.gram, state.problem, state.active
    closed, before, after = gap(gram, active)
    baseline = nominal(problem, state.search.training, active)
    estimates = intervals.of(gram, state.dictionary, active, baseline)
    plain = (
        estimates
        if not active
        else intervals.of(gram, state.dictionary, (), nominal(problem, state.search.training, ()))
    )
    tests = screening.wild_cluster_bootstrap(gram, (), settings.seed)
    last = screening.wild_cluster_bootstrap(gram, active, settings.seed) if active else tests
    first = profiles.profiles_of(problem, before.residual, tests)
    remaining = profiles.profiles_of(problem, after.residual, last) if active else first
    numbers = dict(
        zip([b.name for b in active], zip(estimates.effects, estimates.not_identifiable, strict=True), strict=True)
    )
    named, negligible = (
        tuple(_effect(state, one, numbers[one.block.name], k, group) for k, one in enumerate(group))
        for group in (said.named, said.negligible)
    )
    events = profiles.contact_effects(state, first)
    limit = _detection_limit(state, after.rms)
    slow = f"the residual follows the time, and this log cannot test slow effects: {said.lacking}"
    return JointDiagnosis(
        joint=subject.number,
        name=subject.name,
        verdict=said.verdict,
        reason=slow if said.verdict == "not_testable" else "",
        effects=(*events, *named),
        nominal=plain.nominal,
        augmented=estimates.nominal,
        from_energy=subject.from_energy,
        gap=closed,
        ladder=_ladder(state, said, closed.before, closed.floor),
        omnibus_p=tests.p_value,
        remaining_p=last.p_value,
        detection_limit_nm=limit,
        profiles=first,
        remaining=remaining,
        untestable={k: v for k, v in state.dictionary.not_testable.items() if k not in {b.name for b in active}},
        findings=subject.findings,
        traces=_traces(state, before.residual, after.residual),
        negligible=negligible,
        checks=said.checks,
        remainder_share=said.remainder,
        share_explained=_without_gravity(state, closed.floor),
    )


def _effect(
    state: State, one: Named, numbers: tuple[dict[str, Coefficient], tuple[str, ...]], k: int, group: Sequence[Named]
) -> NamedEffect:
    gram, problem, block = state.gram, state.problem, one.block
    fit = Training(gram).fit(state.active)
    torque = dict(zip(map(id, state.active), split(fit, state.active), strict=True))[id(block)] @ block.columns
    left = residual_of(gram, state.active)
    upto = [other.block for other in group[:k]]
    before, after = (held_out(gram, some, replaced=state.active).rms for some in (upto, [*upto, block]))
    curve = profiles.along_effect(problem, left + torque, block.effect.axis)
    power = float(np.sum(residual_of(gram, ()) ** 2))
    competing = (
        Evidence(name=c.name, two_ln_bayes_factor=c.deficit, correlation=c.correlation)
        for c in one.competing[:COMPETING_SHOWN]
    )
    return NamedEffect(
        name=block.name,
        label=block.effect.label,
        alternatives=one.alternatives,
        parameters=numbers[0],
        p_value=one.gain.p_value,
        evidence=(Evidence(name=block.name, two_ln_bayes_factor=0.0, correlation=1.0), *competing),
        axis=block.effect.axis,
        gap_before_nm=before,
        gap_after_nm=after,
        torque=torque,
        curve=curve,
        size_nm=one.size_nm,
        friction_share=one.friction_share,
        residual_share=min(one.size_nm**2 * len(torque) / max(power, 1e-300), 1.0),
        grade=one.grade,
        folds=problem.folds,
        chosen_in=one.folds,
        not_identifiable=numbers[1],
    )


def _ladder(state: State, said: Conclusion, before: float, floor: float) -> tuple[tuple[str, float], ...]:
    steps, blocks = [("nominal model", before)], []
    for one in said.named:
        blocks.append(one.block)
        steps.append((f"+ {one.block.name}", held_out(state.gram, blocks, replaced=state.active).rms))
    return (*steps, ("noise floor", floor))


def _without_gravity(state: State, floor: float) -> float:
    """Share of the gap that the effects close, gravity in the model before and after."""
    gravity = [b for b in state.active if b.name == "gravity_error"]
    before, after = held_out(state.gram, gravity, replaced=state.active).rms, held_out(state.gram, state.active).rms
    return float("nan") if before <= floor else (before - after) / (before - floor)


def _detection_limit(state: State, left_nm: float) -> float:
    """Rms of an effect, free of the nominal model, that would have been seen with 90 % power. [N m]"""
    from scipy.special import ndtri

    needed = (float(ndtri(1.0 - ALPHA / (2 * max(len(state.gram.blocks), 1)))) + POWER_Z) ** 2
    noise = state.gram.noise
    # The information of an effect as broad as the residual itself: its power per independent sample.
    time = float(np.sum(noise.predictors[-1])) if noise.age.max() else 0.0
    information = noise.effective_samples * max(1.0 - time, 0.05) ** 2 * (noise.scales[-1] * left_nm) ** 2
    return float(left_nm * np.sqrt(needed / max(information, 1.0)))


def _traces(state: State, before: Float, after: Float) -> Traces:
    problem, weight = state.problem, state.problem.samples.weight
    q, dq, _ = problem.kinematics
    measured = problem.samples.y / weight
    return Traces(
        t=problem.samples.t,
        q=q,
        dq=dq,
        displacement=problem.at_samples(displacement(problem.data)),
        cycle=problem.samples.cycle,
        held_out=np.ones(len(q), bool),
        measured=measured,
        before=measured - before / weight,
        after=measured - after / weight,
        along={curve.axis.name: curve.values for curve in problem.curves},
        corner_hz=problem.samples.corner_hz,
    )
