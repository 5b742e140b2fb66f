"""The look of all figures: colours, fonts, file formats."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from importlib import import_module
from io import BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from friction_audit.errors import UsageError, shortened

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Look = dict[str, Any]  # keyword arguments of matplotlib
COLUMN_IN = 3.5  # width of a figure of one joint: a column of an IEEE paper
SHEET_IN = 7.16  # width of a sheet of all joints: both columns

# Okabe and Ito's colours, distinguishable with any colour vision.
RAW = "#9ecae8"
FILTERED = "#004c80"
FITTED = "#d55e00"
DISSIPATED = "#e69f00"
GREEN = "#009e73"
BLUE = "#0072b2"
BORDER = "#000000"
SHADE = "#e9e9e9"
ZOOMED = "#d9ecd9"
REJECTED = "#cc79a7"
MUTED = "#555555"
DASHED = (0, (4, 1.5))

# Style sheets here by name: that of all figures with the fonts of a page, and fonts of a journal and of LaTeX upon it.
STYLES = {name: Path(__file__).with_name("styles") / f"{name}.mplstyle" for name in ("sans", "ieee", "latex")}
STYLE: ContextVar[Mapping[str, Any]] = ContextVar("STYLE", default=MappingProxyType({}))
"""rcParams that come before those of the figures."""
LONGEST_FAULT = 120  # characters of what matplotlib says of a style sheet


def load_style(name: str) -> Mapping[str, Any]:
    """Return the rcParams of a style on that of all figures: by its name here or in matplotlib, or of a style sheet."""
    if name == "sans":
        return {}
    import logging.handlers

    from matplotlib import rc_params_from_file, style

    if name in style.library:
        return dict(style.library[name].items())  # with the type of every name, mypy takes them for no names
    where, expected, path = f"--style {name}", "expected lines like `axes.grid: True`", STYLES.get(name, Path(name))
    if not path.is_file():
        known = f"{', '.join(STYLES)}, or one of matplotlib, e.g. ggplot"
        raise UsageError(f"{where}: neither a file nor a style; give a style sheet (.mplstyle), or a name: {known}")
    logger, heard = logging.getLogger("matplotlib"), logging.handlers.BufferingHandler(capacity=10**6)
    logger.addHandler(heard)  # matplotlib warns of a line that it does not understand, and leaves it out
    try:
        found = rc_params_from_file(path, use_default_template=False)
    except (OSError, UnicodeError) as error:
        raise UsageError(f"{where}: cannot be read ({error}); {expected}; give a style sheet of matplotlib") from error
    finally:
        logger.removeHandler(heard)
    for fault in heard.buffer:
        reason = shortened(fault.getMessage(), LONGEST_FAULT)
        raise UsageError(f"{where}: {reason}; {expected}; correct the file")
    return dict(found.items())


def style_in_force() -> Mapping[str, Any]:
    """Return the rcParams that are not matplotlib's own: those of a program, its style sheets and its matplotlibrc."""
    from matplotlib import rcParams, rcParamsDefault

    known: dict[Any, Any] = rcParamsDefault
    return {name: rcParams[name] for name in known if name != "backend" and rcParams[name] != known[name]}


@contextmanager
def figure_style(*, mathematics: bool = False) -> Iterator[None]:
    """Use the figures' style; ``mathematics``: words between dollar signs are formulas, and none is from a log."""
    import warnings

    from matplotlib import rc_context, rc_params_from_file, rcParamsDefault

    # A matplotlibrc must not change what a command draws; in a program STYLE holds it.
    defaults: dict[Any, Any] = rcParamsDefault  # with the type of every name, mypy looks at this line for seconds
    settings = {name: value for name, value in defaults.items() if name != "backend"}
    settings |= rc_params_from_file(STYLES["sans"], use_default_template=False) | dict(STYLE.get())
    # Words from a log are no LaTeX: panda_joint1 ends its run.
    settings |= {"text.parse_math": mathematics, "text.usetex": False}
    with rc_context(settings), warnings.catch_warnings():
        # Names of joints may be in any script; the user cannot change the font.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


# Formats; metadata that would change from run to run or from one matplotlib to the next is left out.
UNDATED = {"png": {"Software": None}, "svg": {"Date": None, "Creator": None}, "pdf": {"CreationDate": None}}
FORMATS = tuple(UNDATED)


def load_matplotlib(formats: Iterable[str]) -> None:
    """Load what it takes to draw figures in these formats, before the process is copied."""
    for kind in formats:
        import_module(f"matplotlib.backends.backend_{'agg' if kind == 'png' else kind}")


def figure_bytes(figure: "Figure", kind: str) -> bytes:
    """Return the content of a figure's file in one of FORMATS."""
    from matplotlib.ticker import ScalarFormatter

    content = BytesIO()
    with figure_style(mathematics=True):  # axes draw their numbers only now
        for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
            for tick in axis.get_major_ticks() if isinstance(axis.get_major_formatter(), ScalarFormatter) else ():
                tick.label1.set_parse_math(True)  # made while mathematics was off
        figure.savefig(content, format=kind, metadata=UNDATED[kind])
    return content.getvalue()
