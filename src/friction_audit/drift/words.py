"""The sentences of drift."""

import re
from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime
from math import isfinite
from pathlib import PurePath
from statistics import median

from friction_audit.drift.change_points import REACH
from friction_audit.drift.report import ChangePoint, CoefficientDrift, JointDrift
from friction_audit.drift.session import Session
from friction_audit.drift.settings import FEWEST_SESSIONS
from friction_audit.friction.history import Coefficient
from friction_audit.joint_numbers import write_joint_numbers

NAMES = {"coulomb_nm": "Coulomb friction", "viscous_nms_per_rad": "viscous friction"}
UNITS = {"coulomb_nm": "N m", "viscous_nms_per_rad": "N m s/rad"}

LARGEST_DETECTABLE = 10.0  # times the level; a larger detectable change is no information
TWO_DIGITS = 99.5  # larger numbers of per cent are written with all their digits
MOST_NAMES = 3  # sessions that a sentence names


def describe(drift: CoefficientDrift, sessions: Sequence[Session]) -> str:
    """Return one sentence on a coefficient, without a full stop."""
    parts = [_main(drift, sessions)]
    if isfinite(drift.speed_ratio):
        parts.append(f"the speed of motion changed with it ({drift.speed_ratio:.2g} times), compare at like speed")
    if drift.within.low > 0 or drift.within.high < 0:
        parts.append(
            f"within a session it {_verb(drift.within, 'rises', 'falls')} by {_sized(drift.within)}, which is no drift"
        )
    return "; ".join(parts + _isolated(drift, sessions))


def _main(drift: CoefficientDrift, sessions: Sequence[Session]) -> str:
    name, unit = NAMES[drift.coefficient], UNITS[drift.coefficient]
    total = how_much(drift.total, drift.change, unit)
    went = _verb(drift.change, "rose", "fell")
    if drift.shape == "temperature":
        return (
            f"{name} {went} by {total} while it became {abs(drift.warmer_k):.1f} K "
            f"{'warmer' if drift.warmer_k >= 0 else 'colder'}: drift and temperature cannot be separated; "
            "sessions at like temperature would separate them"
        )
    if drift.shape == "none":
        like = " at like temperature" if drift.by_temperature else ""
        return f"no drift of {name}{like}: {_detectable(drift)}"
    if drift.change_points and drift.shape != "step_or_ramp":
        steps = ", ".join(step_words(point, unit, sessions) for point in drift.change_points)
        return f"{name} {f'changed in {len(drift.change_points)} steps: ' * (drift.shape == 'steps')}{steps}"
    if drift.shape == "ramp":
        slope = how_much(_over(drift.trend_per_session, drift), drift.trend_per_session, unit)
        verb = _verb(drift.trend_per_session, "rises", "falls")
        return f"{name} {verb} by {slope} a session, {total} from the reference to the last sessions"
    return (
        f"{name} {went} by {total} from the reference to the last sessions; a step and a slow change describe it "
        "equally well"
    )


def step_words(point: ChangePoint, unit: str, sessions: Sequence[Session]) -> str:
    """Return size and moment of a step."""
    change = Coefficient(
        value=point.after.value - point.before.value,
        low=point.after.low - point.before.high,
        high=point.after.high - point.before.low,
    )
    first, last = when(sessions[point.low - 1], sessions[point.high])
    return f"{_verb(change, 'rose', 'fell')} by {how_much(point.relative, change, unit)} between {first} and {last}"


def when(first: Session, last: Session) -> tuple[str, str]:
    """Return the moments of two sessions: their dates, with the time if they share a date, or their names."""
    if first.start_s is None or last.start_s is None:
        return PurePath(first.path).name, PurePath(last.path).name
    moments = [datetime.fromtimestamp(start, tz=UTC) for start in (first.start_s, last.start_s)]
    days = [f"{moment:%Y-%m-%d}" for moment in moments]
    if days[0] != days[1]:
        return days[0], days[1]
    return f"{moments[0]:%Y-%m-%d %H:%M}", f"{moments[1]:%Y-%m-%d %H:%M} UTC"


def how_much(relative: Coefficient, absolute: Coefficient, unit: str) -> str:
    """Return a size with its interval, in per cent where that means something."""
    if isfinite(relative.value):
        return _sized(relative)
    low, high = sorted((absolute.low, absolute.high), key=abs)
    sign = -1.0 if absolute.value < 0 else 1.0
    return f"{abs(absolute.value):.2g} {unit} ({sign * low:.2g} to {sign * high:.2g})"


def _sized(relative: Coefficient) -> str:
    sign = -1.0 if relative.value < 0 else 1.0
    low, high = sorted((100 * sign * relative.low, 100 * sign * relative.high))
    return f"{percent(sign * relative.value)} % ({low:.2g} to {high:.2g} %)"


def percent(share: float) -> str:
    """Return a share in per cent, two digits of it, more where it is large."""
    return f"{100 * share:.2g}" if abs(100 * share) < TWO_DIGITS else f"{100 * share:.0f}"


