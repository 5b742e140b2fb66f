"""What the pages of the effects and of the simulator say is what the simulator does."""

import re
import shlex
from math import inf
from pathlib import Path

import pytest
from PIL import Image

from friction_audit.cli import main
from friction_audit.effects.effect import Effect
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.registry import effects
from friction_audit.simulation import EFFECTS, SCENARIOS
from friction_audit.simulation.effects import HiddenEffect
from tests.documented_commands import ROOT, blocks, commands

DOCS = ROOT / "docs"
PAGES = DOCS / "effects"
IMAGES = DOCS / "images" / "effects"
COLUMN_PX = 748
LARGEST_BYTES = 60_000
EVERY_EFFECT = pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)


def allowed(parameter: Parameter) -> str:
    """Return the range of a parameter in words."""
    low, high = parameter.lower, parameter.upper
    if low == -inf:
        return "any" if high == inf else f"up to {high:g}"
    return f"from {low:g}" if high == inf else f"{low:g} to {high:g}"


def parameter_table(effect: type[HiddenEffect]) -> str:
    """Return the table of an effect's parameters as its page has it; paste it there when it changes."""
    rows = ["| parameter | usual | unit | allowed | meaning |", "| --- | --- | --- | --- | --- |"]
    for one in effect.parameters():
        unit = "" if one.unit == "1" else one.unit
        rows.append(f"| `{one.name}` | {one.default:g} | {unit} | {allowed(one)} | {one.meaning} |")
    if effect.forms:
        words = ", ".join(f"`{word}`" for word in effect.forms)
        rows.append(f"| `form` | `{effect.forms[0]}` | | {words} | functional form |")
    return "\n".join(rows)


def read(effect: type[HiddenEffect]) -> str:
    return (PAGES / f"{effect.name}.md").read_text()


def test_every_page_is_that_of_an_effect() -> None:
    assert {page.stem for page in PAGES.glob("*.md")} == {"index", *(effect.name for effect in EFFECTS)}
    assert {image.stem for image in IMAGES.iterdir()} == {effect.name for effect in EFFECTS}


def test_the_index_lists_the_effects_by_family() -> None:
    rows = re.findall(r"^\| \[(\w+)\]\((\w+)\.md\) \| (.*) \|$", (PAGES / "index.md").read_text(), re.MULTILINE)
    assert rows == [(effect.name, effect.name, effect.summary) for effect in EFFECTS]


@EVERY_EFFECT
def test_page_has_title_summary_and_family(effect: type[HiddenEffect]) -> None:
    title, _, line = read(effect).splitlines()[:3]
    assert title == f"# {effect.name}"
    assert line == f"*{effect.summary[0].upper()}{effect.summary[1:]}.* Family: {effect.family()}."


@EVERY_EFFECT
def test_parameters_are_the_program_s(effect: type[HiddenEffect]) -> None:
    assert parameter_table(effect) in read(effect)
    assert f"`{effect.strength_name()}=0`" in read(effect)


@EVERY_EFFECT
def test_every_form_has_its_equation(effect: type[HiddenEffect]) -> None:
    equation = read(effect).partition("## Equation")[2].partition("## Parameters")[0]
    rows = re.findall(r"^\| `(\w+)` \| `.+` \|", equation, re.MULTILINE)
    assert rows == list(effect.forms)
    assert effect.forms or blocks(equation.replace("```text", "```sh"), "sh")


@EVERY_EFFECT
def test_effects_it_is_confused_with_exist(effect: type[HiddenEffect]) -> None:
    confused = read(effect).partition("## Confused with")[2].partition("## On a real arm")[0]
    names = re.findall(r"^\| \[(\w+)\]", confused, re.MULTILINE)
    assert names
    assert set(names) <= {other.name for other in EFFECTS} - {effect.name}


@pytest.mark.parametrize("candidate", effects(), ids=lambda candidate: candidate.name)
def test_page_says_where_diagnose_looks(candidate: Effect) -> None:
    seen = (PAGES / f"{candidate.name}.md").read_text().partition("## In `diagnose`")[2].partition("## Example")[0]
    rows = dict(re.findall(r"^\| (axis|looked for|untestable where) \| (.+) \|$", seen, re.MULTILINE))
    assert rows["axis"] == candidate.axis
    assert set(rows) == {"axis", "looked for", "untestable where"}


@EVERY_EFFECT
def test_picture_is_as_wide_as_a_column_and_small(effect: type[HiddenEffect]) -> None:
    path = IMAGES / f"{effect.name}.png"
    assert f"(../images/effects/{effect.name}.png)" in read(effect)
    assert path.stat().st_size <= LARGEST_BYTES
    with Image.open(path) as image:
        assert image.width == COLUMN_PX


@EVERY_EFFECT
def test_example_runs(effect: type[HiddenEffect], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (body,) = blocks(read(effect), "sh")
    (command,) = commands(body)
    program, *words = shlex.split(command)
    monkeypatch.chdir(tmp_path)
    assert program == "friction-audit"
    assert [word for word in words if word.split(":")[0].split("@")[0] == effect.name]
    if "--duration" in words:
        at = words.index("--duration")
        words[at : at + 2] = []
    with pytest.raises(SystemExit) as left:
        main([*words, "--duration", "2", "-q"])
    assert left.value.code == 0
    assert (tmp_path / "log.parquet").exists()
    assert f'"{effect.name}"' in (tmp_path / "truth.json").read_text()


def test_scenarios_are_documented() -> None:
    rows = re.findall(r"^\| `([\w-]+)` \| (.*) \|$", (DOCS / "simulator.md").read_text(), re.MULTILINE)
    assert [row for row in rows if row[0] in {scenario.name for scenario in SCENARIOS}] == [
        (scenario.name, scenario.summary) for scenario in SCENARIOS
    ]
