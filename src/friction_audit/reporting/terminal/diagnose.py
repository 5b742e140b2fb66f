"""Diagnosis -> the table and the sentences that people read."""

import math
import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from friction_audit.diagnosis.candidates.contact_event import CANDIDATE as CONTACT
from friction_audit.diagnosis.candidates.warm_up import UNFELT_PER_K
from friction_audit.diagnosis.result import Effect, Evidence, JointDiscrepancy, others_of
from friction_audit.effects.joint_model import ArmModel
from friction_audit.effects.terms import TERMS
from friction_audit.friction.history import Coefficient
from friction_audit.pipeline import Diagnosis
from friction_audit.reporting.terminal.estimate import NOTHING, format_coefficient, joint_label
from friction_audit.reporting.terminal.plain import plain_lines
from friction_audit.reporting.units import in_unit

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text

TITLES = ("joint", "verdict", "missing", "before\n[N m]", "after\n[N m]", "floor\n[N m]", "closed\n[%]")
WORDS = 3
"""Columns of words; the others hold numbers."""
SMALLEST_P = 0.001
SIGNIFICANT = 0.05
"""Above it the locked cycles do not prove an effect by themselves."""
MOST_NUMBERS = 6
"""Parameters of an effect that a line has room for."""
UNITS = {parameter.name: parameter.unit for term in TERMS for parameter in term.parameters}
MEANINGS = {parameter.name: parameter.meaning for term in TERMS for parameter in term.parameters}
FACTORS = {term.name: tuple(parameter.name for parameter in term.coefficients) for term in TERMS}
SIZES = {"backlash": "gap_rad"}
"""Parameters that are an effect's size, where its factor is none."""
SCALED = ("s", "rad", "rad/(N m)")
"""Units of which a thousandth is easier to read where a number is small."""
SMALL = 0.02
ENDS = (("_hz", " Hz"), ("_s", " s"), ("_rad", " rad"), ("_nm", " N m"))
"""Last words of names that are units."""
IDLE = {"warm_up_per_k": UNFELT_PER_K}
"""Parameters, and the value that they have where what they are for is not used."""
UNTOLD = "not told by this log"
"""In the place of a number whose interval has no bounds."""


def diagnose_table(found: Diagnosis, *, verbose: bool = False) -> "list[Text]":
    """Return what was asked, a row per joint, and what is to be said of each.

    Args:
        found: The result.
        verbose: If True, also the rivals of an effect and what the log cannot show.
    """
    from rich.text import Text

    unit = found.estimate.log.source.torque_unit
    parts = [Text(line) for line in (*_head(found), *plain_lines(_table(found.discrepancy.joints, unit)))]
    for joints in _alike(found.discrepancy.joints, together=not verbose):
        parts.extend(Text(in_unit(line, unit)) for line in _sentences(joints))
        if verbose:
            parts.extend(Text(in_unit(f"  {line}", unit)) for line in _details(joints[0]))
    return parts


def _alike(joints: Sequence[JointDiscrepancy], *, together: bool) -> list[list[JointDiscrepancy]]:
    """Return the joints, those of which the same is to be said together."""
    groups: dict[object, list[JointDiscrepancy]] = {}
    for joint in joints:
        alone = joint.effects or joint.simulation is not None or not together
        groups.setdefault(joint.joint if alone else joint.message, []).append(joint)
    return list(groups.values())


def _head(found: Diagnosis) -> tuple[str, ...]:
    log = found.estimate.log
    samples = f"{len(log.t)} samples, {log.rate_hz:.6g} Hz, {log.duration_s:.6g} s"
    return (
        f"{log.source.path}: {log.source.format}, {samples}",
        f"interaction torque: {found.estimate.interaction.choice.formula}",
        f"declared model: {declared_model(found.settings.model)}",
        f"gaps are rms torques on cycles that no choice was made on{_locked(found)}; intervals are 95 %",
    )


def declared_model(model: ArmModel | None) -> str:
    """Return what the declared model is, in words."""
    if model is None:
        return "inertia, Coulomb and viscous friction, fitted"
    held = dict.fromkeys(name for joint in model.joints if joint is not None for name in joint.held)
    return "as given, its friction fitted again" + (f" except {', '.join(held)}, which it holds" if held else "")


def _locked(found: Diagnosis) -> str:
    """Return how many cycles were locked away, where any were."""
    counts = [joint.gap.cycles for joint in found.discrepancy.joints if joint.gap is not None]
    if not counts:
        return ""
    span = f"{min(counts)}" if min(counts) == max(counts) else f"{min(counts)} to {max(counts)}"
    return f" ({span} per joint)"


def _table(joints: tuple[JointDiscrepancy, ...], unit: str) -> "Table":
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False, collapse_padding=True)
    for column, title in enumerate(in_unit(TITLES, unit)):
        table.add_column(Text(title), justify="left" if column < WORDS else "right", no_wrap=True)
    for joint in joints:
        table.add_row(*_row(joint))
    return table


def _row(joint: JointDiscrepancy) -> tuple[str, ...]:
    missing = "\n".join(line for effect in joint.effects for line in _missing(effect, joint.effects)) or NOTHING
    return (joint_label(joint.joint, joint.name), joint.verdict.replace("_", " "), missing, *_gap(joint))


def _gap(joint: JointDiscrepancy) -> tuple[str, str, str, str]:
    gap = joint.gap
    if gap is None:
        return NOTHING, NOTHING, NOTHING, NOTHING
    if not joint.effects:
        return format_torque(gap.before), NOTHING, format_torque(gap.floor), NOTHING
    closed = NOTHING if math.isnan(gap.shrink) else f"{100 * gap.shrink:.1f}"
    return format_torque(gap.before), format_torque(gap.after), format_torque(gap.floor), closed


