"""The pictures of the page on the paper's figures, drawn by the program: ``python docs/make_paper_images.py``."""  # noqa: INP001

import tempfile
from pathlib import Path

from PIL import Image

from friction_audit.report.figures import save_figure
from friction_audit.reproduce import REPRODUCTIONS, simulate_figures

FOLDER = Path(__file__).parent / "images" / "paper"
WIDTH = 1050
"""Pixels of a picture, those of a column at 300 dpi."""
COLOURS = 160


def small(path: Path) -> Image.Image:
    """Return the picture no wider than a column, in few colours to keep the file small."""
    with Image.open(path) as image:
        scale = min(1.0, WIDTH / image.width)
        size = (round(image.width * scale), round(image.height * scale))
        return image.convert("RGB").resize(size, Image.Resampling.LANCZOS).quantize(COLOURS, dither=Image.Dither.NONE)


def make_pictures(folder: Path = FOLDER) -> None:
    """Draw every figure from the first seed."""
    simulations = simulate_figures(REPRODUCTIONS, seeds=1)
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as drafts:
        for one in REPRODUCTIONS:
            draft = Path(drafts) / f"fig{one.figure}.png"
            save_figure(one.draw(simulations), draft)
            small(draft).save(folder / draft.name, optimize=True)


if __name__ == "__main__":
    make_pictures()
