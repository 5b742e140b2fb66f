"""The comparison of methods: intervals, margins, tunings, trials, and the whole, short."""

from dataclasses import astuple, replace
from functools import cache
from math import inf, nan
from typing import Any

import numpy as np
import pytest

from friction_audit.cli.compare import FIGURES
from friction_audit.compensation.comparison import result
from friction_audit.compensation.comparison.experiment import choose_best, compare, find_margin
from friction_audit.compensation.comparison.methods import BEST, IDLE, METHODS, SETUPS, Method, Setup, Tuning
from friction_audit.compensation.comparison.result import Comparison
from friction_audit.compensation.competitors import Compensator
from friction_audit.reporting.compare import compare_lines
from friction_audit.reporting.figures.comparison import draw_comparison as draw
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.scenarios import simulate
from friction_audit.simulation.settings import IDEAL_SENSORS

# A short comparison, made once.

SEEDS = 2
CHOSEN = ("none", "disturbance_observer", "torque_regulation", "energy", "oracle")


def short_joint(duration_s: float = 15.0) -> Setup:
    joint = SETUPS[0]
    few: dict[str, Any] = {"tuning_seeds": 1, "most_values": 5, "sweeps": 1, "margin_seeds": 1, "margin_share": 0.7}
    return replace(joint, settings=replace(joint.settings, duration_s=duration_s), **few)


@cache
def compared() -> Comparison:
    return compare(short_joint(), SEEDS, [method for method in METHODS if method.name in CHOSEN])


# Means, medians and their intervals. Student's t with 3 degrees of freedom: 3.182; standard deviation 1.291, over the
# root of 4. Tables of the binomial distribution: of 20 values the 6th and the 15th, of 6 the first and the last.

HALF = 3.182446 * np.std([1, 2, 3, 4], ddof=1) / 2


@pytest.mark.parametrize(
    ("interval", "values", "expected"),
    [
        (result.mean_interval, [1.0, 2.0, 3.0, 4.0], (2.5, 2.5 - HALF, 2.5 + HALF)),
        (result.mean_interval, [1.0, nan, 1.0], (1.0, 1.0, 1.0)),
        (result.mean_interval, [nan], (nan, nan, nan)),
        (result.mean_interval, [2.0], (2.0, nan, nan)),
        (result.median_interval, list(range(1, 21)), (10, 6, 15)),
        (result.median_interval, [6, 5, 4, 3, 2, 1], (3, 1, 6)),
        (result.median_interval, [2.0, 1.0, inf, inf, inf, inf, inf], (inf, 1.0, inf)),
        (result.median_interval, [], (nan, nan, nan)),
    ],
)
def test_means_and_medians_by_hand(interval: Any, values: list[float], expected: tuple[float, float, float]) -> None:
    assert astuple(interval(values)) == pytest.approx(expected, rel=1e-6, nan_ok=True)


# Stability margin: bisection.


@pytest.mark.parametrize(("limit", "margin"), [(0.5, 0.0), (1.3, 1.3), (7.0, 7.0), (1000.0, inf)])
def test_limits_are_found(limit: float, margin: float) -> None:
    found = find_margin(lambda factor: factor <= limit)
    assert found == pytest.approx(margin, rel=0.05)
    assert found <= limit or found == inf


# What holds for every method.

EACH = pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)


def tunings(method: Method) -> list[Tuning]:
    own = [method.paper] if method.full is None else [method.paper, method.full]
    return [*own, *method.others, *(sweep.at(value) for sweep in method.sweeps for value in sweep.values)]


@EACH
def test_every_tuning_makes_a_compensator_for_every_joint(method: Method) -> None:
    for tuning in tunings(method):
        made = SETUPS[1].compensated(tuning, 2.0).compensator
        assert isinstance(made, tuple)
        assert len(made) == len(SETUPS[1].settings.joints)
        assert all(isinstance(one, Compensator) for one in made)
        assert tuning.name
        assert tuning.meaning


# Measures of a trial, by hand where a hand can.


def test_without_compensation_a_person_feels_the_joint() -> None:
    rigid: Any = replace(short_joint().settings, hidden=(Hidden(),), sensors=(IDEAL_SENSORS,), compensator=IDLE)
    alone = simulate(rigid, 0)
    outcome = result.measure(alone, result.find_reference(alone))
    assert outcome.lost_s == np.inf
    assert (outcome.coulomb_left, outcome.viscous_left, outcome.inertia_left) == pytest.approx((1, 1, 1), abs=1e-3)
    assert outcome.standstill_rad_s == 0.0
    motion, ends = alone.truth.motion, result.find_reference(alone).ends
    per_cycle = (motion.dissipated_j[ends[-1], 0] - motion.dissipated_j[ends[1], 0]) / (
        motion.t[ends[-1]] - motion.t[ends[1]]
    )
    assert outcome.energy_slope_w == pytest.approx(per_cycle, rel=0.1)


