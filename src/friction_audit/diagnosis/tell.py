"""What people are told of a joint: its effects with sizes and places, and one message."""

from collections.abc import Mapping, Sequence

import numpy as np

from friction_audit.diagnosis.contacts import Undisturbed
from friction_audit.diagnosis.curves import Curve
from friction_audit.diagnosis.declared import least_squares
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.naming import Found, Names
from friction_audit.diagnosis.parameters import Parameters
from friction_audit.diagnosis.profiles import profile_all
from friction_audit.diagnosis.result import Effect, Evidence, Profile, Verdict, Vibration, others_of
from friction_audit.diagnosis.shown_along import shows_along
from friction_audit.effects.contact_event import EFFECT as CONTACT
from friction_audit.effects.registry import motion_to_decide
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float

RIVALS_SHOWN = 6
CONTACTS_TOLD = 3


def effects_of(ground: Ground, names: Names, curves: Sequence[Curve], numbers: Parameters) -> tuple[Effect, ...]:
    """The accepted effects as results, the strongest first, gaps on locked cycles one after the other."""
    found = names.found
    columns = np.hstack([ground.base, *(f.columns for f in found)])
    factors = least_squares(columns[ground.working], ground.y[ground.working])
    effects, at = [], ground.base.shape[1]
    for k, f in enumerate(found):
        width = f.columns.shape[1]
        torque = f.columns @ factors[at : at + width]
        at += width
        effects.append(_effect(ground, found, k, torque, numbers.effects[k], curves))
    return tuple(effects)


def _effect(
    ground: Ground,
    found: Sequence[Found],
    k: int,
    torque: Float,
    parameters: dict[str, Coefficient],
    curves: Sequence[Curve],
) -> Effect:
    f = found[k]
    before, after = (
        float(np.sqrt(np.mean(ground.residual(*(g.columns for g in found[:upto]))[ground.locked] ** 2)))
        for upto in (k, k + 1)
    )
    others = np.hstack([ground.base, *(g.columns for g in found if g is not f)])
    free = torque - others @ least_squares(others, torque)
    curve = _curve(ground, ground.residual(*(g.columns for g in found)) + torque, f, curves)
    return Effect(
        name=f.candidate.name,
        label=f.candidate.label,
        alternatives=f.naming.alternatives,
        together=f.naming.together,
        decide=motion_to_decide(f.candidate.name, f.naming.alternatives),
        parameters=parameters,
        p_value=f.p_value,
        where=_where(ground, torque, curve, curves),
        axis=f.candidate.axis,
        gap_before_nm=before,
        gap_after_nm=after,
        partial_nm=float(np.sqrt(np.mean(free**2))),
        torque=torque,
        curve=curve,
        evidence=(
            Evidence(name=f.candidate.name, delta_bic=0.0, correlation=1.0),
            *(
                Evidence(name=r.name, delta_bic=r.delta_bic, correlation=r.correlation)
                for r in sorted(f.naming.rivals, key=lambda r: r.delta_bic)[:RIVALS_SHOWN]
            ),
        ),
    )


def _where(ground: Ground, torque: Float, curve: Profile, curves: Sequence[Curve]) -> str:
    """Where the effect is, told only on an axis that it is a curve over."""
    speed = ground.data.dq[:: ground.rows.every][ground.rows.used]
    along = next(one.values for one in curves if one.axis.name == curve.axis)
    return curve.where if curve.where and shows_along(torque, along, speed) else "spread over the whole motion"


