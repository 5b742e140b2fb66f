"""``friction-audit reproduce``."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from friction_audit.cli import options as opt
from friction_audit.cli.console import say
from friction_audit.cli.outputs import ResultFolder, show
from friction_audit.cli.parameters import SIMULATION, group, option

if TYPE_CHECKING:
    from friction_audit.reproduce import Simulations
    from friction_audit.reproduce.claims import Claim

EXAMPLES = """Examples:
  friction-audit reproduce
  friction-audit reproduce --figures 3,6,7 --figure-format pdf -o paper
  friction-audit reproduce --figures 10 --persons 100 --json"""

# Written down again, so that the help text loads no numerics.
PAPER_FIGURES = ("3", "6", "7", "8", "9", "10", "11", "12", "13", "14")


@group(SIMULATION)
class SimulationOptions:
    """What is simulated."""

    figures: list[str] = option("Figures of the paper. Default: all.", default=PAPER_FIGURES, some_of=PAPER_FIGURES)
    persons: int = option("Simulated persons, at most 5 for the arm.", default=20, metavar="INT", min=1, max=1000)


def command(
    simulation: SimulationOptions,
    drawing: opt.FigureOptions,
    general: opt.GeneralOptions,
    folder: Path = opt.folder_option("Folder of the figures.", Path("reproduced")),
    overwrite: opt.Overwrite = False,
) -> None:
    """Simulate the paper's figures and measure its claims."""
    from friction_audit.reporting.compare import CLAIM, REPRODUCE, count_line
    from friction_audit.reproduce import REPRODUCTIONS, simulate_figure

    voice, persons = general.voice, simulation.persons
    names = [f"fig{number}" for number in simulation.figures]
    out = ResultFolder(folder=folder, figures=names, formats=drawing.formats, overwrite=overwrite)
    out.check()
    files: list[tuple[str, str, str]] = []
    claims: list[Claim] = []
    simulations: Simulations = {}
    for one in (one for one in REPRODUCTIONS if one.figure in simulation.figures):
        with voice.step(f"simulate figure {one.figure}") as progress:
            simulations = simulate_figure(one, persons, progress, simulations)
        with voice.step(f"check and draw figure {one.figure}"):
            found = one.check(simulations)
            paths = out.save_figure(f"fig{one.figure}", one.draw(simulations))
            files += [(one.figure, one.title, str(path)) for path in paths]
        if not voice.json:
            reasons = [f"{claim.figure}: {claim.note}" for claim in found if not claim.holds and claim.note]
            say("\n".join([*CLAIM.people(found, "t").lines(), *reasons]))
        claims += found
    document = partial(REPRODUCE.json, {"seeds": persons, "claims": claims, "figures": files})
    show(document, lambda: [count_line(claims), *(path for *_, path in files)], voice)