def _detectable(drift: CoefficientDrift) -> str:
    if isfinite(drift.smallest_drift) and drift.smallest_drift <= LARGEST_DETECTABLE:
        return f"a change of {percent(drift.smallest_drift)} % is detectable"
    if isfinite(drift.smallest_drift) or not isfinite(drift.smallest_change):
        return "but the sessions are too few or too scattered to show any"
    return f"a change of {drift.smallest_change:.2g} {UNITS[drift.coefficient]} is detectable"


def _over(slope: Coefficient, drift: CoefficientDrift) -> Coefficient:
    size = abs(drift.level.value) if isfinite(drift.total.value) else float("nan")
    return Coefficient(value=slope.value / size, low=slope.low / size, high=slope.high / size)


def _verb(change: Coefficient, rising: str, falling: str) -> str:
    return rising if change.value >= 0 else falling


def _isolated(drift: CoefficientDrift, sessions: Sequence[Session]) -> list[str]:
    """Name the isolated sessions and how far each is off."""
    parts = [
        f"session {index + 1} ({_name(sessions[index])}) does not fit: {_off(drift, index)}; left out of the change"
        for index in drift.isolated[:MOST_NAMES]
    ]
    if len(drift.isolated) > MOST_NAMES:
        parts.append(f"and {len(drift.isolated) - MOST_NAMES} more sessions left out")
    if drift.isolated and drift.isolated[-1] == drift.sessions[-1]:
        parts.append("the next session shows whether the last one is the beginning of a change")
    return parts


def _name(session: Session) -> str:
    if session.start_s is None:
        return PurePath(session.path).name
    return f"{datetime.fromtimestamp(session.start_s, tz=UTC):%Y-%m-%d}"


def _off(drift: CoefficientDrift, index: int) -> str:
    """Return how far a session lies from the nearest ones that count, two on each side."""
    place = drift.sessions.index(index)
    rows = zip(drift.sessions, drift.values, strict=True)
    near = [(abs(k - place), value.value) for k, (i, value) in enumerate(rows) if i not in drift.isolated]
    usual = median([value for distance, value in near if distance <= REACH] or [value for _, value in near])
    off = drift.values[place].value - usual
    relative = isfinite(drift.total.value) and usual > 0.0
    size = f"{percent(abs(off / usual))} %" if relative else f"{abs(off):.2g} {UNITS[drift.coefficient]}"
    return f"{size} {'above' if off >= 0 else 'below'} the sessions around it"


def describe_too_few(drift: CoefficientDrift) -> str:
    """Return one sentence on a coefficient with too few estimates, with the reason that most sessions share."""
    clauses = Counter(re.split("[:;]", reason)[0] for reason in drift.reasons)
    most = [f"{why} ({count} session{'' if count == 1 else 's'})" for why, count in clauses.most_common(1)]
    return "; ".join([f"{NAMES[drift.coefficient]}: {too_few_words(len(drift.sessions) - len(drift.isolated))}", *most])


def too_few_words(count: int) -> str:
    """Return how many sessions there are and how many it takes."""
    plural = "" if count == 1 else "s"
    return f"{count} comparable session{plural}, at least {FEWEST_SESSIONS} are needed to separate drift from scatter"


def describe_joint(joint: int, coefficients: Sequence[CoefficientDrift]) -> str:
    """Return one sentence on a joint."""
    changed = [drift.message for drift in coefficients if drift.drift or drift.shape == "temperature"]
    if changed:
        rest = "; nothing else changed" if len(changed) < len(coefficients) else ""
        return f"joint {joint}: {'; '.join(changed)}{rest}"
    messages = {drift.message.removeprefix(f"{NAMES[drift.coefficient]}: ") for drift in coefficients}
    if len(messages) == 1 and all(drift.shape == "too_few" for drift in coefficients):
        return f"joint {joint}: {messages.pop()}"
    return f"joint {joint}: {'; '.join(drift.message for drift in coefficients)}"


def describe_arm(robot: str, compared: int, joints: Sequence[JointDrift]) -> str:
    """Return one sentence on an arm."""
    drifting = [joint for joint in joints if joint.drift]
    if drifting:
        numbers = write_joint_numbers(joint.joint for joint in drifting)
        more = f"; joints that changed: {numbers}" if len(drifting) > 1 else ""
        return f"{robot}: {drifting[0].message}{more}"
    if compared < FEWEST_SESSIONS:
        return f"{robot}: {too_few_words(compared)}"
    together = [joint for joint in joints for drift in joint.coefficients if drift.shape == "temperature"]
    if together:
        return f"{robot}: {together[0].message}"
    return f"{robot}: no drift in {compared} sessions{_detectable_on(joints)}"


def _detectable_on(joints: Sequence[JointDrift]) -> str:
    parts = []
    for name, word in NAMES.items():
        sizes = [d.smallest_drift for joint in joints for d in joint.coefficients if d.coefficient == name]
        known = [size for size in sizes if isfinite(size) and size <= LARGEST_DETECTABLE]
        if known:
            ends = dict.fromkeys(percent(size) for size in (min(known), max(known)))
            parts.append(f"{' to '.join(ends)} % of {word}")
    return f": changes of {' and of '.join(parts)} are detectable, joint by joint" if parts else ""
