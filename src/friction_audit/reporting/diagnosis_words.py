"""A diagnosis in words: the answer for a joint, its effects, where they show, what the residual still holds."""

import re
from collections.abc import Sequence

import numpy as np

from friction_audit.diagnosis.result import CONTACT_EVENT, JointDiagnosis, NamedEffect, Profile, ResidualCheck
from friction_audit.diagnosis.samples import LOWEST_CORNER_HZ
from friction_audit.effects.joint_model import ArmModel
from friction_audit.effects.registry import GRAVITY, NAMES, motion_between, terms
from friction_audit.effects.slow import UNFELT_PER_K
from friction_audit.friction.history import Coefficient
from friction_audit.reporting.notices import text_of
from friction_audit.reporting.words import UNBOUNDED, count_of, enumerate_words, format_share, with_unit

MOST_NUMBERS = 6  # parameters of an effect that a line has room for
PARAMETERS_BY_NAME = {parameter.name: parameter for term in terms() for parameter in term.parameters}
# Last words of names that are units, of parameters that no term has.
ENDS = {"_hz": " Hz", "_s": " s", "_rad": " rad", "_nm": " N m"}
# Parameters, and the value at which the part of the formula that they belong to is not used.
IDLE = {"warm_up_per_k": UNFELT_PER_K}
# An entry in the meaning of a parameter that chooses a form: ``0 smooth, 1 dead band, else so many steps``.
CHOICE = re.compile(r"(-?\d+|else) ([^,]+)")
UNDERSCORED = re.compile(rf"\b({'|'.join(name for name in (*NAMES, CONTACT_EVENT) if '_' in name)})\b")
CONTACTS_LISTED = 3
CLEAR = 2.0  # standard errors from which the mean of a bin differs from zero
UNITS = {
    "speed": "rad/s", "position": "rad", "displacement": "rad after a reversal", "acceleration": "rad/s²", "time": "s",
    "load": "N m of load", "temperature": "°C", "neighbour": "rad/s² of a neighbour",
}  # fmt: skip
# Axes that a sentence calls otherwise.
AXES = {"displacement": "displacement since a reversal", "neighbour": "acceleration of a neighbour"}


def others_of(effect: NamedEffect, effects: Sequence[NamedEffect]) -> tuple[str, ...]:
    """Return what an effect may be instead, in words: another name, or a part of an effect that is named as well."""
    named = {one.name for one in effects}
    names = [name for name in effect.alternatives if name not in named]
    return (*names, *(f"a part of {name}" for name in effect.alternatives if name in named))


def plain_names(text: str) -> str:
    """Return a text with the names of effects as people write them, without underscores."""
    spaced = UNDERSCORED.sub(lambda found: found[0].replace("_", " "), text)
    return re.sub("coulomb|stribeck", lambda found: found[0].title(), spaced)


def nominal_model(model: ArmModel | None) -> str:
    """Return what the nominal model is, in words."""
    if model is None:
        return "inertia, Coulomb and viscous friction, fitted"
    held = dict.fromkeys(name for joint in model.joints if joint is not None for name in joint.held)
    return "as given, its friction fitted again" + (f" except {', '.join(held)}, which it holds" if held else "")


def joint_message(joint: JointDiagnosis) -> str:
    """Return the answer for a joint in a sentence: cause, size, what to do; tables and details have the rest."""
    if joint.reason:
        return text_of(joint.reason)
    if joint.verdict == "adequate":
        small = "negligible effects apart, no effect" if joint.negligible else "no effect"
        band = "" if joint.traces is None else f" below {joint.traces.corner_hz:.2g} Hz"
        limit = f"{small}{band} exceeds the detection limit of {joint.detection_limit_nm:.2g} N m RMS"
        return "; ".join(filter(None, (limit, lost_in_noise(joint))))
    gap, unknown, parts = joint.gap, joint.verdict == "unexplained", []
    if unknown:
        size = "" if gap is None else f" ({gap.after:.2g} N m RMS, noise floor {gap.floor:.2g} N m)"
        if gap is not None and joint.checks and f"{gap.after:.2g}" == f"{gap.floor:.2g}":  # noise that has structure
            size = f" ({gap.after:.2g} N m RMS), with {remainder_words(joint, 1)},"
        share = f"{format_share(joint.remainder_share)} of " if joint.remainder_share else ""
        parts.append(f"{share}the residual{size} is unexplained")
    if any(effect.name == CONTACT_EVENT for effect in joint.effects):
        contacts = 0 if joint.contacts is None else len(joint.contacts.spans_s)
        parts.append(f"{count_of(contacts, 'contact')} left out")
    if joint.added or not unknown:
        parts.append(_missing(joint) if joint.added else "no other effect is missing")
    return "; ".join((*parts, _todo(joint)))


