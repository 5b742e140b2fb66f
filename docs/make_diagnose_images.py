"""The pictures of the page of ``diagnose``, of simulated logs: ``python docs/make_diagnose_images.py [NAME...]``.

Each is what ``friction-audit diagnose -o DIR`` draws of the log that ``friction-audit simulate`` makes with the same
scenario, effects and seed.
"""  # noqa: INP001

import io
import sys
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image

from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.joint_log import JointLog
from friction_audit.pipeline import AuditSettings, Diagnosis, diagnose_log
from friction_audit.reporting.figures.registry import figures_of
from friction_audit.reporting.figures.style import figure_style
from friction_audit.simulation import simulate
from friction_audit.simulation.hide import hide
from friction_audit.simulation.scenarios import SCENARIOS

FOLDER = Path(__file__).parent / "images" / "diagnose"
SEED, DPI, COLOURS = 3, 220, 96


@dataclass(frozen=True, kw_only=True)
class Case:
    """A log and what is drawn of it.

    Attributes:
        name: First part of the pictures' names.
        scenario: Of the simulator.
        effects: Hidden in it, as the command line takes them.
        figures: Kinds that are drawn.
    """

    name: str
    scenario: str
    effects: tuple[str, ...]
    figures: tuple[str, ...]


CASES = (Case(name="named", scenario="joint", effects=("stribeck",), figures=("residual",)),)


def simulated(case: Case) -> JointLog:
    """Return the log of a case."""
    settings = next(scenario.settings for scenario in SCENARIOS if scenario.name == case.scenario)
    return simulate(hide(settings, case.effects), SEED).log


def diagnosed(case: Case) -> Diagnosis:
    """Return the diagnosis of a case, with the default settings."""
    return diagnose_log(simulated(case), AuditSettings(), DiagnosisSettings())


def save(figure: Figure, path: Path) -> None:
    """Write a figure in few colours, to keep the file small."""
    drawn = io.BytesIO()
    with figure_style():
        figure.savefig(drawn, format="png", dpi=DPI, metadata={"Software": None})
    with Image.open(drawn) as image:
        image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def make_pictures(names: list[str]) -> None:
    """Draw the pictures of the cases with these names, or of all."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for case in CASES:
        if names and case.name not in names:
            continue
        found = diagnosed(case)
        joints = [joint.joint for joint in found.discrepancy.joints]
        for kind in figures_of("diagnosis"):
            if kind.name in case.figures:
                figure = kind.draw(found, joints[0] if len(joints) == 1 else None)
                save(figure, FOLDER / f"{case.name}-{kind.name}.png")


if __name__ == "__main__":
    make_pictures(sys.argv[1:])
