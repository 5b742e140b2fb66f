"""A drift is slow beside the strokes, and beside a stretch of motion."""

from dataclasses import replace

import numpy as np
import pytest
from friction_audit.diagnosis.cross_products import cross_products
from friction_audit.diagnosis.library import build_library
from friction_audit.diagnosis.search import search

from friction_audit.diagnosis.nominal_model import least_squares, nominal_model
from friction_audit.diagnosis.rows import make_rows
from friction_audit.effects import torque_bias
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.torque_drift import EFFECT as CANDIDATE
from friction_audit.effects.torque_drift import SHORTEST_S
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint

SHARE = np.linspace(0.0, 1.0, len(moved_joint(duration_s=60.0).t))
"""Of a recording of a minute that is over."""


def lacking(data: JointData) -> str | None:
    declared = nominal_model(data, make_rows(data), None)
    return CANDIDATE.not_identifiable(data, declared.baseline(least_squares(declared.columns, declared.y)))


def test_a_minute_of_strokes_shows_a_drift() -> None:
    assert lacking(moved_joint(duration_s=60.0)) is None


@pytest.mark.parametrize("duration_s", [12.0, SHORTEST_S - 1.0])
def test_a_short_log_shows_none(duration_s: float) -> None:
    assert "drift" in str(lacking(moved_joint(duration_s=duration_s)))


def test_a_few_long_strokes_show_none() -> None:
    data = moved_joint(duration_s=60.0)
    few = replace(data, cycle=np.where(data.cycle < 0, -1, data.cycle * 7 // (data.cycle.max() + 1)))
    assert "7 cycles" in str(lacking(few))


def taken(torque: Float, n_eff: float = 500.0) -> dict[str, int]:
    """Names that a search takes of a torque over the time with white noise, with the number of their factors."""
    data = moved_joint(duration_s=60.0)
    rows = make_rows(data)
    declared = nominal_model(data, rows, None)
    baseline = declared.baseline(least_squares(declared.columns, declared.y))
    library = build_library([CANDIDATE, torque_bias.EFFECT], data, baseline, rows)
    y = rows.of(torque) + np.random.default_rng(0).standard_normal(len(rows.t))
    found = search(cross_products(y, declared.columns, [entry.group for entry in library.entries]), n_eff)
    return {chosen.name: len(chosen.factors) for chosen in found.chosen}


@pytest.mark.parametrize("waves", [1, 2, 3, 4])
def test_a_drift_takes_as_many_waves_as_it_has(waves: int) -> None:
    assert taken(np.sin((waves - 0.5) * np.pi * SHARE)) == {"torque_drift": waves}


def test_an_offset_beside_a_ramp_is_no_wave() -> None:
    # Four waves hold 95 % of an offset: if they could not be fewer they would take it with them.
    assert taken(0.6 + SHARE) == {"torque_bias": 1, "torque_drift": 1}
