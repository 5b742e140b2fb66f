"""Figure of the sweeps: where a loop was lost."""

from typing import Any

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from friction_audit.reporting.figures.compare import draw_sweeps


def sweep(held: str, name: str = "a") -> dict[str, Any]:
    """Return a sweep over 1, 2, 3 and so on; + where the loop held, - where it was lost."""
    points = [
        {"value": float(n), "stable": mark == "+", "energy_slope_w": {"value": 0.01 * n}}
        for n, mark in enumerate(held, start=1)
    ]
    return {"method": "energy", "label": "proposed", "sweep": name, "axis": "k", "points": points}


def shaded(*sweeps: dict[str, Any]) -> list[float]:
    """Return where the shade of lost loops starts."""
    (axes,) = draw_sweeps(sweeps, 0.3).axes
    return [patch.get_x() for patch in axes.patches if isinstance(patch, Rectangle)]


def crosses(*sweeps: dict[str, Any]) -> list[float]:
    (axes,) = draw_sweeps(sweeps, 0.3).axes
    return sorted(np.asarray(line.get_xdata()).item() for line in axes.lines if line.get_marker() == "x")


@pytest.mark.parametrize(
    ("held", "start", "at"),
    [
        ("++++", [], []),
        ("++--", [3.0], [3.0]),
        ("-+++", [], [1.0]),
        ("-+-+", [], [1.0, 3.0, 3.0]),
        ("-++-", [4.0], [1.0, 4.0]),
        ("----", [1.0], []),
    ],
)
def test_where_it_was_lost(held: str, start: list[float], at: list[float]) -> None:
    assert shaded(sweep(held)) == start
    assert crosses(sweep(held)) == at


def test_shaded_where_all_are_lost() -> None:
    assert shaded(sweep("++--"), sweep("+++-", "b")) == [4.0]
    assert shaded(sweep("+---"), sweep("++++", "b")) == []
