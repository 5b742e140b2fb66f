"""What holds for every figure of the registry, and for the parts that they are made of."""

import re
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text

from friction_audit.batch.work import session_of
from friction_audit.compensation.settings import ReplaySettings
from friction_audit.drift.two_sides import compare_sides
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.pipeline import AuditSettings, estimate_log, replay_estimate
from friction_audit.reporting.figures import panels
from friction_audit.reporting.figures.registry import FIGURES, FigureKind
from friction_audit.reporting.figures.style import COLUMN_IN, FORMATS, SHEET_IN, STYLE, figure_bytes, load_style
from tests.each_case import thorough
from tests.reporting import batch_by_hand
from tests.reporting.conftest import build_estimate
from tests.reporting.diagnosis_by_hand import VERDICTS_BY_HAND, diagnosis

EVERY = pytest.mark.parametrize("kind", FIGURES, ids=lambda kind: f"{kind.result}-{kind.name}")
ODD = r"a$\bad{$"
"""As mathematics this name would be an error."""
LAST = {kind.result: kind for kind in FIGURES}
"""Of each result one figure."""


@cache
def result_of(kind: str, name: str = "") -> Any:
    if kind == "drift":
        arm = batch_by_hand.arm(8, 3)
        return replace(arm, joints=(replace(arm.joints[0], name=name or arm.joints[0].name), *arm.joints[1:]))
    if kind == "diagnosis":
        first, *others = VERDICTS_BY_HAND
        return diagnosis(replace(first, name=name or first.name), *others)
    log = build_estimate(3).log
    log = replace(log, joint_names=(name or log.joint_names[0], *log.joint_names[1:]))
    estimate = estimate_log(log, AuditSettings())
    if kind == "diff":
        return compare_sides([session_of(estimate)], [session_of(estimate)])
    return estimate if kind == "estimate" else replay_estimate(estimate, ReplaySettings())


def words_in(figure: Figure) -> str:
    """Return all that is written inside panels, above them and at their sides."""
    texts = [text.get_text() for axes in figure.axes for text in axes.texts]
    titles = [axes.get_title(loc=side) for axes in figure.axes for side in ("left", "right")]
    labels = [label.get_text() for axes in figure.axes for label in (*axes.get_yticklabels(), axes.yaxis.label)]
    return " ".join([*texts, *titles, *labels, figure.get_supxlabel()]).replace("\n", " ")


def legend_of(figure: Figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def line(axes: Axes, label: str) -> tuple[Float, Float]:
    (found,) = (one for one in axes.lines if one.get_label() == label)
    return np.asarray(found.get_xdata(), float), np.asarray(found.get_ydata(), float)


@EVERY
def test_sheets_are_a_page_wide_and_name_every_joint_and_joints_are_a_column(kind: FigureKind) -> None:
    result = result_of(kind.result, ODD)
    sheet, column = kind.draw(result), kind.draw(result, 1)
    assert (sheet.get_figwidth(), column.get_figwidth()) == (SHEET_IN, COLUMN_IN)
    for figure in (sheet, column):
        texts = [text for text in figure.findobj(Text) if isinstance(text, Text) and ODD in text.get_text()]
        assert texts
        assert not any(text.get_parse_math() for text in texts)
    left_out = re.findall(r"joints? ([\d, ]+): (?:did|no)", words_in(sheet))
    shown = {number for number in (1, 2, 3) if f"joint {number}" in words_in(sheet)}
    assert shown | {int(number) for found in left_out for number in found.split(",")} >= {1, 2, 3}
    assert sheet.legends or kind.name == "ladder"
    lines = [one for legend in sheet.legends for one in legend.get_lines()]
    looks = [(one.get_color(), one.get_linestyle(), one.get_marker()) for one in lines]
    assert len(looks) == len(set(looks))


@EVERY
def test_a_joint_that_is_not_there_is_named(kind: FigureKind) -> None:
    with pytest.raises(UsageError, match=r"joint 9: .* holds 1, 2, 3"):
        kind.draw(result_of(kind.result), 9)


@pytest.mark.parametrize("kind", [*LAST.values(), *thorough({*FIGURES} - {*LAST.values()})])
def test_a_name_that_is_no_mathematics_can_be_painted(kind: FigureKind) -> None:
    kind.draw(result_of(kind.result, ODD), 1).draw_without_rendering()


@pytest.mark.parametrize("kind", [FIGURES[1], FIGURES[-1]], ids=lambda kind: kind.name)
def test_numbers_of_axes_are_mathematics_in_the_fonts_of_latex(kind: FigureKind) -> None:
    token = STYLE.set(load_style("latex"))
    try:
        figure = kind.draw(result_of(kind.result), 1)
        figure_bytes(figure, "svg")
    finally:
        STYLE.reset(token)
    texts = [text for text in figure.findobj(Text) if isinstance(text, Text) and text.get_visible()]
    numbers = [text for text in texts if "mathdefault" in text.get_text()]
    assert numbers
    assert all(text.get_parse_math() for text in numbers)


@pytest.mark.parametrize("suffix", FORMATS)
def test_the_same_result_gives_the_same_undated_bytes(suffix: str) -> None:
    first, second = (figure_bytes(FIGURES[0].draw(result_of("estimate"), 1), suffix) for _ in range(2))
    assert first == second
    assert len(first) > 1000
    assert not re.search(rb"20\d\d-\d\d-\d\dT", first)


def test_axes_have_the_unit_of_the_torque() -> None:
    axes = panels.label_in_unit(FIGURES[0].draw(result_of("estimate"), 1), "A").axes
    assert "[A]" in axes[0].get_ylabel()
    assert not any("N m" in one.get_ylabel() for one in axes)


def test_the_users_own_matplotlib_settings_change_nothing() -> None:
    with rc_context({"font.size": 30, "lines.linewidth": 9}):
        assert FIGURES[0].draw(result_of("estimate"), 1).axes[0].yaxis.label.get_fontsize() == 7.5


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=400), st.integers(8, 60))
def test_no_extreme_is_lost_and_time_keeps_its_order(values: list[float], most: int) -> None:
    signal = np.array(values)
    t, thinned = panels.thin_extremes(np.arange(len(signal), dtype=np.float64), signal, most)
    width = -(-2 * len(signal) // most)
    whole = len(signal) // width * width if len(signal) > most else len(signal)
    assert thinned.min() <= signal[:whole].min()
    assert thinned.max() >= signal[:whole].max()
    assert (np.diff(t) > 0).all()
    assert len(t) <= max(most, 2) + 1 or len(signal) <= most
    assert (signal[t.astype(int)] == thinned).all()


def test_no_line_bridges_a_gap() -> None:
    t, axes = np.append(np.arange(50.0), [90.0, 91.0]), Figure().subplots()
    panels.draw_curve(axes, t, np.ones(52), 100, label="curve")
    assert np.flatnonzero(np.isnan(line(axes, "curve")[1])).tolist() == [49]


def test_a_slow_signal_passes_the_filter_without_delay_and_a_fast_one_is_gone() -> None:
    t = np.arange(0, 10, 0.001)
    slow, fast = np.sin(2 * np.pi * 0.5 * t), np.sin(2 * np.pi * 100 * t)
    inside = slice(1000, -1000)
    assert panels.smooth(t, slow + fast)[inside] == pytest.approx(slow[inside], abs=2e-3)
    assert panels.smooth(t[:5], t[:5]) is not None
    assert panels.cutoff_hz(t) == panels.CUTOFF_HZ
    assert panels.cutoff_hz(np.arange(0, 10, 1 / 30)) == pytest.approx(6.0)
