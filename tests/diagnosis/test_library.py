"""Candidates as columns: those that the log can show, without columns that are zero."""

import numpy as np
import pytest

from friction_audit.diagnosis.ground import make_ground
from friction_audit.diagnosis.library import build_library, plainer
from friction_audit.effects.effect import Nonlinear
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint
from tests.diagnosis.toy_candidates import BUMP, TOYS, WAVE, altered

GROUND = make_ground(moved_joint(noise_nm=0.02, duration_s=20.0), None, 0)
LIBRARY = build_library(TOYS, GROUND.data, GROUND.baseline(), GROUND.rows)


def test_what_the_log_cannot_show_is_told_and_not_tried() -> None:
    assert LIBRARY.untestable == {"locked_out": "move the moon"}
    assert [entry.candidate.name for entry in LIBRARY.entries] == ["bump", "wave", "square"]


def test_columns_are_those_of_the_candidate_through_the_filter() -> None:
    entry = LIBRARY.entry("bump")
    assert entry.shapes == BUMP.grid(GROUND.data)
    for shape, columns in zip(entry.shapes, entry.group.shapes, strict=True):
        assert columns == pytest.approx(GROUND.rows.of(BUMP.regressor(GROUND.data, GROUND.baseline(), shape)))
    assert LIBRARY.entry("wave").group.shapes[0].shape == (len(GROUND.y), 2)


def test_rules_are_those_of_the_candidate() -> None:
    rule = LIBRARY.entry("bump").group.admissible
    assert rule(np.array([0.1]), 0)
    assert not rule(np.array([-0.1]), 0)


def test_a_column_of_zeros_is_left_out_and_its_factor_is_zero_for_the_rule() -> None:
    asked: list[list[float]] = []

    def columns(data: JointData, _baseline: Nominal, _shape: Nonlinear) -> Float:
        return np.column_stack([np.zeros(len(data.t)), data.q, np.zeros(len(data.t))])

    def admissible(factors: Float, _shape: Nonlinear) -> bool:
        asked.append(factors.tolist())
        return True

    half = altered(WAVE, regressor=columns, admissible=admissible, grid=({},))
    (entry,) = build_library([half], GROUND.data, GROUND.baseline(), GROUND.rows).entries
    assert entry.group.shapes[0] == pytest.approx(GROUND.rows.of(GROUND.data.q)[:, None])
    assert entry.group.admissible(np.array([0.7]), 0)
    assert asked == [[0.0, 0.7, 0.0]]


def test_richer_shapes_are_left_out_of_one_candidate() -> None:
    rich = altered(WAVE, needs_gain=lambda shape: shape["rate"] > 0.2)
    library = build_library((rich, BUMP), GROUND.data, GROUND.baseline(), GROUND.rows)
    kept = plainer(library, "wave")
    assert kept.entry("wave").shapes == ({"rate": 0.1},)
    assert len(kept.entry("wave").group.shapes) == 1
    assert kept.entry("bump") is library.entry("bump")
