"""``--style``: rcParams of a name or a style sheet in every figure, and what is no style."""

from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from friction_audit.reporting.figures.style import RC
from tests.cli.conftest import Run

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