def lost_in_noise(joint: JointDiagnosis) -> str:
    """Return what the log cannot show where its noise asks for the lowest corner; empty elsewhere."""
    if joint.traces is None or joint.traces.corner_hz > LOWEST_CORNER_HZ:
        return ""
    return f"what is faster than {joint.traces.corner_hz:.2g} Hz is lost in the noise of the acceleration"


def _missing(joint: JointDiagnosis) -> str:
    first, *rest = joint.added
    others = others_of(first, joint.effects)
    names = first.name if not others else f"{first.name} or {f'{len(others)} others' if others[1:] else others[0]}"
    share = "" if np.isnan(first.friction_share) else f", {format_share(first.friction_share)} of friction"
    return f"missing: {names} ({first.size_nm:.2g} N m RMS{share}){f' and {len(rest)} more' if rest else ''}"


def _todo(joint: JointDiagnosis) -> str:
    unexplained = joint.verdict == "unexplained"
    in_torque = any((one.code, one.verdict) == ("gravity", "limit") for one in joint.findings)
    if in_torque and (unexplained or any(one.axis in ("position", "load") for one in joint.added)):
        return "gravity is in the torque: give a model of the arm (--robot, --urdf)"
    if unexplained:
        return "look at the figure residual"
    if (unsure := next((one for one in joint.effects if one.alternatives), None)) is not None:
        motion = motion_between(unsure.name, unsure.alternatives[0])
        which = "" if joint.added[:1] == (unsure,) else f" {unsure.name}"
        return f"to separate{which}: {motion.partition(':')[0].partition(';')[0]}"
    it = "it" if len(joint.added) == 1 else "them"
    if GRAVITY in [one.name for one in joint.added]:
        return f"give payload or model of the arm, or add {it} to the model (model.toml)"
    return f"add {it} to the model (model.toml)" if joint.added else "record again without contact"


def negligible_words(joint: JointDiagnosis) -> str:
    """Return the negligible effects with their sizes."""
    return ", ".join(f"{one.name} {one.size_nm:.2g} N m RMS" for one in joint.negligible)


def remainder_words(joint: JointDiagnosis, most: int | None = None) -> str:
    """Return what the augmented model leaves that is no noise, the largest share first."""
    found: dict[tuple[str, str], list[ResidualCheck]] = {}
    for check in joint.checks:
        found.setdefault((check.code, check.along), []).append(check)
    words = [_check(code, along, same, joint) for (code, along), same in found.items()]
    return enumerate_words([*words[:most], f"{len(words) - most} more"] if most and len(words) > most else words)


def _check(code: str, along: str, same: Sequence[ResidualCheck], joint: JointDiagnosis) -> str:
    if code == "line":
        unit = "Hz" if along == "time" else "waves per rad of path"
        numbers = enumerate_words(f"{check.frequency:.2g}" for check in same)
        return f"{'spectral lines' if len(same) > 1 else 'a spectral line'} at {numbers} {unit}"
    if code == "curve":
        where = next((where_words(one) for one in joint.remaining if one.axis == along), "")
        span, _, direction = where.partition(", ")
        return f"a curve {span} ({direction})" if where else f"a curve over {AXES.get(along, along)}"
    if code == "response":
        return f"a linear response to {along} (a filter, a spring)"
    return "friction that varies from cycle to cycle" if code == "scatter" else f"{along} that changes within the log"


