"""Words and numbers in which drift is reported, the same in tables, documents, figures and pages; limits as JUnit."""

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import isfinite
from pathlib import PurePath
from statistics import median
from xml.etree import ElementTree as ET

from friction_audit.drift import report as drift
from friction_audit.drift.change_points import REACH
from friction_audit.drift.session import Session
from friction_audit.errors import printable
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.joint_numbers import write_joint_numbers
from friction_audit.reporting import words
from friction_audit.reporting.notices import text_of
from friction_audit.reporting.table import Tone
from friction_audit.reporting.words import NEWTON_METRES, NOTHING, count_of, format_date, format_start, in_unit

MOST_STATED = 2  # joints in the sentence on an arm
NOTHING_ELSE, WARMER = "; no other change found", " while it became "
NAMES = {"coulomb_nm": "Coulomb", "viscous_nms_per_rad": "viscous"}
UNITS = {"coulomb_nm": "N m", "viscous_nms_per_rad": "N m s/rad"}
DRIFT, STEADY, TEMPERATURE, UNTESTED = "drift", "no drift found", "temperature", "not testable"
VERDICTS = (DRIFT, TEMPERATURE, STEADY, UNTESTED)  # the strongest first
TONES: Mapping[str, Tone] = {DRIFT: "alert", STEADY: "fine", TEMPERATURE: "unsure", UNTESTED: "off"}
# What describes a coefficient over the sessions, in words.
SHAPES = {
    "none": "level", "step": "a step", "steps": "steps", "ramp": "a ramp", "step_or_ramp": "a step or a ramp",
    "temperature": "changes together with the temperature", "too_few": "too few sessions",
}  # fmt: skip
LARGEST_DETECTABLE = 10.0  # times the level; a larger detectable change is no information
WEEK_S = 7 * 86400.0
MOST_NAMES = 3  # sessions that a sentence names
NEEDED = f"at least {drift.FEWEST_SESSIONS} are needed to separate drift from scatter"


def drift_verdict(*found: drift.CoefficientDrift) -> str:
    """Return whether some coefficients drift: the strongest one of VERDICTS, untested without any."""
    others = {"temperature": TEMPERATURE, "too_few": UNTESTED}
    verdicts = (DRIFT if one.drift else others.get(one.shape, STEADY) for one in found)
    return min(verdicts, key=VERDICTS.index, default=UNTESTED)


def is_tested(joint: drift.JointDrift) -> bool:
    """Return whether a coefficient of a joint has sessions enough to be tested for drift."""
    return any(found.shape != "too_few" for found in joint.coefficients)


def describe(found: drift.CoefficientDrift, sessions: Sequence[Session]) -> str:
    """Return one sentence on a coefficient over the sessions of its arm, without a full stop."""
    parts = [headline(found, sessions)]
    if found.shape == "too_few":  # with the reason that most sessions share
        clauses = Counter(re.split("[:;]", text_of(reason))[0] for reason in found.reasons)
        return "; ".join([*parts, *(f"{why} ({count_of(n, 'session')})" for why, n in clauses.most_common(1))])
    if isfinite(found.speed_ratio):
        parts.append(f"the speed of motion changed with it ({found.speed_ratio:.2g} times), compare at like speed")
    if found.within.low > 0 or found.within.high < 0:
        size = how_much(found.within, found.within, "")
        parts.append(f"within a session it {verb_of(found.within, 'rises', 'falls')} by {size}, which is no drift")
    return "; ".join(parts + _isolated(found, sessions))


