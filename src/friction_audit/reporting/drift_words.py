"""Words and numbers in which drift is told, the same in tables, documents, figures and pages."""

import math
from collections.abc import Iterable
from datetime import UTC, datetime

from friction_audit.drift.report import ArmDrift, ChangePoint, CoefficientDrift, JointDrift
from friction_audit.drift.session import Session
from friction_audit.friction.history import Coefficient
from friction_audit.reporting.terminal.estimate import NOTHING, format_coefficient

NAMES = {"coulomb_nm": "Coulomb", "viscous_nms_per_rad": "viscous"}
UNITS = {"coulomb_nm": "N m", "viscous_nms_per_rad": "N m s/rad"}
DRIFT, STEADY, TEMPERATURE, UNTESTED = "drift", "no drift found", "temperature", "not testable"
VERDICTS = (DRIFT, TEMPERATURE, STEADY, UNTESTED)
"""Verdicts, the strongest first."""
SHAPES = {
    "none": "level",
    "step": "a step",
    "steps": "steps",
    "ramp": "a ramp",
    "step_or_ramp": "a step or a ramp",
    "temperature": "changes together with the temperature",
    "too_few": "too few sessions",
}
"""What describes a coefficient over the sessions, in words."""
ROUGH = 2.0
"""First figure of a slope's interval from which on one figure will do."""
LARGE = 1.0
"""Share above which a percentage says nothing but that it is large."""
SMALL = 0.1
"""Share below which a percentage is given with a decimal."""
LAST_S = 253402300799.0
"""The last second of the year 9999, beyond which no calendar goes. [s]"""


def coefficient_name(coefficient: str) -> str:
    """Return what people call a coefficient."""
    return NAMES.get(coefficient, coefficient)


def coefficient_unit(coefficient: str) -> str:
    """Return the unit of a coefficient."""
    return UNITS.get(coefficient, "")


def drift_verdict(found: CoefficientDrift) -> str:
    """Return whether a coefficient drifts: one of VERDICTS."""
    if found.drift:
        return DRIFT
    return {"temperature": TEMPERATURE, "too_few": UNTESTED}.get(found.shape, STEADY)


def joint_verdict(joint: JointDrift) -> str:
    """Return whether a joint drifts: the strongest verdict on its coefficients."""
    return strongest(drift_verdict(found) for found in joint.coefficients)


def arm_verdict(arm: ArmDrift) -> str:
    """Return whether an arm drifts: the strongest verdict on its joints."""
    return strongest(joint_verdict(joint) for joint in arm.joints)


def strongest(verdicts: Iterable[str]) -> str:
    """Return the strongest of some verdicts; without any, that nothing can be tested."""
    return min(verdicts, key=VERDICTS.index, default=UNTESTED)


def arm_sentence(arm: ArmDrift) -> str:
    """Return what is to be said of an arm, without its name in front."""
    return arm.message.removeprefix(f"{arm.robot}: ")


def joint_sentence(joint: JointDrift) -> str:
    """Return what is to be said of a joint, without its number in front."""
    return joint.message.removeprefix(f"joint {joint.joint}: ")


def drifting_joints(arm: ArmDrift) -> tuple[int, ...]:
    """Return the numbers of the joints that drift."""
    return tuple(joint.joint for joint in arm.joints if joint_verdict(joint) == DRIFT)


def change_text(arm: ArmDrift, change: ChangePoint) -> str:
    """Return a step in words: ``session 13 (12 to 14), 2026-03-04: +15.2 ± 1.9 %``."""
    low, high = change.low + 1, change.high + 1
    span = "" if low == high else f" ({low} to {high})"
    date = format_date(arm.sessions[change.session].start_s)
    day = "" if date == NOTHING else f", {date}"
    return f"session {change.session + 1}{span}{day}: {format_change(change.relative, change.after, change.before)}"


def format_change(relative: Coefficient, after: Coefficient, before: Coefficient) -> str:
    """Return a change as a percentage, and where the level is near zero from what to what."""
    if math.isnan(relative.value):
        return f"{format_coefficient(before)} to {format_coefficient(after)}"
    return format_percent(relative)


def total_text(found: CoefficientDrift) -> str:
    """Return the change from the reference to the last sessions: relative, or absolute near a level of zero."""
    if math.isnan(found.total.value) and not math.isnan(found.change.value):
        return f"{signed(found.change)} {coefficient_unit(found.coefficient)}"
    return format_percent(found.total)


def smallest_text(found: CoefficientDrift) -> str:
    """Return the smallest change that these sessions would have shown: relative, or absolute near a level of zero."""
    if math.isnan(found.smallest_drift) and not math.isnan(found.smallest_change):
        return f"{found.smallest_change:.2g} {coefficient_unit(found.coefficient)}"
    return format_share(found.smallest_drift)


