"""The whole comparison, short."""

from collections.abc import Sequence
from dataclasses import replace
from math import inf

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from friction_audit.cli.compare import FIGURES
from friction_audit.compensation.comparison import METHODS, Comparison, compare
from friction_audit.compensation.comparison.experiment import choose_best
from friction_audit.compensation.comparison.methods import BEST, Joint, Tuning
from friction_audit.compensation.comparison.result import Curve, Point
from friction_audit.compensation.compensators import Compensator, FixedCompensation
from friction_audit.reporting.compare import compare_lines
from friction_audit.reporting.figures.comparison import draw_comparison as draw
from friction_audit.reporting.figures.comparison import draw_sweeps
from tests.comparison.conftest import CHOSEN, SEEDS, compared, short_joint


def test_every_method_has_its_rows_in_order() -> None:
    rows = compared().rows
    assert list(dict.fromkeys(row.method for row in rows)) == list(CHOSEN)
    for name in CHOSEN:
        roles = [row.role for row in rows if row.method == name]
        assert roles[0] == "paper"
        assert roles.count("best") == (0 if name in ("none", "oracle") else 1)
    assert all(len(row.outcomes) == SEEDS for row in rows)


def test_what_was_found() -> None:
    slopes = {
        row.method: row.interval(lambda outcome: outcome.energy_slope_w).value
        for row in compared().rows
        if row.role == "paper"
    }
    assert slopes["none"] > 0.1
    assert slopes["none"] > slopes["disturbance_observer"] > slopes["torque_regulation"] > abs(slopes["energy"])
    assert slopes["torque_regulation"] > abs(slopes["oracle"])
    full = compared().row("disturbance_observer", "full")
    assert full is not None
    assert abs(full.interval(lambda outcome: outcome.energy_slope_w).value) < 0.1 * slopes["none"]


def test_a_method_without_stable_tuning_is_reported_and_named() -> None:
    (method,) = (one for one in METHODS if one.name == "torque_regulation")
    hopeless = replace(method, sweeps=(replace(method.sweeps[0], values=(40.0, 80.0)),))
    comparison = compare(short_joint(), SEEDS, [METHODS[0], hopeless])
    best = comparison.row("torque_regulation", BEST)
    assert best is not None
    assert best.tuning_losses == len(comparison.tuning_seeds)
    assert best.stable_share == 0.0
    assert best.margins == (0.0,)
    assert "no setting tried is stable" in table_of(comparison)
    assert tuple(draw(comparison)) == FIGURES


def table_of(comparison: Comparison) -> str:
    lines = compare_lines(comparison.rows, len(comparison.seeds), len(comparison.tuning_seeds))
    return "\n".join(str(line) for line in lines)


def point(slopes_w: Sequence[float], losses: int) -> Point:
    """Return a point of a sweep whose first persons lost the loop."""
    (some,) = (row.outcomes[0] for row in compared().rows if row.method == "none")
    outcomes = tuple(
        replace(some, stable=n >= losses, energy_slope_w=slope, lost_s=3.0 if n < losses else inf)
        for n, slope in enumerate(slopes_w)
    )
    return Point(value=slopes_w[0], tuning=Tuning(name=f"{slopes_w}", meaning="", make=idle), outcomes=outcomes)


def idle(joint: Joint) -> Compensator:  # noqa: ARG001 - what every tuning takes
    return FixedCompensation(coulomb_nm=0.0, viscous_nms_per_rad=0.0)


@pytest.mark.parametrize(
    ("tried", "best", "losses"),
    [
        # Flat, but lost with one person: the steeper one that holds with all.
        ([((0.0, 0.0, 0.0), 1), ((0.1, 0.1, 0.1), 0)], 1, 0),
        # Slopes of both signs are not flat.
        ([((-0.2, 0.0, 0.2), 0), ((0.1, 0.1, 0.1), 0)], 1, 0),
        # Nothing holds with all: with most.
        ([((0.0, 0.0, 0.0), 2), ((0.3, 0.3, 0.3), 1)], 1, 1),
        # What was lost says nothing of the slope.
        ([((9.0, 0.1, 0.1), 1), ((0.2, 0.2, 0.2), 1)], 0, 1),
    ],
)
def test_best_is_what_no_tuning_person_loses(
    tried: list[tuple[tuple[float, ...], int]], best: int, losses: int
) -> None:
    points = [point(slopes_w, lost) for slopes_w, lost in tried]
    chosen = choose_best(points)
    assert chosen is points[best]
    assert chosen.losses == losses


def test_margins_are_looked_for_as_told() -> None:
    joint = short_joint()
    one = compare(replace(joint, plan=replace(joint.plan, margin_seeds=1)), SEEDS, METHODS[:1])
    assert one.margin_seeds == (0,)
    assert one.rows[0].margins == (inf,)
    none = compare(replace(joint, plan=replace(joint.plan, margin_seeds=0)), SEEDS, METHODS[:1])
    assert none.rows[0].margins == ()
    assert np.isnan(none.rows[0].margin.value)
    assert "margin:" not in table_of(none)


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
def test_a_sweep_is_shaded_and_crossed_where_the_loop_was_lost(held: str, start: list[float], at: list[float]) -> None:
    points = tuple(replace(point((0.1,), int(mark == "-")), value=float(n)) for n, mark in enumerate(held, start=1))
    whole = Curve(method="energy", label="proposed", name="a", axis="k", points=points)
    (axes,) = draw_sweeps(replace(compared(), curves=(whole,))).axes
    assert [patch.get_x() for patch in axes.patches if isinstance(patch, Rectangle)] == start
    assert sorted(float(np.asarray(one.get_xdata())[0]) for one in axes.lines if one.get_marker() == "x") == at