def headline(found: drift.CoefficientDrift, sessions: Sequence[Session]) -> str:
    """Return what became of a coefficient; the sessions are read for their moments alone."""
    name, unit = f"{NAMES[found.coefficient]} friction", UNITS[found.coefficient]
    changed = f"{name} {verb_of(found.change)} by {how_much(found.total, found.change, unit)}"
    if found.shape == "too_few":
        return f"{name}: {count_of(len(found.sessions) - len(found.isolated), 'comparable session')}, {NEEDED}"
    if found.shape == "temperature":
        return (
            f"{changed}{WARMER}{abs(found.warmer_k):.1f} K "
            f"{'warmer' if found.warmer_k >= 0 else 'colder'}: drift and temperature cannot be separated; "
            "sessions at like temperature would separate them"
        )
    if found.shape == "none":
        least = f"a change of {amount(found.smallest_drift, found.smallest_change, found.coefficient)} is detectable"
        if found.smallest_drift > LARGEST_DETECTABLE or not isfinite(found.smallest_change):
            least = "but the sessions are too few or too scattered to show any"
        return f"no drift of {name}{' at like temperature' * found.by_temperature}: {least}"
    if found.change_points and found.shape != "step_or_ramp":
        steps = ", ".join(_step(point, unit, sessions) for point in found.change_points)
        return f"{name} {f'changed in {len(found.change_points)} steps: ' * (found.shape == 'steps')}{steps}"
    if found.shape == "ramp":
        size = abs(found.level.value) if isfinite(found.total.value) else math.nan
        trend = found.trend_per_session
        rises = f"{verb_of(trend, 'rises', 'falls')} by {how_much(words.scaled(trend, 1.0 / size), trend, unit)}"
        first, last = (sessions[found.sessions[k]].start_s for k in (0, -1))
        weeks = math.nan if first is None or last is None else (last - first) / WEEK_S
        weekly = abs(trend.value) * (found.sessions[-1] - found.sessions[0]) / weeks if weeks >= 1.0 else math.nan
        about = f", about {amount(weekly / size, weekly, found.coefficient)} a week" if isfinite(weekly) else ""
        total = how_much(found.total, found.change, unit)
        return f"{name} {rises} a session{about}, {total} from the reference to the last sessions"
    return f"{changed} from the reference to the last sessions; a step and a slow change describe it equally well"


def _step(point: drift.ChangePoint, unit: str, sessions: Sequence[Session]) -> str:
    """Return a step and the sessions that it lies between: their dates, with the time if they share one, or names."""
    both = sessions[point.low - 1], sessions[point.high]
    when = [format_date(one.start_s) for one in both]
    if any(one.start_s is None for one in both):
        when = [PurePath(one.path).name for one in both]
    elif when[0] == when[1]:
        when = [format_start(both[0].start_s), f"{format_start(both[1].start_s)} UTC"]
    return f"{verb_of(point.change)} by {how_much(point.relative, point.change, unit)} between {' and '.join(when)}"


def how_much(relative: Coefficient, absolute: Coefficient, unit: str) -> str:
    """Return a size with its interval, in per cent where that means something."""
    shown = relative if isfinite(relative.value) else absolute
    low, high = sorted(math.copysign(1.0, shown.value) * end for end in (shown.low, shown.high))
    if not isfinite(relative.value):
        return f"{abs(absolute.value):.2g} {unit} ({low:.2g} to {high:.2g})"
    if words.percent(low) == words.percent(high):  # two digits are too few
        return words.format_percent(Coefficient(value=abs(relative.value), low=low, high=high)).removeprefix("+")
    return f"{words.percent(abs(relative.value))} % ({words.percent(low)} to {words.percent(high)} %)"


def amount(share: float, size: float, coefficient: str) -> str:
    """Return a change in per cent, or in the unit of the coefficient where it has no share."""
    return f"{words.percent(share)} %" if isfinite(share) else f"{size:.2g} {UNITS[coefficient]}"


def verb_of(change: Coefficient, rising: str = "rose", falling: str = "fell") -> str:
    """Return which way a change goes."""
    return rising if change.value >= 0 else falling