def test_a_competitor_that_is_unstable_is_caught_and_drawn_up_to_there() -> None:
    setup = short_joint()
    (method,) = (one for one in METHODS if one.name == "torque_regulation")
    wild: Tuning = method.sweeps[0].at(40.0)
    reference = result.find_reference(simulate(setup.compensated(METHODS[0].paper), 0))
    simulation = simulate(setup.compensated(wild), 0)
    outcome, course = result.measure(simulation, reference), result.make_course(simulation, reference)
    assert 0.0 < outcome.lost_s < setup.settings.duration_s
    assert outcome.lost_s == course.t[-1]
    assert len(course.t) == len(course.dq) == len(course.interaction_nm) == len(course.energy_j)


# The whole comparison, short.


def test_every_method_has_its_rows_in_order() -> None:
    rows = compared().rows
    assert list(dict.fromkeys(row.method for row in rows)) == list(CHOSEN)
    for name in CHOSEN:
        roles = [row.role for row in rows if row.method == name]
        assert roles[0] == "paper"
        assert roles.count("best") == (0 if name in ("none", "oracle") else 1)
    assert all(len(row.outcomes) == SEEDS for row in rows)


def test_what_was_found() -> None:
    slopes = {row.method: row.interval("energy_slope_w").value for row in compared().rows if row.role == "paper"}
    assert slopes["none"] > 0.1
    assert slopes["none"] > slopes["disturbance_observer"] > slopes["torque_regulation"] > abs(slopes["energy"])
    assert slopes["torque_regulation"] > abs(slopes["oracle"])
    full = compared().row("disturbance_observer", "full")
    assert full is not None
    assert abs(full.interval("energy_slope_w").value) < 0.1 * slopes["none"]


def test_a_method_without_stable_tuning_is_reported_and_named() -> None:
    (method,) = (one for one in METHODS if one.name == "torque_regulation")
    hopeless = replace(method, sweeps=(method.sweeps[0]._replace(values=(40.0, 80.0)),))
    comparison = compare(short_joint(), SEEDS, [METHODS[0], hopeless])
    best = comparison.row("torque_regulation", BEST)
    assert best is not None
    assert best.tuning_losses == len(comparison.tuning_seeds)
    assert best.stable_share == 0.0
    assert best.margins == (0.0,)
    lines = compare_lines(comparison.rows, len(comparison.seeds), len(comparison.tuning_seeds))
    assert any("no setting tried is stable" in str(line) for line in lines)
    assert tuple(draw(comparison)) == FIGURES
    # Two settings of a method are two quantities, each on an axis of its own.
    (curve, *_) = comparison.curves
    both = replace(comparison, curves=(curve, replace(curve, axis="observer gain [1/s]")))
    assert [axes.get_xlabel() for axes in draw(both)["sweep"].axes] == [curve.axis, "observer gain [1/s]"]


# Slopes of the persons and losses of two points, and which is chosen: the first is flat but lost with one person, then
# of both signs, or lost with more; what was lost says nothing of the slope.
@pytest.mark.parametrize(
    ("tried", "best"),
    [
        ([((0.0, 0.0, 0.0), 1), ((0.1, 0.1, 0.1), 0)], 1),
        ([((-0.2, 0.0, 0.2), 0), ((0.1, 0.1, 0.1), 0)], 1),
        ([((0.0, 0.0, 0.0), 2), ((0.3, 0.3, 0.3), 1)], 1),
        ([((9.0, 0.1, 0.1), 1), ((0.2, 0.2, 0.2), 1)], 0),
    ],
)
def test_best_is_what_no_tuning_person_loses(tried: list[tuple[tuple[float, ...], int]], best: int) -> None:
    some, points = compared().rows[0].outcomes[0], []
    for slopes, losses in tried:
        outcomes = (replace(some, lost_s=inf if n >= losses else 1.0, energy_slope_w=w) for n, w in enumerate(slopes))
        points.append(result.Point(value=0.0, tuning=METHODS[0].paper, outcomes=tuple(outcomes)))
    assert choose_best(points) is points[best]
    assert len(points[best].lost_s) == tried[best][1]
