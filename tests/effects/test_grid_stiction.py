"""Stiction as a candidate: what it takes to be seen, and the excess of a joint that breaks away by hand."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.samples import make_samples
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.stiction import AGEINGS_S, AT_ONCE_RAD, FEWEST_BREAKAWAYS
from friction_audit.effects.stiction import EFFECT as CANDIDATE
from tests.diagnosis.started_and_stopped import COULOMB_NM, EXCESS_NM, RISE_NM_PER_S, started_and_stopped
from tests.effects.joint_data_by_hand import baseline, two_sines

AT_ONCE = {"ageing_s": 0.01, "renewal_rad": AT_ONCE_RAD}


def test_a_joint_that_only_turns_around_is_told_to_stand_still() -> None:
    data = two_sines()
    assert "breaks away from a standstill 0 times" in str(CANDIDATE.not_identifiable(data, baseline(data)))


@pytest.mark.parametrize("starts", [FEWEST_BREAKAWAYS - 1, FEWEST_BREAKAWAYS])
def test_so_many_starts_are_enough(starts: int) -> None:
    data = started_and_stopped(starts=starts)
    lacking = CANDIDATE.not_identifiable(data, baseline(data))
    assert (lacking is None) == (starts >= FEWEST_BREAKAWAYS)


def jumping() -> JointData:
    """A joint that starts so fast that no row tells of it."""
    data = started_and_stopped()
    since = data.t % 1.0 - 0.5
    # The last 20 ms before a start take the torque up to friction: no few milliseconds say what it was.
    way = np.where(data.t % 2.0 < 1.0, 1.0, -1.0)
    jump = np.where((since > -0.02) & (since < 0.0), 40.0 * (since + 0.02), 0.0) * way
    held_by_friction = np.where(since >= 0.0, EXCESS_NM + 0.8, 0.0) * way
    assert CANDIDATE.not_identifiable(data, baseline(data)) is None
    return replace(data, torque=data.torque + jump + held_by_friction)


def test_starts_under_a_torque_that_jumps_tell_nothing_and_do_not_count() -> None:
    pushed = jumping()
    assert "0 of them under a torque that rises slowly" in str(CANDIDATE.not_identifiable(pushed, baseline(pushed)))


def test_an_excess_that_fades_over_a_path_is_looked_for_after_any_start() -> None:
    shapes = CANDIDATE.identifiable_part(jumping())
    assert len(shapes) == len(CANDIDATE.grid(jumping())) - len(AGEINGS_S)
    assert min(shape["renewal_rad"] for shape in shapes) > AT_ONCE_RAD


def test_without_starts_nothing_of_it_is_looked_for() -> None:
    assert list(CANDIDATE.identifiable_part(two_sines())) == []


def test_its_factor_is_the_excess_less_what_the_torque_rises_in_a_few_milliseconds() -> None:
    data = started_and_stopped(noise_nm=0.005, starts=40)
    rows = make_samples(data)
    column = rows.of(CANDIDATE.regressor(data, baseline(data), AT_ONCE))
    base = rows.of(np.column_stack([data.ddq, np.sign(data.dq)]))
    factors = np.linalg.lstsq(np.hstack([base, column]), rows.y, rcond=None)[0]
    assert factors[1] == pytest.approx(COULOMB_NM, abs=0.005)
    assert EXCESS_NM - 0.015 * RISE_NM_PER_S < factors[2] < EXCESS_NM + 0.005
    assert np.abs(column[rows.weight == 1.0]).max() < 0.01


def test_the_rest_must_be_long_to_be_worth_much() -> None:
    data = started_and_stopped()
    rows = make_samples(data)
    broke = rows.weight < 1.0
    half_aged = rows.of(CANDIDATE.regressor(data, baseline(data), {**AT_ONCE, "ageing_s": 0.5 / np.log(2.0)}))[broke, 0]
    assert np.abs(half_aged / rows.weight[broke]) == pytest.approx(0.5, abs=0.04)
    assert np.array_equal(np.sign(half_aged), np.sign(rows.y[broke]))
