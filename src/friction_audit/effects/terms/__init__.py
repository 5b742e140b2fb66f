"""The terms there are: one file each."""

import difflib

from friction_audit.effects.term import Term
from friction_audit.effects.terms import (
    asymmetric_coulomb,
    asymmetric_viscous,
    backlash,
    cable_spring,
    coulomb,
    friction_step,
    frictional_lag,
    gravity_error,
    inertia,
    inertia_error,
    inertial_coupling,
    joint_elasticity,
    joint_limit_stop,
    load_dependent_friction,
    nonlinear_viscous,
    offset,
    position_dependent_friction,
    presliding,
    stiction,
    stribeck,
    time_delay,
    torque_bias,
    torque_crosstalk,
    torque_drift,
    torque_ripple,
    unlogged_compensation,
    viscous,
    warm_up,
)
from friction_audit.errors import AnalysisError

__all__ = ["TERMS", "near_names", "term_of"]

TERMS: tuple[Term, ...] = (
    inertia.TERM,
    coulomb.TERM,
    viscous.TERM,
    offset.TERM,
    stribeck.TERM,
    nonlinear_viscous.TERM,
    position_dependent_friction.TERM,
    torque_ripple.TERM,
    cable_spring.TERM,
    joint_limit_stop.TERM,
    torque_drift.TERM,
    warm_up.TERM,
    friction_step.TERM,
    stiction.TERM,
    presliding.TERM,
    frictional_lag.TERM,
    time_delay.TERM,
    joint_elasticity.TERM,
    backlash.TERM,
    asymmetric_coulomb.TERM,
    asymmetric_viscous.TERM,
    torque_bias.TERM,
    torque_crosstalk.TERM,
    load_dependent_friction.TERM,
    gravity_error.TERM,
    inertia_error.TERM,
    inertial_coupling.TERM,
    unlogged_compensation.TERM,
)
"""In the order of the documentation."""


def term_of(name: str) -> Term:
    """Return the term of a name.

    Raises:
        AnalysisError: If there is none; the message names those that are near.
    """
    for term in TERMS:
        if term.name == name:
            return term
    known = ", ".join(term.name for term in TERMS)
    raise AnalysisError(f"{name!r} is no term{near_names(name, [term.name for term in TERMS])}; expected {known}")


def near_names(name: str, names: list[str]) -> str:
    """Return `` (did you mean ...?)``, or nothing where no name is near."""
    near = difflib.get_close_matches(name, names, 1)
    return f" (did you mean {near[0]}?)" if near else ""
