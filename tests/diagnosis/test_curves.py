"""Quantities that a residual is held against, and curves over them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.diagnosis.problem import AXES, curve, knots_of
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from friction_audit.reporting.diagnosis_words import UNITS
from tests.diagnosis.moved_joint import moved_joint

DATA = moved_joint(duration_s=10.0)


def value(name: str, data: JointData) -> Float | None:
    return next(axis for axis in AXES if axis.name == name).value(data)


def test_every_axis_has_a_unit_for_its_sentence() -> None:
    assert set(UNITS) == {axis.name for axis in AXES}


def test_what_the_log_does_not_hold_is_no_axis() -> None:
    there = {axis.name for axis in AXES if axis.value(DATA) is not None}
    assert there == {"speed", "position", "displacement", "acceleration", "time"}
    warm = replace(DATA, temperature=DATA.t, load=np.cos(DATA.q))
    assert value("temperature", warm) is warm.temperature
    assert value("load", warm) is warm.load


def test_the_neighbour_is_the_one_that_moves_most_and_never_the_joint_itself() -> None:
    others = np.column_stack([0.1 * DATA.dq, 9.0 * DATA.ddq, 2.0 * DATA.dq])
    among = replace(DATA, others_ddq=others, others_joint=1)
    assert value("neighbour", among) == pytest.approx(2.0 * DATA.dq)


@given(st.lists(st.floats(-10, 10), min_size=1, max_size=50), st.integers(2, 8))
def test_knots_ascend_from_the_smallest_to_the_largest(values: list[float], most: int) -> None:
    array = np.array(values)
    knots = knots_of(array, np.ones(len(array), bool), most)
    assert 1 <= len(knots) <= most
    assert np.all(np.diff(knots) > 0)
    assert knots[0] == array.min()


def test_knots_are_those_of_the_samples_that_count() -> None:
    values = np.arange(100.0)
    assert knots_of(values, values < 11, 3) == pytest.approx([0.0, 5.0, 10.0])
    assert len(knots_of(values, np.zeros(100, bool))) == 0
    assert len(knots_of(np.ones(100), np.ones(100, bool))) == 1


def test_a_curve_is_a_line_between_its_knots_for_each_direction() -> None:
    values, dq = np.array([0.0, 0.5, 2.0, 2.5]), np.array([1.0, 1.0, -1.0, -1.0])
    by_hand = [[1, 0, 0, 0, 0, 0], [0.5, 0.5, 0, 0, 0, 0], [0, 0, 0, 0, 0.5, 0.5], [0, 0, 0, 0, 0.25, 0.75]]
    assert curve(values, np.array([0.0, 1.0, 3.0]), dq) == pytest.approx(np.array(by_hand))


@given(st.integers(2, 6), st.integers(0, 1000))
def test_hats_of_a_curve_add_up_to_the_direction(most: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    values, dq = rng.standard_normal((2, 200))
    columns = curve(values, knots_of(values, np.ones(200, bool), most), dq)
    assert columns[:, : columns.shape[1] // 2].sum(axis=1) == pytest.approx((dq > 0).astype(float))
    assert columns.sum(axis=1) == pytest.approx(1.0)
