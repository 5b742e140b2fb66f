"""Contacts over time: what the grown model leaves of the torque, stretches in which something touched shaded."""

from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from friction_audit.audit import Diagnosis
from friction_audit.discrepancy.candidates.contact_event import Contact, find_contacts
from friction_audit.discrepancy.declared import least_squares
from friction_audit.discrepancy.grown_model import grow_model
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.prepare import prepare
from friction_audit.discrepancy.result import Effect, JointDiscrepancy
from friction_audit.discrepancy.rows import Rows, filter_rows, make_rows
from friction_audit.errors import AnalysisError
from friction_audit.interaction.known_arm import known_arm
from friction_audit.joint_log import Float
from friction_audit.model.joint_model import Provenance
from friction_audit.report.figures.diagnose_look import GROWN, joint_name
from friction_audit.report.figures.layout import label_panel
from friction_audit.report.figures.style import MUTED, REJECTED, ZOOMED

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

ASIDE_S = 1.0
"""What is shown before and after a contact."""
MOST_LEFT_OUT = 0.5
"""Share of a contact's rows below which those that were kept are its edges'."""
LEAST_WIDTH = 0.004
"""Share of a panel that a stretch is drawn wide at least."""


class Touched(NamedTuple):
    """What the grown model leaves of a joint's torque, NaN where the joint does not move, and when it was touched.

    Attributes:
        t: Time, shape (k,). [s]
        left: Torque, shape (k,). [N m]
        contacts: Stretches of time.
        corner_hz: Corner of the low-pass filter that the torque went through. [Hz]
    """

    t: Float
    left: Float
    contacts: tuple[Contact, ...]
    corner_hz: float


def touched(found: Diagnosis, joint: JointDiscrepancy) -> Touched:
    """Return the residual of all rows: a diagnosis keeps those without a contact only."""
    estimate, traces = found.estimate, joint.traces
    assert traces is not None
    arm = known_arm(estimate.log, estimate.settings.torque, estimate.interaction.choice)
    column = estimate.interaction.joint_numbers.index(joint.joint)
    data = prepare(estimate.interaction, estimate.cycles, estimate.log, arm)[column]
    stated = found.settings.model
    rows = make_rows(data, traces.corner_hz)
    try:
        model = grow_model(joint, None if stated is None else stated.joints[joint.joint - 1], Provenance())
        torque = model.torque(data.motion())
        effects = torque - _friction_and_inertia(data, joint)
    except AnalysisError:  # a number below zero, which a fit may give and no model allows
        torque, effects = _simple_torque(data, rows), np.zeros(len(data.t))
    left = filter_rows(data.torque - torque, rows.kernel, rows.every)
    seen = (data.moving & data.valid)[:: rows.every]
    # At rest friction holds what it can: what there is of it must stay in the torque in which contacts are looked for.
    beside = find_contacts(data, effects)
    return Touched(
        t=data.t[:: rows.every],
        left=np.where(seen, left, np.nan),
        contacts=tuple(contact for contact in beside if _left_out(rows.t, traces.t, contact)),
        corner_hz=traces.corner_hz,
    )


def _left_out(every: Float, kept: Float, contact: Contact) -> bool:
    """Whether a diagnosis that kept these of all rows, times of shape (k,) and (m,), left most of a contact out.

    Where a contact begins and ends depends on the model beside which it was found.
    """
    rows, there = (np.sum((t >= contact.start_s) & (t <= contact.stop_s)) for t in (every, kept))
    return bool(there < MOST_LEFT_OUT * rows)


def _friction_and_inertia(data: JointData, joint: JointDiscrepancy) -> Float:
    """What the declared model's own factors make, beside the effects, shape (n,). [N m]"""
    columns = {"inertia_kg_m2": data.ddq, "coulomb_nm": data.way, "viscous_nms_per_rad": data.dq}
    parts = [joint.grown[name].value * column for name, column in columns.items() if name in joint.grown]
    return np.asarray(np.sum(parts, axis=0) if parts else np.zeros(len(data.t)))


def _simple_torque(data: JointData, rows: Rows) -> Float:
    """Torque of inertia, Coulomb and viscous friction, whatever their signs, fitted to the rows, shape (n,). [N m]"""
    columns = np.column_stack([data.ddq, data.motion().direction, data.dq])
    return np.asarray(columns @ least_squares(rows.of(columns), rows.y))


def contact_panels(
    found: Diagnosis, joint: JointDiscrepancy, effect: Effect, *, sheet: bool
) -> "list[Callable[[Axes], list[Artist]]]":
    """Return what draws the whole log and, off a sheet, the contact with the largest torque close by."""
    shown = touched(found, joint)
    title = f"{joint_name(joint)}: {effect.name}"
    whole = partial(_draw, shown, title, (float(shown.t[0]), float(shown.t[-1])))
    if sheet or not shown.contacts:
        return [whole]
    largest = max(shown.contacts, key=lambda contact: _largest(shown, contact))
    near = (largest.start_s - ASIDE_S, largest.stop_s + ASIDE_S)
    return [whole, partial(_draw, shown, "the largest", near)]


def _largest(shown: Touched, contact: Contact) -> float:
    inside = shown.left[(shown.t >= contact.start_s) & (shown.t <= contact.stop_s)]
    return float(np.max(np.abs(np.nan_to_num(inside)), initial=0.0))


def _draw(shown: Touched, title: str, limits: tuple[float, float], axes: "Axes") -> "list[Artist]":
    label_panel(axes, title)
    axes.axhline(0.0, color=MUTED, lw=0.4, zorder=1)
    label = f"measured less model, below {shown.corner_hz:.3g} Hz"
    handles: list[Artist] = list(axes.plot(shown.t, shown.left, color=GROWN, lw=0.6, label=label))
    least = LEAST_WIDTH * (limits[1] - limits[0])
    for contact in shown.contacts:
        more = 0.5 * max(least - (contact.stop_s - contact.start_s), 0.0)
        handles.append(
            axes.axvspan(
                contact.start_s - more, contact.stop_s + more, facecolor=ZOOMED, edgecolor=REJECTED, lw=0.4, zorder=0,
                label="contact",
            )
        )  # fmt: skip
    axes.set_xlim(*limits)
    axes.set_xlabel("Time [s]")
    return handles
