"""Friction of a joint's model fed forward by a compensator, and which terms of a model can run in its loop."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from friction_audit.compiled import Record, compiled
from friction_audit.dynamics.motion import Motion, Term
from friction_audit.dynamics.torque_tables import Tables, bend_on, bristle_damping, bristle_nm, tabulate, taken
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Caution

UNABLE: Mapping[str, str] = {  # why a term cannot run in the loop: what it follows from, which the loop does not have
    **dict.fromkeys(("stiction", "frictional_lag"), "past"),
    **dict.fromkeys(("joint_elasticity", "backlash"), "two_sides"),
    **dict.fromkeys(("torque_crosstalk", "inertial_coupling"), "neighbours"),
    "load_dependent_friction": "load",
    "time_delay": "late",
}
# Terms that belong to friction though the work of the term alone may be given back.
OF_FRICTION = (
    *("asymmetric_coulomb", "asymmetric_viscous", "presliding"),
    *("stiction", "frictional_lag", "load_dependent_friction"),
)


class Feed(NamedTuple):
    """Friction as tables, and the bristles of the controller."""

    tables: Tables  # what friction takes
    bent: Float  # state of the bristles, shape (1 + m,); changed


def straighten(tables: Tables, *, damping_nms_per_rad: float = 0.0) -> Tables:
    """Return tables with a damper that are right at any speed, for a compensated joint is faster than a recorded one.

    The last slope over speed is kept as a torque in proportion to the speed: what is left is level at its end.
    """
    speeds = np.asarray(tables.speed_step * np.arange(tables.speed.shape[1]), np.float64)
    slope = (tables.speed[:, -1] - tables.speed[:, -2]) / tables.speed_step
    damped = slope + damping_nms_per_rad * np.array([1.0, -1.0])
    return tables._replace(
        speed=tables.speed - slope[:, None] * speeds, position_per_speed=tables.position_per_speed + damped[:, None]
    )


def feed_of(terms: Sequence[FittedTerm], motion: Motion) -> Feed:
    """Return the feed-forward of terms of friction, before the first tick."""
    tables, past = tabulate(0.0, terms, motion)
    refuse((), past)
    return Feed(straighten(tables), np.zeros(1 + len(tables.bristles.reach)))


@compiled()
def feed_friction(memory: Record, feed: Feed, q: float, v: float, i: int) -> None:
    """Give a compensator what friction takes at sample i; nothing later than that is read."""
    if memory.ticks > 0:
        bend_on(feed.bent, q - memory.q_rad, feed.tables)
    memory.q_rad = q
    sign = 1.0 if v >= 0.0 else -1.0
    memory.modelled_nm = sign * taken(sign, q, abs(v), float(i), feed.tables)
    memory.bristle_nm = bristle_nm(feed.bent, 0.0, feed.tables) + bristle_damping(feed.bent, sign, feed.tables) * v


def refuse(terms: Sequence[FittedTerm], past: Sequence[Term] = ()) -> None:
    """Raise AnalysisError that says which terms, or terms of the past, cannot run in a compensator's loop, and why."""
    found = [(term.name, UNABLE.get(term.name, "")) for term in terms]
    for place, term in enumerate(terms):
        if term.numbers.get("gravity_error_source", 0.0) != 0.0:
            found[place] = (term.name, "arm")
        if term.numbers.get("warm_up_per_k", 0.0) != 0.0:
            found[place] = (term.name, "temperature")
    found += [(term.name, "past_here") for term in past]
    reasons = tuple(Caution("not_in_loop", numbers={"name": name, "case": case}) for name, case in found if case)
    if reasons:
        raise AnalysisError((Caution("model_not_run", numbers={"terms": reasons}),))
