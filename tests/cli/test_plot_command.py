"""``plot``, and ``--style`` in every command: a style sheet holds in all figures, and what is no style is refused."""

from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd
import pytest

from friction_audit import parallel
from friction_audit.cli.parameters import PLOTTED
from tests.each_case import thorough
from tests.in_this_process import Run


def test_a_sheet_and_every_joint(run: Run, logs: Path, tmp_path: Path) -> None:
    answer = run("plot", logs / "moved2.csv")
    names = ["velocity-torque", "velocity-torque-joint1", "velocity-torque-joint2"]
    assert answer.out.split() == [f"figures/{name}.png" for name in names]
    assert all((tmp_path / path).stat().st_size > 10_000 for path in answer.out.split())


@pytest.mark.usefixtures("sketched")
def test_a_joint_that_did_not_move_has_no_figure_of_its_own(run: Run, logs: Path) -> None:
    frame = pd.read_csv(logs / "moved2.csv")
    frame.loc[:, frame.columns.str.contains("q_2")] = 0.0
    frame.to_csv("half.csv", index=False)
    answer = run("plot", "half.csv")
    assert answer.out.split() == ["figures/velocity-torque.png", "figures/velocity-torque-joint1.png"]
    assert "velocity-torque: no figure of joint 2 alone: did not move" in answer.err


@pytest.mark.thorough
def test_copies_of_the_process_draw_the_same_files(run: Run, logs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = []
    for workers in (1, 3):
        monkeypatch.setattr(parallel, "workers_for", lambda _, workers=workers: workers)
        answer = run("plot", logs / "moved2.csv", "--figure-format", "svg", "-o", "drawn", "--overwrite")
        drawn.append({path: Path(path).read_bytes() for path in answer.out.split()})
    assert list(drawn[0]) == list(drawn[1])
    assert len(drawn[0]) == 3
    assert drawn[0] == drawn[1]


@pytest.mark.usefixtures("sketched")
def test_one_joint_needs_no_sheet(run: Run, logs: Path) -> None:
    words = ("--joints", "2", "--figures", "all", "--figure-format", "svg,pdf", "-o", "x", "--json")
    answer = run("plot", logs / "moved2.csv", *words)
    figures = answer.document()["figures"]
    assert tuple(figure["kind"] for figure in figures[::2]) == PLOTTED
    assert {figure["joint"] for figure in figures} == {2}
    assert {Path(figure["path"]).suffix for figure in figures} == {".svg", ".pdf"}


@pytest.mark.usefixtures("sketched")
def test_a_joint_at_rest_is_drawn_all_the_same(run: Run, logs: Path) -> None:
    answer = run("plot", logs / "still.csv", "--figures", "all")
    assert answer.code == 0
    assert len(answer.out.split()) == len(PLOTTED)


SHEET = "axes.grid: True\nfont.size: 13\nlines.linewidth: 2.5\nsavefig.dpi: 50\ntext.usetex: True\n"


@pytest.mark.parametrize("command", ["plot", *thorough(["estimate", "diff"])])
def test_a_style_sheet_holds_in_the_figures_of_every_command(command: str, run: Run, logs: Path) -> None:
    Path("paper.mplstyle").write_text(SHEET)
    log, kind = logs / "moved1.csv", "sides" if command == "diff" else "velocity-torque"
    words = [command, log, *([log] if command == "diff" else []), "--figures", kind, "-q"]
    assert run(*words, "-o", "own", "--style", "paper.mplstyle").code == 0
    assert run(*words, "-o", "usual").code == 0
    own, usual = (plt.imread(f"{folder}/{kind}.png").shape[:2] for folder in ("own", "usual"))
    assert own == pytest.approx([50 / 300 * one for one in usual], abs=1)


@pytest.mark.parametrize(("content", "found"), [
    (None, "neither a file nor a style; give a style sheet (.mplstyle), or a name: sans, ieee, latex"),
    (b"axes.gird: True\n", "Bad key axes.gird in file"),
    (b"font.size: large it is\n", "Bad value in file"),
    (b"no colon\n", "Missing colon in file"),
    (b"\xff\xfe\x00binary", "cannot be read"),
])  # fmt: skip
def test_what_is_no_style_is_refused_before_anything_is_done(content: bytes | None, found: str, run: Run) -> None:
    if content is not None:
        Path("my.mplstyle").write_bytes(content)
    answer = run("plot", "absent.csv", "--style", "my.mplstyle")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith(f"error: --style my.mplstyle: {found}"), answer.err
    assert answer.err.count("\n") == 1
