"""Friction of a joint's model fed forward by a compensator, and which terms of a model can run in its loop."""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from friction_audit.compiled import Record, compiled
from friction_audit.dynamics.motion import Motion, Term
from friction_audit.dynamics.torque_tables import Tables, bend_on, bristle_damping, bristle_nm, tabulate, taken
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

PAST = "it follows from the past of the motion, and the loop knows speed, place and moment only"
TWO_SIDES = "the person is on one side of it and the compensator on the other, and the loop has one side only"
ARM = "it follows from the other joints, and a replay moves one joint alone"
UNABLE: Mapping[str, str] = {  # why a term cannot run in the loop
    "stiction": PAST,
    "frictional_lag": PAST,
    "load_dependent_friction": "it needs the load on the gear, which a replay does not predict",
    "time_delay": "a joint does not move otherwise because its torque is read late, and the loop reads it on time",
    "joint_elasticity": TWO_SIDES,
    "backlash": TWO_SIDES,
    "torque_crosstalk": ARM,
    "inertial_coupling": ARM,
}
# Terms that belong to friction though the work of the term alone may be given back.
OF_FRICTION = (
    "asymmetric_coulomb",
    "asymmetric_viscous",
    "presliding",
    "stiction",
    "frictional_lag",
    "load_dependent_friction",
)
NO_MODEL = "the model file has no model of it; give one, or remove --joint-model"


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
        speed=tables.speed - slope[:, None] * speeds, place_per_speed=tables.place_per_speed + damped[:, None]
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


def refuse(terms: Iterable[FittedTerm], past: Iterable[Term] = ()) -> None:
    """Raise AnalysisError that says which terms, or terms of the past, cannot run in a compensator's loop, and why."""
    reasons = []
    for term in terms:
        values, reason = term.numbers, UNABLE.get(term.name, "")
        if values.get("gravity_error_source", 0.0) != 0.0:
            reason = "it needs the model of the arm, and a replay moves one joint alone"
        if values.get("warm_up_per_k", 0.0) != 0.0:
            reason = "it needs the temperature, which a replay does not read"
        if reason:
            reasons.append(f"{term.name}: {reason}")
    reasons += [f"{term.name}: along this recording, {PAST}" for term in past]
    if reasons:
        raise AnalysisError(
            f"its model cannot run in a compensator's loop: {'; '.join(reasons)}; take it out of the file"
        )
