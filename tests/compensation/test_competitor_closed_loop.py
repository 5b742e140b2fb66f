"""The competitors in the hand of the same person, on the same joint."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from friction_audit.compensation.compensators import (
    DisturbanceObserver,
    FixedCompensation,
    Guard,
    LugreCompensation,
    TorqueRegulation,
)
from friction_audit.compensation.compensators.model_based import PUBLISHED, fit_sigmoid
from tests.compensation.competitor_bench import COULOMB, INERTIA, VISCOUS, guided, work_j

ORACLE = FixedCompensation(coulomb_nm=COULOMB, viscous_nms_per_rad=VISCOUS)
LUGRE = LugreCompensation(coulomb_nm=COULOMB, breakaway_nm=COULOMB, viscous_nms_per_rad=VISCOUS)
OBSERVER = DisturbanceObserver(inertia_kg_m2=INERTIA, observer_gain_per_s=50.0)
REGULATION = TorqueRegulation(inertia_kg_m2=INERTIA, desired_inertia_kg_m2=0.15)


@pytest.fixture(scope="module")
def uncompensated_j() -> float:
    return work_j(guided(None))


def test_an_oracle_leaves_no_friction_and_nobody_beats_it(uncompensated_j: float) -> None:
    best = abs(work_j(guided(ORACLE)))
    assert best < 5e-3 * uncompensated_j
    for competitor in (LUGRE, OBSERVER, REGULATION, fit_sigmoid(COULOMB, VISCOUS), PUBLISHED[0]):
        assert best < abs(work_j(guided(competitor))) < uncompensated_j


@pytest.mark.parametrize("right", [ORACLE, LUGRE, fit_sigmoid(COULOMB, VISCOUS, steepness_s_per_rad=40.0)])
def test_twenty_percent_too_little_leaves_twenty_percent(right: Any, uncompensated_j: float) -> None:
    left = work_j(guided(right.scaled(0.8))) / uncompensated_j
    assert left == pytest.approx(0.2 + work_j(guided(right)) / uncompensated_j, abs=0.03)


@pytest.mark.parametrize("right", [LUGRE, fit_sigmoid(COULOMB, VISCOUS)])
def test_a_guard_takes_back_what_over_compensation_put_in(right: Any) -> None:
    over = right.scaled(1.6)
    wild, guarded = (
        guided(replace(over, guard=Guard(passivity=passivity)), duration_s=12.0) for passivity in (False, True)
    )
    assert work_j(wild) < -0.1
    # What is compensated too much, over the time in which it is paid back.
    fastest = float(np.abs(guarded.dq).max())
    assert work_j(guarded) > -0.6 * (COULOMB + VISCOUS * fastest) * fastest * Guard().payback_s