def contact_effects(ground: Ground, undisturbed: Undisturbed) -> tuple[Effect, ...]:
    """Contacts as one effect: the gap is that of all locked rows before, and of those that are left after."""
    contacts = undisturbed.contacts
    if not contacts:
        return ()
    before, after = (float(np.sqrt(np.mean(g.residual()[g.locked] ** 2))) for g in (ground, undisturbed.ground))
    speed = ground.data.dq[:: ground.rows.every][ground.rows.used]
    profiles = profile_all(ground.residual(), ground.curves, speed, ground.rows.cycle, None)
    lengths = [contact.stop_s - contact.start_s for contact in contacts]
    told = ", ".join(f"at {c.start_s:.1f} s ({c.stop_s - c.start_s:.2g} s long)" for c in contacts[:CONTACTS_TOLD])
    more = f" and {len(contacts) - CONTACTS_TOLD} more" if len(contacts) > CONTACTS_TOLD else ""
    numbers = {
        "contacts": float(len(contacts)),
        "first_contact_s": contacts[0].start_s,
        "longest_contact_s": max(lengths),
        "largest_contact_nm": _largest(ground, undisturbed),
    }
    nothing = np.zeros(len(undisturbed.ground.y))
    effect = Effect(
        name=CONTACT.name,
        label=CONTACT.label,
        alternatives=(),
        decide="",
        parameters={name: Coefficient(value=v, low=float("nan"), high=float("nan")) for name, v in numbers.items()},
        p_value=float("nan"),
        where=told + more,
        axis=CONTACT.axis,
        gap_before_nm=before,
        gap_after_nm=after,
        partial_nm=float(np.sqrt(max(before**2 - after**2, 0.0))),
        torque=nothing,
        curve=next(profile for profile in profiles if profile.axis == CONTACT.axis),
        evidence=(Evidence(name=CONTACT.name, delta_bic=0.0, correlation=1.0),),
    )
    return (effect,)


def _largest(ground: Ground, undisturbed: Undisturbed) -> float:
    """The torque of all contacts that is farthest from none, with its sign; none where no row is left in them. [N m]"""
    clean = undisturbed.ground
    left = (ground.y - ground.base @ least_squares(clean.base, clean.y)) / ground.rows.weight
    touched = left[~np.isin(ground.rows.t, clean.rows.t)]
    return float(touched[np.argmax(np.abs(touched))]) if len(touched) else 0.0


def _curve(ground: Ground, shown: Float, f: Found, curves: Sequence[Curve]) -> Profile:
    """What an effect and the noise leave along the effect's own axis, or the most telling one where it has none."""
    speed = ground.data.dq[:: ground.rows.every][ground.rows.used]
    profiles = profile_all(shown, curves, speed, ground.rows.cycle, None)
    return next((profile for profile in profiles if profile.axis == f.candidate.axis), profiles[0])


def message_of(
    verdict: Verdict,
    effects: Sequence[Effect],
    remaining: Sequence[Profile],
    also: Sequence[str],
    limit_nm: float,
    significant: bool,
    untestable: Mapping[str, str],
) -> str:
    """One or two sentences; ``also`` are phrases on what follows no quantity of the motion."""
    named = " and ".join(f"{e.name} ({e.label})" for e in effects)
    if verdict == "adequate" and significant:
        return (
            "nothing large enough for a name is missing: the residual is coloured, and no function of the motion "
            f"explains 2 % of it; an effect of {limit_nm:.2g} N m rms is detectable"
        )
    if verdict == "adequate":
        return f"nothing is missing: an effect of {limit_nm:.2g} N m rms is detectable"
    if verdict == "not_testable":
        return "; ".join(dict.fromkeys(untestable.values()))
    if verdict == "unexplained":
        at = next((p.where for p in remaining if p.where), "spread over the whole motion")
        what = f"in addition to {named} something" if effects else "something"
        return f"{what} is missing that nothing in the catalogue explains: {'; '.join((at, *also))}"
    if verdict == "ambiguous":
        unsure = "; ".join(
            f"{e.name} cannot be separated from {', '.join(others_of(e, effects))} in this log"
            for e in effects
            if e.alternatives
        )
        return f"{named}: {unsure}"
    return f"{named}: {effects[0].where}"


def vibration_of(vibration: Vibration) -> str:
    """Where a vibration is."""
    return (
        f"a vibration at {vibration.frequency_hz:.3g} Hz ({vibration.low_hz:.3g} to {vibration.high_hz:.3g} Hz), "
        f"{vibration.rms_nm:.2g} N m rms"
    )
