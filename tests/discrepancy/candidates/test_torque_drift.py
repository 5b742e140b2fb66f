"""A drift is slow beside the strokes, and beside a stretch of motion."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.discrepancy.candidates.torque_drift import CANDIDATE, SHORTEST_S
from friction_audit.discrepancy.declared import declare, least_squares
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.rows import make_rows
from tests.discrepancy.moved_joint import moved_joint


def lacking(data: JointData) -> str | None:
    declared = declare(data, make_rows(data), None)
    return CANDIDATE.untestable(data, declared.baseline(least_squares(declared.columns, declared.y)))


def test_a_minute_of_strokes_shows_a_drift() -> None:
    assert lacking(moved_joint(duration_s=60.0)) is None


@pytest.mark.parametrize("duration_s", [12.0, SHORTEST_S - 1.0])
def test_a_short_log_shows_none(duration_s: float) -> None:
    assert "drift" in str(lacking(moved_joint(duration_s=duration_s)))


def test_a_few_long_strokes_show_none() -> None:
    data = moved_joint(duration_s=60.0)
    few = replace(data, cycle=np.where(data.cycle < 0, -1, data.cycle * 7 // (data.cycle.max() + 1)))
    assert "7 cycles" in str(lacking(few))
