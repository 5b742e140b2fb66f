"""Where simulation and measurement disagree: joint by joint, the names that stand, their sizes and the verdict."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace

import numpy as np

from friction_audit import parallel
from friction_audit.diagnosis import residual_checks, selection
from friction_audit.diagnosis.augmented_model import gap_in_motion
from friction_audit.diagnosis.contact_events import touched
from friction_audit.diagnosis.dictionary import Block
from friction_audit.diagnosis.fitted_model import FittedModel, gains, gap, held_out, wild_cluster_bootstrap
from friction_audit.diagnosis.nonlinear import Estimates, intervals
from friction_audit.diagnosis.prepare import Subject
from friction_audit.diagnosis.problem import refuse_few
from friction_audit.diagnosis.procedure import State, accepted, select
from friction_audit.diagnosis.result import ContactTrace, JointDiagnosis, NamedEffect, ResidualCheck, Traces, Verdict
from friction_audit.diagnosis.samples import make_samples
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.effect import Effect
from friction_audit.effects.registry import GRAVITY, effects
from friction_audit.effects.slow import ContactEvent
from friction_audit.errors import AnalysisError, FrictionAuditError, bug
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from friction_audit.preprocessing.even_grid import filtered
from friction_audit.preprocessing.interaction import Caution, Reason, quoted, reason_of

WORKING_BYTES = 1000  # of a process per sample of the fine grid (benchmarks/bench_diagnose.py)
FEWEST_CYCLES = 6
ALPHA = 0.05  # family-wise error of the detection limit
POWER_Z = 1.28  # normal quantile of 90 % power
COMPETING_SHOWN = 6
SIMULATED = 5  # one of so many folds is simulated forward
NEGLIGIBLE = 0.01  # of the joint's friction torque, rms
MINOR = 0.1
ENOUGH = 0.5  # share of the explainable power that names must explain, or nothing holds


def diagnose_subjects(
    subjects: Sequence[Subject], settings: DiagnosisSettings, report: Callable[[float], None] | None = None
) -> tuple[JointDiagnosis, ...]:
    """Diagnose joints side by side; ``report`` takes the share of them that is done."""
    candidates = [c for c in effects() if settings.candidates is None or c.name in settings.candidates]

    def one(k: int) -> JointDiagnosis:
        """Diagnose a joint; an error is the result of this joint and not the end of the others."""
        subject = subjects[k]
        # The last of an odd number of joints has a second core to itself, for the columns of its effects.
        last = k == joints - 1 and joints % (workers if workers > 1 else parallel.WORKERS) == 1
        try:
            joints_side_by_side = nullcontext() if last else parallel.one_joint_at_a_time()
            with joints_side_by_side, parallel.sparing_memory() if is_long else nullcontext():
                return diagnose_joint(subject, candidates, settings)
        except AnalysisError as error:
            return _answer(subject, "not_testable", reason_of(error))
        except (FrictionAuditError, MemoryError, Warning):  # warnings are errors where the tests run
            raise
        except Exception as error:  # noqa: BLE001 - reported as a bug: verdict, traceback and exit code 1
            sentence, traceback = bug("the diagnosis", error)
            return replace(_answer(subject, "failed", quoted(sentence)), findings=(), traceback=traceback)

    joints, working_bytes = len(subjects), WORKING_BYTES * max(len(subject.data.t) for subject in subjects)
    is_long = working_bytes > parallel.KEPT  # to map less of it anew would take longer than it frees
    workers = parallel.workers_for(joints, working_bytes)
    # Half of the work is in the interpreter, for which threads would wait.
    found = parallel.in_processes(one, joints, workers) if workers > 1 else parallel.per_joint(one, joints)
    diagnosed: list[JointDiagnosis] = []
    for joint in found:
        diagnosed.append(joint)
        if report is not None:
            report(len(diagnosed) / joints)
    return tuple(diagnosed)


def diagnose_joint(
    subject: Subject, effects: Sequence[Effect], settings: DiagnosisSettings, *, simulated: bool = True
) -> JointDiagnosis:
    """Say whether anything is missing in the nominal model of a joint, and what: of some effects, those that count."""
    # What is kept with a copy, columns of the arm's model above all, is freed with it.
    rigid = subject.data.rigid
    subject = replace(subject, data=replace(subject.data, rigid=None if rigid is None else replace(rigid)))
    if wrong := tuple(one for one in subject.findings if one.verdict == "fault"):
        return _answer(subject, "data_fault", wrong)
    try:
        if len(np.unique(subject.data.cycle)) > FEWEST_CYCLES:  # one is that of samples outside of any
            refuse_few(subject.data, make_samples(subject.data))
        cycles = len(np.unique(make_samples(subject.data).cycle))
        if cycles < FEWEST_CYCLES:
            numbers = {"cycles": cycles, "fewest": FEWEST_CYCLES, "lacking": subject.lacking}
            return _answer(subject, "not_testable", (Caution("too_few_cycles", numbers=numbers),))
        state = select(subject.data, subject.model, effects)
        if not state.gram.blocks:
            return _answer(subject, "not_testable", tuple(dict.fromkeys(state.dictionary.not_testable.values())))
        keep_stable(state)
        found = _result(subject, state, settings)
    except (AnalysisError, np.linalg.LinAlgError) as error:
        return _answer(subject, "not_testable", reason_of(error))
    test = np.unique(state.problem.samples.cycle[SIMULATED * state.problem.fold < state.problem.folds])
    return replace(found, simulation=gap_in_motion(found, subject, test)) if simulated else found


def _answer(subject: Subject, verdict: Verdict, reason: Reason = ()) -> JointDiagnosis:
    return JointDiagnosis(
        joint=subject.number,
        name=subject.name,
        verdict=verdict,
        reason=reason,
        from_energy=subject.from_energy,
        findings=subject.findings,
    )


def keep_stable(state: State) -> None:
    """Drop effects that too few of the folds choose, or that structure outside the catalogue replaces."""
    while state.active:
        state.folds = selection.shares_of_folds(state.gram, state.active, state.search.most_numbers)
        unsteady = [
            b
            for b in state.active
            if state.folds[b.name] < selection.LEAST_FOLDS * state.problem.folds
            or residual_checks.competing_structure(state.search.training, state.active, b)
        ]
        if not unsteady:
            return
        state.active = accepted(state, [b for b in state.active if b not in unsteady])


def _result(subject: Subject, state: State, settings: DiagnosisSettings) -> JointDiagnosis:
    gram, problem, active = state.gram, state.problem, state.active
    closed, before, after = gap(gram, active)
    model = state.fitted()
    estimates = intervals(model, state.dictionary)
    tests = wild_cluster_bootstrap(gram, (), settings.seed)
    first = residual_checks.profiles_of(problem, before.residual, tests.curves)
    plain, last, remaining = estimates, tests, first
    if active:
        plain = intervals(state.fitted(()), state.dictionary)
        last = wild_cluster_bootstrap(gram, active, settings.seed)
        remaining = residual_checks.profiles_of(problem, after.residual, last.curves)
    traces = _traces(state, before.residual, after.residual)
    named, negligible = _effects(state, model, estimates, settings.min_effect_nm, traces)
    small = {one.name for one in negligible}
    checks = tuple(c for c in residual_checks.run(model) if c.code != "change" or c.along not in small)
    bare = held_out(gram, [b for b in active if b.name == GRAVITY], replaced=active).rms
    verdict, lacking = verdict_of(state, named, checks), _lacking(state, checks)
    slow = (Caution("untested_time", numbers={"lacking": lacking}),) if verdict == "not_testable" else ()
    return replace(
        _answer(subject, verdict, slow),
        effects=(*contact_effects(state, before.residual, tests.curves), *named),
        nominal=plain.nominal,
        augmented=estimates.nominal,
        gap=closed,
        ladder=(
            ("nominal model", closed.before),
            *((f"+ {one.name}", one.gap_after_nm) for one in named),
            ("noise floor", closed.floor),
        ),
        omnibus_p=tests.p_value,
        remaining_p=last.p_value,
        detection_limit_nm=_detection_limit(state, after.rms),
        profiles=first,
        remaining=remaining,
        untestable={k: v for k, v in state.dictionary.not_testable.items() if k not in {b.name for b in active}},
        traces=traces,
        contacts=contact_trace(state),
        negligible=negligible,
        checks=checks,
        remainder_share=max((check.share for check in checks), default=0.0),
        share_explained=float("nan") if bare <= closed.floor else (bare - after.rms) / (bare - closed.floor),
    )


def verdict_of(state: State, named: Sequence[NamedEffect], checks: Sequence[ResidualCheck]) -> Verdict:
    """The one word."""
    if not named:
        if checks:
            return "not_testable" if _lacking(state, checks) else "unexplained"
        return "named" if state.contacts else "adequate"
    # No torque of a named effect holds a spectral line, so that a line says nothing against a name.
    remainder = max((c.share for c in checks if c.code != "line"), default=0.0)
    before, after = (float(np.mean(state.fitted(some).residual ** 2)) for some in ((), state.active))
    if before - after < ENOUGH * (before - after + remainder * after):
        return "unexplained"
    return "ambiguous" if any(one.alternatives for one in named) else "named"


def _lacking(state: State, checks: Sequence[ResidualCheck]) -> Reason:
    """Why slow effects are not tested where the residual follows the time; empty elsewhere."""
    if not checks or (checks[0].code, checks[0].along) != ("curve", "time"):
        return ()
    why = state.dictionary.not_testable
    return tuple(why[e.name] for e in state.dictionary.effects if e.name in why and e.axis == "time")[:1]


def _effects(
    state: State, model: FittedModel, estimates: Estimates, least_nm: float, traces: Traces
) -> tuple[tuple[NamedEffect, ...], tuple[NamedEffect, ...]]:
    """Effects that count, and those too small to, the largest first, each with what held-out cycles leave with it."""
    gram, problem, active = state.gram, state.problem, state.active
    data, baseline = problem.data, model.nominal
    friction = np.abs(baseline.coulomb_nm * data.direction + baseline.viscous_nms_per_rad * data.dq)[data.used]
    friction_nm = max(float(np.sqrt(np.mean(friction**2))), 1e-12)
    left, nominal_nm = model.residual, held_out(gram, (), replaced=active).rms
    torques, size_nm = model.whole(state.dictionary)
    each = zip(active, torques, gains(gram, active), size_nm.tolist(), *estimates[1:], strict=True)
    added: dict[bool, list[Block]] = {False: [], True: []}  # by whether they are negligible
    found: dict[bool, list[NamedEffect]] = {False: [], True: []}
    for block, torque, gain, size, parameters, unknown in sorted(each, key=lambda one: -one[3]):
        effect, share = block.effect, size / friction_nm
        grade = "negligible" if share < NEGLIGIBLE or size < least_nm else ("minor" if share < MINOR else "major")
        competing, small = selection.competing_effects(state.search, active, block), grade == "negligible"
        before = found[small][-1].gap_after_nm if found[small] else nominal_nm
        added[small].append(block)
        after = held_out(gram, added[small], replaced=active).rms
        found[small].append(
            NamedEffect(
                name=block.name,
                label=effect.label,
                alternatives=selection.indistinguishable(gram, competing, block, active),
                parameters=parameters,
                p_value=gain.p_value,
                evidence=competing[:COMPETING_SHOWN],
                axis=effect.axis,
                gap_before_nm=before,
                gap_after_nm=after,
                torque=torque,
                curve=residual_checks.profiles_of(problem, left + torque, {}, effect.axis)[0],
                size_nm=size,
                friction_share=share,
                residual_share=max(before**2 - after**2, 0.0) / nominal_nm**2,
                grade=grade,
                folds=problem.folds,
                chosen_in=(state.folds or {}).get(block.name, 0),
                not_identifiable=unknown,
            )
        )
    free = len(problem.chain) > 0
    drawn = (replace(one, own=residual_checks.own_axis(one, traces, free_of_chain=free)) for one in found[False])
    return tuple(drawn), tuple(found[True])


def _detection_limit(state: State, left_nm: float) -> float:
    """Rms of an effect, free of the nominal model, that would have been seen with 90 % power. [N m]"""
    from scipy.special import ndtri

    tried = len(state.gram.blocks) + sum(map(len, state.dictionary.withheld.values()))
    needed = (float(ndtri(1.0 - ALPHA / (2 * max(tried, 1)))) + POWER_Z) ** 2
    noise = state.gram.noise
    # The information of an effect as broad as the residual itself: its power per independent sample.
    time = float(np.sum(noise.predictors[-1])) if noise.age.max() else 0.0
    information = noise.effective_samples * max(1.0 - time, 0.05) ** 2 * (noise.scales[-1] * left_nm) ** 2
    return float(state.fitted().taken_by_chain(state.dictionary) * left_nm * np.sqrt(needed / max(information, 1.0)))


def _traces(state: State, before: Float, after: Float) -> Traces:
    problem, weight = state.problem, state.problem.samples.weight
    q, dq, _ = problem.kinematics
    measured = (problem.with_chain or problem).samples.y / weight
    return Traces(
        t=problem.samples.t,
        q=q,
        dq=dq,
        cycle=problem.samples.cycle,
        held_out=np.ones(len(q), bool),
        measured=measured,
        before=measured - before / weight,
        after=measured - after / weight,
        along={curve.axis.name: curve.values for curve in problem.curves},
        corner_hz=problem.samples.corner_hz,
    )


def contact_effects(state: State, residual: Float, p_values: Mapping[str, float]) -> tuple[NamedEffect, ...]:
    """Contacts as one effect of the answer, along the time of what the nominal model leaves."""
    problem, X, whole, contacts = state.problem, state.problem.X, state.disturbed, state.contacts
    if whole is None:
        return ()
    coefficients = np.linalg.lstsq(X @ X.T, X @ problem.y, rcond=1e-12)[0]
    left, inside = (whole.y - coefficients @ whole.X) / whole.samples.weight, touched(whole, contacts)
    before, after = (float(np.sqrt(np.mean(one**2))) for one in (left, left[~inside]))
    largest = float(left[inside][np.argmax(np.abs(left[inside]))]) if inside.any() else 0.0
    lengths = [one.stop_s - one.start_s for one in contacts]
    numbers = {"contacts": float(len(contacts)), "first_contact_s": contacts[0].start_s,
               "longest_contact_s": max(lengths), "largest_contact_nm": largest}  # fmt: skip
    size = float(np.sqrt(max(before**2 - after**2, 0.0)))
    return (
        NamedEffect(
            name=ContactEvent.name,
            label=ContactEvent.label,
            parameters={k: Coefficient.around(v) for k, v in numbers.items()},
            axis=ContactEvent.axis,
            gap_before_nm=before,
            gap_after_nm=after,
            torque=np.zeros(len(problem.y)),
            curve=residual_checks.profiles_of(problem, residual, p_values, ContactEvent.axis)[0],
            size_nm=size,
            residual_share=(size / before) ** 2 if before > 0 else 0.0,
            grade="major",
        ),
    )


def contact_trace(state: State) -> ContactTrace | None:
    """What the augmented model leaves over the whole log, samples of contacts included; None without contacts."""
    if not state.contacts:
        return None
    data, samples = state.problem.data, state.problem.samples
    fine = state.fitted().fine_residual
    left = filtered(fine[None], samples.kernel, np.arange(0, len(fine), samples.every))[0]
    seen = (data.moving & data.valid)[:: samples.every]
    return ContactTrace(
        t=data.t[:: samples.every],
        residual_nm=np.where(seen, left, np.nan),
        spans_s=tuple((contact.start_s, contact.stop_s) for contact in state.contacts),
    )
