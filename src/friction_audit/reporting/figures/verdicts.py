"""Diagnosis -> verdicts of all joints, the residual after each effect, and the evidence of competing effects."""

from collections.abc import Sequence
from functools import partial
from textwrap import fill
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from friction_audit.diagnosis.result import UNANSWERED, Evidence, JointDiagnosis, NamedEffect
from friction_audit.reporting.diagnosis_words import joint_message, verdict_words
from friction_audit.reporting.figures.panels import (
    add_legend,
    chosen_joints,
    grid,
    is_narrow,
    joint_title,
    label_panel,
    new_figure,
    write_message,
)
from friction_audit.reporting.figures.style import (
    BORDER,
    COLUMN_IN,
    FITTED,
    GREEN,
    MUTED,
    SHADE,
    SHEET_IN,
    Look,
    figure_style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from friction_audit.pipeline import Diagnosis

NOMINAL, AUGMENTED = FITTED, GREEN


class Mark(NamedTuple):
    """How a number is drawn, and what it is."""

    marker: str
    colour: str
    face: str
    label: str
    size: float = 4.0


NOMINAL_MARK = Mark("D", NOMINAL, NOMINAL, "nominal model")
AUGMENTED_MARK = Mark("o", AUGMENTED, AUGMENTED, "with the effects named")
FLOOR_MARK = Mark("|", BORDER, BORDER, "noise floor", 9.0)
LIMIT_MARK = Mark("^", MUTED, "white", "detection limit", 3.5)
CHARACTERS = {COLUMN_IN: 30, SHEET_IN: 64}  # of a line of the verdict, by the width of the figure
MOST_LINES = 3
WIDER = 1.3  # times the largest and the smallest torque up to which the axis reaches


def write_verdict(axes: "Axes", joint: JointDiagnosis) -> None:
    """Fill a panel with the verdict on a joint that has nothing to draw there."""
    label_panel(axes, joint_title(joint.joint, joint.name))
    sentence = f"{joint.verdict.replace('_', ' ')}: {joint_message(joint).partition(';')[0]}"
    write_message(axes, sentence, characters=52 if is_narrow(axes) else 36, instead=True)


def _draw_mark(axes: "Axes", mark: Mark, x: float, y: float) -> None:
    look: Look = {"color": mark.colour, "mfc": mark.face, "ms": mark.size, "mew": 0.9, "ls": ""}
    axes.plot(x, y, mark.marker, label=mark.label, **look)


@figure_style()
def draw_verdicts(found: "Diagnosis", joint: int | None) -> "Figure":
    """Draw one joint at column width, or every joint on a sheet, a line for each."""
    joints = chosen_joints(found.discrepancy.joints, joint)
    figure = new_figure(COLUMN_IN if joint is not None else SHEET_IN, 0.8 + 0.34 * max(len(joints), 2))
    axes, words = figure.subplots(1, 2, sharey=True)
    words.set_axis_off()
    for place, one in enumerate(joints):
        _draw_torques(axes, place, one)
        text = fill(said_of(one), CHARACTERS[figure.get_figwidth()], max_lines=MOST_LINES, placeholder=" ...")
        words.annotate(text, (0.0, place), xycoords=("axes fraction", "data"), va="center", fontsize=6.5)
    label_panel(axes)
    _name_rows(axes, [joint_title(one.joint, one.name) for one in joints])
    _scale_torques(axes, joints)
    add_legend(figure)
    return figure


def said_of(joint: JointDiagnosis) -> str:
    """Return the verdict and names, and where there is no answer, the message."""
    words = verdict_words(joint)
    return f"{words}: {joint.reason}" if joint.verdict in UNANSWERED else words


def _draw_torques(axes: "Axes", place: int, joint: JointDiagnosis) -> None:
    """Draw a line from the residual of the nominal model to that of the augmented one."""
    gap = joint.gap
    if gap is None:
        return
    axes.hlines(place, gap.after, gap.before, color=MUTED, lw=0.8, zorder=2)
    _draw_mark(axes, NOMINAL_MARK, gap.before, place)
    _draw_mark(axes, FLOOR_MARK, gap.floor, place)
    if joint.effects:
        _draw_mark(axes, AUGMENTED_MARK, gap.after, place)
    if np.isfinite(joint.detection_limit_nm):
        _draw_mark(axes, LIMIT_MARK, joint.detection_limit_nm, place)


def _name_rows(axes: "Axes", names: Sequence[str]) -> None:
    """Name the rows of a panel, the first on top."""
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.set_yticks(range(len(names)), names)
    axes.tick_params(axis="y", length=0)


def _scale_torques(axes: "Axes", joints: Sequence[JointDiagnosis]) -> None:
    """Let a logarithmic axis hold all that is drawn, with plain numbers at 1 and 3 times the powers of ten."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set_xlabel("Held-out residual torque, rms [N m]")
    gaps = [(one.gap.before, one.gap.after, one.gap.floor, one.detection_limit_nm) for one in joints if one.gap]
    values = np.array(gaps).ravel()
    values = values[np.isfinite(values) & (values > 0.0)]
    if not len(values):
        axes.set_xticks([])
        return
    axes.set_xscale("log")
    axes.set_xlim(float(values.min()) / WIDER, float(values.max()) * WIDER)
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(axis="x", color=MUTED, lw=0.25, alpha=0.5)


ROOM = 1.22  # width of a panel over its longest bar, for the number at its end


@figure_style()
def draw_ladder(found: "Diagnosis", joint: int | None) -> "Figure":
    """Draw the residual after each effect of one joint at column width, or of every joint on a sheet."""
    joints = chosen_joints(found.discrepancy.joints, joint)
    heights = [0.45 + 0.21 * max(len(one.ladder), 3) for one in joints]
    figure, panels = grid(heights, sheet=joint is None, across=2, head_in=0.75)
    for axes, one in zip(panels, joints, strict=True):
        _draw_steps(axes, one)
    figure.supxlabel("Residual torque on held-out cycles, rms [N m]")
    return figure


def _draw_steps(axes: "Axes", joint: JointDiagnosis) -> None:
    """Draw a bar per step, the largest on top, and a line at the noise floor."""
    if not joint.ladder or joint.gap is None:
        write_verdict(axes, joint)
        return
    steps = [label for label, _ in joint.ladder[1:-1]]
    values = [value for _, value in joint.ladder]
    places, last = np.arange(len(values)), len(values) - 1
    colours = [NOMINAL, *(AUGMENTED for _ in steps), SHADE]
    axes.barh(places, values, height=0.66, color=colours, edgecolor=MUTED, lw=0.4)
    axes.axvline(values[last], color=MUTED, lw=0.7, ls=":")
    for place, value in zip(places, values, strict=True):
        axes.annotate(f"{value:.4f}", (value, place), (2, 0), textcoords="offset points", va="center", fontsize=6.5)
    label_panel(axes, f"{joint_title(joint.joint, joint.name)}: {explained_words(joint)}", across=4)
    _name_rows(axes, ["nominal model", *steps, "noise floor"])
    axes.set_xlim(0.0, ROOM * max(values))


def explained_words(joint: JointDiagnosis) -> str:
    """Return the share explained of what is above the noise floor, on how many cycles, and without what."""
    gap = joint.gap
    assert gap is not None
    contacts = ", contacts left out" if len(joint.added) < len(joint.effects) else ""
    cycles = f"on {gap.cycles} held-out cycles{contacts}"
    if not joint.added:
        return f"nothing added\n{cycles}"
    if np.isnan(gap.shrink):
        return f"at the noise floor from the start\n{cycles}"
    error = f" ± {100 * gap.shrink_se:.1f}" if np.isfinite(gap.shrink_se) else ""
    return f"{100 * gap.shrink:.1f}{error} % explained\n{cycles}"


ON_SHEET = 4  # competing effects on a sheet, the named one among them
LINEAR_TO = 10.0  # 2 ln of a Bayes factor up to which the axis is linear, logarithmic beyond
STRONG = 6.0  # 2 ln of a Bayes factor that counts as strong evidence (Kass and Raftery 1995)
CHOSEN = Mark("o", AUGMENTED, AUGMENTED, "the effect named")
ALIKE = Mark("o", FITTED, "white", "indistinguishable")
BEATEN = Mark("x", BORDER, BORDER, "rejected")
ELSEWHERE = Mark("+", MUTED, MUTED, "explains something else")  # as good or better, with another torque


@figure_style()
def draw_evidence(found: "Diagnosis", joint: int | None) -> "Figure":
    """Draw a panel per effect of one joint at column width, or of every joint on a sheet."""
    sheet = joint is None
    panels, heights = [], []
    for one in chosen_joints(found.discrepancy.joints, joint):
        if not one.added:
            panels.append(partial(write_verdict, joint=one))
            heights.append(0.9)
        for effect in one.added:
            competitors = nearest(effect) if sheet else effect.evidence
            panels.append(partial(_draw_competitors, joint=one, effect=effect, competitors=competitors))
            heights.append(0.45 + 0.17 * len(competitors))
    figure, grid_axes = grid(heights, sheet=sheet, across=2, head_in=0.75)
    for axes, draw in zip(grid_axes, panels, strict=True):
        draw(axes)
    add_legend(figure)
    figure.supxlabel("2 ln Bayes factor, effect named over this one; r: correlation")
    return figure


def nearest(effect: NamedEffect, most: int = ON_SHEET) -> tuple[Evidence, ...]:
    """Return the best competing effects and all that are indistinguishable from an effect."""
    ranked = enumerate(effect.evidence)
    return tuple(competitor for place, competitor in ranked if place < most or competitor.name in effect.alternatives)


def mark_of(effect: NamedEffect, competitor: Evidence) -> Mark:
    """Return how a competing effect is marked."""
    if competitor.name == effect.name:
        return CHOSEN
    if competitor.name in effect.alternatives:
        return ALIKE
    return ELSEWHERE if competitor.two_ln_bayes_factor < STRONG else BEATEN


def _draw_competitors(
    axes: "Axes", joint: JointDiagnosis, effect: NamedEffect, competitors: Sequence[Evidence]
) -> None:
    """Draw a line per competing effect, the best on top."""
    axes.set_xscale("symlog", linthresh=LINEAR_TO, linscale=1.0)
    axes.axvline(STRONG, color=MUTED, lw=0.7, ls=":", label=f"strong evidence ({STRONG:g})")
    for place, competitor in enumerate(competitors):
        axes.hlines(place, 0.0, competitor.two_ln_bayes_factor, color=MUTED, lw=0.5)
        _draw_mark(axes, mark_of(effect, competitor), competitor.two_ln_bayes_factor, place)
        if place:
            axes.annotate(
                f"r = {competitor.correlation:.2f}", (1.0, place), (2, 0), xycoords=("axes fraction", "data"),
                textcoords="offset points", va="center", fontsize=6.5, color=MUTED,
            )  # fmt: skip
    label_panel(axes, f"{joint_title(joint.joint, joint.name)}: {effect.name}")
    _scale_evidence(axes, [competitor.two_ln_bayes_factor for competitor in competitors])
    _name_rows(axes, [competitor.name for competitor in competitors])


def _scale_evidence(axes: "Axes", worse: Sequence[float]) -> None:
    from matplotlib.ticker import FuncFormatter, SymmetricalLogLocator

    axes.set_xlim(min(-2.0, 1.6 * min(worse)), 1.6 * max(*worse, LINEAR_TO))
    axes.xaxis.set_major_locator(SymmetricalLogLocator(base=10.0, linthresh=LINEAR_TO))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
