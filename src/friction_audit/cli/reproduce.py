"""``friction-audit reproduce``."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from friction_audit.cli import chain
from friction_audit.cli.choices import option
from friction_audit.cli.console import Voice, say
from friction_audit.cli.figure_files import save_figures
from friction_audit.cli.grouped_help import SIMULATION
from friction_audit.cli.options import PNG, FigureFolder, FigureFormats, GeneralOptions, Overwrite

if TYPE_CHECKING:
    from friction_audit.reproduce import Claim, Reproduction, Simulations

EXAMPLES = """Examples:
  friction-audit reproduce
  friction-audit reproduce --figures 3,6,7 --figure-format pdf -o paper
  friction-audit reproduce --figures 10 --persons 100 --json"""

PAPER_FIGURES = ("3", "6", "7", "8", "9", "10", "11", "12", "13", "14")
"""Written down again, as in ``choices``, so that the help text loads no numerics."""


def command(
    general: GeneralOptions,
    figures: Annotated[
        list[str], option(SIMULATION, "Figures of the paper to draw. Default: all.", "--figures", some_of=PAPER_FIGURES)
    ] = list(PAPER_FIGURES),  # noqa: B006 - Typer copies it
    persons: Annotated[
        int,
        option(
            SIMULATION,
            "Simulated persons where a person moves the joint, at most 5 for the whole arm.",
            metavar="INT",
            min=1,
            max=1000,
        ),
    ] = 20,
    formats: FigureFormats = PNG,
    folder: FigureFolder = Path("reproduced"),
    overwrite: Overwrite = False,
) -> None:
    """Simulate the paper's figures and measure its claims."""
    voice = general.voice
    paths = {number: [folder / f"fig{number}.{suffix}" for suffix in formats] for number in figures}
    chain.check_outputs([path for each in paths.values() for path in each], overwrite=overwrite)
    chosen, claims = _reproduce(paths, persons, voice, overwrite=overwrite, json=general.json)
    files = [(one.figure, one.title, str(path)) for one in chosen for path in paths[one.figure]]
    _print(claims, files, persons, json=general.json)


def _reproduce(
    paths: dict[str, list[Path]], seeds: int, voice: Voice, *, overwrite: bool, json: bool
) -> "tuple[Sequence[Reproduction], list[Claim]]":
    """Simulate, check and draw one figure after the other; print its claims as soon as it is done."""
    from friction_audit.reporting.compare import claim_lines
    from friction_audit.reproduce import REPRODUCTIONS, simulate_figures

    chosen = [one for one in REPRODUCTIONS if one.figure in paths]
    claims: list[Claim] = []
    simulations: Simulations = {}
    for one in chosen:
        with voice.step(f"simulate figure {one.figure}") as progress:
            simulations = simulate_figures([one], seeds, progress, simulations)
        with voice.step(f"check and draw figure {one.figure}"):
            found = one.check(simulations)
            save_figures(one.draw(simulations), paths[one.figure], overwrite=overwrite)
        if not json:
            say("\n".join(claim_lines([asdict(claim) for claim in found])))
        claims += found
    return chosen, claims


def _print(claims: "list[Claim]", files: list[tuple[str, str, str]], seeds: int, *, json: bool) -> None:
    from friction_audit.reporting.compare import count_line, reproduce_document
    from friction_audit.reporting.documents import write_document

    rows = [asdict(claim) for claim in claims]
    if json:
        say(write_document(reproduce_document(rows, files, seeds)), nl=False)
        return
    say(count_line(rows))
    for _, _, path in files:
        say(path)
