"""Diagnosis -> figures: the kinds, in the order in which they are read."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from friction_audit.reporting.figures.diagnose_contacts import draw_verdicts
from friction_audit.reporting.figures.diagnose_evidence import draw_effects, draw_evidence, draw_ladder
from friction_audit.reporting.figures.diagnose_residual import draw_residual
from friction_audit.reporting.figures.diagnose_simulation import draw_simulation

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from friction_audit.pipeline import Diagnosis


@dataclass(frozen=True, kw_only=True, slots=True)
class DiagnosisFigure:
    """A kind of figure of a diagnosis.

    Attributes:
        name: Unique name, also the start of the file's name.
        draw: Draws one joint, given by its number for people, or with None all joints on one sheet.
        summary: One line for help and documentation.
    """

    name: str
    draw: "Callable[[Diagnosis, int | None], Figure]"
    summary: str


DIAGNOSIS_FIGURES = (
    DiagnosisFigure(
        name="verdicts",
        draw=draw_verdicts,
        summary="verdict and gap of every joint, before, after and at the floor of the noise",
    ),
    DiagnosisFigure(
        name="simulation",
        draw=draw_simulation,
        summary="torque and motion measured against simulated, before and after, on locked cycles",
    ),
    DiagnosisFigure(
        name="residual",
        draw=draw_residual,
        summary="residual against the axis on which an effect shows itself, before and after",
    ),
    DiagnosisFigure(
        name="ladder",
        draw=draw_ladder,
        summary="what the declared model leaves, what is left after each effect, and the floor of the noise",
    ),
    DiagnosisFigure(
        name="effects",
        draw=draw_effects,
        summary="each effect's own curve with its interval, and the fitted effect over it",
    ),
    DiagnosisFigure(
        name="evidence",
        draw=draw_evidence,
        summary="how much worse the rivals of a named effect do, and which cannot be told from it",
    ),
)
