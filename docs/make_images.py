"""The picture of the README, drawn by the program from a sample log: ``python docs/make_images.py``."""  # noqa: INP001

import tempfile
from pathlib import Path

from PIL import Image

from friction_audit.audit import AuditSettings, Estimate, estimate_log
from friction_audit.ingest import read_log
from friction_audit.report.figures import FIGURES, save_figure

ROOT = Path(__file__).parents[1]
LOG = ROOT / "sample_logs" / "hand_guided.parquet"
PICTURE = ROOT / "docs" / "images" / "estimate.png"
JOINT = 1
KINDS = ("velocity-torque", "coefficients")
HEIGHT_IN = 3.2
COLOURS = 48
MARGIN = 60


def draw(estimate: Estimate, kind: str, folder: Path) -> Image.Image:
    """Draw one figure of the joint, as ``friction-audit plot`` does, at a common height."""
    figure = next(one for one in FIGURES if one.name == kind).draw(estimate, JOINT)
    figure.set_size_inches(figure.get_figwidth(), HEIGHT_IN)
    save_figure(figure, folder / f"{kind}.png")
    with Image.open(folder / f"{kind}.png") as image:
        return image.convert("RGB")


def side_by_side(images: list[Image.Image]) -> Image.Image:
    """Return the images next to each other on white, in few colours to keep the file small."""
    width = sum(image.width for image in images) + MARGIN * (len(images) - 1)
    sheet = Image.new("RGB", (width, max(image.height for image in images)), "white")
    left = 0
    for image in images:
        sheet.paste(image, (left, 0))
        left += image.width + MARGIN
    return sheet.quantize(COLOURS, dither=Image.Dither.NONE)


def make_picture(path: Path = PICTURE) -> None:
    """Draw velocity against torque beside the coefficients over time."""
    estimate = estimate_log(read_log(LOG), AuditSettings(joints=(JOINT,)))
    with tempfile.TemporaryDirectory() as folder:
        sheet = side_by_side([draw(estimate, kind, Path(folder)) for kind in KINDS])
    path.parent.mkdir(parents=True, exist_ok=True)
    sheet.save(path, optimize=True)


if __name__ == "__main__":
    make_picture()
