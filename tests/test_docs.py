"""What the documentation says is so: commands, outputs, links, codes, formats, keys."""

import io
import json
import re
import runpy
from contextlib import chdir, redirect_stdout
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from friction_audit.cli.console import DAMAGED, EXCEEDED
from friction_audit.errors import AnalysisError, InputError, UsageError
from friction_audit.io.readers import READERS, read_log
from friction_audit.io.readers.channel_names import QUANTITIES, parse_name
from friction_audit.io.readers.clocks import find_time
from friction_audit.joint_log import JOINT_CHANNELS
from friction_audit.pipeline import AuditSettings, estimate_log
from friction_audit.reporting.estimate import ESTIMATE
from friction_audit.reporting.figures import FIGURES
from friction_audit.simulation import EFFECTS
from friction_audit.simulation.effects.effect import HiddenEffect
from tests.documented_commands import PAGES, ROOT, Terminal, blocks, commands, examples, same
from tests.in_this_process import diagnosed_once

DOCS = ROOT / "docs"
ON_PAGES = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
CONTRIBUTING = ROOT / "CONTRIBUTING.md"
LONG = [page for page in PAGES if page.stem in ("paper", "recording", "compare", "report")]
"""Pages whose commands take long and are held elsewhere: figures of the paper, logs of several lengths, a comparison,
reports as in ``index.md``."""
REPEATED = [page for page in PAGES if page.stem in ("index", "convert", "diagnose", "estimate", "replay", "simulate")]
"""Pages whose commands on imagined logs take long, and are those of other pages with other options."""
SHOWN = [pytest.param(page, marks=[pytest.mark.thorough] if page in LONG else []) for page in PAGES]
IMAGINED = [pytest.param(page, marks=[pytest.mark.thorough] if page in (*LONG, *REPEATED) else []) for page in PAGES]


def cells(page: Path) -> list[list[str]]:
    rows = [line for line in page.read_text().splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in row.strip("|").split(" | ")] for row in rows]


@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize("page", SHOWN, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_run_and_print_what_the_page_shows(page: Path, tmp_path: Path) -> None:
    terminal = Terminal(tmp_path)
    for body in blocks(page.read_text(), "console"):
        for example in examples(body):
            assert not terminal.provide_logs(example.command), f"{example.command}: a log that nobody has; use ```sh"
            shown = terminal.run(example.command)
            assert same(example.output, shown), f"$ {example.command}\n{shown}"


@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize("page", IMAGINED, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_on_imagined_logs_run(page: Path, tmp_path: Path) -> None:
    terminal = Terminal(tmp_path)
    for command in (line for body in blocks(page.read_text(), "sh") for line in commands(body)):
        terminal.provide_logs(command)
        # The stand-ins hold one topic, and its name is not the one imagined.
        shown = terminal.run(re.sub(r" --topic \S+", "", command.partition(" | ")[0]))
        assert terminal.code == 0, f"$ {command}\n{shown}"


@pytest.mark.usefixtures("sketched")
@ON_PAGES
def test_python_runs(page: Path, tmp_path: Path) -> None:
    Terminal(tmp_path)
    for body in blocks(page.read_text(), "python"):
        with chdir(tmp_path), diagnosed_once(), redirect_stdout(io.StringIO()) as said:
            exec(compile(body, str(page), "exec"), {})
        assert said.getvalue() or page == CONTRIBUTING  # which shows modules


def test_the_effect_of_the_example_has_one_law_on_both_sides() -> None:
    detector: dict[str, Any] = {}
    simulator: dict[str, Any] = {}
    for body, names in zip(blocks(CONTRIBUTING.read_text(), "python"), (detector, simulator), strict=True):
        exec(compile(body, str(CONTRIBUTING), "exec"), names)
    dq, fan = np.array([-2.0, 0.0, 0.5]), simulator["Fan"](push_nms2_per_rad2=0.02)
    column = detector["Fan"]().columns(SimpleNamespace(dq=dq), ())
    pushed = [simulator["fan_nm"].py_func(fan, speed) for speed in dq]
    assert pushed == pytest.approx(-0.02 * column[:, 0])


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub names them."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@ON_PAGES
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)\s]+)\)", page.read_text())
    inner = [link for link in links if not link.startswith(("http://", "https://"))]
    for link in inner:
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


def test_every_page_is_in_the_contents() -> None:
    reached: set[Path] = set()
    waiting = [DOCS / "index.md"]
    while waiting:
        page = waiting.pop()
        reached.add(page)
        linked = {(page.parent / name).resolve() for name in re.findall(r"\]\(([^)\s#]+\.md)", page.read_text())}
        waiting += [one for one in linked if one.is_relative_to(DOCS) and one not in reached and one.exists()]
    assert set(DOCS.rglob("*.md")) - reached == set()


def test_pages_name_no_machine() -> None:
    for page in PAGES:
        assert not re.search(r"(?<![\w.*])/(?:home|tmp|work|root|usr)\b", page.read_text()), page


def test_the_table_of_messages_is_that_of_the_source() -> None:
    """The script that writes it would change nothing; a code without a meaning ends it."""
    page = runpy.run_path(str(DOCS / "make_message_page.py"))["page_of"]
    text = (DOCS / "troubleshooting.md").read_text()
    assert page(text) == text, "run python docs/make_message_page.py"


def test_every_reader_and_name_of_a_column_is_documented() -> None:
    rows = [row[:2] for row in cells(DOCS / "formats.md")]
    for reader in READERS:
        assert [f"`{reader.name}`", " ".join(f"`{suffix}`" for suffix in reader.suffixes)] in rows
    words = {row[0].strip("`"): re.findall(r"`(\w+)`", row[1]) for row in rows}
    for channel in QUANTITIES:
        found = {parsed.channel for word in words[channel] if (parsed := parse_name(word)) is not None}
        assert found == {channel}
    for page in ("formats.md", "nomenclature.md"):
        assert {*JOINT_CHANNELS} <= {name for row in cells(DOCS / page) for name in re.findall(r"`(\w+)`", row[0])}


