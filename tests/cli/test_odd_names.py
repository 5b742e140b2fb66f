"""Names that are no text, that a terminal, a page or a spreadsheet obeys, or that fill it; terminals of few letters."""

import csv
import json
import os
import re
import subprocess
import sys
import unicodedata
from dataclasses import replace
from pathlib import Path

import pytest

from friction_audit.errors import AnalysisError
from friction_audit.io.readers import read_log
from friction_audit.io.writers.write_log import write_log
from friction_audit.reporting.figures.panels import joint_title
from tests.in_this_process import Run
from tests.reporting.conftest import build_estimate

OBEYED = "\x1b[31m\x1b]0;title\x07\x1b[2J\x08\r\x9b31m\x7f\u202egnp\u2066\u061c\u200f"
"""Colour, title, clearing of the terminal, backspace, and turns of the direction of writing."""
FORMULAS = ("=cmd|' /C calc'!A0", "@SUM(1+1)", "\t=1+1", "-x", "+ y")


def call(*words: str | bytes, encoding: str = "utf-8") -> "subprocess.CompletedProcess[bytes]":
    command, env = [sys.executable, "-m", "friction_audit", *words], {**os.environ, "PYTHONIOENCODING": encoding}
    return subprocess.run(command, env=env, capture_output=True, check=False)


def test_a_name_that_is_no_text_and_a_terminal_of_ascii(logs: Path, tmp_path: Path) -> None:
    odd = os.fsencode(tmp_path) + b"/run\xff.csv"
    with open(odd, "wb") as stream:  # noqa: PTH123 - a Path cannot hold it on every system
        stream.write((logs / "moved1.csv").read_bytes())
    done = call("estimate", odd, "--json", "-q")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["source"]["path"].endswith("run\udcff.csv")
    done = call("estimate", odd, "-q", encoding="ascii")
    assert (done.returncode, b"Coulomb" in done.stdout) == (0, True), done.stderr
    done = call("estimate", b"absent\xff.csv")
    assert (done.returncode, done.stderr[:25]) == (3, b"error: absent\\udcff.csv: ")


def log_named(name: str, logs: Path, path: Path) -> Path:
    write_log(replace(read_log(logs / "moved1.csv"), joint_names=(name,)), path)
    return path


def obeyed(text: str) -> set[str]:
    """Return what of a text is no letter to be shown: all control characters and marks of direction."""
    marks = "\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
    return {letter for letter in text if unicodedata.category(letter) == "Cc" or letter in marks} - {"\n", "\t"}


@pytest.mark.parametrize("words", ["info -v", "estimate -v", "replay", "convert out.csv", "estimate no", "info no"])
def test_no_name_commands_the_terminal(words: str, run: Run, logs: Path, tmp_path: Path) -> None:
    command, *others = words.split()
    log = log_named(f"a{OBEYED}[/red]", logs, tmp_path / f"run{OBEYED}[red].parquet")
    answer = run(command, tmp_path / f"{OBEYED}.csv" if others == ["no"] else log, *set(others) - {"no"})
    assert answer.code in (0, 3), answer
    assert "31m" in answer.out + answer.err or words == "convert out.csv"
    assert obeyed(answer.out + answer.err) == set()


def test_no_name_commands_a_page(run: Run, logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = log_named(f"a{OBEYED}", logs, tmp_path / f"run{OBEYED}.parquet")

    def no_answer(*_: object) -> None:
        raise AnalysisError("no candidate")

    monkeypatch.setattr("friction_audit.reporting.report.diagnose_estimate", no_answer)
    assert run("report", log, "-o", "page", "--format", "markdown", "-q").code == 0
    (page,) = (tmp_path / "page").iterdir()
    assert obeyed(page.read_text(encoding="utf-8")) == set()


@pytest.mark.usefixtures("sketched")
def test_no_cell_is_a_formula_or_commands_the_terminal(run: Run, tmp_path: Path) -> None:
    names = tuple(f"{name}{OBEYED}" for name in FORMULAS)
    write_log(replace(build_estimate(len(names), count=8).log, joint_names=names), tmp_path / "run.parquet")
    assert run("estimate", "run.parquet", "-o", "out", "--export", "csv", "-q").code == 0
    tables = {path.name: path.read_text(encoding="utf-8") for path in (tmp_path / "out").glob("*.csv")}
    assert {"coefficient_history.csv", "coefficients.csv", "cycles.csv"} <= tables.keys()
    for text in tables.values():
        assert obeyed(text) == set()
        rows = list(csv.reader(text.splitlines()))
        assert {row[1][:2] for row in rows[1:]} <= {f"'{name[0]}" for name in FORMULAS}
        signed = [cell for row in rows for cell in row if cell[:1] in set("=+-@\t")]
        assert [cell for cell in signed if not re.fullmatch(r"-[\d.]+(e-\d+)?", cell)] == []


@pytest.mark.parametrize("name", ["x" * 10_000, " word" * 2000])
def test_a_long_name_is_cut(name: str, run: Run, logs: Path, tmp_path: Path) -> None:
    """A figure that it leaves no room would warn; a warning is an error here."""
    log = log_named(name, logs, tmp_path / "run.parquet")
    answer = run("estimate", log, "-q")
    assert "…" in answer.out
    assert len(answer.out) < 2000
    assert len(joint_title(1, name)) < 40
    assert run("plot", log, "-o", "figures", "-q").code == 0


@pytest.mark.parametrize("dialect", ["csv-long", "csv-rostopic", "csv-bag"])
@pytest.mark.parametrize("name", ["=1+1", "a, b", 'the "elbow"', "-5"])
def test_a_log_keeps_its_names(name: str, dialect: str, tmp_path: Path) -> None:
    """Tables of results are for spreadsheets; a log in CSV is read back, and its names are what they were."""
    sample = Path(__file__).parents[2] / "sample_logs" / "formats" / "csv.csv"
    log = replace(read_log(sample).take_joints([1]), joint_names=(name,))
    write_log(log, tmp_path / "run.csv", dialect=dialect)
    assert read_log(tmp_path / "run.csv").joint_names == (name,)
