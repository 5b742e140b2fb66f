"""The generated parts of the pages of the effects are those of the program, and each page is whole."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from PIL import Image

from friction_audit.simulation import EFFECTS
from friction_audit.simulation.effects import HiddenEffect
from tests.documented_commands import ROOT, blocks

DOCS = ROOT / "docs"
PAGES = DOCS / "effects"
IMAGES = DOCS / "images" / "effects"
COLUMN_PX = 748
LARGEST_BYTES = 60_000
SECTIONS = ["Equation", "Parameters", "In `diagnose`"]
EVERY_EFFECT = pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)


def read(effect: type[HiddenEffect]) -> str:
    return (PAGES / f"{effect.name}.md").read_text()


def test_generated_parts_are_those_of_the_program(tmp_path: Path) -> None:
    """The script that writes the pages would change none of them."""
    (tmp_path / "effects").mkdir()
    script = (DOCS / "make_effect_pages.py").read_text()
    (tmp_path / "make_effect_pages.py").write_text(script)
    for page in PAGES.glob("*.md"):
        (tmp_path / "effects" / page.name).write_text(page.read_text())
    subprocess.run([sys.executable, tmp_path / "make_effect_pages.py"], check=True)
    for page in PAGES.glob("*.md"):
        written = (tmp_path / "effects" / page.name).read_text()
        assert written == page.read_text(), f"run python docs/make_effect_pages.py {page.stem}"


def test_every_page_is_that_of_an_effect() -> None:
    assert {page.stem for page in PAGES.glob("*.md")} == {"index", *(effect.name for effect in EFFECTS)}
    assert {image.stem for image in IMAGES.iterdir()} == {effect.name for effect in EFFECTS}


@EVERY_EFFECT
def test_a_page_has_all_sections_and_an_equation_for_every_form(effect: type[HiddenEffect]) -> None:
    assert re.findall(r"^## (.*)$", read(effect), re.MULTILINE) == SECTIONS
    equation = read(effect).partition("## Equation")[2].partition("## Parameters")[0]
    assert re.findall(r"^\| `(\w+)` \| `.+` \|", equation, re.MULTILINE) == list(effect.forms)
    assert effect.forms or blocks(equation.replace("```text", "```sh"), "sh")
    assert re.search(r"^Not tested where .+\.$", read(effect).partition("## In `diagnose`")[2], re.MULTILINE)


@EVERY_EFFECT
def test_picture_is_as_wide_as_a_column_and_small(effect: type[HiddenEffect]) -> None:
    path = IMAGES / f"{effect.name}.png"
    assert f"(../images/effects/{effect.name}.png)" in read(effect)
    assert path.stat().st_size <= LARGEST_BYTES
    with Image.open(path) as image:
        assert image.width == COLUMN_PX
