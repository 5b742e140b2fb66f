"""LogReport -> the figures of its page: which there are, what they show, and how they are made small."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure as Drawing
from matplotlib.lines import Line2D

from friction_audit.parallel import in_processes, workers_for
from friction_audit.reporting.figures.panels import label_in_unit, thin_extremes
from friction_audit.reporting.figures.registry import Figure as FigureKind
from friction_audit.reporting.figures.registry import figures_of
from friction_audit.reporting.html.page import Figure, draw_inline
from friction_audit.reporting.report import JointReport, LogReport, joint_words
from friction_audit.reporting.words import in_unit, joint_label

FIRST = "velocity-torque"  # stands next to the answer
SECTIONS = {"estimate": "friction", "replay": "compensator", "diagnosis": "diagnosis"}  # by the result that is drawn
LOG_FIGURES = tuple(kind for kind in figures_of(*SECTIONS) if kind.caption)
MOST_BYTES = 2_500_000  # figures of one page together
ON_A_SHEET = 8  # joints of one figure
CLOUD = 60  # dots in a panel from which on they are an image: text would be larger than the rest of the page
COARSE_PT = 0.5  # invisible deviation of a drawn line
MOST_POINTS = 1500  # points of a curve over time: more than a panel has dots of a screen, also enlarged


class Drawn(NamedTuple):
    """The figures of a page by section, in order, and titles of those that found no room."""

    by_section: Mapping[str, list[Figure]]
    left_out: Mapping[str, list[str]]


@lru_cache(maxsize=1)  # a page and its PDF have the same figures
def draw_figures(report: LogReport) -> Drawn:
    """Draw the figures sheet by sheet, all kinds of the first joints before those of the next, while there is room."""
    from friction_audit.reporting.figures.style import load_matplotlib

    drawn, left = Drawn(defaultdict(list), defaultdict(list)), MOST_BYTES
    sheets = list(_sheets(report))
    load_matplotlib(["svg", "png"] if sheets else [])  # once, and not by every copy
    work = in_processes(lambda k: _figure(report, *sheets[k]), len(sheets), workers_for(len(sheets)))
    for kind, _, title in sheets:
        figure = next(work) if left > 0 else None
        left -= 0 if figure is None else len(figure.svg)
        if figure is None or left < 0:
            drawn.left_out[_section(kind)].append(title)
        else:
            drawn.by_section[_section(kind)].append(figure)
    return drawn


def _section(kind: FigureKind) -> str:
    return "verdicts" if kind.name == FIRST else SECTIONS[kind.result]


def _sheets(report: LogReport) -> Iterator[tuple[FigureKind, tuple[JointReport, ...], str]]:
    """Yield kind, joints and title of every figure of the sections asked for."""
    shown = {}
    for kind in LOG_FIGURES:
        result = getattr(report, kind.result)
        if result is not None and _section(kind) in ("verdicts", *report.sections):
            layout = kind.layout()
            shown[kind] = {one.joint for one in layout.joints(result) if layout.has(result, one)}
    every = [one for one in report.joints if any(one.joint in numbers for numbers in shown.values())]
    for first in range(0, len(every), ON_A_SHEET):
        own = every[first : first + ON_A_SHEET]
        which = "" if len(every) <= ON_A_SHEET else f", joints {own[0].joint} to {own[-1].joint}"
        for kind, numbers in shown.items():
            joints = tuple(one for one in own if one.joint in numbers)
            if joints:
                yield kind, joints, f"{kind.title}{which}"


def _figure(report: LogReport, kind: FigureKind, joints: tuple[JointReport, ...], title: str) -> Figure:
    numbers = tuple(one.joint for one in joints)
    drawing = label_in_unit(kind.draw(getattr(report, kind.result), numbers), report.unit)
    _make_small(drawing)
    words = [f"joint {joint_label(one.joint, one.name)}: {joint_words(one)}" for one in joints]
    words_in_unit = in_unit(f"{title}. {'; '.join(words)}.", report.unit)
    prefix = f"{kind.name}-{numbers[0]}"
    return draw_inline(drawing, prefix, title=title, caption=kind.caption, description=words_in_unit)


def _make_small(drawing: Drawing) -> None:
    """Let clouds of dots be images, and leave of curves what is visible."""
    for line in drawing.findobj(Line2D):
        assert isinstance(line, Line2D)
        x, y = (np.asarray(data, dtype=np.float64) for data in line.get_data())
        dots = line.get_linestyle() == "None"
        line.set_rasterized(dots and len(x) > CLOUD)
        long = len(x) > MOST_POINTS and not dots and line.get_drawstyle() == "default"
        if long and bool((np.diff(x) > 0.0).all() and np.isfinite(y).all()):
            line.set_data(*thin_extremes(x, y, MOST_POINTS))
        line.get_path().simplify_threshold = COARSE_PT
