"""The proof of the sign on motion whose friction is known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from friction_audit.joint_log import Float, JointLog
from friction_audit.preprocessing.interaction import SignEvidence
from friction_audit.preprocessing.sign import coarse_log, most, prove_sign
from tests.synthetic_interaction import log_of


def strokes(seconds: float = 20.0, speed: float = 0.5, drift: float = 0.05, hz: float = 0.5) -> tuple[JointLog, Float]:
    """One joint going to and fro, never back to the same place, and its acceleration."""
    t = np.arange(0.0, seconds, 0.001)
    omega = 2 * np.pi * hz
    dq = speed * np.sin(omega * t) + drift
    q = speed / omega * (1 - np.cos(omega * t)) + drift * t
    return log_of(t, q, dq, tau_interaction=np.zeros(len(t))), speed * omega * np.cos(omega * t)


def judged(log: JointLog, torque: Float) -> SignEvidence:
    coarse = coarse_log(log)
    (found,) = prove_sign(coarse, coarse.mean(torque))
    return found


@given(
    coulomb=st.floats(0.1, 0.5),
    offset=st.floats(-3, 3),
    gravity=st.floats(-20, 20),
    inertia=st.floats(0, 3),
    seed=st.integers(0, 100),
)
def test_the_sign_is_proved_under_any_offset_gravity_and_inertia(
    coulomb: float, offset: float, gravity: float, inertia: float, seed: int
) -> None:
    log, ddq = strokes()
    noise = np.random.default_rng(seed).normal(0, 0.055, len(log.t))
    torque = coulomb * np.sign(log.dq[:, 0]) + offset + gravity * np.cos(log.q[:, 0]) + inertia * ddq + noise
    right, wrong = (judged(log, sign * torque[:, None]) for sign in (1.0, -1.0))
    assert (right.verdict, wrong.verdict) == ("rises", "falls")
    assert right.against_motion_nm == pytest.approx(coulomb, abs=0.05)


def test_torque_that_does_not_know_the_direction_is_undecided_in_most_cases() -> None:
    log, _ = strokes(60.0)
    noises = (np.random.default_rng(seed).normal(0, 1, (len(log.t), 1)) for seed in range(40))
    verdicts = [judged(log, noise).verdict for noise in noises]
    assert verdicts.count("undecided") >= 34


def test_few_strokes_prove_the_sign_of_noise_no_more_often_than_many() -> None:
    log, _ = strokes(4.0)
    noises = (np.random.default_rng(seed).normal(0, 1, (16, 1)).repeat(250, axis=0) for seed in range(100))
    assert [judged(log, noise).verdict for noise in noises].count("undecided") >= 90


@pytest.mark.parametrize(
    ("speed", "drift", "hz", "verdict"),
    [(0.003, 0.0, 0.5, "still"), (0.04, 0.0, 0.5, "rises"), (0.008, 0.0, 0.04, "rises"), (0.2, 0.6, 0.5, "undecided")],
    ids=["at rest", "slow strokes", "slow strokes of 60 mrad", "one way"],
)
def test_what_motion_proves(speed: float, drift: float, hz: float, verdict: str) -> None:
    log, _ = strokes(10.0 / hz, speed, drift, hz)
    evidence = judged(log, np.sign(log.dq))
    assert evidence.verdict == verdict
    assert verdict == "rises" or not most((evidence,), "rises")


def test_blocks_that_hold_a_hole_are_left_out() -> None:
    log, _ = strokes()
    t = log.t + np.where(log.t > 10, 100.0, 0.0)
    holed = replace(log, t=t)
    assert 0 < np.count_nonzero(~coarse_log(holed).whole) <= 3
    assert judged(holed, np.sign(log.dq)).against_motion_nm == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize("samples", [2, 3, 50])
def test_the_shortest_logs_are_still_or_undecided(samples: int) -> None:
    log, _ = strokes()
    short = log.take_window(0.0, samples * 0.001)
    assert judged(short, short.dq).verdict in ("still", "undecided")
