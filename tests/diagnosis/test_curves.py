"""Curves over every axis that varies, as wide as the cycles allow."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.axes import curve, knots_of
from friction_audit.diagnosis.curves import build_curves
from friction_audit.diagnosis.omnibus import FEW_TO_TEST
from friction_audit.diagnosis.rows import make_rows
from tests.diagnosis.moved_joint import moved_joint


def test_one_curve_per_axis_with_its_values_at_the_rows() -> None:
    data = moved_joint(duration_s=60.0)
    rows = make_rows(data)
    curves = {one.axis.name: one for one in build_curves(data, rows)}
    assert set(curves) == {"speed", "position", "displacement", "acceleration", "time"}
    assert curves["time"].values == pytest.approx(rows.t)
    assert curves["speed"].values == pytest.approx(np.abs(data.dq[:: rows.every][rows.used]))
    (columns,) = curves["position"].group.shapes
    # The curve is bent on the fine grid and low-passed like the torque, not bent at the rows.
    by_hand = rows.of(curve(data.q, knots_of(data.q, data.used), data.dq))
    assert columns == pytest.approx(by_hand)


def test_a_constant_axis_has_no_curve() -> None:
    data = replace(moved_joint(duration_s=40.0), temperature=np.full(16000, 25.0), load=np.zeros(16000))
    assert {"temperature", "load"}.isdisjoint(one.axis.name for one in build_curves(data, make_rows(data)))


@pytest.mark.parametrize("duration_s", [8.0, 40.0, 60.0])
def test_few_cycles_allow_few_columns(duration_s: float) -> None:
    data = moved_joint(duration_s=duration_s)
    rows = make_rows(data)
    widest = max(one.group.shapes[0].shape[1] for one in build_curves(data, rows))
    assert widest <= max(len(np.unique(rows.cycle)), FEW_TO_TEST) / 3
    assert (widest == 12) == (duration_s == 60.0)
