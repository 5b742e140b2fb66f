"""The verdict on a joint and its effects in the few words that fit into a figure or a table's cell."""

import re
from collections.abc import Sequence

from friction_audit.diagnosis.result import JointDiagnosis, NamedEffect, others_of
from friction_audit.effects.joint_model import ArmModel
from friction_audit.effects.registry import terms
from friction_audit.effects.warm_up import UNFELT_PER_K
from friction_audit.friction.history import Coefficient
from friction_audit.reporting.words import format_quantity, format_torque

# Parameters of an effect that a line has room for.
MOST_NUMBERS = 6
PARAMETERS_BY_NAME = {parameter.name: parameter for term in terms() for parameter in term.parameters}
COEFFICIENTS = {term.name: tuple(parameter.name for parameter in term.coefficients) for term in terms()}
# Parameters that are an effect's size, where its coefficient is not.
SIZES = {"backlash": ("gap_rad",)}
# Last words of names that are units, of parameters that no term has.
ENDS = {"_hz": " Hz", "_s": " s", "_rad": " rad", "_nm": " N m"}
# Parameters, and the value at which the part of the formula that they belong to is not used.
IDLE = {"warm_up_per_k": UNFELT_PER_K}
# An entry in the meaning of a parameter that chooses a form: ``0 smooth, 1 dead band, else so many steps``.
CHOICE = re.compile(r"(-?\d+|else) ([^,]+)")


def names_of(effect: NamedEffect, effects: Sequence[NamedEffect]) -> str:
    """Return the name of one of some effects and of those indistinguishable from it."""
    return " or ".join((effect.name, *others_of(effect, effects)))


def verdict_words(joint: JointDiagnosis) -> str:
    """Return a verdict with the names it gives."""
    word = joint.verdict.replace("_", " ")
    named = " and ".join(names_of(effect, joint.effects) for effect in joint.effects)
    if joint.verdict == "unexplained" and named:
        return f"{word}, with {named}"
    return f"{word}: {named}" if named else word


def energy_disagreements(joint: JointDiagnosis) -> tuple[str, ...]:
    """Return what may cause friction coefficients of torque fit and energy method whose intervals do not overlap."""
    found = []
    for name, words in (("viscous_nms_per_rad", _viscous_differs), ("coulomb_nm", _coulomb_differs)):
        if name in joint.nominal and name in joint.from_energy:
            torque, energy = joint.nominal[name], joint.from_energy[name]
            if energy.low > torque.high or energy.high < torque.low:
                found.append(words(energy.value, torque.value))
    return tuple(found)


def _viscous_differs(energy: float, torque: float) -> str:
    cause = (
        "a delay between velocity and torque, or viscous friction that is not linear"
        if energy > torque
        else "friction that is larger at low speed, or energy that goes to other joints"
    )
    return f"viscous friction {energy:.3g} N m s/rad from energy, {torque:.3g} from torque: {cause}"


def _coulomb_differs(energy: float, torque: float) -> str:
    return (
        f"Coulomb friction {energy:.3g} N m from energy, {torque:.3g} from torque: "
        "an offset of the torque, an error of gravity, or energy that goes to other joints"
    )


def nominal_model(model: ArmModel | None) -> str:
    """Return what the nominal model is, in words."""
    if model is None:
        return "inertia, Coulomb and viscous friction, fitted"
    held = dict.fromkeys(name for joint in model.joints if joint is not None for name in joint.held)
    return "as given, its friction fitted again" + (f" except {', '.join(held)}, which it holds" if held else "")


def effect_size(effect: NamedEffect) -> str:
    """Return the number that is an effect's size; of several coefficients the RMS of its torque given all else."""
    names = [name for name in SIZES.get(effect.name, COEFFICIENTS.get(effect.name, ())) if name in effect.parameters]
    if len(names) == 1:
        return format_quantity(effect.parameters[names[0]], PARAMETERS_BY_NAME[names[0]].unit)
    return f"{format_torque(effect.size_nm)} N m rms"


def effect_numbers(effect: NamedEffect) -> str:
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
    known = PARAMETERS_BY_NAME.get(name)
    if known is None:
        end = next((end for end in ENDS if name.endswith(end)), "")
        return f"{name.removesuffix(end).replace('_', ' ')} {number.value:.4g}{ENDS.get(end, '')}"
    if CHOICE.match(known.meaning):
        forms: dict[str, str] = dict(CHOICE.findall(known.meaning))
        chosen = str(round(number.value))
        return forms.get(chosen, f"{forms['else']} {chosen}" if "else" in forms else "")
    return f"{known.meaning} {format_quantity(number, known.unit)}"
