"""Which logs there are, and what a manifest says of them."""

from pathlib import Path

import pytest

from friction_audit.batch.find_logs import LogFile, find_logs
from friction_audit.batch.identity import read_manifest
from friction_audit.errors import InputError, UsageError

TREE = (
    "run10.csv", "run2.csv", "notes.txt", ".hidden.csv", ".git/x.csv", "2026-03-01/a.mcap", "2026-03-01/b.mcap",
    "bag/metadata.yaml", "bag/bag_0.db3", "split/split_0.mcap", "split/split_1.mcap", "results/ledger.sqlite",
    "results/sessions.csv", "mixed/mixed_0.mcap", "mixed/monday.mcap", "said/metadata.yaml", "said/notes.csv",
    "zipped/zipped_0.db3.zstd",
)  # fmt: skip


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for path in (tmp_path / "lab" / name for name in TREE):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(str(path.relative_to(tmp_path)))
    return tmp_path


def names(logs: list[LogFile]) -> list[str]:
    return [log.path for log in logs]


# A bag says that it is one and has a storage file, or has files that are called as it is and no others.
IN_THE_LAB = [
    f"lab/{name}"
    for name in ("2026-03-01/a.mcap", "2026-03-01/b.mcap", "bag", "mixed/mixed_0.mcap", "mixed/monday.mcap", "run2.csv",
                 "run10.csv", "said/notes.csv", "split", "zipped")
]  # fmt: skip


def test_a_folder_is_searched_to_the_bottom(tree: Path) -> None:
    logs = find_logs(["lab"], {})
    assert names(logs) == IN_THE_LAB
    assert all(Path(log.place) == tree / log.path for log in logs)
    assert logs[0].folders == ("2026-03-01", "lab")
    assert logs[0].size == len("lab/2026-03-01/a.mcap")


@pytest.mark.usefixtures("tree")
def test_each_log_once_however_it_is_named() -> None:
    Path("link.csv").symlink_to("lab/run2.csv")
    assert names(find_logs(["lab", "lab/run2.csv", "lab/*.csv", "./lab/bag", "lab/bag/", "link.csv"], {})) == IN_THE_LAB


@pytest.mark.usefixtures("tree")
def test_globs_and_named_files() -> None:
    nested = sorted(f"lab/{name}" for name in TREE if name.endswith(".mcap"))
    assert names(find_logs(["lab/**/*.mcap"], {})) == nested
    assert names(find_logs(["lab/notes.txt"], {})) == ["lab/notes.txt"]
    Path("odd[1].csv").touch()
    assert names(find_logs(["odd[1].csv"], {})) == ["odd[1].csv"]


@pytest.mark.usefixtures("tree")
def test_a_manifest_names_logs_and_says_more_of_others() -> None:
    Path("manifest.csv").write_text("path,robot\nlab/run2.csv,left\n")
    rows = read_manifest(Path("manifest.csv"))
    alone = find_logs([], rows)
    assert [log.row.robot for log in alone if log.row] == ["left"]
    both = find_logs(["."], rows, leave_out=[Path("manifest.csv")])
    assert names(both) == IN_THE_LAB
    assert [log.path for log in both if log.row] == ["lab/run2.csv"]


@pytest.mark.usefixtures("tree")
def test_what_leads_nowhere_is_said_at_once() -> None:
    Path("empty").mkdir()
    with pytest.raises(InputError) as caught:
        find_logs(["lab", "absent.csv", "empty", "lab/*.bag"], {})
    said = str(caught.value)
    assert "absent.csv: no such file or directory" in said
    assert "empty: no log there or below; expected files that end in" in said
    assert "lab/*.bag: no file matches" in said


def test_urls(tree: Path) -> None:
    pytest.importorskip("fsspec")
    root = f"file://{tree}"
    assert names(find_logs([f"{root}/lab"], {})) == [f"{root}/{name}" for name in IN_THE_LAB]
    one = find_logs([f"{root}/lab/run2.csv"], {})[0]
    assert (one.folders, one.size) == (("lab",), len("lab/run2.csv"))
    assert one.changed
    assert names(find_logs([f"{root}/lab/run*.csv"], {})) == [f"{root}/lab/run2.csv", f"{root}/lab/run10.csv"]
    with pytest.raises(InputError, match=r"absent\.csv: no log there"):
        find_logs([f"{root}/absent.csv"], {})
    with pytest.raises(UsageError, match=r"nosuch://x/y\.csv: .*check the part before"):
        find_logs(["nosuch://x/y.csv"], {})


def test_urls_without_fsspec(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "fsspec.core", None)
    with pytest.raises(UsageError, match=r"s3://lab/a.csv: .*pip install 'friction-audit\[remote\]'"):
        find_logs(["s3://lab/a.csv"], {})


def write(folder: Path, content: str | bytes) -> Path:
    for name in ("run1.csv", "run2.csv"):
        (folder / name).touch()
    path = folder / "manifest.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
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
    said = (first.robot, first.start_s, first.temperature_c, first.payload, first.note)
    assert said == ("left", 1772323200.0, 23.5, "0.7 kg, hand", "after service")
    assert (second.robot, second.start_s, second.temperature_c, second.note) == ("", None, None, "")


FAULTY: dict[str, tuple[str | bytes, str]] = {
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
    "no text": (b"path\n\xff\xfe\n", "is not text in UTF-8"),
}


@pytest.mark.parametrize("fault", FAULTY)
def test_faults_are_named(fault: str, tmp_path: Path) -> None:
    text, message = FAULTY[fault]
    with pytest.raises(InputError) as caught:
        read_manifest(write(tmp_path, text))
    assert message in str(caught.value)
    assert str(caught.value).startswith(str(tmp_path / "manifest.csv"))


def test_a_manifest_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_manifest(tmp_path / "absent.csv")