def format_torque(value: float) -> str:
    """Return a torque to a thousandth, a dash where there is none. [N m]"""
    return NOTHING if math.isnan(value) else f"{value:.3f}" if value < 10.0 else f"{value:.1f}"  # noqa: PLR2004


def _missing(effect: Effect, effects: Sequence[Effect]) -> Iterator[str]:
    """Yield one of some effects with its alternatives and its size, a line each."""
    yield effect.name
    yield from (f"or {other}" for other in others_of(effect, effects))
    yield f"  {_size(effect)}"


def _size(effect: Effect) -> str:
    """Return the number that is an effect's size; of several factors the rms of its torque, free of all else."""
    sizes = (SIZES[effect.name],) if effect.name in SIZES else FACTORS.get(effect.name, ())
    factors = [name for name in sizes if name in effect.parameters]
    if len(factors) == 1:
        return format_quantity(effect.parameters[factors[0]], UNITS[factors[0]])
    return f"{format_torque(effect.partial_nm)} N m rms"


def format_quantity(number: Coefficient, unit: str) -> str:
    """Return a value with its 95 % interval and unit, in thousandths where it is small.

    Examples: ``0.150 ± 0.010 N m``; ``3.1 ± 0.2 ms``.
    """
    if math.isnan(number.value):
        return NOTHING
    if math.isinf(number.high - number.low):
        return UNTOLD
    if unit in SCALED and abs(number.value) < SMALL:
        number = Coefficient(value=1e3 * number.value, low=1e3 * number.low, high=1e3 * number.high)
        unit = f"m{unit}"
    text = f"{number.value:.4g}" if number.low == number.high else format_coefficient(number)
    return text if unit in ("", "1") else f"{text} {unit}"


def _sentences(joints: Sequence[JointDiscrepancy]) -> Iterator[str]:
    """Yield what is to be said of joints alike: their message, each effect in numbers, the simulated motion."""
    numbers = ", ".join(str(joint.joint) for joint in joints)
    first = joints[0]
    yield f"joint{'s' if len(joints) > 1 else ''} {numbers}: {first.message}"
    for effect in first.effects:
        yield from (f"  {line}" for line in _effect(effect, first.message))
    gap = first.simulation
    if gap is not None:
        yield f"  simulated motion strays by {gap.before:.3g} -> {gap.after:.3g} {gap.unit} rms"


def _effect(effect: Effect, said: str) -> Iterator[str]:
    p_value = format_p_value(effect.p_value)
    if effect.p_value > SIGNIFICANT:
        p_value += " on the locked cycles alone, plain on all together"
    gap = f"gap {format_torque(effect.gap_before_nm)} -> {format_torque(effect.gap_after_nm)} N m"
    if effect.name == CONTACT.name:
        gap += " as its rows are left out, as they are above and in all that follows"
    yield f"{effect.name}: {'; '.join(text for text in (effect_numbers(effect), gap, p_value) if text)}"
    if effect.where not in said:
        yield f"  where: {effect.where}"
    if effect.decide:
        yield f"  to decide: {effect.decide}"


def format_p_value(p: float) -> str:
    """Return a p-value in words; nothing for an event, which no other cycle can confirm."""
    if math.isnan(p):
        return ""
    return f"p < {SMALLEST_P}" if p < SMALLEST_P else f"p = {p:.2g}"


def effect_numbers(effect: Effect) -> str:
    """Return the parameters in words; more than people can read are left to the document."""
    words = [_parameter(name, number) for name, number in effect.parameters.items()]
    if len(words) > MOST_NUMBERS:
        return f"{len(words)} numbers, see the JSON document"
    return ", ".join(word for word in words if word)


def _parameter(name: str, number: Coefficient) -> str:
    """Return a parameter in words: one of no term by its name alone, one that chooses a form by that form.

    Nothing where it only says that a part of the formula is not used.
    """
    if IDLE.get(name) == number.value:
        return ""
    if name not in MEANINGS:
        bare, unit = next(((name.removesuffix(end), unit) for end, unit in ENDS if name.endswith(end)), (name, ""))
        return f"{bare.replace('_', ' ')} {number.value:.4g}{unit}"
    meaning = MEANINGS[name]
    if CHOICE.match(meaning):
        return _choice(meaning, round(number.value))
    return f"{meaning} {format_quantity(number, UNITS.get(name, ''))}"


CHOICE = re.compile(r"(-?\d+|else) ([^,]+)")
"""An entry in the meaning of a parameter that chooses a form: ``0 smooth, 1 dead band, else so many steps``."""


def _choice(meaning: str, chosen: int) -> str:
    """Return the form that is chosen, or nothing if it is the usual one that needs no words."""
    forms: dict[str, str] = dict(CHOICE.findall(meaning))
    return forms.get(str(chosen), f"{forms['else']} {chosen}" if "else" in forms else "")


def _details(joint: JointDiscrepancy) -> Iterator[str]:
    """Yield what only some want to know."""
    for effect in joint.effects:
        for rival in effect.evidence:
            if rival.name != effect.name:
                yield _rival(effect, rival)
    if joint.effects and not math.isnan(joint.detection_limit_nm):
        yield f"what else is missing is below {joint.detection_limit_nm:.2g} N m rms"
    reasons: dict[str, list[str]] = {}
    for name, reason in joint.untestable.items():
        reasons.setdefault(reason, []).append(name)
    yield from (f"this log cannot show {', '.join(names)}: {reason}" for reason, names in reasons.items())


def _rival(effect: Effect, rival: Evidence) -> str:
    return f"{rival.name} in place of {effect.name}: BIC {rival.delta_bic:+.0f}, correlation {rival.correlation:.2f}"