def _isolated(found: drift.CoefficientDrift, sessions: Sequence[Session]) -> list[str]:
    """Name the isolated sessions and how far each lies from the nearest ones that count, two on each side."""
    parts = []
    counted = [k for k, session in enumerate(found.sessions) if session not in found.isolated]
    for index in found.isolated[:MOST_NAMES]:
        one, place = sessions[index], found.sessions.index(index)
        which = PurePath(one.path).name if one.start_s is None else format_date(one.start_s)
        near = [k for k in counted if abs(k - place) <= REACH] or counted
        usual = median(found.values[k].value for k in near)
        off = found.values[place].value - usual
        share = abs(off / usual) if isfinite(found.total.value) and usual > 0.0 else math.nan
        size = f"{amount(share, abs(off), found.coefficient)} {'above' if off >= 0 else 'below'} the sessions around it"
        parts.append(f"session {index + 1} ({which}) does not fit: {size}; left out of the change")
    if len(found.isolated) > MOST_NAMES:
        parts.append(f"and {len(found.isolated) - MOST_NAMES} more sessions left out")
    if found.isolated and found.isolated[-1] == found.sessions[-1]:
        parts.append("the next session shows whether the last one is the beginning of a change")
    return parts


def joint_sentence(arm: drift.ArmDrift, joint: drift.JointDrift) -> str:
    """Return one sentence on a joint, without its number in front."""
    found = joint.coefficients
    messages = {one.coefficient: describe(one, arm.sessions) for one in found}
    if changed := [messages[one.coefficient] for one in found if one.drift or one.shape == "temperature"]:
        sizes, _, rests = zip(*(text.partition(WARMER) for text in changed), strict=True)
        if rests[0] and len({*rests}) == 1:
            changed = [f"{' and '.join(sizes)}{WARMER}{rests[0]}"]
        return "; ".join(changed) + (NOTHING_ELSE if len(sizes) < len(found) else "")
    alike = {text.removeprefix(f"{NAMES[name]} friction: ") for name, text in messages.items()}
    return alike.pop() if len(alike) == 1 else "; ".join(messages.values())


def arm_sentence(arm: drift.ArmDrift) -> str:
    """Return one sentence on an arm, without its name in front."""
    drifting = [joint for joint in arm.joints if joint.drift]
    together = [joint for joint in arm.joints if any(one.shape == "temperature" for one in joint.coefficients)]
    compared = len(arm.compared)
    if not any(map(is_tested, arm.joints)):
        few = compared < drift.FEWEST_SESSIONS
        found = count_of(compared, "comparable session") if few else "no joint has an estimate in enough sessions"
        return f"{found}, {NEEDED}"
    if drifting or together:
        stated = drifting[:MOST_STATED] or together[:1]
        said = [f"joint {joint.joint}: {joint_sentence(arm, joint)}" for joint in stated]
        if drifting[1:]:  # what else did not change on the one joint would read as of the arm
            said = [text.removesuffix(NOTHING_ELSE) for text in said]
        if drifting[MOST_STATED:]:
            said.append(f"joints that changed: {write_joint_numbers(joint.joint for joint in drifting)}")
        if together[1:] and not drifting:
            said.append(f"likewise {words.joints_label(joint.joint for joint in together[1:])}")
        return "; ".join(said)
    parts = []
    every = [one for joint in arm.joints for one in joint.coefficients if one.smallest_drift <= LARGEST_DETECTABLE]
    for name, word in NAMES.items():
        if sizes := [one.smallest_drift for one in every if one.coefficient == name]:
            parts.append(f"{words.range_of(sizes, words.percent)} % of {word} friction")
    least = f": changes of {' and of '.join(parts)} are detectable, joint by joint" if parts else ""
    return f"no drift in {compared} sessions{least}"


def batch_sentence(arms: Sequence[drift.ArmDrift]) -> str:
    """Return one sentence on all arms."""
    if not arms:
        return "No session could be read: no statement on drift is possible."
    verdicts = [drift_verdict(*(one for joint in arm.joints for one in joint.coefficients)) for arm in arms]
    drifting = [arm for arm in arms if arm.drift]
    warmer = [arm for arm, verdict in zip(arms, verdicts, strict=True) if verdict == TEMPERATURE]
    steady, untested = (count_of(verdicts.count(one), "arm") for one in (STEADY, UNTESTED))
    found = [f"No drift of the friction was found on {steady}"] if STEADY in verdicts else []
    if drifting[1:]:
        names = words.enumerate_words(arm.robot for arm in drifting)
        found = [f"Friction drifts on {len(drifting)} of {count_of(len(arms), 'arm')}: {names}"]
    elif drifting or len(arms) == 1:
        found = [f"{(drifting or arms)[0].robot}: {arm_sentence((drifting or arms)[0])}"]
    elif UNTESTED in verdicts:
        found.append(f"{'no' if found else 'No'} answer on {untested}")
    if warmer and len(arms) > 1:
        names = words.enumerate_words(arm.robot for arm in warmer)
        found.append(f"{'drift' if found else 'Drift'} and temperature cannot be separated on {names}")
    return f"{'; '.join(found)}."


