"""File names that are no text, and terminals that know few letters."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.conftest import Run


def call(*words: str | bytes, encoding: str = "utf-8") -> "subprocess.CompletedProcess[bytes]":
    return subprocess.run(
        [sys.executable, "-m", "friction_audit", *words],
        env={**os.environ, "PYTHONIOENCODING": encoding},
        capture_output=True,
        check=False,
    )


@pytest.fixture
def odd(logs: Path, tmp_path: Path) -> bytes:
    """Return a log whose name is not UTF-8."""
    name = os.fsencode(tmp_path) + b"/run\xff.csv"
    with open(name, "wb") as stream:  # noqa: PTH123 - a Path cannot hold it on every system
        stream.write((logs / "moved1.csv").read_bytes())
    return name


def test_a_name_that_is_no_text(odd: bytes) -> None:
    done = call("estimate", odd, "--json", "-q")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["source"]["path"].endswith("run\udcff.csv")


@pytest.mark.usefixtures("sketched")
def test_a_document_that_names_it(odd: bytes, run: Run, tmp_path: Path) -> None:
    answer = run("estimate", os.fsdecode(odd), "--json", "-q", "-o", os.fsdecode(os.fsencode(tmp_path) + b"/\xff"))
    assert answer.code == 0, answer.err
    assert answer.document()["source"]["path"].endswith("run\udcff.csv")
    assert json.loads((tmp_path / "\udcff" / "estimate.json").read_text()) == answer.document()


def test_an_error_about_it() -> None:
    done = call("estimate", b"absent\xff.csv")
    assert done.returncode == 3
    assert done.stderr.startswith(b"error: absent\\udcff.csv: ")


def test_a_terminal_of_ascii(logs: Path) -> None:
    done = call("estimate", str(logs / "moved1.csv"), "-q", encoding="ascii")
    assert done.returncode == 0, done.stderr
    assert b"Coulomb" in done.stdout
