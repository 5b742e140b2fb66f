"""TwoSides: its document, its table for files, its warnings and its text."""

from collections.abc import Iterable, Iterator
from math import isfinite

from friction_audit.drift.covariates import INVALID, Condition
from friction_audit.drift.session import COEFFICIENTS
from friction_audit.drift.two_sides import CoefficientChange, JointChange, TwoSides
from friction_audit.friction.history import Coefficient
from friction_audit.reporting.documents import SETTINGS, WARNINGS
from friction_audit.reporting.drift_words import NAMES, UNITS, amount, how_much, limit_lines, total_text, verb_of
from friction_audit.reporting.notices import Notice, notice, reason_lines, session_sentences, text_of
from friction_audit.reporting.table import JOINTS, Column, Document, Record
from friction_audit.reporting.words import NOTHING, format_p, in_unit, iso_start, joints_label, signed

ADJUSTED = "p value of no change, adjusted over all joints and coefficients (Holm)"
RECORDING = Record(
    Column("path", str, "as given or found"),
    Column("sha256", str, "of the log"),
    Column("start", str, "ISO 8601, UTC", lambda one: iso_start(one.start_s), null=True),
    Column("duration", float, "length", unit="s"),
    Column("joints", int, "number of joints of the log", "log_joints"),
    Column("torque_unit", ("N m", "A", "mA"), "of the torque"),
    Column("method", str, "friction model and estimator"),
    Column("conditions", dict, "how it was recorded and read"),
    Column("damaged", bool, "whether part of the file was left out"),
    Column("warnings", [str], "what was noticed", lambda one: session_sentences(one.warnings)),
)


def _coefficient(unit: str) -> Record:
    return Record(
        Column("before", Coefficient, "random-effects mean where there are several recordings", "before", unit=unit),
        Column("after", Coefficient, "likewise", "after", unit=unit),
        Column("difference", Coefficient, "after less before", "found.change", unit=unit),
        Column("relative_change", Coefficient, "difference over the value before", "found.total"),
        Column("degrees_of_freedom", float, "of the difference (Welch-Satterthwaite)", "freedom"),
        Column("p_value", float, ADJUSTED, "found.p_value"),
        Column("single_p_value", float, "of this test alone (Welch)"),
        Column("changed", bool, "whether the adjusted p value is at most 0.05", "found.drift"),
        Column("smallest_detectable", float, "change found with 90 % power", "found.smallest_change", unit=unit),
        Column("smallest_detectable_relative", float, "the same over the value before", "found.smallest_drift"),
    )


LAW = Record(
    Column("speed", [float], "speed", unit="rad/s"),
    Column("change", [float], "friction torque after less before", unit="N m"),
    Column("low", [float], "lower end of its 95 % interval at this speed", unit="N m"),
    Column("high", [float], "upper end", unit="N m"),
)


def _from_to(change: CoefficientChange) -> str:
    values = [f"{one.value:.3g}" if isfinite(one.value) else NOTHING for one in (change.before, change.after)]
    return NOTHING if values == [NOTHING, NOTHING] else " -> ".join(values)


def _people(place: int, title: str, unit: str) -> tuple[Column, ...]:
    get = f"coefficients.{place}"
    return (
        Column("from_to", str, get=get, form=_from_to, unit=unit, title=title, on="t"),
        Column("change", float, get=f"{get}.found", form=total_text, on="t"),
        Column("p", float, get=f"{get}.found.p_value", form=format_p, on="t"),
    )


