"""A place is told only where the torque is a curve over the axis."""

import numpy as np
import pytest

from friction_audit.diagnosis.profiles import shows_along
from friction_audit.joint_log import Float

PLACE: Float = np.tile(np.linspace(0.0, 1.0, 600), 8)
DQ = np.repeat([1.0, -1.0] * 4, 600)


@pytest.mark.parametrize(
    "torque",
    [np.zeros(4800), np.full(4800, 0.1), np.sign(DQ), np.sign(DQ) * np.exp(-PLACE / 0.1), np.sin(6.0 * PLACE)],
    ids=["nothing", "an offset", "against the motion", "fading", "a wave of the place"],
)
def test_a_curve_for_each_direction_is_shown(torque: Float) -> None:
    assert shows_along(torque, PLACE, DQ)


@pytest.mark.parametrize(
    "torque",
    [np.sin(0.9 * np.arange(4800)), np.sin(400.0 * PLACE), np.repeat([1.0, 1.0, -1.0, -1.0] * 2, 600)],
    ids=["ringing", "waves finer than a stretch", "now this way, now that way"],
)
def test_what_averages_away_along_the_axis_is_not(torque: Float) -> None:
    assert not shows_along(torque, PLACE, DQ)


def test_half_of_it_beside_the_curve_is_the_border() -> None:
    ringing = np.sqrt(2.0) * np.sin(0.9 * np.arange(4800))
    assert shows_along(1.1 + ringing, PLACE, DQ)
    assert not shows_along(0.9 + ringing, PLACE, DQ)
