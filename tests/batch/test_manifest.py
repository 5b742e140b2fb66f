from pathlib import Path

import pytest

from friction_audit.batch.manifest import read_manifest
from friction_audit.errors import InputError


def write(folder: Path, text: str) -> Path:
    (folder / "run1.csv").touch()
    (folder / "run2.csv").touch()
    path = folder / "manifest.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_rows_by_place(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        "\ufeffPath, start, robot, temperature, payload, note, operator\n"
        'run1.csv, 2026-03-01, left, 23.5, "0.7 kg, hand", after service, Ann\n'
        "\n"
        "s3://lab/run2.mcap,,,,,\n",
    )
    rows = read_manifest(path)
    assert list(rows) == [str(tmp_path / "run1.csv"), "s3://lab/run2.mcap"]
    first, second = rows.values()
    assert (first.robot, first.temperature_c, first.payload, first.note) == (
        "left",
        23.5,
        "0.7 kg, hand",
        "after service",
    )
    assert first.start_s == 1772323200.0
    assert (second.robot, second.start_s, second.temperature_c, second.note) == ("", None, None, "")


FAULTY = {
    "no path": ("robot\nleft\n", "no column path; found robot; expected path, start"),
    "empty": ("", "no column at all; found an empty file"),
    "header alone": ("path\n", "no rows below the header"),
    "misspelt": ("path,temprature\nrun1.csv,20\n", "column temprature: did you mean temperature?"),
    "twice": ("path,path\nrun1.csv,run2.csv\n", "column path comes twice"),
    "same log twice beside another fault": (
        "path,temperature\nrun1.csv,warm\nrun1.csv,20\n",
        "expected degrees Celsius, such as 23.5; line 3: run1.csv comes twice, first in line 2",
    ),
    "same log twice": ("path\nrun1.csv\n./run1.csv\n", "line 3: ./run1.csv comes twice, first in line 2"),
    "too many cells": ("path,note\nrun1.csv,a,b\n", "line 2: 3 cells under 2 columns; put text with commas in quotes"),
}


@pytest.mark.parametrize("fault", FAULTY)
def test_faults_are_named(fault: str, tmp_path: Path) -> None:
    text, message = FAULTY[fault]
    with pytest.raises(InputError) as caught:
        read_manifest(write(tmp_path, text))
    assert message in str(caught.value)
    assert str(caught.value).startswith(str(tmp_path / "manifest.csv"))


def test_all_faults_at_once(tmp_path: Path) -> None:
    text = "path,start,temperature\nabsent.csv,,\nrun1.csv,tomorrow,warm\n,,\nrun2.csv,2026-03-01,\n,2026-03-01,\n"
    with pytest.raises(InputError) as caught:
        read_manifest(write(tmp_path, text))
    said = str(caught.value)
    for part in (
        "line 2: absent.csv: no such file",
        "line 3: start tomorrow: expected a date",
        "line 3: temperature warm: expected degrees",
        "line 6: no path",
    ):
        assert part in said


def test_what_is_no_text(tmp_path: Path) -> None:
    path = tmp_path / "manifest.csv"
    path.write_bytes(b"path\n\xff\xfe\n")
    with pytest.raises(InputError, match="is not text in UTF-8"):
        read_manifest(path)
    with pytest.raises(InputError, match="cannot be read"):
        read_manifest(tmp_path / "absent.csv")