def where_effect(effect: NamedEffect, joint: JointDiagnosis) -> str:
    """Return where an effect shows itself; empty where no quantity of the motion shows it."""
    if effect.name != CONTACT_EVENT:
        return "" if effect.own is not None else where_words(effect.curve)
    spans = () if joint.contacts is None else joint.contacts.spans_s
    places = ", ".join(f"at {start:.1f} s ({stop - start:.2g} s long)" for start, stop in spans[:CONTACTS_LISTED])
    more = len(spans) - CONTACTS_LISTED
    return places + (f" and {more} more" if more > 0 else "")


def where_words(curve: Profile) -> str:
    """Return the stretch of an axis on which a torque is clear and large, and in which direction; empty for none."""
    up, up_se, down, down_se = curve.forwards, curve.forwards_se, curve.backwards, curve.backwards_se
    size = np.fmax(np.abs(up), np.abs(down))
    clear = (np.abs(up) > CLEAR * up_se) | (np.abs(down) > CLEAR * down_se)
    if curve.axis not in UNITS or not np.any(clear & np.isfinite(size)):
        return ""
    large = np.flatnonzero(clear & (size >= 0.5 * np.nanmax(np.where(clear, size, np.nan))))
    low, high = float(curve.edges[large[0]]), float(curve.edges[large[-1] + 1])
    span = _span(curve.axis, low, high, from_start=large[0] == 0, to_end=large[-1] == len(size) - 1)
    strength = []  # root mean square of a direction in standard errors: about 1 where nothing is, 0 if it is empty
    for mean, error in ((up[large], up_se[large]), (down[large], down_se[large])):
        ratio = mean[error > 0] / error[error > 0]
        strength.append(float(np.sqrt(np.mean(ratio**2))) if len(ratio) else 0.0)
    clear_up, clear_down = strength
    direction = "forwards only" if clear_up > clear_down else "backwards only"
    if min(clear_up, clear_down) > CLEAR:
        against = np.nansum(up[large]) * np.nansum(down[large]) < 0
        direction = "against the motion" if against else "same sign in both directions"
    return f"{span}, {direction}"


def _span(axis: str, low: float, high: float, *, from_start: bool, to_end: bool) -> str:
    below, above = ("before", "after") if axis == "time" else ("below", "above")
    if from_start and to_end:
        return "over the whole log" if axis == "time" else f"over the whole range of {AXES.get(axis, axis)}"
    span = f"{below} {high:.3g}" if from_start else f"{above} {low:.3g}" if to_end else f"from {low:.3g} to {high:.3g}"
    return f"{span} {UNITS[axis]}"


def effect_numbers(effect: NamedEffect, most: float = MOST_NUMBERS) -> str:
    """Return the parameters in words; more than people can read are left to the document."""
    lost = effect.not_identifiable
    words = [_parameter(name, number) for name, number in effect.parameters.items() if name not in lost]
    text = ", ".join(filter(None, words)) if len(words) <= most else f"{len(words)} parameters, in the document"
    meanings = (PARAMETERS_BY_NAME[name].meaning if name in PARAMETERS_BY_NAME else name for name in lost)
    unknown = f"{UNBOUNDED} from this log: {', '.join(meanings)}" if lost else ""
    return "; ".join(filter(None, (text, unknown)))


def _parameter(name: str, number: Coefficient) -> str:
    """Nothing for a part of the formula that is not used; of a parameter that chooses a form, that form."""
    if IDLE.get(name) == number.value:
        return ""
    known = PARAMETERS_BY_NAME.get(name)
    if known is None:
        end = next((end for end in ENDS if name.endswith(end)), "")
        return f"{name.removesuffix(end).replace('_', ' ')} {number.value:.4g}{ENDS.get(end, '')}"
    if CHOICE.match(known.meaning):
        forms: dict[str, str] = dict(CHOICE.findall(known.meaning))
        chosen = str(round(number.value))
        return forms.get(chosen, f"{forms['else']} {chosen}" if "else" in forms else "").removeprefix("if ")
    return f"{known.meaning} {with_unit(number, known.unit)}"
