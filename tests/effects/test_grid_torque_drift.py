"""A drift is slow beside the strokes, and beside a stretch of motion."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.nominal_model import least_squares, nominal_model
from friction_audit.diagnosis.samples import make_samples
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.torque_drift import EFFECT as CANDIDATE
from friction_audit.effects.torque_drift import SHORTEST_S
from tests.diagnosis.moved_joint import moved_joint

SHARE = np.linspace(0.0, 1.0, len(moved_joint(duration_s=60.0).t))
"""Of a recording of a minute that is over."""


def lacking(data: JointData) -> str | None:
    nominal = nominal_model(data, make_samples(data), None)
    return CANDIDATE.not_identifiable(data, nominal.baseline(least_squares(nominal.columns, nominal.y)))


def test_a_minute_of_strokes_shows_a_drift() -> None:
    assert lacking(moved_joint(duration_s=60.0)) is None


@pytest.mark.parametrize("duration_s", [12.0, SHORTEST_S - 1.0])
def test_a_short_log_shows_none(duration_s: float) -> None:
    assert "drift" in str(lacking(moved_joint(duration_s=duration_s)))


def test_a_few_long_strokes_show_none() -> None:
    data = moved_joint(duration_s=60.0)
    few = replace(data, cycle=np.where(data.cycle < 0, -1, data.cycle * 7 // (data.cycle.max() + 1)))
    assert "7 cycles" in str(lacking(few))
