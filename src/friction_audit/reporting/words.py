"""Numbers, dates and lists as people read them, the same in tables, figures and pages."""

import math
import re
from collections.abc import Callable, Iterable
from datetime import UTC, datetime

from friction_audit.errors import printable
from friction_audit.friction.history import Coefficient

NEWTON_METRES = "N m"
NOTHING = "-"
MARK = "!"  # of a row of a table with a warning about its physics
UNBOUNDED = "not identifiable"
# Characters of a joint's name: no column and no panel has room for more; the same above a panel or a column of joints.
LONGEST_NAME, SHORTEST_NAME = 24, 16
LOPSIDED = 0.25  # share by which the two sides of an interval may differ and still be written as one
MOST_DIGITS = 4  # no sensor of a joint resolves more, and the table stays narrower than a terminal; a motor's may
SMALLEST_P = 0.001
TWO_DIGITS = 99.5  # larger numbers of per cent are written with all their digits
SCALED, SMALL = ("s", "rad", "rad/(N m)"), 0.02  # units of which a thousandth is easier to read where a number is small
ROUGH = 2.0  # first figure of a slope's interval from which on one figure will do
WIDEST_RELATIVE = 20.0  # width of an interval of a relative change above which its digits mean nothing
LAST_S = 253402300799.0  # the last second of the year 9999, beyond which no calendar goes
# Units that follow from that of the torque.
FROM_TORQUE = {NEWTON_METRES: "{}", "[J]": "[{} rad]", "kg m²": "{} s²/rad", "kg m^2": "{} s^2/rad"}


def in_unit(text: str, torque_unit: str) -> str:
    """Return a unit, or a sentence of the analysis with units in it, where the torque is in another one."""
    if torque_unit == NEWTON_METRES:
        return text
    if text == "J":
        return f"{torque_unit} rad"
    for metric, other in FROM_TORQUE.items():
        text = text.replace(metric, other.format(torque_unit))
    return re.sub(r"(?<=\d) J\b", f" {torque_unit} rad", text)


def joint_label(joint: int, name: str, most: int = LONGEST_NAME) -> str:
    """Return the joint's number, and its name where that says more; a long one is cut before its end, which differs."""
    shown = " ".join(printable(name).split())
    if len(shown) > most and len(shown := shown.removesuffix("_joint")) > most:
        shown = f"{shown[: most // 4]}\N{HORIZONTAL ELLIPSIS}{shown[1 + most // 4 - most :]}"
    return str(joint) if not shown or re.search(rf"(?<!\d)0*{joint}$", name) else f"{joint} {shown}"


def format_coefficient(coefficient: Coefficient) -> str:
    """Return value and interval with the digits that it leaves: ``0.245 ± 0.006``, lopsided ``0.25 +0.01/-0.03``."""
    if math.isnan(coefficient.value):
        return NOTHING
    up, down = coefficient.high - coefficient.value, coefficient.value - coefficient.low
    if math.isnan(up + down):
        return f"{coefficient.value:.4g}"
    wide = max(up, down)
    most = max(MOST_DIGITS, 2 - math.floor(math.log10(abs(coefficient.value) or 1.0)))
    digits = most if wide <= 0 else min(max(1 - math.floor(math.log10(wide)), 0), most)
    last = 10.0**-digits
    value, above, below = (f"{side:.{digits}f}" for side in (coefficient.value, max(up, last), max(down, last)))
    holds_zero = coefficient.low < 0.0 < coefficient.high
    if abs(up - down) <= LOPSIDED * wide and (wide > abs(coefficient.value)) == holds_zero:
        return f"{value} ± {max(wide, last):.{digits}f}"
    return f"{value} +{above}/-{below}"


def with_unit(number: Coefficient, unit: str) -> str:
    """Return a value with its 95 % interval and unit, in thousandths where it is small: ``3.1 ± 0.2 ms``."""
    if math.isnan(number.value):
        return NOTHING
    if math.isinf(number.high - number.low):
        return UNBOUNDED
    if unit in SCALED and abs(number.value) < SMALL:
        number, unit = scaled(number, 1e3), f"m{unit}"
    text = f"{number.value:.4g}" if number.low == number.high else format_coefficient(number)
    return text if unit in ("", "1") else f"{text} {unit}"


def scaled(number: Coefficient, factor: float) -> Coefficient:
    """Return a value and its interval in another unit; the factor is positive."""
    return Coefficient(value=factor * number.value, low=factor * number.low, high=factor * number.high)


def signed(number: Coefficient) -> str:
    """Return a value with its interval and always a sign."""
    text = format_coefficient(number)
    return text if number.value < 0.0 or text == NOTHING else f"+{text}"


def format_percent(relative: Coefficient) -> str:
    """Return a relative change with its 95 % interval: ``+15.2 ± 1.9 %``; rounded where it has none."""
    if math.isnan(relative.value):
        return NOTHING
    if math.isnan(relative.low + relative.high):
        return f"{100.0 * relative.value:+.2g} %"
    return UNBOUNDED if relative.high - relative.low > WIDEST_RELATIVE else f"{signed(scaled(relative, 100.0))} %"


def percent(share: float) -> str:
    """Return a share in per cent, two digits of it, more where it is large."""
    return f"{100 * share:.2g}" if abs(100 * share) < TWO_DIGITS else f"{100 * share:.0f}"


def format_share(share: float) -> str:
    """Return a share as a percentage, above 100 % only that it is."""
    return NOTHING if math.isnan(share) else ">100 %" if share > 1.0 else f"{percent(share)} %"


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


def format_p(p: float) -> str:
    """Return a p-value in the cell of a table."""
    return NOTHING if math.isnan(p) else f"< {SMALLEST_P}" if p < SMALLEST_P else f"{p:.2g}"


def iso_start(start_s: float | None) -> str | None:
    """Return when a recording began as ISO 8601, UTC; None where it is not known or no calendar has it."""
    if start_s is None or not 0.0 <= start_s <= LAST_S:
        return None
    return datetime.fromtimestamp(start_s, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def format_start(start_s: float | None) -> str:
    """Return when a recording began, to the minute, UTC; a dash where that is not known."""
    return (iso_start(start_s) or NOTHING)[:16].replace("T", " ")


def format_date(start_s: float | None) -> str:
    """Return the day on which a recording began, UTC; a dash where that is not known."""
    return (iso_start(start_s) or NOTHING)[:10]


def count_of(number: int, thing: str) -> str:
    """Return a number of things: ``1 session``, ``2 sessions``."""
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"


def enumerate_words(words: Iterable[object]) -> str:
    """Return words as people list them: ``1, 2 and 3``; nothing for none."""
    *rest, last = [*map(str, words)] or [""]
    return f"{', '.join(rest)} and {last}" if rest else last


def range_of(values: Iterable[float], form: Callable[[float], str]) -> str:
    """Return the smallest and the largest of some numbers, ``1 to 3``, or one text where both have the same."""
    found = list(values)
    return " to ".join(dict.fromkeys(map(form, (min(found), max(found)))))


def joints_label(numbers: Iterable[int]) -> str:
    """Return ``joint 1`` or ``joints 1, 3``."""
    found = list(dict.fromkeys(numbers))
    return f"joint{'s' if len(found) > 1 else ''} {', '.join(map(str, found))}"
