"""Stiction: moments of break-away by hand, what it takes to be seen, and the excess of a joint that breaks away."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from friction_audit.diagnosis.samples import make_samples
from friction_audit.effects import breakaway
from friction_audit.effects.breakaway import STICTION
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from tests.effects.joint_data_by_hand import (
    COULOMB_NM,
    EXCESS_NM,
    RISE_NM_PER_S,
    baseline,
    started_and_stopped,
    two_sines,
)

AT_ONCE = {"ageing_s": 0.01, "renewal_rad": breakaway.AT_ONCE_RAD}
STEP_S = 1.0 / 400.0
T: Float = np.arange(800, dtype=np.float64) * STEP_S
DEAD = 3e-3
LEVEL, RISE, INERTIA = 0.3, 2.0, 0.5


def start(onset_s: float, direction: float = 1.0, excess: float = 0.0) -> tuple[Float, Float, Float]:
    """Position, velocity and torque of a joint that breaks away when its rising torque passes level plus excess."""
    u = np.maximum(T - onset_s, 0.0)
    jump, rate = excess / INERTIA, RISE / INERTIA
    q, dq = jump * u**2 / 2 + rate * u**3 / 6, jump * u + rate * u**2 / 2
    return direction * q, direction * dq, direction * (LEVEL + excess + RISE * (T - onset_s))


@given(onset_s=st.floats(0.3, 1.5), direction=st.sampled_from([-1.0, 1.0]))
def test_a_smooth_start_reads_the_level_of_sliding(onset_s: float, direction: float) -> None:
    q, dq, torque = start(onset_s, direction)
    found = breakaway.find_breakaways(q, dq, DEAD, STEP_S)
    assert found.direction.tolist() == [direction]
    assert T[found.onset[0]] == pytest.approx(onset_s, abs=STEP_S)
    assert found.of(torque)[0] == pytest.approx(direction * LEVEL, abs=RISE * STEP_S)
    bent = 1.0 + 3.0 * T - 7.0 * T**2  # is carried on exactly
    assert found.of(np.column_stack([bent, T])) == pytest.approx(np.column_stack([bent, T])[found.onset])
    assert found.samples[0, -1] < found.onset[0]
    assert (found.samples.shape[1] - 1) * STEP_S == pytest.approx(breakaway.STANDSTILL_S)


START = start(1.0)[:2]


@pytest.mark.parametrize(
    ("q", "dq", "starts"),
    [
        (*START, 1),
        (START[0] + 0.02 * DEAD * T, START[1], 1),
        (START[0] + 0.5 * DEAD * T, START[1], 0),
        (-np.cos(2 * np.pi * T), 2 * np.pi * np.sin(2 * np.pi * T), 0),
        (START[0] + 1e-4 * (T >= 0.9), START[1], 0),
        (START[0], np.where(START[1] < 1.5 * DEAD, START[1], 0.0), 0),
        (0.0 * T, 0.0 * T, 0),
    ],
    ids=["start", "hardly creeps", "creeps", "turns around", "count of the encoder", "twitch", "never moves"],
)
def test_what_is_a_start(q: Float, dq: Float, starts: int) -> None:
    found = breakaway.find_breakaways(q, dq, DEAD, STEP_S)
    assert found.of(np.zeros((len(q), 3))).shape == (starts, 3)


@pytest.mark.parametrize("direction", [-1.0, 1.0])
def test_the_standstill_takes_the_direction_of_the_motion_and_no_acceleration(direction: float) -> None:
    q, dq, _ = start(1.0, direction)
    noise = DEAD / 5 * np.random.default_rng(0).standard_normal(len(q))
    found = breakaway.find_breakaways(q, dq + noise, DEAD, STEP_S)
    held, ddq = breakaway.signed_rest(dq + noise, noise / STEP_S, found, DEAD)
    before = slice(found.samples[0, 0], found.certain[0])
    assert held[before] == pytest.approx(direction * DEAD)
    assert np.all(ddq[found.samples] == 0.0)
    outside = np.setdiff1d(np.arange(len(q)), np.arange(before.start, before.stop))
    assert np.array_equal(held[outside], (dq + noise)[outside])
    again = breakaway.find_breakaways(q, held, DEAD, STEP_S)
    assert np.array_equal(again.samples, found.samples)
    assert np.array_equal(again.certain, found.certain)


@pytest.mark.parametrize("direction", [-1.0, 1.0])
def test_a_start_by_a_motor_that_held_the_other_way_tells_nothing(direction: float) -> None:
    q, dq, _ = start(1.0, direction)
    torque = direction * (LEVEL + 0.5 * RISE * (T - 1.0))
    found = breakaway.find_breakaways(q, dq, DEAD, STEP_S)
    jumps = np.where(T < 1.0, -direction * LEVEL, direction * (LEVEL + 100.0 * (T - 1.0)))
    falls = np.where(T < 1.0, torque, 0.8 * torque)
    assert [breakaway.torque_known(each, found, STEP_S).tolist() for each in (torque, jumps, falls)] == [
        [True],
        [False],
        [True],
    ]


@pytest.mark.parametrize(("fall", "known"), [(0.0, False), (0.05, False), (0.3, True)])
def test_a_start_under_a_fast_torque_tells_something_where_that_falls_behind_it(fall: float, known: bool) -> None:
    q, dq, _ = start(1.0, excess=0.3)
    found = breakaway.find_breakaways(q, dq, DEAD, STEP_S)
    rising = LEVEL + 0.3 + 10.0 * (T - T[found.onset[0]])
    behind = LEVEL + 0.3 - fall
    assert breakaway.torque_known(np.where(T[found.onset[0]] < T, behind, rising), found, STEP_S).tolist() == [known]


def jumping() -> JointData:
    """A joint that starts so fast that no row tells of it."""
    data = started_and_stopped()
    since = data.t % 1.0 - 0.5
    # The last 20 ms before a start take the torque up to friction: no few milliseconds say what it was.
    way = np.where(data.t % 2.0 < 1.0, 1.0, -1.0)
    jump = np.where((since > -0.02) & (since < 0.0), 40.0 * (since + 0.02), 0.0) * way
    held_by_friction = np.where(since >= 0.0, EXCESS_NM + 0.8, 0.0) * way
    assert STICTION.not_identifiable(data, baseline(data)) is None
    return replace(data, torque=data.torque + jump + held_by_friction)


@pytest.mark.parametrize(
    ("data", "lacking"),
    [
        (two_sines(), "breaks away from a standstill 0 times"),
        (started_and_stopped(starts=breakaway.FEWEST_BREAKAWAYS - 1), f"at least {breakaway.FEWEST_BREAKAWAYS} times"),
        (started_and_stopped(starts=breakaway.FEWEST_BREAKAWAYS), "None"),
        (jumping(), "0 of them under a torque that rises slowly"),
    ],
    ids=["turns around", "too few starts", "enough", "torque that jumps"],
)
def test_so_many_starts_are_enough(data: JointData, lacking: str) -> None:
    assert lacking in str(STICTION.not_identifiable(data, baseline(data)))


def test_an_excess_that_fades_over_a_path_is_looked_for_after_any_start() -> None:
    shapes = STICTION.identifiable_part(jumping())
    assert len(shapes) == len(STICTION.grid(jumping())) - len(breakaway.AGEINGS_S)
    assert min(shape["renewal_rad"] for shape in shapes) > breakaway.AT_ONCE_RAD


def test_its_factor_is_the_excess_less_what_the_torque_rises_in_a_few_milliseconds() -> None:
    data = started_and_stopped(noise_nm=0.005, starts=40)
    rows = make_samples(data)
    column = rows.of(STICTION.regressor(data, baseline(data), AT_ONCE))
    base = rows.of(np.column_stack([data.ddq, np.sign(data.dq)]))
    factors = np.linalg.lstsq(np.hstack([base, column]), rows.y, rcond=None)[0]
    assert factors[1] == pytest.approx(COULOMB_NM, abs=0.005)
    assert EXCESS_NM - 0.015 * RISE_NM_PER_S < factors[2] < EXCESS_NM + 0.005
    assert np.abs(column[rows.weight == 1.0]).max() < 0.01
