"""Stability margin: bisection, and what a gain is."""

from collections.abc import Sequence
from math import inf

import pytest

from friction_audit.compensation.comparison.experiment import LARGEST, amplify, find_margins
from friction_audit.compensation.compensators import (
    Compensator,
    DisturbanceObserver,
    EnergyCompensator,
    FixedCompensation,
    JointModelCompensation,
    LugreCompensation,
    SigmoidCompensation,
    TorqueRegulation,
)
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.errors import UsageError

LIMITS = (0.5, 1.3, 7.0, 1000.0)


def test_limits_are_found_side_by_side() -> None:
    def hold(asked: Sequence[tuple[int, float]]) -> list[bool]:
        return [factor <= LIMITS[number] for number, factor in asked]

    margins = find_margins(len(LIMITS), hold)
    assert margins[0] == 0.0
    assert margins[1:3] == pytest.approx([1.3, 7.0], rel=0.05)
    assert margins[1] <= LIMITS[1]
    assert margins[2] <= LIMITS[2]
    assert margins[3] == inf
    assert LARGEST == 32.0


def test_nothing_to_search_for() -> None:
    assert find_margins(0, lambda _: []) == []


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
def test_twice_the_gain(compensator: Compensator, name: str, twice: float) -> None:
    assert getattr(amplify(compensator, 2.0), name) == pytest.approx(twice)
    assert amplify(compensator, 1.0) == compensator


def test_the_terms_of_a_model_file_have_no_gain() -> None:
    terms = (FittedTerm("coulomb", (0.3,)),)
    with pytest.raises(UsageError, match="have no gain"):
        amplify(JointModelCompensation(terms=terms), 2.0)
