"""Contacts are events: once they explain what the motion does not, their rows are left out of everything else.

An event is in the cycle in which it happened and in no other, so that no locked cycle can confirm it, and whatever is
fitted to its rows is not a property of the joint.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.discrepancy.candidates.contact_event import CANDIDATE, Contact, find_contacts
from friction_audit.discrepancy.ground import Ground
from friction_audit.discrepancy.library import Library, keep_rows, without
from friction_audit.discrepancy.naming import search_library


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Undisturbed:
    """A joint without the rows in which something touched it.

    Attributes:
        ground: The joint; as it was where there were no contacts.
        library: What may be named, contacts not among it.
        contacts: When it was touched.
    """

    ground: Ground
    library: Library
    contacts: tuple[Contact, ...]


def leave_out_contacts(ground: Ground, library: Library) -> Undisturbed:
    """Leave contacts out where a search takes them beside everything that the motion can explain.

    The search goes over all cycles: an event that lies in a locked one is in no other, and nothing is learned from it.
    """
    others = without(library, CANDIDATE.name)
    contacts = find_contacts(ground.data) if len(others.entries) < len(library.entries) else ()
    if not contacts:
        return Undisturbed(ground=ground, library=others, contacts=())
    _, outcome, _ = search_library(replace(ground, working=np.ones_like(ground.working)), library)
    if all(chosen.name != CANDIDATE.name for chosen in outcome.chosen):
        return Undisturbed(ground=ground, library=others, contacts=())
    kept = ~_touched(ground, contacts)
    return Undisturbed(ground=ground.keep(kept), library=keep_rows(others, kept), contacts=contacts)


def _touched(ground: Ground, contacts: tuple[Contact, ...]) -> NDArray[np.bool_]:
    """Rows that the filter mixes with a contact, shape (m,)."""
    reach = len(ground.rows.kernel) // 2 * ground.data.step_s
    inside = [
        (ground.rows.t >= contact.start_s - reach) & (ground.rows.t <= contact.stop_s + reach) for contact in contacts
    ]
    return np.asarray(np.any(inside, axis=0), bool)
