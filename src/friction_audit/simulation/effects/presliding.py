"""Presliding: springs that give way hold a joint at rest, so that friction depends on the path since a reversal."""

import math
from dataclasses import dataclass

from friction_audit.compiled import Record, compiled
from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import ALIKE, Given, HiddenEffect, Setting, Values, must, number, strength

LUGRE, DAHL, MAXWELL_SLIP = range(3)

BRISTLES = 8
FIRST_YIELD = sum(1.0 / k for k in range(1, BRISTLES + 1)) / BRISTLES
LINEAR = 1e-9
LEAST_LEVEL = 1e-6


@dataclass(frozen=True, kw_only=True, slots=True)
class Presliding(HiddenEffect):
    """Springs that hold the joint before it slides."""

    summary = "friction builds up like a spring over the path since a reversal"
    forms = ("lugre", "dahl", "maxwell_slip")

    displacement_rad: float = strength(0.005, "Coulomb friction over the stiffness at rest", "rad", upper=0.1)
    damping_s: float = number(0.005, "micro-damping over stiffness, LuGre form", "s", upper=0.1)
    exponent: float = number(1.5, "exponent of the Dahl form", lower=0.2, upper=3.0)
    form: int = LUGRE

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        bristles, reach, exponent, damping = values.values()
        all_of_it = abs(bristles - setting.joint.coulomb_nm) <= 2 * ALIKE * bristles
        must(all_of_it, "its bristles bear all of the Coulomb friction, no other share of it")
        if exponent == 1.0:
            return {"displacement_rad": reach, "damping_s": damping, "form": "lugre"}
        must(damping == 0.0, "its bristles with damping have the exponent 1")
        return {"displacement_rad": reach, "exponent": exponent, "form": "dahl"}


@compiled()
def stiffness(group: Record, coulomb_nm: float) -> float:
    """Return the stiffness at rest, constant whatever the present level; takes a displacement > 0. [N m/rad]"""
    return float(coulomb_nm / group.displacement_rad)


@compiled()
def lugre_advance(z: float, sigma0: float, level: float, velocity: float, h: float) -> float:
    """Move the deflection on by h at constant velocity: the exact solution of Canudas de Wit et al. (1995), eq. 1.

    Stable for every h, because the deflection decays towards its steady value by an exponential.
    """
    decay = sigma0 * abs(velocity) * h / level
    reached = -math.expm1(-decay) / decay if decay > 0.0 else 1.0
    return z * math.exp(-decay) + velocity * h * reached


@compiled()
def lugre_rate(z: float, sigma0: float, level: float, velocity: float) -> float:
    """Return the rate of the deflection: Canudas de Wit et al. (1995), eq. 1."""
    return velocity - sigma0 * abs(velocity) * z / level


@compiled()
def lugre_force(z: float, rate: float, sigma0: float, sigma1: float) -> float:
    """Return the force of the bristles of Canudas de Wit et al. (1995), without the viscous term."""
    return sigma0 * z + sigma1 * rate


@compiled()
def passive_damping(sigma1: float, level: float, velocity: float) -> float:
    """Return the micro-damping, less at speed, so that LuGre is passive at every viscous coefficient.

    With the stored energy sigma0 z^2 / 2, the dissipated power is a quadratic form in z and v that is not negative as
    long as sigma1 |v| <= 4 level. A constant sigma1 would take a viscous coefficient above sigma1 (Fs - Fc) / Fc
    (Barabanov and Ortega 2000).
    """
    return sigma1 / (1.0 + sigma1 * abs(velocity) / (4.0 * level))


@compiled()
def dahl_advance(z: float, sigma0: float, level: float, velocity: float, h: float, exponent: float) -> float:
    """Move the deflection on by h at constant velocity: the exact solution of Dahl (1976) for any exponent.

    What is missing to the steady value, as a share of the level, falls along the path at its power ``exponent``.
    """
    if velocity == 0.0:
        return z
    sign = 1.0 if velocity > 0.0 else -1.0
    path = sigma0 * abs(velocity) * h / level
    missing = 1.0 - sigma0 * z * sign / level
    bend = exponent - 1.0
    if abs(bend) < LINEAR or missing == 0.0:
        missing *= math.exp(-path)
    else:
        grown = 1.0 + bend * path * abs(missing) ** bend
        missing *= grown ** (-1.0 / bend) if grown > 0.0 else 0.0
    return sign * level * (1.0 - missing) / sigma0


@compiled()
def yield_rad(group: Record, k: int) -> float:
    """Return where element k of Maxwell-slip yields at the Coulomb level, uniformly spread (Iwan 1966). [rad]

    All elements bear the same share of the level; their first yield is such that their stiffness adds up to that at
    rest.
    """
    return float(group.displacement_rad * FIRST_YIELD * (k + 1))


@compiled()
def advance(group: Record, bristles: Float, coulomb_nm: float, level: float, velocity: float, h: float) -> None:
    """Move the deflections on by h at constant velocity, in place.

    Without Coulomb friction there is nothing that holds the joint, and nothing happens.
    LuGre and Dahl use the first deflection. Coulomb friction sets the stiffness; the level is that of steady sliding
    without the viscous part, at least a millionth of it.
    """
    if coulomb_nm <= 0.0:
        return
    level = max(level, LEAST_LEVEL * coulomb_nm)
    sigma0 = stiffness(group, coulomb_nm)
    if group.form == LUGRE:
        bristles[0] = lugre_advance(bristles[0], sigma0, level, velocity, h)
    elif group.form == DAHL:
        bristles[0] = dahl_advance(bristles[0], sigma0, level, velocity, h, group.exponent)
    else:
        for k in range(BRISTLES):
            limit = yield_rad(group, k) * level / coulomb_nm
            held = min(limit, max(-limit, bristles[k]))
            bristles[k] = min(limit, max(-limit, held + velocity * h))


@compiled()
def force_nm(group: Record, bristles: Float, coulomb_nm: float, level: float, velocity: float) -> float:
    """Return the friction torque without the viscous part, positive in steady motion forward (there: level). [N m]

    Passive in every form, also while the level changes: sigma0 z^2 / 2, summed over the elements, is the stored energy.
    LuGre and Dahl creep under a load that swings below break-away (Dupont et al. 2002); Maxwell-slip does not.
    """
    if coulomb_nm <= 0.0:
        return 0.0
    level = max(level, LEAST_LEVEL * coulomb_nm)
    sigma0 = stiffness(group, coulomb_nm)
    if group.form == LUGRE:
        sigma1 = passive_damping(group.damping_s * sigma0, level, velocity)
        return float(lugre_force(bristles[0], lugre_rate(bristles[0], sigma0, level, velocity), sigma0, sigma1))
    if group.form == DAHL:
        return float(sigma0 * bristles[0])
    force = 0.0
    for k in range(BRISTLES):
        force += coulomb_nm / (BRISTLES * yield_rad(group, k)) * bristles[k]
    return force
