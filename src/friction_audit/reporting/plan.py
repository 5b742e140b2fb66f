"""The next recording: its document and its text."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from friction_audit.diagnosis.result import VERDICTS
from friction_audit.friction.history import Coefficient
from friction_audit.planning.plan import Answer, JointPlan
from friction_audit.planning.task import Task
from friction_audit.reporting.documents import WARNINGS
from friction_audit.reporting.drift_words import NAMES, UNITS
from friction_audit.reporting.notices import Notice, notice
from friction_audit.reporting.table import Column, Document, Record
from friction_audit.reporting.words import joint_label, joints_label, with_unit

PURPOSES = {"decide": "to decide between", "diagnose": "to diagnose", "estimate": "to estimate friction"}


class Recording(NamedTuple):
    """The motions of one recording, one joint after the other, and where its trajectory was written."""

    purpose: str
    plans: tuple[JointPlan, ...]
    files: tuple[str, ...]


MOST_NAMES = 2  # in a line of the table; the document has all


def _answer(answer: Answer) -> str:
    names = list({frozenset(one): " or ".join(one) for one in answer.sets}.values())
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return ": ".join(filter(None, (answer.verdict.replace("_", " "), " and ".join(names[:MOST_NAMES]) + more)))


STROKE = Record(
    Column("way", float, "signed", "displacement_rad", unit="rad"),
    Column("speed", float, "highest", "speed_rad_s", unit="rad/s"),
    Column("ease", float, "time of the rise of the velocity, and of its fall", "ease_s", unit="s"),
    Column("rest", float, "rest afterwards", "rest_s", unit="s"),
)
RUN = Record(
    Column("words", str, "what it is"),
    Column("low", float, "lowest position relative to the start", "span_rad.0", unit="rad"),
    Column("high", float, "highest", "span_rad.1", unit="rad"),
    Column("duration", float, "its length", "duration_s", unit="s"),
    Column("strokes", [STROKE], "from rest to rest"),
)
LIMITS = Record(
    Column("start", float, "position at the start", "start_rad", unit="rad"),
    Column("low", float, "lowest position", "low_rad", unit="rad"),
    Column("high", float, "highest position", "high_rad", unit="rad"),
    Column("speed", float, "highest speed", "speed_rad_s", unit="rad/s"),
    Column("acceleration_rad_s2", float, "highest acceleration"),
    Column("jerk_rad_s3", float, "highest jerk"),
    Column("source", str, "where the limits come from"),
)
SEPARATED = Record(
    Column("effect", str, "if this effect is there"),
    Column("other", str, "against this one"),
    Column("two_ln_likelihood_ratio", float, "expected of the recording: from 10 on very strong"),
)
ANSWER = Record(
    Column("effect", str, "if this effect is there", title="if the joint has", on="jt"),
    Column(
        "numbers", {"*": float}, "as simulated; empty where it does nothing in this motion",
        lambda answer: {key: value for key, value in answer.numbers.items() if not isinstance(value, str)},
    ),
    Column("verdict", VERDICTS, "verdict of `diagnose`"),
    Column("names", [[str]], "names of each effect, with those that it may be instead", "sets", on="j"),
    Column("answer", str, get=_answer, title="diagnose would answer", on="t"),
    Column("exact", bool, "whether the simulator has these very numbers, and not only near or usual ones"),
    Column("decided", bool, "whether it is named, and no wrong name with it", on="jt"),
)  # fmt: skip
JOINT_PLAN = Record(
    Column("joint", int, "number, from 1", "task.joint.number"),
    Column("name", str, "name in the log", "task.joint.name"),
    Column("why", str, "what is open", "task.why", null=True),
    Column("duration", float, "its length", "duration_s", unit="s"),
    Column("limits", LIMITS, "limits that it keeps"),
    Column("runs", [RUN], "in order"),
    Column("rest", float, "after them; then the same runs follow once more; 0: they do not", unit="s"),
    Column("separated", [SEPARATED], "what the design expects of each pair of effects"),
    Column("answers", [ANSWER], "what `diagnose` would answer, simulated; empty if it was not"),
    Column("coefficients", {"*": Coefficient}, "what `estimate` would find, simulated"),
    Column("left_out", {"*": str}, "competing names that were not planned for, and why", "task.unknown"),
)
RECORDING = Record(
    Column("purpose", tuple(PURPOSES), "what it is for"),
    Column("duration", float, "its length", lambda one: sum(plan.duration_s for plan in one.plans), unit="s"),
    Column("joints", [JOINT_PLAN], "one after the other", "plans"),
    Column("files", [str], "where the trajectory was written"),
)
SETTLED = Record(
    Column("joint", int, "number, from 1", "joint.number"),
    Column("name", str, "name in the log", "joint.name"),
    Column("why", str, "the answer that there is"),
)
PLAN = Document(
    "plan/1",
    "The next recording of an arm",
    Column("source", str, "log or result; null without one", null=True),
    Column("recordings", [RECORDING], "what to record"),
    Column("settled", [SETTLED], "joints for which nothing is planned"),
    WARNINGS,
)


def plan_notices(recordings: Iterable[Recording], *, known_start: bool) -> Iterator[Notice]:
    """Yield what the user must know before running the motion."""
    plans = [plan for one in recordings for plan in one.plans]
    if plans and not known_start:
        yield notice("start_unknown")
    for plan in plans:
        number = plan.task.joint.number
        yield from (notice("name_left_out", number, name=name, why=why) for name, why in plan.task.unknown.items())
        answers = plan.answers if plan.task.purpose == "decide" else ()
        if near := " and ".join(one.effect for one in answers if not one.exact):
            yield notice("near_numbers", number, names=near)
        if undecided := " or ".join(one.effect for one in answers if not one.decided):
            yield notice("not_decided", number, names=undecided)


def plan_lines(recordings: Sequence[Recording], settled: Sequence[Task]) -> list[str]:
    """Return the motions as text for a person, and what `diagnose` would answer after them."""
    done = [one for one in settled if not one.at_rest]
    lines = [f"joint {joint_label(one.joint.number, one.joint.name)}: no motion planned: {one.why}" for one in done]
    if still := [one.joint.number for one in settled if one.at_rest]:
        lines.append(f"{joints_label(still)}: did not move; for a recording of one: --joints {still[0]}")
    if settled and not any(plan.task.why for one in recordings for plan in one.plans):
        lines.append("The best recording otherwise:")
    for one in recordings:
        for plan in one.plans:
            lines += [*([""] if lines else []), *_joint_lines(plan)]
        command = "estimate" if one.purpose == "estimate" else "diagnose"
        lines += [*one.files, f"then: friction-audit {command} RECORDING --thresholds auto"]
    return lines


def _joint_lines(plan: JointPlan) -> Iterator[str]:
    limits, joint, why = plan.limits, plan.task.joint, plan.task.why
    # Of a reason what there is, without what it may come from: the motion below is what to do.
    decided = f" {why}" if plan.task.purpose == "decide" else f" ({why.partition(':')[0]})" if why else ""
    by = "by hand or by the robot" if joint.hand else "by the robot"
    purpose = f"{PURPOSES[plan.task.purpose or 'decide']}{decided}"
    yield f"joint {joint_label(joint.number, joint.name)}, {purpose}: {plan.duration_s:.0f} s, {by}"
    yield (
        f"start at {limits.start_rad:z.2f} rad; within {limits.low_rad:z.2f} to {limits.high_rad:z.2f} rad, "
        f"{limits.speed_rad_s:.3g} rad/s, {limits.acceleration_rad_s2:.3g} rad/s², {limits.jerk_rad_s3:.3g} rad/s³ "
        f"({limits.source})"
    )
    words = [run.words for run in plan.runs]
    for run in {one.words: one for one in plan.runs}.values():
        low, high = run.span_rad
        count = words.count(run.words)
        yield f"  {count} x {run.words}; {low:+.2f} to {high:+.2f} rad from the start, {run.duration_s:.0f} s"
    if len(plan.runs) > 1:
        yield "  in mixed order, each from rest to rest; the other joints hold still"
    if plan.rest_s:
        yield f"  then rest for {plan.rest_s:.0f} s, and all of it once more: a drift shows most between both ends"
    if plan.answers:
        yield from ANSWER.people(plan.answers, "t").lines()
    if plan.coefficients:
        there = ", ".join(
            f"{NAMES[key]} {getattr(joint.parameters, key):.3g} {UNITS[key]}" for key in plan.coefficients
        )
        found = ", ".join(f"{NAMES[key]} {with_unit(one, UNITS[key])}" for key, one in plan.coefficients.items())
        yield f"simulated with {there}, estimate finds, with 95 % intervals: {found}"
