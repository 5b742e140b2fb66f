"""Diagnosis: its document, its tables for files and pages, and its text."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from friction_audit.diagnosis.data_audit import DataFinding
from friction_audit.diagnosis.result import VERDICTS, JointDiagnosis, NamedEffect, Profile, others_of
from friction_audit.effects.contact_event import EFFECT as CONTACT
from friction_audit.friction.history import Coefficient
from friction_audit.io.tidy_table import TidyTable
from friction_audit.pipeline import Diagnosis
from friction_audit.reporting.diagnosis_words import (
    effect_numbers,
    effect_size,
    energy_disagreements,
    names_of,
    nominal_model,
)
from friction_audit.reporting.documents import NO_OPTIONS, SETTINGS, SOURCE, WARNINGS, settings_document
from friction_audit.reporting.notices import diagnose_notices
from friction_audit.reporting.table import (
    INTERVAL,
    JOINT,
    NAME,
    PEOPLE,
    Column,
    Document,
    Get,
    Record,
    Table,
    Tone,
    joint_column,
    to_json,
)
from friction_audit.reporting.terminal_table import log_line, table_lines
from friction_audit.reporting.words import (
    NOTHING,
    format_p,
    format_torque,
    in_unit,
    joints_label,
)

WORDS: Mapping[str, str] = {verdict: verdict.replace("_", " ") for verdict in VERDICTS}
"""Verdicts in documents and as people read them."""
TONES: Mapping[str, Tone] = {
    "adequate": "fine",
    "named": "alert",
    "ambiguous": "unsure",
    "unexplained": "alert",
    "not testable": "off",
    "data fault": "alert",
    "failed": "alert",
}
FINDING_TONES: Mapping[str, Tone] = {"fine": "fine", "limit": "unsure", "fault": "alert"}
# Above it the held-out cycles alone do not prove an effect.
SIGNIFICANT = 0.05
CURVE = Record(
    (
        Column("centre", [float], "mean of the quantity in each bin"),
        Column("forwards_nm", [float], "mean torque in it while moving forwards", "forwards"),
        Column("backwards_nm", [float], "the same backwards", "backwards"),
        Column("forwards_se_nm", [float], "standard error of the mean", "forwards_se"),
        Column("backwards_se_nm", [float], "the same backwards", "backwards_se"),
    )
)
PROFILE = Record(
    (
        Column("axis", str, "the quantity"),
        Column("label", str, "the quantity with its unit"),
        Column("share", float, "share of the mean square that a curve over it explains"),
        Column("p_value", float, "that nothing depends on it"),
        Column("where", str, "where along it model and measurement disagree"),
        Column("curve", CURVE, "the mean residual, of the first entry", null=True),
    )
)
EVIDENCE = Record(
    (
        Column("name", str, "the effect, or another one in its place"),
        Column("delta_bic", float, "difference in BIC: above 0 it explains less, from 6 on clearly"),
        Column("correlation", float, "of the two torques"),
    )
)


class EffectRow(NamedTuple):
    """An effect of a joint and its place among those of the joint, from 1."""

    joint: JointDiagnosis
    rank: int
    effect: NamedEffect


def named_effects(joints: Iterable[JointDiagnosis]) -> list[EffectRow]:
    """Return the effects of joints, the strongest of each first."""
    return [EffectRow(joint, rank, one) for joint in joints for rank, one in enumerate(joint.effects, start=1)]


def _names(row: EffectRow) -> str:
    return names_of(row.effect, row.joint.effects)


def _steps(joint: JointDiagnosis) -> list[dict[str, Any]]:
    return [{"step": step, "label": label, "rms_nm": rms} for step, (label, rms) in enumerate(joint.ladder)]


def _profiles(profiles: Sequence[Profile]) -> list[dict[str, Any]]:
    """Return what the residual depends on, the strongest first, with the curve of that one."""
    names = ("axis", "label", "share", "p_value", "where")
    return [
        {name: getattr(one, name) for name in names} | {"curve": None if k else one} for k, one in enumerate(profiles)
    ]


def _bins(joint: JointDiagnosis) -> list[dict[str, Any]]:
    names = ("centre", "forwards_nm", "forwards_se_nm", "backwards_nm", "backwards_se_nm")
    every = [("nominal", one) for one in joint.profiles] + [("augmented", one) for one in joint.remaining]
    return [
        {"of": model, "axis": one.axis, "axis_label": one.label, **dict(zip(names, cells, strict=True))}
        for model, one in every
        for cells in zip(one.centre, one.forwards, one.forwards_se, one.backwards, one.backwards_se, strict=True)
    ]


def _findings(joints: Iterable[JointDiagnosis]) -> list[tuple[JointDiagnosis, DataFinding]]:
    return [(joint, finding) for joint in joints for finding in joint.findings]


def _values(row: EffectRow) -> dict[str, float]:
    return {name: number.value for name, number in row.effect.parameters.items()}


def _intervals(row: EffectRow) -> dict[str, tuple[float, float]]:
    return {name: (number.low, number.high) for name, number in row.effect.parameters.items()}


EFFECT = Record(
    (
        joint_column("joint", on="p"),
        Column("rank", int, on="f"),
        Column("effect", str, get="effect.name", on="f"),
        Column("name", str, "name in the catalogue", "effect.name", on="j"),
        Column("effect", str, get=lambda r: f"{_names(r)}: {r.effect.label}", title="effect", on="p"),
        Column("label", str, "in words", "effect.label"),
        Column("alternatives", [str], "indistinguishable effects", "effect.alternatives", on="j"),
        Column("alternatives", str, get=lambda r: " ".join(r.effect.alternatives), on="f"),
        Column("decide", str, "the motion that would distinguish them", "effect.decide", null=True, on="j"),
        Column("parameters", {"*": float}, "values by name with the unit", _values, on="j"),
        Column("parameters_ci95", {"*": INTERVAL}, "their 95 % intervals", _intervals, on="j"),
        Column("p_value", float, "family-wise, on held-out cycles; null of an event", "effect.p_value"),
        Column("gap_before", float, "residual RMS without it", "effect.gap_before_nm", unit="N m"),
        Column("gap_after", float, "residual RMS with it", "effect.gap_after_nm", unit="N m"),
        Column(
            "gap",
            float,
            get="effect",
            form=lambda e: f"{format_torque(e.gap_before_nm)} to {format_torque(e.gap_after_nm)}",
            sort=lambda r: r.effect.gap_before_nm - r.effect.gap_after_nm,
            title="residual RMS",
            unit="N m",
            on="p",
        ),
        Column("p", float, get="effect.p_value", form=format_p, title="p", on="p"),
        Column("where", str, "where it shows, in words", "effect.where", title="where", words=True, on="jfp"),
        Column("decide", str, get="effect.decide", on="f"),
        Column("numbers", str, get=lambda r: effect_numbers(r.effect), title="parameters", on="p"),
        Column("axis", str, "the quantity on which it shows", "effect.axis", on="j"),
        Column("size", float, "RMS of its torque free of the nominal model", "effect.size_nm", unit="N m", on="j"),
        Column("evidence", [EVIDENCE], "the effect and others in its place", "effect.evidence", on="j"),
        Column("curve", CURVE, "mean of what it explains over `axis`", "effect.curve", on="j"),
    ),
    name="effects",
    summary="an effect that the model of a joint misses, the strongest first",
)
PARAMETER = Record(
    (
        Column("effect", str, get="0"),
        Column("parameter", str, get="1"),
        Column("value", float, get="2.value"),
        Column("ci95_low", float, get="2.low"),
        Column("ci95_high", float, get="2.high"),
    ),
    name="effect_parameters",
    summary="a parameter of an effect, with its 95 % interval",
)
DECISION = Record(
    (
        joint_column("joint"),
        Column("effects", str, get=_names, title="effects", on="p"),
        Column("decide", str, get="effect.decide", title="motion", on="p"),
    )
)
COMPETITOR = Record(
    (
        joint_column("0.joint"),
        Column("effect", str, get="0.effect.name", title="effect", on="p"),
        Column("competitor", str, get="1.name", title="competing effect", on="p"),
        Column("delta_bic", float, get="1.delta_bic", form="+.0f", title="difference in BIC", on="p"),
        Column("correlation", float, get="1.correlation", form=".2f", title="correlation", on="p"),
    )
)
UNTESTABLE = Record(
    (
        joint_column("0"),
        Column("effects", str, get=lambda row: ", ".join(row[1]), title="effects", on="p"),
        Column("why", str, get="2", title="why", on="p"),
    )
)
STEP = Record(
    (
        Column("step", int, on="f"),
        Column("label", str, on="f"),
        Column("step", str, "nominal model, each effect, noise floor", "label", on="j"),
        Column("rms", float, "residual RMS", unit="N m"),
    ),
    name="gap_ladder",
    summary="residual RMS after each effect, on held-out cycles",
)
GAP = Record(
    (
        Column("baseline_rms", float, "residual RMS of the nominal model", "before", unit="N m"),
        Column("final_rms", float, "residual RMS of the augmented model", "after", unit="N m"),
        Column("noise_floor_rms", float, "RMS of the noise", "floor", unit="N m"),
        Column("shrink", float, "share explained: of the way from the first to the noise floor"),
        Column("shrink_standard_error", float, "its standard error", "shrink_se"),
        Column("final_over_floor", float, "augmented over noise", "over_floor"),
        Column("held_out_cycles", int, "number of held-out cycles", "cycles"),
    )
)
SIMULATION = Record(
    (
        Column("before", float, "of the nominal model"),
        Column("after", float, "of the augmented model"),
        Column("unit", str, "unit of both"),
    )
)
CHECK = Record(
    (
        Column("code", ("curve", "line", "scatter", "change"), "what the residual holds"),
        Column("along", str, "the quantity, or the effect that changes"),
        Column("share", float, "of the mean square"),
        Column("frequency", float, "of a line: in Hz over time, else in waves per rad", null=True),
    )
)
FINDING = Record(
    (
        joint_column("0"),
        Column("code", str, "stable short name", "1.code", title="check", code=True, on="jp"),
        Column(
            "verdict",
            ("fine", "limit", "fault"),
            "whether it limits the answer",
            "1.verdict",
            title="verdict",
            tone=FINDING_TONES.__getitem__,
            on="jp",
        ),
        Column("value", float, "what was found", "1.value", title="found", on="jp"),
        Column("bound", float, "what it was held against", "1.bound", title="bound", on="jp"),
        Column("unit", str, "its unit", "1.unit", title="unit", on="jp"),
        Column("message", str, "what it means", "1.message", title="what it means", on="jp"),
    )
)


def _augmented(path: str) -> Callable[[JointDiagnosis], float | None]:
    """Return what gets a number of the augmented model, None where no effect was added."""
    one, _, name = path.partition(".")
    return lambda joint: getattr(getattr(joint, one), name, None) if joint.effects else None


def _percent(share: float) -> str:
    return f"{100 * share:.1f}"


def _missing(joint: JointDiagnosis) -> str:
    """Return the effects with their alternatives and sizes, a line each."""
    lines = []
    for effect in joint.effects:
        others = (f"or {other}" for other in others_of(effect, joint.effects))
        lines += [effect.name, *others, f"  {effect_size(effect)}"]
    return "\n".join(lines)


def _torque(name: str, title: str, short: str, get: Get) -> Column:
    return Column(name, float, get=get, unit="N m", title=title, short=short, on=PEOPLE)


JOINT_DIAGNOSIS = Record(
    (
        JOINT,
        NAME,
        joint_column(),
        Column("verdict", VERDICTS, "the answer"),
        Column("verdict", str, form=WORDS.__getitem__, title="verdict", tone=TONES.__getitem__, on=PEOPLE),
        Column("message", str, "the answer in one or two sentences"),
        Column("missing", str, get=_missing, title="missing", on="t"),
        Column(
            "missing",
            str,
            get=lambda joint: " and ".join(names_of(one, joint.effects) for one in joint.effects),
            title="missing",
            on="p",
        ),
        Column("effects", [EFFECT], "the strongest first", lambda joint: named_effects([joint]), on="j"),
        Column("gap", GAP, "residual RMS on held-out cycles; null if nothing was fitted", on="j", null=True),
        Column("gap_before", float, get="gap.before", unit="N m", on="f"),
        Column("gap_after", float, get="gap.after", unit="N m", on="f"),
        Column("noise_floor", float, get="gap.floor", unit="N m", on="f"),
        Column("shrink", float, get="gap.shrink", on="f"),
        Column("held_out_cycles", int, get="gap.cycles", on="f"),
        _torque("before", "baseline RMS", "RMS\nbefore", "gap.before"),
        _torque("after", "augmented RMS", "RMS\nafter", _augmented("gap.after")),
        _torque("floor", "noise floor", "noise\nfloor", "gap.floor"),
        Column(
            "shrink",
            float,
            get=_augmented("gap.shrink"),
            form=_percent,
            unit="%",
            title="share explained",
            short="expl.",
            on=PEOPLE,
        ),
        Column("held_out_cycles", int, get="gap.cycles", title="held-out cycles", on="p"),
        Column("simulation_gap", SIMULATION, "forward-simulation velocity error", "simulation", on="j", null=True),
        Column(
            "simulation_gap_before",
            float,
            get="simulation.before",
            unit="rad/s",
            title="velocity error: nominal",
            on="fp",
        ),
        Column("simulation_gap_after", float, get="simulation.after", unit="rad/s", on="f"),
        Column(
            "simulation_gap_after", float, get=_augmented("simulation.after"), unit="rad/s", title="augmented", on="p"
        ),
        Column(
            "detection_limit",
            float,
            "RMS that is detected with 90 % power",
            unit="N m",
            form=".2g",
            title="detection limit",
            on="jfp",
        ),
        Column("omnibus_p_value", float, "that nothing is missing from the nominal model", "omnibus_p"),
        Column("remaining_p_value", float, "that nothing is missing from the augmented model", "remaining_p"),
        Column("nominal", {"*": Coefficient}, "coefficients of the nominal model, fitted alone", on="j"),
        Column("augmented", {"*": Coefficient}, "the same fitted with the effects", on="j"),
        Column("disagreements", [str], "where energy method and torque fit differ", energy_disagreements, on="j"),
        Column("from_energy", {"*": Coefficient}, "the coefficients of `estimate`", on="j"),
        Column("ladder", [STEP], "residual RMS after each effect", _steps, on="j"),
        Column(
            "profiles",
            [PROFILE],
            "what the residual depends on, the strongest first",
            lambda joint: _profiles(joint.profiles),
            on="j",
        ),
        Column(
            "remaining", [PROFILE], "the same of the augmented model", lambda joint: _profiles(joint.remaining), on="j"
        ),
        Column("checks", [CHECK], "structures in what the augmented model leaves", on="j"),
        Column("untestable", {"*": str}, "effects that this log cannot show, with the motion that it lacks", on="j"),
        Column("findings", [FINDING], "the audit of the data", lambda joint: _findings([joint]), on="j"),
    ),
    name="verdicts",
    summary="verdict and residual RMS of a joint",
)
BIN = Record(
    (
        Column("of", str),
        Column("axis", str),
        Column("axis_label", str),
        Column("centre"),
        Column("forwards", unit="N m"),
        Column("forwards_se", unit="N m"),
        Column("backwards", unit="N m"),
        Column("backwards_se", unit="N m"),
    ),
    name="residual_profiles",
    summary="mean residual in a bin of one quantity",
)
RESIDUAL = Record(
    (
        Column("time", get="t", unit="s"),
        Column("cycle", int, get=lambda traces: traces.cycle + 1),
        Column("held_out", bool),
        Column("q", get="q", unit="rad"),
        Column("dq", get="dq", unit="rad/s"),
        Column("measured", get="measured", unit="N m"),
        Column("nominal", get="before", unit="N m"),
        Column("augmented", get="after", unit="N m"),
        Column("residual_before", get=lambda traces: traces.measured - traces.before, unit="N m"),
        Column("residual_after", get=lambda traces: traces.measured - traces.after, unit="N m"),
    ),
    name="residual",
    summary="torque of a joint: measured, of the nominal and of the augmented model, low-passed alike",
    time="time_s",
    arrays=True,
)
# The gaps between the cycles that were simulated are no rows.
SIMULATED = Record(
    (
        Column("time", get=lambda gap: gap.t[np.isfinite(gap.t)], unit="s"),
        Column("dq_measured", get=lambda gap: gap.measured[np.isfinite(gap.t)], unit="rad/s"),
        Column("dq_nominal", get=lambda gap: gap.nominal[np.isfinite(gap.t)], unit="rad/s"),
        Column("dq_augmented", get=lambda gap: gap.augmented[np.isfinite(gap.t)], unit="rad/s"),
    ),
    name="simulated_motion",
    summary="velocity of a joint measured and simulated, on held-out cycles",
    time="time_s",
    arrays=True,
)
DIAGNOSE: Document = Document(
    "diagnose",
    2,
    "Which effects the model of each joint misses, and how much of the residual they explain",
    Record((SOURCE, SETTINGS, WARNINGS, Column("joints", [JOINT_DIAGNOSIS], "per joint"))),
)


def diagnose_document(found: Diagnosis, reading: Mapping[str, object] = NO_OPTIONS) -> dict[str, Any]:
    """Return the document of a diagnosis.

    Args:
        found: The result.
        reading: How the log was read: options of the reader by name.
    """
    return DIAGNOSE.json(
        {
            "source": found.estimate.log,
            "settings": settings_document(found.estimate, reading) | {"diagnosis": to_json(found.settings)},
            "warnings": diagnose_notices(found),
            "joints": found.discrepancy.joints,
        },
        found.estimate.log.source.torque_unit,
    )


def diagnose_tables(found: Diagnosis) -> tuple[TidyTable, ...]:
    """Return the tables of a diagnosis for files."""
    joints, unit = found.discrepancy.joints, found.estimate.log.source.torque_unit
    rows: tuple[tuple[Record, Callable[[JointDiagnosis], Any]], ...] = (
        (JOINT_DIAGNOSIS, lambda joint: [joint]),
        (EFFECT, lambda joint: named_effects([joint])),
        (
            PARAMETER,
            lambda joint: [(e.name, name, value) for e in joint.effects for name, value in e.parameters.items()],
        ),
        (STEP, _steps),
        (BIN, _bins),
        (RESIDUAL, lambda joint: joint.traces),
        (SIMULATED, lambda joint: joint.simulation),
    )
    return tuple(record.file(((one.joint, one.name, of(one)) for one in joints), unit) for record, of in rows)


def page_tables(found: Diagnosis) -> tuple[Table, ...]:
    """Return the tables of a diagnosis for the page that have rows."""
    joints, unit = found.discrepancy.joints, found.estimate.log.source.torque_unit
    effects = named_effects(joints)
    competitors = [(row, one) for row in effects for one in row.effect.evidence if one.name != row.effect.name]
    tables = (
        JOINT_DIAGNOSIS.people(joints, caption="Residual of the model on held-out cycles (RMS)", unit=unit).filled(),
        EFFECT.people(
            effects, caption="Missing effects, the strongest of a joint first; intervals are 95 %", unit=unit
        ),
        DECISION.people(
            [row for row in effects if row.effect.decide],
            caption="What to record to distinguish effects that this log does not",
        ),
        COMPETITOR.people(
            competitors,
            caption="Competing effects in the place of each effect: above zero they explain less, from 6 on clearly",
            folded=True,
        ),
        UNTESTABLE.people(
            _untestable(joints), caption="Effects that this log cannot show, and why", folded=True, unit=unit
        ),
    )
    return tuple(table for table in tables if table.rows)


def data_tables(found: Diagnosis | None) -> tuple[Table, ...]:
    """Return the audit of the data for the page: what is not fine, and all of it."""
    rows = _findings(() if found is None else found.discrepancy.joints)
    bad = [row for row in rows if row[1].verdict != "fine"]
    tables = (
        FINDING.people(bad, caption="Limits and faults of the data"),
        FINDING.people(rows, caption="Every check of the data", folded=True),
    )
    return tuple(table for table in tables if table.rows)


def _untestable(joints: Iterable[JointDiagnosis]) -> Iterator[tuple[JointDiagnosis, list[str], str]]:
    """Yield joint, effects that its log cannot show, and why: effects with the same reason together."""
    for joint in joints:
        reasons: dict[str, list[str]] = {}
        for name, reason in joint.untestable.items():
            reasons.setdefault(reason, []).append(name)
        yield from ((joint, names, reason) for reason, names in reasons.items())


def diagnose_lines(found: Diagnosis, *, verbose: bool = False) -> list[str]:
    """Return what was asked, a row per joint, and the answer of each.

    Args:
        found: The result.
        verbose: If True, also the competing effects and what the log cannot show.
    """
    log, joints = found.estimate.log, found.discrepancy.joints
    counts = [joint.gap.cycles for joint in joints if joint.gap is not None]
    span = " to ".join(map(str, sorted({min(counts), max(counts)}))) if counts else ""
    lines = [
        log_line(log),
        f"interaction torque: {found.estimate.interaction.choice.formula}",
        f"nominal model: {nominal_model(found.settings.model)}",
        f"residual RMS on held-out cycles{f' ({span} per joint)' if span else ''}; intervals are 95 %",
        *table_lines(JOINT_DIAGNOSIS.people(joints, "t", unit=log.source.torque_unit)),
    ]
    for alike in _alike(joints, together=not verbose):
        sentences = [*_sentences(alike), *(f"  {line}" for line in (_details(alike[0]) if verbose else ()))]
        lines += [in_unit(line, log.source.torque_unit) for line in sentences]
    return lines


def _alike(joints: Sequence[JointDiagnosis], *, together: bool) -> list[list[JointDiagnosis]]:
    """Return the joints, those with the same answer together."""
    groups: dict[object, list[JointDiagnosis]] = {}
    for joint in joints:
        alone = joint.effects or joint.simulation is not None or not together
        groups.setdefault(joint.joint if alone else joint.message, []).append(joint)
    return list(groups.values())


def _sentences(joints: Sequence[JointDiagnosis]) -> Iterator[str]:
    """Yield the message of joints with the same answer, each effect in numbers, the simulated motion."""
    first = joints[0]
    yield f"{joints_label(joint.joint for joint in joints)}: {first.message}"
    for effect in first.effects:
        p = format_p(effect.p_value)
        p = "" if p == NOTHING else f"p {p}" if p.startswith("<") else f"p = {p}"
        if effect.p_value > SIGNIFICANT:
            p += " on held-out cycles; significant on all cycles"
        gap = f"residual RMS {format_torque(effect.gap_before_nm)} -> {format_torque(effect.gap_after_nm)} N m"
        if effect.name == CONTACT.name:
            gap += " without the samples of the contacts, which are left out of all else here"
        yield f"  {effect.name}: {'; '.join(text for text in (effect_numbers(effect), gap, p) if text)}"
        if effect.where not in first.message:
            yield f"    where: {effect.where}"
        if effect.decide:
            yield f"    to decide: {effect.decide}"
    if (error := first.simulation) is not None:
        yield f"  forward-simulation velocity error {error.before:.3g} -> {error.after:.3g} {error.unit} RMS"


def _details(joint: JointDiagnosis) -> Iterator[str]:
    for row in named_effects([joint]):
        for one in row.effect.evidence:
            if one.name != row.effect.name:
                scores = f"BIC {one.delta_bic:+.0f}, correlation {one.correlation:.2f}"
                yield f"{one.name} in place of {row.effect.name}: {scores}"
    if joint.effects and not math.isnan(joint.detection_limit_nm):
        yield f"detection limit for other effects: {joint.detection_limit_nm:.2g} N m RMS"
    yield from (f"this log cannot show {', '.join(names)}: {reason}" for _, names, reason in _untestable([joint]))
