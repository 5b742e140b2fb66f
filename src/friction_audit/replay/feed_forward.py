"""What a compensator with a joint's model is told at each tick: what friction takes here, now, at this speed."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float
from friction_audit.model.joint_model import FittedTerm
from friction_audit.model.move import bend_on, drag, held_torque, taken
from friction_audit.model.tables import Tables, tabulate
from friction_audit.model.term import Motion
from friction_audit.replay.records import Record
from friction_audit.replay.straight_tables import straighten


class Feed(NamedTuple):
    """Friction as tables, and the bristles of the controller.

    Attributes:
        tables: What friction takes.
        bent: State of the bristles, shape (1 + m,); changed.
    """

    tables: Tables
    bent: Float


def feed_of(terms: Sequence[FittedTerm], motion: Motion) -> Feed:
    """Return what a compensator with these terms is told, before its first tick.

    Args:
        terms: Terms of friction that can run in the loop.
        motion: The recording, n samples.

    Raises:
        AnalysisError: If a term follows from more than the motion of the instant.
    """
    tables, past = tabulate(0.0, terms, motion)
    if past:
        names = ", ".join(term.name for term in past)
        raise AnalysisError(
            f"friction of {names} follows from more than speed, place and moment; take it out of the model"
        )
    return Feed(straighten(tables), np.zeros(1 + len(tables.spring_reach)))


def no_feed() -> Feed:
    """Return what a compensator is told that has no use for it."""
    still = Motion(t=np.arange(2.0), q=np.zeros(2), dq=np.zeros(2), ddq=np.zeros(2))
    return feed_of((), still)


@compiled()
def tell_friction(memory: Record, feed: Feed, q: float, v: float, i: int) -> None:
    """Tell a compensator what friction takes at sample i; nothing later than that is read."""
    if memory.ticks > 0:
        bend_on(feed.bent, q - memory.q_rad, feed.tables)
    memory.q_rad = q
    sign = 1.0 if v >= 0.0 else -1.0
    memory.modelled_nm = sign * taken(0 if v >= 0.0 else 1, q, abs(v), float(i), feed.tables)
    memory.bristle_nm = held_torque(feed.bent, 0.0, feed.tables) + drag(feed.bent, sign, feed.tables) * v