def test_names_of_clocks_are_the_program_s() -> None:
    clocks = ("robot_time", "header_stamp", "log_time", "column")
    rows = [row for row in cells(DOCS / "formats.md") if row[0].strip("`") in clocks]
    assert [row[0].strip("`") for row in rows] == list(clocks)
    for clock, _, names in rows:
        for name in re.findall(r"`([^`]+)`", names.partition(";")[0]):
            found = find_time([name])
            assert found is not None, name
            assert f"`{found.clock}`" == clock, name
    assert all(find_time([name]) is not None for name in ("time_ms", "time [ms]", "t (us)"))


def assert_shown(shown: Any, real: Any, where: str = "") -> None:
    """Compare what a page shows of a document with the document; lists may be cut short."""
    if isinstance(shown, dict):
        assert shown.keys() == real.keys(), where
        for key, value in shown.items():
            assert_shown(value, real[key], f"{where}.{key}")
    elif isinstance(shown, list):
        for value, other in zip(shown, real, strict=False):
            assert_shown(value, other, f"{where}[]")
    elif isinstance(shown, float):
        assert shown == pytest.approx(real, rel=0.02, abs=0.002), where
    else:
        assert shown == real, where


def test_the_document_shown_is_the_document() -> None:
    (body,) = blocks((DOCS / "commands" / "estimate.md").read_text(), "json")
    log = read_log(ROOT / "sample_logs" / "hand_guided.parquet")
    document = ESTIMATE.of(estimate_log(log, AuditSettings(joints=(1,))))
    assert_shown(json.loads(body), document["joints"][0])


def test_exit_codes_are_the_program_s() -> None:
    codes = {0, 1, EXCEEDED, DAMAGED, *(error.exit_code for error in (UsageError, InputError, AnalysisError))}
    page = (DOCS / "troubleshooting.md").read_text().partition("<!-- codes -->")[0]
    assert {int(code) for code in re.findall(r"^\| (\d) \|", page, re.MULTILINE)} == codes


def test_figures_are_documented() -> None:
    for figure in FIGURES:
        page = "diff.md" if figure.result == "diff" else "plot.md"
        assert figure.result == "drift" or f"`{figure.name}`" in (DOCS / "commands" / page).read_text()


def test_readme_tells_the_truth_of_its_log() -> None:
    readme = (ROOT / "README.md").read_text()
    truth = json.loads((ROOT / "sample_logs" / "truth.json").read_text())["hand_guided.parquet"]
    coulomb, viscous = truth["coulomb_nm"], truth["viscous_nms_per_rad"]
    assert f"simulated with\n{coulomb:.2f} N m and {viscous:.2f} N m s/rad" in readme
    log = read_log(ROOT / "sample_logs" / "hand_guided.parquet")
    joint = estimate_log(log, AuditSettings(joints=(truth["joint"],))).friction.joints[0]
    assert joint.coulomb.low < coulomb < joint.coulomb.high
    just_missed = not joint.viscous.low < viscous < joint.viscous.high
    assert ("as the viscous one here just does" in readme) == just_missed


# The pages of the effects: their generated parts are those of the program, and each page is whole.

EFFECT_PAGES, IMAGES = DOCS / "effects", DOCS / "images" / "effects"
COLUMN_PX, LARGEST_BYTES = 748, 60_000
SECTIONS = ["Equation", "Parameters", "In `diagnose`"]
EVERY_EFFECT = pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)


def read(effect: type[HiddenEffect]) -> str:
    return (EFFECT_PAGES / f"{effect.name}.md").read_text()


def test_generated_parts_are_those_of_the_program() -> None:
    made = runpy.run_path(str(DOCS / "make_effect_pages.py"))
    for page in EFFECT_PAGES.glob("*.md"):
        text, name = page.read_text(), page.stem
        written = made["index"](text) if name == "index" else made["page_of"](text, name)
        assert written == text, f"run python docs/make_effect_pages.py {name}"


def test_every_page_is_that_of_an_effect() -> None:
    assert {page.stem for page in EFFECT_PAGES.glob("*.md")} == {"index", *(effect.name for effect in EFFECTS)}
    assert {image.stem for image in IMAGES.iterdir()} == {effect.name for effect in EFFECTS}


@EVERY_EFFECT
def test_a_page_has_all_sections_and_an_equation_for_every_form(effect: type[HiddenEffect]) -> None:
    assert re.findall(r"^## (.*)$", read(effect), re.MULTILINE) == SECTIONS
    equation = read(effect).partition("## Equation")[2].partition("## Parameters")[0]
    assert re.findall(r"^\| `(\w+)` \| `.+` \|", equation, re.MULTILINE) == list(effect.forms)
    assert effect.forms or blocks(equation.replace("```text", "```sh"), "sh")
    assert re.search(r"^Not tested where .+\.$", read(effect).partition("## In `diagnose`")[2], re.MULTILINE)


@EVERY_EFFECT
def test_a_page_shows_its_picture_as_wide_as_a_column(effect: type[HiddenEffect]) -> None:
    assert f"(../images/effects/{effect.name}.png)" in read(effect)
    with Image.open(IMAGES / f"{effect.name}.png") as image:
        assert image.width == COLUMN_PX


def test_pictures_are_small() -> None:
    for image in (DOCS / "images").rglob("*.*"):
        assert image.stat().st_size <= (LARGEST_BYTES if image.parent == IMAGES else 200_000), image
