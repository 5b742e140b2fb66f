"""``--style``: rcParams of a name or a style sheet in every figure, and what is no style."""

from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest
from matplotlib.figure import Figure

import friction_audit
from friction_audit.reporting.figures.style import RC
from tests.cli.conftest import Run
from tests.reporting.conftest import build_estimate

SHEET = "axes.grid: True\nfont.size: 13\nlines.linewidth: 2.5\nsavefig.dpi: 50\ntext.usetex: True\n"


def size_of(path: Path) -> tuple[int, int]:
    height, width = plt.imread(path).shape[:2]
    return width, height


@pytest.mark.parametrize("command", ["plot", "estimate", "diff"])
def test_a_style_sheet_holds_in_the_figures_of_every_command(command: str, run: Run, logs: Path) -> None:
    Path("paper.mplstyle").write_text(SHEET)
    log, kind = logs / "moved1.csv", "sides" if command == "diff" else "velocity-torque"
    words = [command, log, *([log] if command == "diff" else []), "--figures", kind, "-q"]
    assert run(*words, "-o", "own", "--style", "paper.mplstyle").code == 0
    assert run(*words, "-o", "usual").code == 0
    own, usual = (size_of(Path(folder) / f"{kind}.png") for folder in ("own", "usual"))
    assert own == pytest.approx([50 / RC["savefig.dpi"] * one for one in usual], abs=1)


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (None, "neither a file nor a style; give a style sheet (.mplstyle), or a name: sans, ieee, latex"),
        (b"axes.gird: True\n", "Bad key axes.gird in file"),
        (b"font.size: large it is\n", "Bad value in file"),
        (b"no colon\n", "Missing colon in file"),
        (b"\xff\xfe\x00binary", "cannot be read"),
    ],
)
def test_what_is_no_style_is_refused_before_anything_is_done(content: bytes | None, found: str, run: Run) -> None:
    if content is not None:
        Path("my.mplstyle").write_bytes(content)
    answer = run("plot", "absent.csv", "--style", "my.mplstyle")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith(f"error: --style my.mplstyle: {found}"), answer.err
    assert answer.err.count("\n") == 1


def test_rcparams_of_a_program_hold_in_its_figures_and_not_in_those_of_commands(run: Run, logs: Path) -> None:
    result = build_estimate(1, count=24, rate=200.0)
    usual = friction_audit.plot(result)
    with mpl.rc_context({"axes.facecolor": "#eeeeff", "font.size": 13, "xtick.labelsize": 12}):
        own = friction_audit.plot(result)
        assert run("plot", logs / "moved1.csv", "-o", "own", "-q").code == 0
    assert run("plot", logs / "moved1.csv", "-o", "usual", "-q").code == 0
    assert isinstance(own, Figure)
    assert isinstance(usual, Figure)
    assert own.axes[0].get_facecolor() == mpl.colors.to_rgba("#eeeeff") != usual.axes[0].get_facecolor()
    sizes = [figure.axes[0].get_xticklabels()[0].get_fontsize() for figure in (own, usual)]
    assert sizes == [12, RC["xtick.labelsize"]]
    pictures = {(Path(folder) / "velocity-torque.png").read_bytes() for folder in ("own", "usual")}
    assert len(pictures) == 1
