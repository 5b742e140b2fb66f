"""Figures of one command: the same files whoever draws them."""

import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from matplotlib.figure import Figure

from friction_audit import parallel
from friction_audit.cli import outputs
from friction_audit.cli.console import Voice
from friction_audit.cli.outputs import FigureFile, ResultFolder
from friction_audit.errors import AnalysisError, UsageError
from friction_audit.reporting.figures.style import figure_style

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="no process is copied there")
FORMATS = ("png", "svg", "pdf")


def line(joint: int | None) -> Figure:
    with figure_style():
        figure = Figure(figsize=(2.0, 1.0))
        figure.subplots().plot([0.0, 1.0 if joint is None else joint])
        figure.suptitle("torque [N m]")
    return figure


def nothing(joint: int | None) -> Figure:
    raise AnalysisError(f"joint {joint}: nothing to draw")


def drawn_by(
    workers: int, folder: Path, kinds: tuple[str, ...] = ("line",), *, verbose: bool = False
) -> list[FigureFile]:
    known = [
        SimpleNamespace(name="line", result="any", draw=lambda _, joint: line(joint)),
        SimpleNamespace(name="nothing", result="any", draw=lambda _, joint: nothing(joint)),
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parallel, "workers_for", lambda _: workers)
        patch.setattr(outputs, "FIGURES", known)
        voice = Voice(quiet=False, verbose=verbose)
        out = ResultFolder(folder=folder, figures=kinds, formats=FORMATS, overwrite=False)
        return out.write_figures({"any": 0}, (2, 5), "N m", voice, each_joint=True)


def test_copies_write_the_same_files_in_the_same_order(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    alone, together = drawn_by(1, tmp_path / "one"), drawn_by(3, tmp_path / "three", verbose=True)
    assert [(file.kind, file.joint, file.path.name) for file in together] == [
        ("line", joint, f"{name}.{suffix}")
        for joint, name in ((None, "line"), (2, "line-joint2"), (5, "line-joint5"))
        for suffix in FORMATS
    ]
    assert [file.path.read_bytes() for file in together] == [file.path.read_bytes() for file in alone]
    told = [words.split(":")[0] for words in capsys.readouterr().err.splitlines()]
    assert told == ["draw line", "draw line-joint2", "draw line-joint5"]


@pytest.mark.parametrize("workers", [1, 3])
def test_what_cannot_be_drawn_is_said_and_those_before_it_are_there(workers: int, tmp_path: Path) -> None:
    with pytest.raises(AnalysisError, match="joint None: nothing to draw"):
        drawn_by(workers, tmp_path, ("line", "nothing"))
    assert len(list(tmp_path.iterdir())) == 3 * len(FORMATS)


@pytest.mark.parametrize("workers", [1, 3])
def test_a_file_that_exists_is_left_as_it_is(workers: int, tmp_path: Path) -> None:
    (tmp_path / "line-joint2.png").touch()
    with pytest.raises(UsageError, match=r"line-joint2\.png: exists already"):
        drawn_by(workers, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {*(f"line.{suffix}" for suffix in FORMATS), "line-joint2.png"}
    assert (tmp_path / "line-joint2.png").read_bytes() == b""
