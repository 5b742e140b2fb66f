"""Bristles by hand, and what holds for any of them: no rate, no energy from nothing, a memory of reversals."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.terms.presliding import TERM, bristle
from friction_audit.joint_log import Float

EXPONENTS = (0.0, 0.3, 0.5, 0.8, 1.0, 1.5, 2.5)
paths = st.lists(st.floats(-0.1, 0.1), min_size=2, max_size=30).map(lambda steps: np.cumsum([0.0, *steps]))
exponents = st.sampled_from(EXPONENTS)


def along(q: Float, step_s: float = 0.01) -> Motion:
    t: Float = np.arange(len(q), dtype=np.float64) * step_s
    dq = np.gradient(q, t)
    return Motion(t=t, q=q, dq=dq, ddq=np.gradient(dq, t))


def test_one_stop_by_hand() -> None:
    q = np.array([0.0, 0.1, 0.3, 0.2, 0.0, -0.1])
    assert_allclose(bristle(q, 0.2, 0.0), [0.0, 0.5, 1.0, 0.5, -0.5, -1.0], atol=1e-15)


def test_dahl_by_hand_from_rest_and_after_a_reversal() -> None:
    x = np.linspace(0.0, 3.0, 31)
    assert_allclose(bristle(x, 1.0, 1.0), 1.0 - np.exp(-x), atol=1e-14)
    there_and_back = np.concatenate([x * 20.0, 60.0 - x])
    assert_allclose(bristle(there_and_back, 1.0, 1.0)[31:], 2.0 * np.exp(-x) - 1.0, atol=1e-14)


def test_a_slow_one_by_hand() -> None:
    x = np.linspace(0.0, 3.0, 31)  # dm/dx = -m^2 with m(0) = 1
    assert_allclose(bristle(x, 1.0, 2.0), 1.0 - 1.0 / (1.0 + x), atol=1e-14)


def test_stops_of_an_exponent_of_all_but_one_are_finite() -> None:
    x = np.linspace(0.0, 3.0, 31)
    assert_allclose(bristle(x, 1.0, np.nextafter(1.0, 0.0)), bristle(x, 1.0, 1.0 - 1e-9), atol=1e-6)


@pytest.mark.parametrize("exponent", [0.2, 0.5, 0.8])
def test_stops_in_parallel_have_the_curve_of_their_exponent(exponent: float) -> None:
    bend, x = 1.0 - exponent, np.linspace(0.0, 8.0, 801)
    missing = np.maximum(2.0**bend - bend * x, 0.0) ** (1.0 / bend)
    q = np.concatenate([np.linspace(0.0, 30.0, 300), 30.0 - x])
    assert_allclose(-bristle(q, 1.0, exponent)[300:], 1.0 - missing, atol=0.01)


@given(paths, exponents)
def test_never_beyond_the_level(q: Float, exponent: float) -> None:
    assert np.all(np.abs(bristle(q, 0.01, exponent)) <= 1.0 + 1e-12)


@given(paths, exponents)
def test_how_fast_a_path_is_gone_changes_nothing(q: Float, exponent: float) -> None:
    finer = np.interp(np.arange(0, len(q) - 0.9, 0.25), np.arange(len(q)), q)
    assert_allclose(bristle(finer, 0.02, exponent)[::4], bristle(q, 0.02, exponent), atol=1e-9)


@given(paths, exponents)
def test_a_closed_path_gone_again_and_again_takes_energy(q: Float, exponent: float) -> None:
    finer = np.interp(np.arange(0, len(q) - 0.99, 0.01), np.arange(len(q)), q)
    loop = np.concatenate([finer, finer[::-1]])
    z, dq = bristle(np.tile(loop, 3), 0.02, exponent), np.diff(np.tile(loop, 3))
    work = 0.5 * (z[1:] + z[:-1]) * dq
    assert work[2 * len(loop) :].sum() >= -1e-3 * np.abs(dq).sum()


def test_stops_remember_the_reversal_that_a_small_loop_interrupted() -> None:
    q = np.concatenate([np.linspace(0, 1, 50), np.linspace(1, 0.7, 30), np.linspace(0.7, 0.8, 30), [0.7, 0.6]])
    straight = np.concatenate([np.linspace(0, 1, 50), np.linspace(1, 0.7, 30), [0.6]])
    assert bristle(q, 0.5, 0.5)[-1] == pytest.approx(bristle(straight, 0.5, 0.5)[-1], abs=1e-12)


def test_damping_is_a_time_times_the_rate() -> None:
    motion = along(0.05 * np.sin(np.linspace(0.0, 12.0, 600)))
    without, with_damping = (TERM.regressor(motion, (0.01, 1.0, damping))[:, 0] for damping in (0.0, 0.02))
    rate = np.gradient(bristle(motion.q, 0.01, 1.0), motion.t)
    assert_allclose(with_damping - without, 0.02 * rate, atol=1e-12)


def test_far_from_a_reversal_and_with_zero_strength_nothing_is_left() -> None:
    motion = along(np.linspace(0.0, 1.0, 200))
    assert_allclose(TERM.regressor(motion, (1e-3, 0.5, 0.0))[20:], 0.0, atol=1e-12)
    assert_array_equal(TERM.torque((0.0, 1e-3, 0.5, 0.0), motion), 0.0)
