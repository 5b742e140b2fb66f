"""ArmDrift -> figures: the kinds, in the order in which they are read."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from friction_audit.reporting.figures.batch_changes import draw_changes, draw_control
from friction_audit.reporting.figures.batch_drift import draw_curves, draw_drift

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from friction_audit.drift.report import ArmDrift


@dataclass(frozen=True, kw_only=True, slots=True)
class BatchFigure:
    """A kind of figure of an arm over its sessions.

    Attributes:
        name: Unique name, also the start of the file's name.
        draw: Draws one joint, given by its number for people, or with None all joints on one sheet.
        summary: One line for help and documentation, and the figure's title on a page.
    """

    name: str
    draw: "Callable[[ArmDrift, int | None], Figure]"
    summary: str


BATCH_FIGURES = (
    BatchFigure(
        name="changes",
        draw=draw_changes,
        summary="change of each coefficient from the reference to the last sessions, and what was too small to be seen",
    ),
    BatchFigure(
        name="drift",
        draw=draw_drift,
        summary="coefficients over sessions with their 95 % intervals, steps and trends",
    ),
    BatchFigure(
        name="control",
        draw=draw_control,
        summary="control chart: each session against the reference",
    ),
    BatchFigure(
        name="curves",
        draw=draw_curves,
        summary="velocity-torque curves of the first session, of the reference and of the last",
    ),
)
