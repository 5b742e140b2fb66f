"""LogReport -> sentences: the verdict of each joint, and what the page says in a line."""

import math
from collections.abc import Mapping, Sequence

from friction_audit.compensation.result import JointReplay
from friction_audit.diagnosis.candidates import CANDIDATES
from friction_audit.friction.history import Coefficient, JointFriction
from friction_audit.reporting.drift_words import count_of, enumerate_words
from friction_audit.reporting.figures.diagnose_look import names_of
from friction_audit.reporting.log_report import JointReport, LogReport
from friction_audit.reporting.terminal.estimate import NOTHING, format_coefficient

NO_ESTIMATE, ESTIMATED = "no estimate", "estimated"
WORDS: Mapping[str, str] = {
    "none": "nothing missing",
    "named": "effect named",
    "ambiguous": "ambiguous",
    "unexplained": "unexplained",
    "not_testable": "not testable",
    "data_fault": "data fault",
    "failed": "failed",
}
"""Verdicts of a diagnosis as the page says them."""
UNITS = (("Coulomb", "N m"), ("viscous", "N m s/rad"))
EFFECTS = frozenset(candidate.name for candidate in CANDIDATES)
MOST_GROUPS = 4
"""Things that a lead says of different joints; more are counted."""


def verdict_word(joint: JointReport) -> str:
    """Return the verdict of a joint in a word or two."""
    if joint.discrepancy is not None and joint.discrepancy.verdict != "not_testable":
        return WORDS[joint.discrepancy.verdict]
    if joint.friction.reason:
        return NO_ESTIMATE
    return ESTIMATED if joint.discrepancy is None else WORDS["not_testable"]


def verdict_sentence(joint: JointReport) -> str:
    """Return what is to be said of a joint in a line: its friction, what is missing, what would have been saved."""
    found, parts = joint.discrepancy, [friction_words(joint.friction)]
    # That a joint did not move needs to be said once.
    if found is not None and not (joint.friction.reason and found.verdict == "not_testable"):
        parts.append(found.message)
    if joint.replay is not None:
        parts.append(removal_words(joint.replay))
    return " ".join(_as_sentence(part) for part in parts if part)


def friction_words(friction: JointFriction) -> str:
    """Return the coefficients with their intervals, or why there are none."""
    if friction.reason:
        return f"{NO_ESTIMATE}: {friction.reason}"
    pairs = zip(UNITS, (friction.coulomb, friction.viscous), strict=True)
    return ", ".join(f"{name} {with_unit(value, unit)}" for (name, unit), value in pairs if not math.isnan(value.value))


def with_unit(value: Coefficient, unit: str) -> str:
    """Return a value with its interval and unit, a dash for none."""
    text = format_coefficient(value)
    return text if text == NOTHING else f"{text} {unit}"


def removal_words(joint: JointReplay) -> str:
    """Return how much of the dissipation a compensator would have removed; nothing where that is not known."""
    numbers = joint.numbers
    if joint.reason or numbers is None or math.isnan(numbers.dissipation_removed):
        return ""
    if not math.isnan(numbers.diverged_s):
        return f"the compensator would have run away after {numbers.diverged_s:.3g} s"
    if numbers.dissipation_removed < 0.0:
        left = 100 * (1.0 - numbers.dissipation_removed)
        return f"a compensator would have left the person with {left:.0f} % of what friction took"
    return f"a compensator would have removed {100 * numbers.dissipation_removed:.0f} % of what friction took"


def _as_sentence(text: str) -> str:
    """Return a text with a capital at its start, unless that is the name of an effect, and a full stop."""
    start = text if text.partition(" ")[0] in EFFECTS else f"{text[:1].upper()}{text[1:]}"
    return start if start.endswith((".", "!", "?")) else f"{start}."


def lead_sentence(report: LogReport) -> str:
    """Return what the report says, in two sentences."""
    joints = report.joints
    known = [one for one in joints if not one.friction.reason]
    if not known:
        return "Friction is estimated on no joint."
    of_all = "" if len(known) == len(joints) else f" of {len(joints)}"
    estimated = f"Friction is estimated on {_joints(known, len(joints))}{of_all}."
    groups: dict[str, list[JointReport]] = {}
    for one in known:
        if one.discrepancy is not None:
            groups.setdefault(_missing(one), []).append(one)
    if len(groups) > MOST_GROUPS:
        return f"{estimated} {_counted(known)}"
    said = [f"{words} on {_joints(own, len(joints))}" for words, own in groups.items()]
    return " ".join([estimated, *([_as_sentence("; ".join(said))] if said else [])])


def _missing(joint: JointReport) -> str:
    found = joint.discrepancy
    assert found is not None
    names = enumerate_words(names_of(effect, found.effects) for effect in found.effects) if found.effects else ""
    beside = f" beside {names}" if names else ""
    return {
        "none": "nothing is missing from the model",
        "named": f"the model misses {names}",
        "ambiguous": f"the model misses {names}",
        "unexplained": f"something unexplained is missing{beside}",
        "not_testable": "what the model misses cannot be tested",
        "data_fault": "the data contradict themselves",
        "failed": "the diagnosis failed",
    }[found.verdict]


def _counted(joints: Sequence[JointReport]) -> str:
    words = [verdict_word(one) for one in joints]
    return _as_sentence("; ".join(f"{word}: {count_of(words.count(word), 'joint')}" for word in dict.fromkeys(words)))


def _joints(joints: Sequence[JointReport], every: int) -> str:
    """Return which joints are meant."""
    if len(joints) == every:
        return "the joint" if every == 1 else f"all {every} joints"
    numbers = enumerate_words(one.friction.joint for one in joints)
    return f"{'joint' if len(joints) == 1 else 'joints'} {numbers}"
