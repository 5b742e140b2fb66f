"""How every figure looks: sizes for a two-column paper, colours that everybody can tell apart."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

COLUMN_IN = 3.5
"""Width of a figure of one joint: a column of a two-column paper. [in]"""
SHEET_IN = 7.0
"""Width of a sheet of all joints: the page. [in]"""

# Okabe and Ito's colours, distinguishable with any colour vision.
RAW = "#9ecae8"
FILTERED = "#004c80"
FITTED = "#d55e00"
DISSIPATED = "#e69f00"
BORDER = "#000000"
SHADE = "#e9e9e9"
ZOOMED = "#d9ecd9"
REJECTED = "#cc79a7"
MUTED = "#555555"

RC: dict[str, Any] = {
    "font.size": 7.5,
    "axes.labelsize": 7.5,
    "axes.titlesize": 7.5,
    "axes.titlelocation": "left",
    "axes.titlepad": 3.0,
    "axes.linewidth": 0.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "xtick.major.width": 0.5,
    "ytick.major.width": 0.5,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.2,
    "lines.linewidth": 0.8,
    "hatch.linewidth": 0.4,
    "figure.constrained_layout.h_pad": 0.02,
    "figure.constrained_layout.w_pad": 0.02,
    "savefig.dpi": 300,
    "pdf.fonttype": 42,
    "svg.hashsalt": "friction-audit",
}


@contextmanager
def figure_style(*, mathematics: bool = False) -> Iterator[None]:
    """Use the figures' style inside the block; a letter that its font lacks is a box, or the reader's own in a page.

    Args:
        mathematics: Whether words between dollar signs are formulas, where no word comes from a log.
    """
    import warnings

    from matplotlib import rc_context, rcParamsDefault

    # The user's own matplotlibrc must not change what a result looks like.
    defaults: dict[Any, Any] = rcParamsDefault  # told the type of every name, mypy looks at this line for seconds
    settings = {name: value for name, value in defaults.items() if name != "backend"} | RC
    settings["text.parse_math"] = mathematics
    with rc_context(settings), warnings.catch_warnings():
        # Names of joints may be in any script; there is nothing that the user could do about the font.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield
