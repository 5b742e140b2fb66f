"""The pictures of two pages, drawn by the program: ``python docs/make_paper_images.py``.

Those of the page on the paper's figures, from the first seed, and those of the page on ``compare``, twenty persons.
"""  # noqa: INP001

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from PIL import Image

from friction_audit.compare import SCENES, compare
from friction_audit.compare.draw import draw
from friction_audit.report.figures import save_figure
from friction_audit.reproduce import REPRODUCTIONS, simulate_figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FOLDER = Path(__file__).parent / "images"
SEEDS = 20
"""Persons of the comparison."""
WIDTH = 1050
"""Pixels of a picture, those of a column at 300 dpi."""
COLOURS = 160


def small(path: Path) -> Image.Image:
    """Return the picture no wider than a column, in few colours to keep the file small."""
    with Image.open(path) as image:
        scale = min(1.0, WIDTH / image.width)
        size = (round(image.width * scale), round(image.height * scale))
        return image.convert("RGB").resize(size, Image.Resampling.LANCZOS).quantize(COLOURS, dither=Image.Dither.NONE)


def keep(figure: "Figure", path: Path) -> None:
    """Write a figure as a small picture."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as drafts:
        draft = Path(drafts) / path.name
        save_figure(figure, draft)
        small(draft).save(path, optimize=True)


def make_paper_pictures(folder: Path = FOLDER / "paper") -> None:
    """Draw every figure of the paper from the first seed."""
    simulations = simulate_figures(REPRODUCTIONS, seeds=1)
    for one in REPRODUCTIONS:
        keep(one.draw(simulations), folder / f"fig{one.figure}.png")


def make_compare_pictures(folder: Path = FOLDER / "compare") -> None:
    """Draw the figures of the comparison; they show no margins."""
    joint = SCENES[0]
    comparison = compare(replace(joint, plan=replace(joint.plan, margin_seeds=0)), SEEDS)
    for name, figure in draw(comparison).items():
        keep(figure, folder / f"{name}.png")


if __name__ == "__main__":
    make_paper_pictures()
    make_compare_pictures()
