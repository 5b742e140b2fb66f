"""Contacts over time: what the grown model leaves of the torque, stretches in which something touched shaded."""

from collections.abc import Sequence
from functools import partial
from textwrap import fill
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from friction_audit.diagnosis.declared import least_squares
from friction_audit.diagnosis.find_contacts import find_contacts
from friction_audit.diagnosis.grown_model import grow_model
from friction_audit.diagnosis.prepare import prepare
from friction_audit.diagnosis.result import UNANSWERED, Effect, JointDiscrepancy
from friction_audit.diagnosis.rows import Rows, filter_rows, make_rows
from friction_audit.effects.contact_event import Contact
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.joint_model import Provenance
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float
from friction_audit.pipeline import Diagnosis
from friction_audit.preprocessing.torque_source import known_arm
from friction_audit.reporting.figures.diagnose_look import (
    DECLARED,
    GROWN,
    chosen_joints,
    joint_name,
    once,
    verdict_words,
)
from friction_audit.reporting.figures.style import (
    BORDER,
    COLUMN_IN,
    MUTED,
    REJECTED,
    SHEET_IN,
    ZOOMED,
    add_legend,
    figure_style,
    label_panel,
    new_figure,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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


HEAD_IN, ROW_IN = 0.8, 0.34
CHARACTERS = {COLUMN_IN: 30, SHEET_IN: 64}
"""Characters of a line of the verdict, by the width of the figure."""
MOST_LINES = 3
WIDER = 1.3
"""Times the largest and the smallest torque up to which the axis reaches."""


class Mark(NamedTuple):
    """How a torque is drawn, and what it is."""

    marker: str
    colour: str
    face: str
    size: float
    label: str


DECLARED_MARK = Mark("D", DECLARED, DECLARED, 4.0, "declared model")
GROWN_MARK = Mark("o", GROWN, GROWN, 4.0, "with the effects named")
FLOOR_MARK = Mark("|", BORDER, BORDER, 9.0, "floor of the noise")
LIMIT_MARK = Mark("^", MUTED, "white", 3.5, "detection limit")


def draw_verdicts(found: Diagnosis, joint: int | None) -> "Figure":
    """Draw one joint at column width, or every joint on a sheet, a line for each."""
    with figure_style():
        joints = chosen_joints(found, joint)
        figure = new_figure(COLUMN_IN if joint is not None else SHEET_IN, HEAD_IN + ROW_IN * max(len(joints), 2))
        axes, words = figure.subplots(1, 2, sharey=True, gridspec_kw={"width_ratios": (1.0, 1.0)})
        handles = [handle for place, one in enumerate(joints) for handle in _draw_joint(axes, place, one)]
        _scale(axes, joints)
        _write(words, joints, CHARACTERS[figure.get_figwidth()])
        add_legend(figure, once(handles))
        return figure


def _draw_joint(axes: "Axes", place: int, joint: JointDiscrepancy) -> "list[Artist]":
    """Draw a line from the gap of the declared model to that of the grown one; return the legend's entries."""
    if joint.gap is None:
        return []
    gap = joint.gap
    axes.hlines(place, gap.after, gap.before, color=MUTED, lw=0.8, zorder=2)
    points = [(DECLARED_MARK, gap.before), (FLOOR_MARK, gap.floor)]
    points += [(GROWN_MARK, gap.after)] if joint.effects else []
    points += [(LIMIT_MARK, joint.detection_limit_nm)] if np.isfinite(joint.detection_limit_nm) else []
    handles: list[Artist] = []
    for mark, value in points:
        handles += axes.plot(
            value, place, mark.marker, color=mark.colour, mfc=mark.face, ms=mark.size, mew=0.9, label=mark.label
        )
    return handles


def _scale(axes: "Axes", joints: Sequence[JointDiscrepancy]) -> None:
    """Name the joints, and let a logarithmic axis hold all that is drawn."""
    gaps = [(one.gap.before, one.gap.after, one.gap.floor, one.detection_limit_nm) for one in joints if one.gap]
    values = np.array(gaps).ravel()
    values = values[np.isfinite(values) & (values > 0.0)]
    label_panel(axes, "")
    axes.set_ylim(len(joints) - 0.5, -0.5)
    axes.set_yticks(range(len(joints)), [joint_name(one) for one in joints])
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("Torque on locked cycles, rms [N m]")
    if not len(values):
        axes.set_xticks([])
        return
    axes.set_xscale("log")
    axes.set_xlim(float(values.min()) / WIDER, float(values.max()) * WIDER)
    _few_ticks(axes)


def _few_ticks(axes: "Axes") -> None:
    """Write plain numbers at 1 and 3 times the powers of ten."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(axis="x", color=MUTED, lw=0.25, alpha=0.5)


def _write(axes: "Axes", joints: Sequence[JointDiscrepancy], characters: int) -> None:
    """Write what is said of each joint beside its line."""
    axes.set_axis_off()
    for place, joint in enumerate(joints):
        text = fill(said_of(joint), characters, max_lines=MOST_LINES, placeholder=" ...")
        axes.annotate(text, (0.0, place), xycoords=("axes fraction", "data"), va="center", fontsize=6.5)


def said_of(joint: JointDiscrepancy) -> str:
    """Return the verdict and names, and where there is no answer, the message."""
    words = verdict_words(joint)
    return f"{words}: {joint.message}" if joint.verdict in UNANSWERED else words
