"""Diagnosis: its document, its tables for files and pages, and its text on the terminal."""

from collections.abc import Iterator

import numpy as np

from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.effects.registry import effect_of, motion_to_decide
from friction_audit.joint_log import Float
from friction_audit.pipeline import Diagnosis
from friction_audit.reporting import diagnosis_tables as tables, diagnosis_words as words
from friction_audit.reporting.documents import ResultDocument
from friction_audit.reporting.notices import SENTENCE_END, diagnose_notices, log_line, physics_of, text_of
from friction_audit.reporting.table import Column, Record, to_json
from friction_audit.reporting.words import format_share, in_unit, joints_label, range_of

LONGEST = 225  # characters of a line about an effect without its joint; what is longer is for ``-v``
BIN = Record(
    Column("of", str, get="0"),
    Column("axis", str, get="1.axis"),
    Column("axis_label", str, get="1.label"),
    Column("centre", get="2.0"),
    Column("forwards", get="2.1", unit="N m"),
    Column("forwards_se", get="2.2", unit="N m"),
    Column("backwards", get="2.3", unit="N m"),
    Column("backwards_se", get="2.4", unit="N m"),
    name="residual_profiles",
    summary="mean residual in a bin of one quantity",
)
RESIDUAL = Record(
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
    name="residual",
    summary="torque of a joint: measured, of the nominal and of the augmented model, low-passed alike",
    over="time_s",
)
SIMULATED = Record(
    Column("time", get="t", unit="s"),
    Column("dq_measured", get="measured", unit="rad/s"),
    Column("dq_nominal", get="nominal", unit="rad/s"),
    Column("dq_augmented", get="augmented", unit="rad/s"),
    name="simulated_motion",
    summary="velocity of a joint measured and simulated, on held-out cycles",
    over="time_s",
)
DIAGNOSE: ResultDocument = ResultDocument(
    "diagnose/3",
    "Which effects the model of each joint misses, and how much of the residual they explain",
    Column("joints", [tables.JOINT_DIAGNOSIS], "per joint", lambda found: found.joints),
    notices=diagnose_notices,
    settings=lambda found: {"diagnosis": to_json(found.settings)},
    files=(
        (tables.JOINT_DIAGNOSIS, lambda _, joint: [joint]),
        (tables.EFFECT, lambda _, joint: tables.effect_rows([joint])),
        (tables.NEGLIGIBLE, lambda _, joint: tables.effect_rows([joint], "negligible")),
        (tables.PARAMETER, lambda _, joint: [
            (row.effect.name, *one) for row in tables.effect_rows([joint]) for one in row.known.items()
        ]),
        (tables.CHECK, lambda _, joint: joint.checks),
        (tables.STEP, lambda _, joint: list(enumerate(joint.ladder))),
        (BIN, lambda _, joint: [
            (model, one, cells)
            for model, profiles in (("nominal", joint.profiles), ("augmented", joint.remaining))
            for one in profiles
            for cells in zip(one.centre, one.forwards, one.forwards_se, one.backwards, one.backwards_se, strict=True)
        ]),
        (RESIDUAL, lambda _, joint: joint.traces),
        (SIMULATED, lambda _, joint: _simulated(joint)),
    ),
)  # fmt: skip


def _simulated(joint: JointDiagnosis) -> dict[str, Float] | None:
    """Return the signals of the cycles that were simulated, without the gaps between them."""
    if (gap := joint.simulation) is None:
        return None
    there = np.isfinite(gap.t)
    return {name: getattr(gap, name)[there] for name in ("t", "measured", "nominal", "augmented")}


def diagnose_lines(found: Diagnosis, *, verbose: bool = False) -> list[str]:
    """Return a row and a sentence per joint, then the effects in numbers; with ``verbose`` also what competes."""
    log, joints = found.estimate.log, found.joints
    unit = log.source.torque_unit
    marked, physics = physics_of(diagnose_notices(found), joints)
    counts = [joint.gap.cycles for joint in joints if joint.gap is not None]
    span = range_of(counts, str) if counts else "0"
    lines = [
        log_line(log),
        f"interaction torque: {found.estimate.interaction.choice.formula}",
        f"nominal model: {words.nominal_model(found.settings.model)}",
        f"residual RMS on held-out cycles: {span} per joint, each held out once; intervals are 95 %",
        *tables.JOINT_DIAGNOSIS.people(joints, "t", unit=unit).filled().lines(marked),
        *physics,
    ]
    details: list[str] = []
    groups: dict[object, list[JointDiagnosis]] = {}
    for joint in joints:
        answer = SENTENCE_END.split(text_of(joint.reason))[0]
        groups.setdefault(answer if answer and not verbose else joint.joint, []).append(joint)
    for answer, alike in groups.items():
        numbers, joint = joints_label(joint.joint for joint in alike), alike[0]
        message = answer if isinstance(answer, str) else words.joint_message(joint)
        lines.append(in_unit(f"{numbers}: {message}", unit))
        more = [*_details(joint, verbose=verbose), *(_competing(joint) if verbose else ())]
        details += [in_unit(f"{numbers}, {line}", unit) for line in more]
    if effects := tables.effect_rows(joints):
        lines += ["", *tables.EFFECT.people(effects, "t", unit=unit).lines()]
    return lines + details


def _details(joint: JointDiagnosis, *, verbose: bool) -> Iterator[str]:
    """Yield each effect in numbers, the negligible effects, and what the residual still holds."""
    for effect in joint.effects:
        numbers = words.effect_numbers(effect, np.inf if verbose else words.MOST_NUMBERS)
        short = f"{len(effect.parameters)} parameters, shown with -v"
        texts = ("; ".join(filter(None, (numbers, words.where_effect(effect, joint)))), numbers, short)
        head = f"{effect.name} ({effect.label}): "
        yield head + next(one for one in texts if verbose or len(head + one) <= LONGEST or one is short)
        if recorder := effect_of(effect.name).recorder:
            yield f"{effect.name}: {recorder}"
    if joint.verdict != "adequate" and (lost := words.lost_in_noise(joint)):
        yield lost
    if joint.simulation is not None and joint.simulation.after > joint.simulation.before:
        yield "the simulated motion is worse with the effects: without feedback, small errors of torque add up"
    if joint.negligible:
        yield f"negligible: {words.negligible_words(joint)}"
    if joint.checks:
        left = words.remainder_words(joint, most=None if verbose else 2)
        yield f"{format_share(joint.remainder_share)} of the residual is unexplained: {left}"


def _competing(joint: JointDiagnosis) -> Iterator[str]:
    """Yield the motions that decide, what competes with each effect, and what the log cannot show."""
    for effect in joint.effects:
        if effect.alternatives:
            yield f"to decide on {effect.name}: {motion_to_decide(effect.name, effect.alternatives)}"
        for one in effect.evidence:
            scores = f"2 ln BF {one.two_ln_bayes_factor:+.0f}, correlation {one.correlation:.2f}"
            yield f"{one.name} in place of {effect.name}: {scores}"
    if joint.effects and not np.isnan(joint.detection_limit_nm):
        yield f"detection limit for other effects: {joint.detection_limit_nm:.2g} N m rms"
    yield from (f"this log cannot show {', '.join(names)}: {why}" for _, names, why in tables.untestable_rows(joint))
