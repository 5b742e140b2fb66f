"""The proof of the sign on motion whose friction is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.joint_log import Float, JointLog, Source
from friction_audit.preprocessing.sign import coarse_log, most, prove_sign


def strokes(seconds: float = 20.0, speed: float = 0.5, drift: float = 0.05) -> tuple[JointLog, Float]:
    """One joint going to and fro, never back to the same place, and its acceleration."""
    t = np.arange(0.0, seconds, 0.001)
    omega = 2 * np.pi * 0.5
    dq = speed * np.sin(omega * t) + drift
    q = speed / omega * (1 - np.cos(omega * t)) + drift * t
    log = JointLog(
        t=t,
        q=q[:, None],
        dq=dq[:, None],
        tau_interaction=np.zeros((len(t), 1)),
        joint_names=("joint1",),
        source=Source(path="made", sha256="", format="made"),
    )
    return log, speed * omega * np.cos(omega * t)


@given(
    coulomb=st.floats(0.1, 0.5),
    offset=st.floats(-3, 3),
    gravity=st.floats(-20, 20),
    inertia=st.floats(0, 3),
    seed=st.integers(0, 100),
)
def test_the_sign_is_proved_whatever_offset_gravity_and_inertia_hide_it(
    coulomb: float, offset: float, gravity: float, inertia: float, seed: int
) -> None:
    log, ddq = strokes()
    noise = np.random.default_rng(seed).normal(0, 0.055, len(log.t))
    torque = coulomb * np.sign(log.dq[:, 0]) + offset + gravity * np.cos(log.q[:, 0]) + inertia * ddq + noise
    coarse = coarse_log(log)
    (right,) = prove_sign(coarse, coarse.mean(torque[:, None]))
    (wrong,) = prove_sign(coarse, coarse.mean(-torque[:, None]))
    assert (right.verdict, wrong.verdict) == ("rises", "falls")
    assert right.against_motion_nm == pytest.approx(coulomb, abs=0.05)


def test_torque_that_does_not_know_the_direction_is_undecided_in_most_cases() -> None:
    log, _ = strokes(60.0)
    coarse = coarse_log(log)
    verdicts = []
    for seed in range(40):
        noise = np.random.default_rng(seed).normal(0, 1, (len(log.t), 1))
        verdicts.append(prove_sign(coarse, coarse.mean(noise))[0].verdict)
    assert verdicts.count("undecided") >= 34


def test_a_joint_at_rest_is_still() -> None:
    log, _ = strokes(speed=0.003, drift=0.0)
    coarse = coarse_log(log)
    (evidence,) = prove_sign(coarse, coarse.mean(log.dq))
    assert evidence.verdict == "still"
    assert not most((evidence,), "rises")


def test_slow_strokes_count_as_motion() -> None:
    log, _ = strokes(speed=0.04, drift=0.0)
    coarse = coarse_log(log)
    assert prove_sign(coarse, coarse.mean(0.3 * np.sign(log.dq)))[0].verdict == "rises"


def test_one_way_motion_proves_nothing() -> None:
    log, _ = strokes(speed=0.2, drift=0.6)
    coarse = coarse_log(log)
    assert prove_sign(coarse, coarse.mean(np.sign(log.dq)))[0].verdict == "undecided"


def test_blocks_that_hold_a_hole_are_left_out() -> None:
    log, _ = strokes()
    t = log.t + np.where(log.t > 10, 100.0, 0.0)
    holed = JointLog(
        t=t, q=log.q, dq=log.dq, tau_interaction=log.tau_interaction, joint_names=("a",), source=log.source
    )
    coarse = coarse_log(holed)
    assert 0 < np.count_nonzero(~coarse.whole) <= 3
    assert prove_sign(coarse, coarse.mean(np.sign(log.dq)))[0].against_motion_nm == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize("samples", [2, 3, 50])
def test_the_shortest_logs_are_still_or_undecided(samples: int) -> None:
    log, _ = strokes()
    short = log.take_window(0.0, samples * 0.001)
    coarse = coarse_log(short)
    assert prove_sign(coarse, coarse.mean(short.dq))[0].verdict in ("still", "undecided")