MOST_TOLD = 20.0
"""Width of an interval of a relative change from which on its digits would only pretend to tell something."""
UNTOLD = "not told"


def format_percent(relative: Coefficient) -> str:
    """Return a relative change with its 95 % interval: ``+15.2 ± 1.9 %``; rounded where it has none."""
    if math.isnan(relative.value):
        return NOTHING
    if math.isnan(relative.low + relative.high):
        return f"{100.0 * relative.value:+.2g} %"
    if relative.high - relative.low > MOST_TOLD:
        return UNTOLD
    return f"{signed(scaled(relative, 100.0))} %"


def signed(number: Coefficient) -> str:
    """Return a value with its interval and always a sign."""
    text = format_coefficient(number)
    return text if number.value < 0.0 or text == NOTHING else f"+{text}"


def scaled(number: Coefficient, factor: float) -> Coefficient:
    """Return a value and its interval in another unit; the factor is positive."""
    return Coefficient(value=factor * number.value, low=factor * number.low, high=factor * number.high)


def format_share(share: float) -> str:
    """Return a share as a percentage; a dash for NaN."""
    if math.isnan(share):
        return NOTHING
    if share > LARGE:
        return f">{100 * LARGE:.0f} %"
    return f"{100 * share:.2g} %" if share < SMALL else f"{100 * share:.0f} %"


def format_slope(slope: Coefficient) -> str:
    """Return a slope with its interval; slopes are small, so that the digits follow the interval's size."""
    if math.isnan(slope.value):
        return NOTHING
    half = 0.5 * (slope.high - slope.low)
    if not half > 0.0:
        return f"{slope.value:+.2g}"
    size = math.floor(math.log10(half))
    digits = max(0, 1 - size if half < ROUGH * 10.0**size else -size)
    value = f"{slope.value:+.{digits}f}"
    return f"{value if float(value) else 0} ± {half:.{digits}f}"  # many sessions: no row of zeros


def trend_text(found: CoefficientDrift) -> str:
    """Return the trend per session: over the reference's level, or absolute near a level of zero."""
    return _per(found, found.trend_per_session)


def daily_text(found: CoefficientDrift) -> str:
    """Return the trend per day, like ``trend_text``."""
    return _per(found, found.trend_per_day)


def _per(found: CoefficientDrift, slope: Coefficient) -> str:
    if math.isnan(slope.value):
        return NOTHING
    if math.isnan(found.total.value) or not found.level.value > 0.0:
        return f"{format_slope(slope)} {coefficient_unit(found.coefficient)}"
    return f"{format_slope(scaled(slope, 100.0 / found.level.value))} %"


def format_p(p_value: float) -> str:
    """Return a p-value; a dash for NaN."""
    if math.isnan(p_value):
        return NOTHING
    return "< 0.001" if p_value < 1e-3 else f"{p_value:.2g}"  # noqa: PLR2004 - as printed


def format_start(start_s: float | None) -> str:
    """Return when a session began, to the minute, UTC; a dash where nothing tells."""
    moment = _moment(start_s)
    return NOTHING if moment is None else f"{moment:%Y-%m-%d %H:%M}"


def format_date(start_s: float | None) -> str:
    """Return the day on which a session began, UTC; a dash where nothing tells."""
    moment = _moment(start_s)
    return NOTHING if moment is None else f"{moment:%Y-%m-%d}"


def iso_start(start_s: float | None) -> str | None:
    """Return when a session began as ISO 8601, UTC, or None."""
    moment = _moment(start_s)
    return None if moment is None else moment.isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _moment(start_s: float | None) -> datetime | None:
    if start_s is None or not 0.0 <= start_s <= LAST_S:
        return None
    return datetime.fromtimestamp(start_s, UTC)


def count_of(number: int, thing: str) -> str:
    """Return a number of things: ``1 session``, ``2 sessions``."""
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"


def enumerate_words(words: Iterable[object]) -> str:
    """Return words as people list them: ``1, 2 and 3``."""
    *rest, last = map(str, words)
    return f"{', '.join(rest)} and {last}" if rest else last


def span_of(sessions: Iterable[Session]) -> str:
    """Return from when to when sessions were recorded, or nothing where no start is known."""
    starts = sorted(
        session.start_s for session in sessions if format_date(session.start_s) != NOTHING and session.start_s
    )
    if not starts:
        return ""
    first, last = format_date(starts[0]), format_date(starts[-1])
    return first if first == last else f"{first} to {last}"
