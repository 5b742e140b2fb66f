"""The pictures of two pages, small copies of what the program draws: ``python docs/make_paper_images.py FOLDER``.

The program draws them beforehand, in the same runs that print the numbers on these pages:

    friction-audit reproduce -o FOLDER/paper
    friction-audit compare -o FOLDER/compare
"""  # noqa: INP001

import sys
from pathlib import Path

from PIL import Image

IMAGES = Path(__file__).parent / "images"
PAGES = ("paper", "compare")
WIDTH = 1050
"""Pixels of a picture, those of a column at 300 dpi."""
COLOURS = 160


def small(path: Path) -> Image.Image:
    """Return the picture no wider than a column, in few colours to keep the file small."""
    with Image.open(path) as image:
        scale = min(1.0, WIDTH / image.width)
        size = (round(image.width * scale), round(image.height * scale))
        return image.convert("RGB").resize(size, Image.Resampling.LANCZOS).quantize(COLOURS, dither=Image.Dither.NONE)


def make_pictures(drawn: Path, images: Path = IMAGES) -> None:
    """Copy all pictures of both pages."""
    for page in PAGES:
        paths = sorted((drawn / page).glob("*.png"))
        if not paths:
            raise SystemExit(f"{drawn / page}: found no pictures; draw them first, as told at the top of this script")
        (images / page).mkdir(parents=True, exist_ok=True)
        for path in paths:
            small(path).save(images / page / path.name, optimize=True)


if __name__ == "__main__":
    make_pictures(Path(sys.argv[1]))
