"""Words and numbers in which drift is reported, the same in tables, documents, figures and pages."""

import math
from collections.abc import Iterable, Mapping

from friction_audit.drift.report import ArmDrift, ChangePoint, CoefficientDrift, JointDrift
from friction_audit.drift.session import Session
from friction_audit.friction.history import Coefficient
from friction_audit.reporting.table import Tone
from friction_audit.reporting.words import (
    NOTHING,
    format_coefficient,
    format_date,
    format_percent,
    format_share,
    format_slope,
    scaled,
    signed,
)

NAMES = {"coulomb_nm": "Coulomb", "viscous_nms_per_rad": "viscous"}
UNITS = {"coulomb_nm": "N m", "viscous_nms_per_rad": "N m s/rad"}
DRIFT, STEADY, TEMPERATURE, UNTESTED = "drift", "no drift found", "temperature", "not testable"
# The strongest first.
VERDICTS = (DRIFT, TEMPERATURE, STEADY, UNTESTED)
TONES: Mapping[str, Tone] = {DRIFT: "alert", STEADY: "fine", TEMPERATURE: "unsure", UNTESTED: "off"}
# What describes a coefficient over the sessions, in words.
SHAPES = {
    "none": "level",
    "step": "a step",
    "steps": "steps",
    "ramp": "a ramp",
    "step_or_ramp": "a step or a ramp",
    "temperature": "changes together with the temperature",
    "too_few": "too few sessions",
}


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


def span_of(sessions: Iterable[Session]) -> str:
    """Return from when to when sessions were recorded, or nothing where no start is known."""
    starts = sorted(
        session.start_s for session in sessions if format_date(session.start_s) != NOTHING and session.start_s
    )
    if not starts:
        return ""
    first, last = format_date(starts[0]), format_date(starts[-1])
    return first if first == last else f"{first} to {last}"
