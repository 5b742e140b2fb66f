"""Crosstalk by hand."""

import numpy as np
import pytest

from friction_audit.effects.terms.torque_crosstalk import TERM
from tests.effects.arm_motion import N, among_three
from tests.effects.motion_by_hand import motion_of

BEFORE, AFTER = np.arange(N), 20.0 + np.arange(N)


@pytest.mark.parametrize(
    ("side", "expected"), [(-1, (1.0, 0.0)), (1, (0.0, 1.0)), (0, (1.0, 1.0))], ids=["before", "after", "both"]
)
def test_it_reads_the_sensors_that_are_meant(side: int, expected: tuple[float, float]) -> None:
    columns = TERM.regressor(among_three(), (side,))
    assert columns == pytest.approx(np.column_stack([expected[0] * BEFORE, expected[1] * AFTER]))


def test_the_first_and_the_last_joint_have_one_neighbour() -> None:
    assert not TERM.regressor(among_three(joint=0), (0,))[:, 0].any()
    assert not TERM.regressor(among_three(joint=2), (0,))[:, 1].any()


def test_its_own_sensor_does_not_matter() -> None:
    motion = among_three()
    before = TERM.regressor(motion, (0,))
    assert motion.others is not None
    motion.others.sensed[:, 1] = 99.0
    assert np.array_equal(TERM.regressor(motion, (0,)), before)


def test_a_single_joint_has_none() -> None:
    assert not TERM.regressor(motion_of(dq=[1.0, -1.0]), (0,)).any()
