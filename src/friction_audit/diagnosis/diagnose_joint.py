"""One joint: is anything missing, what, and how far does the gap close."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from friction_audit.diagnosis.against_energy import differences_from_energy
from friction_audit.diagnosis.constancy import find_inconstant
from friction_audit.diagnosis.contacts import (
    Undisturbed,
    contact_trace,
    contacts_beside,
    leave_out_contacts,
    without_contacts,
)
from friction_audit.diagnosis.cross_products import CrossProducts
from friction_audit.diagnosis.data_audit import DataFinding, faults
from friction_audit.diagnosis.declared import coefficients
from friction_audit.diagnosis.floor import noise_floor
from friction_audit.diagnosis.forward_gap import gap_in_motion
from friction_audit.diagnosis.gap import Gap, measure_gap
from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.library import Library, build_library, prewhitened_library, without
from friction_audit.diagnosis.motion_noise import noise_in_columns
from friction_audit.diagnosis.naming import (
    Names,
    find_names,
    search_library,
    unknowns,
    with_moments_of_all_cycles,
    worth,
)
from friction_audit.diagnosis.omnibus import MIN_SPARE_CYCLES, Omnibus, even_weights, omnibus_test
from friction_audit.diagnosis.outdone import find_outdone, what_speaks
from friction_audit.diagnosis.parameters import Parameters, parameters_of
from friction_audit.diagnosis.profiles import profile_all
from friction_audit.diagnosis.restless import find_restless
from friction_audit.diagnosis.result import Effect as NamedEffect
from friction_audit.diagnosis.result import JointDiscrepancy, Profile, Traces, Verdict
from friction_audit.diagnosis.ringing import find_ringing, rings
from friction_audit.diagnosis.ripple_scan import with_scanned_orders
from friction_audit.diagnosis.rows import make_rows
from friction_audit.diagnosis.sampling_delay import put_on_time
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.diagnosis.shown_along import with_own_axes
from friction_audit.diagnosis.slow_noise import news_of, prewhitened, slow_noise, told_by_both
from friction_audit.diagnosis.tell import contact_effects, effects_of, message_of
from friction_audit.effects.contact_event import EFFECT as CONTACT
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import JointData, strokes
from friction_audit.effects.joint_model import JointModel
from friction_audit.errors import AnalysisError
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

FEWEST_CYCLES = 6
MORE_MOTION = "move the joint back and forth, or count slower strokes with --thresholds auto"
FEWEST_CLUSTERS = 12
"""Independent parts of the working cycles, below which nothing can be tested."""
CLUSTERS_PER_COLUMN = 3
"""A candidate that has more columns than a third of the independent cycles proves nothing."""
POWER_Z = 1.28
"""Normal quantile of 90 % power."""
OVER_FLOOR = 1.05
"""A grown model that leaves more than so many times the floor does not explain the joint."""
LEAST_OVER_FLOOR = 1.02
"""A declared model that leaves less than so many times the floor, a fifth of the noise, misses nothing worth a word."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Subject:
    """A joint to diagnose.

    Attributes:
        data: The joint on the fine grid.
        number: Number for people.
        name: Its name.
        findings: What the audit of its data found.
        from_energy: What the energy method says of it.
        model: Its declared model, None for the simple one.
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


def diagnose_joint(subject: Subject, candidates: Sequence[Effect], settings: DiagnosisSettings) -> JointDiscrepancy:
    """Say whether anything is missing in the declared model of a joint, and what.

    Args:
        subject: The joint.
        candidates: Effects that may be named.
        settings: Error probability and seed.
    """
    wrong = faults(subject.findings)
    if wrong:
        return _unanswered(subject, "data_fault", "; ".join(finding.message for finding in wrong))
    cycles = len(np.unique(make_rows(subject.data).cycle))
    if cycles < FEWEST_CYCLES:
        lacking = subject.lacking or MORE_MOTION
        return _unanswered(
            subject,
            "not_testable",
            f"{cycles} energy cycles with motion; at least {FEWEST_CYCLES} are needed: {lacking}",
        )
    ground = make_ground(subject.data, subject.model, settings.seed)
    clusters = len(np.unique(ground.clusters(ground.working).number))
    if clusters < FEWEST_CLUSTERS:
        return _unanswered(
            subject,
            "not_testable",
            f"{cycles} energy cycles with motion, worth {clusters} independent ones where {FEWEST_CLUSTERS} are needed "
            "beside those locked away: move the joint back and forth for longer",
        )
    try:
        found = _judge(subject, ground, candidates, settings)
    except AnalysisError as error:
        # What one joint lacks must not take the answer away from the others.
        return _unanswered(subject, "not_testable", str(error))
    locked = np.unique(ground.rows.cycle[ground.locked])
    known = subject.known_inertia_kg_m2
    motion = gap_in_motion(found, subject.model, subject.data, locked, known_inertia_kg_m2=known)
    return with_own_axes(replace(found, simulation=motion))


def _unanswered(subject: Subject, verdict: Verdict, message: str) -> JointDiscrepancy:
    return JointDiscrepancy(
        joint=subject.number,
        name=subject.name,
        verdict=verdict,
        message=message,
        from_energy=subject.from_energy,
        findings=subject.findings,
    )


def _judge(
    subject: Subject, ground: Ground, candidates: Sequence[Effect], settings: DiagnosisSettings
) -> JointDiscrepancy:
    rng = np.random.default_rng(settings.seed)
    library = build_library(candidates, ground.data, ground.baseline(), ground.rows)
    undisturbed = leave_out_contacts(ground, library)
    first, names = _named(undisturbed, candidates, settings, rng)
    if undisturbed.contacts and names.found:
        contacts = contacts_beside(ground, undisturbed, names)
        if len(contacts) < len(undisturbed.contacts):
            undisturbed = without_contacts(ground, without(library, CONTACT.name), contacts)
            first, names = _named(undisturbed, candidates, settings, rng)
    events = contact_effects(ground, undisturbed)
    ground = undisturbed.ground
    if (on_time := put_on_time(ground, names)) is not None:
        subject = replace(subject, data=on_time.data, findings=(*subject.findings, on_time.finding))
        return _judge(subject, make_ground(on_time.data, subject.model, settings.seed), candidates, settings)
    if not events and (ringing := find_ringing(ground, names, settings.alpha, rng)) is not None:
        names, events = ringing.names, (ringing.effect,)
    last = _test(ground, names, rng) if names.found else first
    found = _told(subject, ground, names, events, (first, last), settings.alpha, rng)
    return replace(found, contacts=contact_trace(found, undisturbed.contacts, subject.data, subject.model))


def _named(
    undisturbed: Undisturbed, candidates: Sequence[Effect], settings: DiagnosisSettings, rng: np.random.Generator
) -> tuple[Omnibus, Names]:
    """Whether anything is missing, and what; once more where noise is slow, for names that it had hidden."""
    first, names = _searched(undisturbed, candidates, settings, rng)
    ground = undisturbed.ground
    noise = slow_noise(ground, [f.columns for f in names.found])
    if noise is None:
        return first, names
    news = news_of(ground, noise)
    library = prewhitened_library(undisturbed.library, news)
    fast = replace(undisturbed, ground=prewhitened(ground, news), library=library)
    first, again = _searched(fast, candidates, settings, rng)
    return first, told_by_both(ground, undisturbed.library, names, again)


def _searched(
    undisturbed: Undisturbed, candidates: Sequence[Effect], settings: DiagnosisSettings, rng: np.random.Generator
) -> tuple[Omnibus, Names]:
    """Whether anything is missing, and what."""
    ground = undisturbed.ground
    names = Names(found=(), library=undisturbed.library, baseline=ground.baseline())
    first = _test(ground, names, rng)
    library = with_scanned_orders(ground, names.library)
    searched = search_library(ground, library)
    # What happens in a few cycles only, as a late step or a slow drift, may be plain and yet not significant with
    # random signs per cycle.
    rejected = first.p_value <= settings.alpha
    if library.entries and (rejected or searched[1].chosen):
        names = find_names(ground, candidates, library, settings.alpha, rng, searched, rejected=rejected)
    if rejected and names.disproved:
        names = _without_disproved(ground, candidates, library, searched[0], names, settings, rng)
    return first, names


def _without_disproved(
    ground: Ground,
    candidates: Sequence[Effect],
    library: Library,
    earlier: CrossProducts,
    names: Names,
    settings: DiagnosisSettings,
    rng: np.random.Generator,
) -> Names:
    """The names of a search without what did not hold, where anything is still missing and more speaks for those.

    What stood in for the truth on the working cycles kept it out. The products of the search before it hold all that
    this one needs.
    """
    if names.found and _test(ground, names, rng).p_value > settings.alpha:
        return names
    for name in names.disproved:
        library = without(library, name)
    searched = search_library(ground, library, earlier)
    again = find_names(ground, candidates, library, settings.alpha, rng, searched)
    both = ([f.columns for f in one.found] for one in (names, again))
    worth_of_all = len(ground.y) / ground.memory(*(f.columns for f in again.found))
    first, second = (
        what_speaks(ground, columns, unknowns(one), worth_of_all)
        for columns, one in zip(both, (names, again), strict=True)
    )
    return again if second > first else names


def _told(
    subject: Subject,
    ground: Ground,
    names: Names,
    events: tuple[NamedEffect, ...],
    tests: tuple[Omnibus, Omnibus],
    alpha: float,
    rng: np.random.Generator,
) -> JointDiscrepancy:
    """Everything that is to be said, from what was found and the tests without and with it."""
    columns = [f.columns for f in names.found]
    left = ground.residual(), ground.residual(*columns)
    gap = _gap(ground, left, noise_floor(ground, ground.curves, *columns))
    before = _profiles(ground, left[0], tests[0])
    after = _profiles(ground, left[1], tests[1]) if columns else before
    told = with_moments_of_all_cycles(ground, names)
    numbers = parameters_of(ground, told, names.baseline)
    effects = (*events, *effects_of(ground, names, ground.curves, numbers))
    factors = coefficients(ground.base, ground.y, ground.rows.cycle)
    declared = dict(zip(ground.declared.names, factors, strict=True))
    # A step whose moment lies in a locked cycle is put where all cycles have it: else a stroke there seems to scatter.
    grown, fine = [f.columns for f in told], [f.candidate.regressor(ground.data, names.baseline, f.shape) for f in told]
    over = OVER_FLOOR if names.found else LEAST_OVER_FLOOR
    restless = find_restless(ground, grown, fine, over, lambda shake: rings(_as_told(names, numbers), events, shake))
    limit = _detection_limit(ground, names, gap, alpha)
    doubts = _doubts(ground, names, rng)
    open_end = restless.decides or bool(doubts)
    verdict = _verdict(names, tests[0], gap, alpha, touched=bool(events), open_end=open_end)
    return JointDiscrepancy(
        joint=subject.number,
        name=subject.name,
        verdict=verdict,
        message=message_of(
            verdict,
            effects,
            after,
            (*doubts, *restless.phrases),
            limit,
            tests[0].p_value <= alpha,
            names.library.untestable,
        ),
        effects=effects,
        declared=declared,
        grown=numbers.declared,
        from_energy=subject.from_energy,
        disagreements=differences_from_energy(declared, subject.from_energy),
        gap=gap,
        ladder=_ladder(gap, effects),
        omnibus_p=tests[0].p_value,
        remaining_p=tests[1].p_value,
        detection_limit_nm=limit,
        profiles=before,
        remaining=after,
        vibration=restless.vibration,
        scatter_nm=None if restless.scatter is None else restless.scatter.rms_nm,
        untestable=_not_shown(names),
        findings=subject.findings,
        traces=_traces(ground, left),
    )


def _not_shown(names: Names) -> dict[str, str]:
    """Why the log cannot show an effect, by name: of those that were not found even so."""
    found = {f.candidate.name for f in names.found}
    return {name: why for name, why in names.library.untestable.items() if name not in found}


def _gap(ground: Ground, left: tuple[Float, Float], floor: float) -> Gap:
    """What is left of the locked cycles without and with what was found, and the noise."""
    before, after = (one[ground.locked] for one in left)
    return measure_gap(before, after, floor, ground.rows.cycle[ground.locked])


def _profiles(ground: Ground, left: Float, test: Omnibus) -> tuple[Profile, ...]:
    """What a residual depends on."""
    speed = ground.data.dq[:: ground.rows.every][ground.rows.used]
    return profile_all(left, ground.curves, speed, ground.rows.cycle, test)


def _as_told(names: Names, numbers: Parameters) -> Names:
    """The names with those shapes that a reader is told."""
    shapes = [
        {name: told[name].value if name in told else value for name, value in f.shape.items()}
        for f, told in zip(names.found, numbers.effects, strict=True)
    ]
    return replace(names, found=tuple(replace(f, shape=one) for f, one in zip(names.found, shapes, strict=True)))


def _doubts(ground: Ground, names: Names, rng: np.random.Generator) -> tuple[str, ...]:
    """Why names that fit may stand in for something else, a phrase each.

    What a model does not get right is much the same all through a cycle, however many independent samples of noise that
    holds: as many numbers as cycles fit whatever it is.
    """
    fitted, cycles = unknowns(names), len(np.unique(ground.rows.cycle))
    crowded = f"{fitted} numbers were fitted to {cycles} cycles, so that names may stand in for something else"
    alone = (f for f in names.found if not f.naming.alternatives)
    noise = [noise_in_columns(ground, f.candidate, names.baseline, f.shape, rng) for f in names.found]
    outdone = find_outdone(ground, [f.columns for f in names.found], fitted, _axes(names))
    return (
        *([crowded] if fitted > cycles else []),
        *([outdone] if outdone else []),
        *(why for f in alone if (why := f.candidate.stands_in(ground.data, f.shape))),
        *find_inconstant(ground, [(f.candidate.name, f.columns) for f in names.found], noise),
    )


def _axes(names: Names) -> set[str]:
    """Quantities on which what was named shows itself, or what it may be instead."""
    axes = {entry.candidate.name: entry.candidate.axis for entry in names.library.entries}
    others = (name for f in names.found for name in f.naming.alternatives)
    return {f.candidate.axis for f in names.found} | {axes[name] for name in others if name in axes}


def _test(ground: Ground, names: Names, rng: np.random.Generator) -> Omnibus:
    """Whether anything is missing beside what was found, which enters as the torque that was fitted."""
    effects = [f.columns for f in names.found]
    w = ground.working
    left = ground.residual(*effects)
    torque = (ground.residual() - left)[:, None] if effects else np.zeros((len(left), 0))
    found = ground.clusters(w, *effects)
    cluster = found.number
    named = {f.candidate.name for f in names.found}
    catalogue = [entry.group for entry in names.library.entries if entry.group.name not in named]
    groups = [*catalogue, *(curve.group for curve in ground.curves), ground.surface]
    clusters, base = len(np.unique(cluster)), ground.base.shape[1] + torque.shape[1]
    widest = min(clusters // CLUSTERS_PER_COLUMN, clusters - base - MIN_SPARE_CYCLES)
    fitting = [narrow for group in groups if (narrow := group.narrow(widest)) is not None]
    even = even_weights(left[w], cluster, len(np.unique(ground.rows.cycle[w])))
    return omnibus_test(
        ground.y[w],
        np.hstack([ground.base, torque])[w],
        fitting,
        cluster,
        rng,
        remember=found.remember,
        weight=even,
        at=np.flatnonzero(w),
    )


def _verdict(names: Names, first: Omnibus, gap: Gap, alpha: float, *, touched: bool, open_end: bool) -> Verdict:
    """The one word; ``open_end`` where something shakes or scatters following no motion, or a name only stands in."""
    if not names.library.entries:
        return "not_testable"
    if open_end:
        return "unexplained"
    if not names.found:
        missing = gap.before > (LEAST_OVER_FLOOR if first.p_value <= alpha else OVER_FLOOR) * gap.floor
        return "unexplained" if missing else ("named" if touched else "adequate")
    if gap.over_floor > OVER_FLOOR:
        return "unexplained"
    return "ambiguous" if any(f.naming.alternatives for f in names.found) else "named"


def _detection_limit(ground: Ground, names: Names, gap: Gap, alpha: float) -> float:
    """Root mean square of an effect, free of the declared model, that would have been seen with 90 % power."""
    from scipy.special import ndtri

    tried = max(sum(len(entry.shapes) for entry in names.library.entries), 1)
    needed = (float(ndtri(1.0 - alpha / (2 * tried))) + POWER_Z) ** 2
    return float(gap.after * np.sqrt(needed / worth(ground, *(f.columns for f in names.found))))


def _ladder(gap: Gap, effects: Sequence[NamedEffect]) -> tuple[tuple[str, float], ...]:
    first = effects[0].gap_before_nm if effects else gap.before
    steps = [("declared model", first), *((f"+ {effect.name}", effect.gap_after_nm) for effect in effects)]
    return (*steps, ("floor of the noise", gap.floor))


def _traces(ground: Ground, left: tuple[Float, Float]) -> Traces:
    every, used = ground.rows.every, ground.rows.used
    displacement, weight = strokes(ground.data).displacement, ground.rows.weight
    return Traces(
        t=ground.rows.t,
        q=ground.data.q[::every][used],
        dq=ground.data.dq[::every][used],
        displacement=displacement[::every][used],
        cycle=ground.rows.cycle,
        held_out=ground.locked,
        measured=ground.rows.y / weight,
        before=(ground.rows.y - left[0]) / weight,
        after=(ground.rows.y - left[1]) / weight,
        along={curve.axis.name: curve.values for curve in ground.curves},
        corner_hz=ground.rows.corner_hz,
    )
