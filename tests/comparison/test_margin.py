"""Stability margin: bisection, and what a gain is."""

from math import inf
from typing import Any

import pytest

from friction_audit.compensation.comparison.experiment import find_margin
from friction_audit.compensation.compensators import (
    DisturbanceObserver,
    EnergyCompensator,
    FixedCompensation,
    LugreCompensation,
    SigmoidCompensation,
    TorqueRegulation,
)


@pytest.mark.parametrize(("limit", "margin"), [(0.5, 0.0), (1.3, 1.3), (7.0, 7.0), (1000.0, inf)])
def test_limits_are_found(limit: float, margin: float) -> None:
    found = find_margin(lambda factor: factor <= limit)
    assert found == pytest.approx(margin, rel=0.05)
    assert found <= limit or found == inf


@pytest.mark.parametrize(
    ("compensator", "name", "twice"),
    [
        (FixedCompensation(coulomb_nm=0.3, viscous_nms_per_rad=0.1), "coulomb_nm", 0.6),
        (SigmoidCompensation(height_nm=0.6, steepness_s_per_rad=9.0), "height_nm", 1.2),
        (LugreCompensation(coulomb_nm=0.3, breakaway_nm=0.3, viscous_nms_per_rad=0.1), "viscous_nms_per_rad", 0.2),
        (EnergyCompensator(), "factor", 2.0),
        (DisturbanceObserver(inertia_kg_m2=0.3, observer_gain_per_s=20.0), "observer_gain_per_s", 40.0),
        (TorqueRegulation(inertia_kg_m2=0.3, desired_inertia_kg_m2=0.15), "desired_inertia_kg_m2", 0.1),
    ],
    ids=lambda value: type(value).__name__,
)
def test_twice_the_gain(compensator: Any, name: str, twice: float) -> None:
    assert getattr(compensator.scaled(2.0), name) == pytest.approx(twice)
    assert compensator.scaled(1.0) == compensator
