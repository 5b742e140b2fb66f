"""Torque feedback: what it makes of friction and inertia, and where it runs away."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from numpy.testing import assert_allclose

from friction_audit.compensation.compensators.feedback import TorqueRegulation
from friction_audit.compensation.compensators.law import Guard
from friction_audit.simulation import JointParameters
from tests.compensation.competitor_bench import COULOMB, INERTIA, TICK_S, VISCOUS, feed, guided, runs_away, work_j
from tests.compensation.stability import regulation_limit

HALVED = TorqueRegulation(inertia_kg_m2=INERTIA, desired_inertia_kg_m2=INERTIA / 2)


def test_the_torque_is_proportional_to_what_is_measured() -> None:
    torque = np.array([0.0, 1.0, -0.4, 3.0])
    assert_allclose(feed(HALVED, 0.3, torque)[0], torque)
    assert_allclose(feed(replace(HALVED, desired_inertia_kg_m2=0.1), 0.3, torque)[0], 2 * torque)
    assert_allclose(feed(replace(HALVED, desired_inertia_kg_m2=0.6), 0.3, torque)[0], -torque / 2)


def test_the_filter_is_a_first_order_low_pass() -> None:
    filtered = replace(HALVED, cutoff_hz=20.0)
    torque, _ = feed(filtered, 0.0, np.concatenate([[0.0], np.ones(50)]))
    assert_allclose(torque, -np.expm1(-2 * np.pi * 20.0 * np.arange(51) * TICK_S), atol=1e-12)


@pytest.mark.parametrize("desired", [0.24, 0.15, 0.12, 0.6])
def test_friction_shrinks_like_the_inertia(desired: float) -> None:
    shaped = guided(replace(HALVED, desired_inertia_kg_m2=desired))
    assert work_j(shaped) / work_j(guided(None)) == pytest.approx(desired / INERTIA, rel=0.02)


@pytest.mark.parametrize("cutoff_hz", [inf, 100.0, 30.0])
@pytest.mark.parametrize(("inertia", "hand"), [(0.3, 0.3), (0.2, 0.6)])
def test_the_loop_runs_away_just_below_the_limit(inertia: float, hand: float, cutoff_hz: float) -> None:
    settings = TorqueRegulation(inertia_kg_m2=inertia, desired_inertia_kg_m2=inertia, cutoff_hz=cutoff_hz)
    limit = regulation_limit(settings, inertia_kg_m2=inertia, outer_inertia_kg_m2=hand, period_s=TICK_S)
    joint = JointParameters(inertia_kg_m2=inertia, coulomb_nm=COULOMB, viscous_nms_per_rad=VISCOUS)
    stable, unstable = (
        guided(replace(settings, desired_inertia_kg_m2=share * limit), joint=joint, hand=hand, duration_s=4.0)
        for share in (1.05, 0.95)
    )
    assert not runs_away(stable)
    assert runs_away(unstable)


def test_an_unstable_loop_ends_silent() -> None:
    motion = guided(replace(HALVED, desired_inertia_kg_m2=0.05), duration_s=4.0)
    loud = np.flatnonzero(motion.compensation_nm[:, 0])
    assert np.all(np.isfinite(motion.dq))
    assert loud[-1] < 3000
    assert np.abs(motion.dq[-500:]).max() < 10.0


def test_limits_do_not_hide_an_unstable_loop() -> None:
    held = replace(HALVED, desired_inertia_kg_m2=0.05, guard=Guard(max_torque_nm=5.0))
    motion = guided(held, duration_s=4.0)
    assert np.abs(motion.compensation_nm).max() <= 5.0
    assert np.all(motion.compensation_nm[-2000:] == 0.0)
