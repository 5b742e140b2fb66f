"""LuGre as a compensator, against its solution by hand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from friction_audit.compensation.compensators.model_based import LugreCompensation
from friction_audit.errors import UsageError
from tests.compensation.competitor_bench import TICK_S, feed

LUGRE = LugreCompensation(
    coulomb_nm=0.3,
    breakaway_nm=0.5,
    viscous_nms_per_rad=0.07,
    stribeck_rad_s=0.05,
    stiffness_nm_per_rad=300.0,
    damping_nms_per_rad=0.2,
)


def level(dq: float) -> float:
    return 0.3 + 0.2 * float(np.exp(-((dq / 0.05) ** 2)))


@pytest.mark.parametrize("speed", [-1.0, -0.05, 0.02, 0.4])
@pytest.mark.parametrize("dt", [1e-3, 2e-2])
def test_bristles_bend_exponentially_at_any_tick(speed: float, dt: float) -> None:
    ticks = 40
    torque, memory = feed(LUGRE, np.full(ticks, speed), 0.0, dt)
    bend = np.sign(speed) * level(speed) / 300 * (1 - np.exp(-300 * abs(speed) * np.arange(ticks) * dt / level(speed)))
    rate = speed - 300 * abs(speed) * bend / level(speed)
    assert memory["bristle_rad"] == pytest.approx(bend[-1], rel=1e-9)
    assert_allclose(torque, 300 * bend + 0.2 * rate + 0.07 * speed, rtol=1e-9)


def test_before_it_slides_it_is_a_spring_that_holds() -> None:
    moving, resting = np.full(100, 1e-3), np.zeros(500)
    torque, memory = feed(LUGRE, np.concatenate([moving, resting]), 0.0)
    travel = 99.5 * 1e-3 * TICK_S
    assert memory["bristle_rad"] == pytest.approx(travel, rel=0.05)
    assert_allclose(torque[-499:], 300 * memory["bristle_rad"], rtol=1e-12)


def test_it_does_not_stick_less_than_it_slides() -> None:
    with pytest.raises(UsageError, match="breakaway_nm"):
        LugreCompensation(coulomb_nm=0.3, breakaway_nm=0.2, viscous_nms_per_rad=0.0)
