"""All effects by name. Importing this module loads no numerics: effects are imported when they are first used."""

from collections.abc import Sequence
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

from friction_audit.errors import AnalysisError, near_misses

if TYPE_CHECKING:
    from friction_audit.effects.effect import Effect

# Family -> its effects -> the module of each, in the order of the documentation, of help and of the search. The module
# defines the effect as a class of its name.
FAMILIES = {
    "velocity": {
        "stribeck": "instant",
        "stiction": "breakaway",
        "nonlinear_viscous": "instant",
        "asymmetric_coulomb": "instant",
        "asymmetric_viscous": "instant",
        "presliding": "presliding",
        "frictional_lag": "delays",
    },
    "load and place": {
        "load_dependent_friction": "load",
        "position_dependent_friction": "position",
        "torque_ripple": "position",
        "gravity_error": "load",
        "cable_spring": "position",
        "joint_limit_stop": "position",
    },
    "sensors": {
        "torque_bias": "instant",
        "torque_drift": "slow",
        "time_delay": "delays",
        "torque_crosstalk": "neighbours",
    },
    "structure": {
        "joint_elasticity": "transmission",
        "backlash": "transmission",
        "inertia_error": "instant",
        "inertial_coupling": "neighbours",
    },
    "slow and events": {
        "warm_up": "slow",
        "friction_step": "slow",
        "contact_event": "slow",
        "unlogged_compensation": "instant",
    },
}
# Effects that no motion of one kind separates, and effects that may be a part of others where these are found too.
INDISTINGUISHABLE = ({"asymmetric_coulomb", "torque_bias"}, {"cable_spring", "joint_limit_stop"})
PART_OF = {
    "asymmetric_coulomb": ("torque_drift",),
    "torque_bias": ("torque_drift",),
    "presliding": ("backlash", "joint_elasticity"),  # effects_backlash_120003
    "time_delay": ("backlash", "joint_elasticity"),  # pairs_joint_elasticity+friction_step_90018
}
GRAVITY = "gravity_error"  # which is large where the torque holds gravity
MODULES = {name: module for members in FAMILIES.values() for name, module in members.items()}
NAMES = tuple(MODULES)


@cache
def effects() -> tuple["Effect", ...]:
    """Return the effects that a diagnosis may name, in the order of ``NAMES``."""
    found = {name: import_module(f"friction_audit.effects.{module}") for name, module in MODULES.items()}
    return tuple(getattr(module, name.title().replace("_", ""))() for name, module in found.items())


@cache
def terms() -> tuple["Effect", ...]:
    """Return everything that may be a term of a joint model: the nominal terms, then the effects with a formula."""
    nominal: tuple[Effect, ...] = import_module("friction_audit.effects.instant").NOMINAL
    return nominal + tuple(effect for effect in effects() if effect.coefficients)


@cache
def effect_of(name: str) -> "Effect":
    """Return an effect of ``effects()`` by name; KeyError if there is none."""
    return {effect.name: effect for effect in effects()}[name]


@cache
def term_of(name: str) -> "Effect":
    """Return a term by name; AnalysisError, with those that are near, if there is none."""
    known = {term.name: term for term in terms()}
    if name not in known:
        raise AnalysisError(f"{name!r} is no term; expected {', '.join(known)}{near_misses(name, known)}")
    return known[name]


def same_as(name: str) -> set[str]:
    """Return an effect with those that no motion of one kind separates from it."""
    return next((alike for alike in INDISTINGUISHABLE if name in alike), {name})


def motion_between(one: str, other: str) -> str:
    """Return which motion separates two effects; of a pair that is not easily confused, the motions of both."""
    first, second = effect_of(one), effect_of(other)
    known = first.separate.get(other) or second.separate.get(one)
    return known or "; ".join(dict.fromkeys([first.record, second.record]))


def motion_to_decide(name: str, alternatives: Sequence[str]) -> str:
    """Return the motion that separates an effect from its alternatives, or one for each; empty without any."""
    motions = {other: motion_between(name, other) for other in alternatives}
    if len(set(motions.values())) <= 1:
        return next(iter(motions.values()), "")
    return "; ".join(f"against {other}: {motion}" for other, motion in motions.items())
