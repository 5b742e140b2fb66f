"""Contacts are events: once they explain what the motion does not, their rows are left out of everything else.

An event is in the cycle in which it happened and in no other, so that no locked cycle can confirm it, and whatever is
fitted to its rows is not a property of the joint.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.declared import FRICTION, INERTIA, least_squares
from friction_audit.diagnosis.find_contacts import find_contacts
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.grown_model import grow_model
from friction_audit.diagnosis.library import Library, keep_rows, without
from friction_audit.diagnosis.naming import Found, Names, on_rows, search_library, with_moments_of_all_cycles
from friction_audit.diagnosis.result import ContactTrace, JointDiscrepancy
from friction_audit.diagnosis.ripple_scan import with_scanned_orders
from friction_audit.diagnosis.rows import filter_rows, make_rows
from friction_audit.effects.contact_event import EFFECT as CANDIDATE
from friction_audit.effects.contact_event import Contact, contacts_of, overlap
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.joint_model import JointModel, Provenance
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

SHIFTED = 2.0
"""Times a torque what is left where it is told at a moment and comes at another one, at most."""


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
    """Leave out contacts that stand out beside everything that the motion can explain.

    What a search over all cycles takes beside them is what it can explain: an event that lies in a locked cycle is in
    no other, and nothing is learned from it.
    """
    others = without(library, CANDIDATE.name)
    tried = next((entry.shapes for entry in library.entries if entry.candidate.name == CANDIDATE.name), ({},))
    if not tried[0]:
        return Undisturbed(ground=ground, library=others, contacts=())
    every = replace(ground, working=np.ones_like(ground.working))
    library = with_scanned_orders(every, library)
    _, outcome, _ = search_library(every, library)
    taken = [(library.entry(one.name), one.shape) for one in outcome.chosen if one.name != CANDIDATE.name]
    contacts = contacts_of(tried[0])
    if taken or _of_a_file(ground):
        # Fitted with all rows: else the one moment at which a stop is deep would be a contact.
        baseline = ground.baseline()
        fine = [entry.candidate.regressor(ground.data, baseline, entry.shapes[shape]) for entry, shape in taken]
        contacts = _beside(every, [entry.columns[shape] for entry, shape in taken], fine)
    return without_contacts(ground, others, contacts)


def contacts_beside(ground: Ground, undisturbed: Undisturbed, names: Names) -> tuple[Contact, ...]:
    """The contacts that still stand out of what a joint's names leave of all its rows.

    None is new: beside a name whose numbers are not quite right something always stands out. A moment at which
    something changes is refined once more with the rows of the contacts, for it may lie in one of them. Nor is a
    contact what flanks that strike or a spring that rings would leave if they did so at another moment.
    """
    told = with_moments_of_all_cycles(ground, on_rows(ground, names))
    fine = [f.candidate.regressor(ground.data, names.baseline, f.shape) for f in told]
    every = replace(ground, working=np.ones_like(ground.working))
    torques = _torques(every, [f.columns for f in told], fine)
    beside = find_contacts(ground.data, np.sum(torques[1:], axis=0))
    left = ground.data.torque - ground.declared.stated - np.sum(torques, axis=0)
    shaken = [torque for f, torque in zip(told, torques[-len(told) :], strict=True) if _shakes(f)]
    return tuple(
        contact
        for contact in undisturbed.contacts
        if any(overlap(contact, other) for other in beside)
        and not any(_within(contact, ground.data.t, left, torque) for torque in shaken)
    )


def _shakes(found: Found) -> bool:
    """Whether noise of the motion shifts when an effect's torque comes."""
    return bool(found.candidate.multimodal or found.candidate.noise_biased)


def _within(contact: Contact, t: Float, left: Float, torque: Float) -> bool:
    """Whether what stands out is no more than a torque that comes at another moment: twice itself at most."""
    inside = (t >= contact.start_s) & (t <= contact.stop_s)
    return float(np.sum(left[inside] ** 2)) < SHIFTED**2 * float(np.sum(torque[inside] ** 2))


def without_contacts(ground: Ground, library: Library, contacts: tuple[Contact, ...]) -> Undisturbed:
    """A joint without the rows of some contacts; its library holds none."""
    if not contacts:
        return Undisturbed(ground=ground, library=library, contacts=())
    kept = ~_touched(ground, contacts)
    return Undisturbed(ground=ground.keep(kept), library=keep_rows(library, kept), contacts=contacts)


def _beside(ground: Ground, effects: Sequence[Float], fine: Sequence[Float]) -> tuple[Contact, ...]:
    """Contacts beside effects: columns on the rows, shape (m, p) each, and on the fine grid, shape (n, p) each.

    What a model file declares beside inertia and friction is there as well.
    """
    return find_contacts(ground.data, np.sum(_torques(ground, effects, fine)[1:], axis=0))


def _torques(ground: Ground, effects: Sequence[Float], fine: Sequence[Float]) -> list[Float]:
    """Torque of inertia and friction, of what else a model file declares, and of each effect, shape (n,) each."""
    columns = np.hstack([ground.base, *effects])
    factors = least_squares(columns[ground.working], ground.y[ground.working])
    own = _of_a_file(ground)
    plain = [k for k in range(ground.base.shape[1]) if k not in own]
    ends = np.cumsum([ground.base.shape[1], *(effect.shape[1] for effect in effects)]).tolist()
    declared = [ground.declared.fine[:, some] @ factors[some] for some in (plain, own)]
    return [*declared, *(one @ factors[i:j] for one, (i, j) in zip(fine, pairwise(ends), strict=True))]


def _of_a_file(ground: Ground) -> list[int]:
    """Places of the declared columns that are neither inertia nor Coulomb or viscous friction."""
    return [k for k, name in enumerate(ground.declared.names) if name not in (INERTIA, *FRICTION.values())]


def _touched(ground: Ground, contacts: tuple[Contact, ...]) -> NDArray[np.bool_]:
    """Rows that the filter mixes with a contact, shape (m,)."""
    reach = len(ground.rows.kernel) // 2 * ground.data.step_s
    inside = [
        (ground.rows.t >= contact.start_s - reach) & (ground.rows.t <= contact.stop_s + reach) for contact in contacts
    ]
    return np.asarray(np.any(inside, axis=0), bool)


def contact_trace(
    joint: JointDiscrepancy, contacts: tuple[Contact, ...], data: JointData, model: JointModel | None
) -> ContactTrace | None:
    """Return what the augmented model leaves over the whole log, samples of contacts included; None without contacts.

    Args:
        joint: The diagnosis without the samples of the contacts.
        contacts: The stretches left out of it.
        data: The joint on the fine grid.
        model: Its nominal model; None for inertia, Coulomb and viscous friction.
    """
    if not contacts or joint.traces is None:
        return None
    rows = make_rows(data, joint.traces.corner_hz)
    try:
        torque = grow_model(joint, model, Provenance()).torque(data.motion())
    except AnalysisError:  # a coefficient below zero, which a fit may give and no model allows
        columns = np.column_stack([data.ddq, data.motion().direction, data.dq])
        torque = np.asarray(columns @ least_squares(rows.of(columns), rows.y))
    left = filter_rows(data.torque - torque, rows.kernel, rows.every)
    seen = (data.moving & data.valid)[:: rows.every]
    return ContactTrace(
        t=data.t[:: rows.every],
        residual_nm=np.where(seen, left, np.nan),
        spans_s=tuple((contact.start_s, contact.stop_s) for contact in contacts),
    )