def first_after(change: drift.ChangePoint) -> str:
    """Return the number of the first session after a step, with its interval: ``13 (12 to 14)``."""
    low, high = change.low + 1, change.high + 1
    return f"{change.session + 1}{'' if low == high else f' ({low} to {high})'}"


def format_change(change: drift.ChangePoint) -> str:
    """Return the size of a step as a percentage, and where the level is near zero from what to what."""
    if math.isnan(change.relative.value):
        return f"{words.format_coefficient(change.before)} to {words.format_coefficient(change.after)}"
    return words.format_percent(change.relative)


def total_text(found: drift.CoefficientDrift) -> str:
    """Return the change from the reference to the last sessions: relative, or absolute near a level of zero."""
    if math.isnan(found.total.value) and not math.isnan(found.change.value):
        return f"{words.signed(found.change)} {UNITS[found.coefficient]}"
    return words.format_percent(found.total)


def smallest_text(found: drift.CoefficientDrift) -> str:
    """Return the smallest change that these sessions would have shown: relative, or absolute near a level of zero."""
    if found.smallest_drift > LARGEST_DETECTABLE:
        return f">{words.percent(LARGEST_DETECTABLE)} %"
    if not isfinite(found.smallest_change):
        return NOTHING
    return amount(found.smallest_drift, found.smallest_change, found.coefficient)


def slope_text(found: drift.CoefficientDrift, slope: Coefficient) -> str:
    """Return a trend: over the reference's level, or absolute near a level of zero."""
    if math.isnan(slope.value):
        return NOTHING
    if math.isnan(found.total.value) or not found.level.value > 0.0:
        return f"{words.format_slope(slope)} {UNITS[found.coefficient]}"
    return f"{words.format_slope(words.scaled(slope, 100.0 / found.level.value))} %"


def span_of(sessions: Iterable[Session]) -> str:
    """Return from when to when sessions were recorded, or nothing where no start is known."""
    starts = [one.start_s for one in sessions if format_date(one.start_s) != NOTHING and one.start_s]
    return words.range_of(starts, format_date) if starts else ""


def curve_sessions(arm: drift.ArmDrift) -> tuple[tuple[int, ...], ...]:
    """Return the sessions whose curves are drawn: the first, those of the reference, the last."""
    compared = arm.compared or tuple(range(len(arm.sessions)))
    return compared[:1], arm.reference, compared[-1:]


def sessions_text(arm: drift.ArmDrift) -> str:
    """Return how many sessions an arm has, when they were recorded, and how many were compared."""
    span = span_of(arm.sessions)
    return f"{count_of(len(arm.sessions), 'session')}{f', {span}' if span else ''}, {len(arm.compared)} compared"


def limit_lines(exceeded: Iterable[str], cannot_tell: Iterable[str]) -> list[str]:
    """Return the sentences on limits that are not kept, each led by what is wrong."""
    return [f"limit exceeded: {one}" for one in exceeded] + [f"cannot test: {one}" for one in cannot_tell]


# Of what is not kept: the element, and what it counts as. A limit that cannot be tested is an error and not skipped,
# for servers count what is skipped as passed, and the command exits with 7.
OUTCOMES = {"exceeded": ("failure", "failures"), "untestable": ("error", "errors")}