JOINT_CHANGE = Record(
    *JOINTS,
    Column("coulomb", _coefficient("N m"), "Coulomb friction", "coefficients.0"),
    Column("viscous", _coefficient("N m s/rad"), "viscous friction", "coefficients.1"),
    Column("law", LAW, "Coulomb plus viscous friction over the speed", on="j", null=True),
    Column("reason", str, "why an estimate is missing", lambda one: text_of(one.reason), null=True, on="j"),
    *_people(0, "Coulomb", "N m"),
    *_people(1, "viscous", "N m s/rad"),
)
CHANGES = Record(
    Column("coefficient", str, get="found.coefficient", on="f"),
    Column("unit", str, get=lambda change: UNITS[change.found.coefficient], on="f"),
    *_coefficient("").columns,
    name="changes",
    summary="a friction coefficient of a joint before and after, with 95 % intervals",
)
DIFF = Document(
    "diff/1",
    "The friction of an arm before and after",
    Column("before", [RECORDING], "recordings of the first side", "sides.before"),
    Column("after", [RECORDING], "recordings of the second side", "sides.after"),
    SETTINGS,
    WARNINGS,
    Column("changed", bool, "whether a coefficient of a joint changed", "sides.arms.0.drift"),
    Column("exceeded", [str], "limits that are exceeded, a sentence each"),
    Column("cannot_tell", [str], "limits that the two sides cannot test"),
    Column("joints", [JOINT_CHANGE], "joints that both sides have", "sides.joints"),
)


def diff_notices(sides: TwoSides) -> Iterator[Notice]:
    """Yield what limits the comparison."""
    yield from (notice("same_recording", path=path) for path in sides.twice)
    alike: dict[tuple[str, str, str], list[Condition]] = {}
    for one in sides.conditions:
        alike.setdefault((one.name, one.before, one.after), []).append(one)
    for (name, before, after), same in alike.items():
        joints = [one.joint for one in same if one.joint is not None]
        words = {"where": f"{joints_label(joints)}: " if joints else "", "name": name}
        words |= {"before": before or "none", "after": after or "none"}
        invalid = name in INVALID
        yield notice("not_comparable" if invalid else "conditions_differ", None if invalid else same[0].joint, **words)
    for number, first in sides.one_sided:
        yield notice("joint_on_one_side", number, side="before" if first else "after")
    for joint in sides.joints:
        if joint.reason:
            yield notice("not_compared", joint.joint, why=in_unit(text_of(joint.reason), sides.unit))


def diff_lines(sides: TwoSides, exceeded: Iterable[str] = (), cannot_tell: Iterable[str] = ()) -> list[str]:
    """Return what was compared, a row and a sentence per joint, and the limits."""
    lines = []
    for name, side in (("before", sides.before), ("after", sides.after)):
        first, last = side[0].path, side[-1].path
        lines.append(f"{name}: {first if len(side) == 1 else f'{len(side)} recordings, {first} to {last}'}")
    tests = sum(isfinite(one.single_p_value) for joint in sides.joints for one in joint.coefficients)
    lines += [f"changes with 95 % intervals; p adjusted over {tests} tests (Holm)"]
    lines += JOINT_CHANGE.people(sides.joints, "t", unit=sides.unit).lines()
    tested = (one for one in sides.joints if any(isfinite(found.single_p_value) for found in one.coefficients))
    lines += [in_unit(_sentence(joint), sides.unit) for joint in tested]
    lines += [in_unit(f"not compared: {line}", sides.unit) for line in reason_lines(sides.joints)]
    return lines + limit_lines(exceeded, cannot_tell)


def _sentence(joint: JointChange) -> str:
    """Return which coefficients of a joint changed, what would have been found, and the change of its torque."""
    parts = []
    for name, one in zip(COEFFICIENTS, joint.coefficients, strict=True):
        found = one.found
        if found.drift:
            size = how_much(found.total, found.change, UNITS[name])
            parts.append(f"{NAMES[name]} friction {verb_of(found.change)} by {size}")
        elif isfinite(one.single_p_value):
            least = amount(found.smallest_drift, found.smallest_change, name)
            parts.append(f"no change of {NAMES[name]} friction found, {least} is detectable")
    if joint.law is not None:
        law = joint.law
        ends = Coefficient(value=law.change_nm[-1], low=law.low_nm[-1], high=law.high_nm[-1])
        parts.append(f"friction at {law.speed_rad_s[-1]:.2g} rad/s {signed(ends)} N m")
    return f"joint {joint.joint}: {'; '.join(parts)}"