def limit_sentences(arms: Sequence[drift.ArmDrift], asked: Iterable[drift.Limit]) -> tuple[tuple[str, ...], ...]:
    """Return one sentence for each coefficient beyond a limit, and for each that cannot be tested by one."""
    judged = list(drift.judge(arms, tuple(asked)))
    return tuple(tuple(_limit_sentence(one) for one in judged if one.verdict == kind) for kind in OUTCOMES)


def limits_beyond_all(arms: Sequence[drift.ArmDrift], asked: Iterable[drift.Limit]) -> Iterator[str]:
    """Name the limits in the unit of a coefficient that are larger than all of it: they were meant in per cent."""
    for limit in asked:
        judged = drift.judge(arms, [] if limit.relative else [limit])
        levels = [abs(one.found.level.value) for one in judged if one.found and isfinite(one.found.level.value)]
        if levels and max(levels) < limit.size:
            unit = UNITS[limit.coefficient or "coulomb_nm"]
            most = f"more than all of it, at most {max(levels):.2g} {unit}"
            yield f"--fail-on {limit.text}: {limit.size:g} {unit} is {most}; per cent is {limit.text}%"


def _limit_sentence(one: drift.Judged) -> str:
    """Return what a limit that is not kept is exceeded by, or why it cannot be tested."""
    found, limit = one.found, one.limit
    if found is None:
        return f"the limit {limit.text}: no session has an estimate that it is meant for"
    change = found.total if limit.relative else found.change
    name = f"{one.robot}, joint {one.joint}: {NAMES[found.coefficient]} friction"
    if one.verdict == "exceeded":
        size = how_much(found.total if limit.relative else UNDETERMINED, found.change, UNITS[found.coefficient])
        sure = min(abs(change.low), abs(change.high)) >= limit.size and change.low * change.high > 0
        went = f"{verb_of(change)} by {size} since the reference"
        return f"{name} {went}, {'surely' if sure else 'probably'} beyond the limit {limit.text}"
    least = found.smallest_drift if limit.relative else found.smallest_change
    size = amount(least if limit.relative else math.nan, least, found.coefficient)
    why = f"only a change of {size} or more is detectable; record more or longer sessions"
    if found.shape == "temperature":
        why = "drift and temperature cannot be separated; record sessions at like temperature"
    elif found.drift:
        why = "the reference is near zero, so there is no relative change; give a limit without %"
    elif found.shape == "too_few" or not isfinite(least):
        sessions = count_of(len(found.sessions) - len(found.isolated), "comparable session")
        return f"{name}: the limit {limit.text} cannot be tested with {sessions}; record more"
    return f"{name}: the limit {limit.text} cannot be tested: {why}"


def junit_text(
    command: str, arms: Sequence[drift.ArmDrift], asked: Sequence[drift.Limit], unit: str = NEWTON_METRES
) -> str:
    """Return the XML of the limits of a command, a suite per limit; torques are in a unit."""
    root = ET.Element("testsuites", name=f"friction-audit {command}")
    for limit in asked:
        suite = ET.SubElement(root, "testsuite", name=limit.text)
        for one in drift.judge(arms, [limit]):
            words = () if one.found is None else (f"joint {one.joint}", f"{NAMES[one.found.coefficient]} friction, ")
            place = (printable(part).replace(".", "_") for part in ("friction-audit", command, one.robot or "no arm"))
            name = f"{': '.join(words)}limit {limit.text}"
            case = ET.SubElement(suite, "testcase", classname=".".join(place), name=name)
            if one.verdict in OUTCOMES:
                sentence = printable(in_unit(_limit_sentence(one), unit))
                ET.SubElement(case, OUTCOMES[one.verdict][0], message=sentence, type=one.verdict).text = sentence
            elif one.found is not None:
                ET.SubElement(case, "system-out").text = f"change {in_unit(total_text(one.found), unit)}"
    for whole in (root, *root):
        for element, counted in (("testcase", "tests"), *OUTCOMES.values()):
            whole.set(counted, str(len(whole.findall(f".//{element}"))))
    ET.indent(root)
    return ET.tostring(root, "unicode", xml_declaration=True) + "\n"
