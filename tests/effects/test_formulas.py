"""Columns of every effect against numbers by hand, one line of a table each, and properties."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.dynamics.motion import Motion, Others, RigidBody
from friction_audit.effects.instant import bend
from friction_audit.effects.load import SEVERAL, TILT
from friction_audit.effects.neighbours import AFTER, ALL, BEFORE, BOTH, JOINTS, MODEL, TIP
from friction_audit.effects.presliding import bristle
from friction_audit.effects.registry import term_of
from friction_audit.joint_log import Float
from friction_audit.preprocessing.even_grid import first_order

N = 5
DQ: Float = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])


def motion_of(**signals: Sequence[float] | Float) -> Motion:
    """A motion of which only some signals are told; a second between samples, all else at rest at zero."""
    told: dict[str, Any] = {name: np.asarray(values, dtype=np.float64) for name, values in signals.items()}
    n = len(next(iter(told.values())))
    rest = dict.fromkeys(("q", "dq", "ddq"), np.zeros(n)) | {"t": np.arange(n, dtype=np.float64)}
    return Motion(**(rest | told))


def among_three(*, joint: int = 1, rigid: RigidBody | None = None) -> Motion:
    """Joint 1 of 0 to 2; the sensors read 10 k + sample, accelerations are k + 1, speeds 2 (k + 1)."""
    numbers = np.arange(3.0)
    others = Others(
        joint=joint,
        q=np.zeros((N, 3)),
        dq=np.tile(2.0 * (numbers + 1.0), (N, 1)),
        ddq=np.tile(numbers + 1.0, (N, 1)),
        sensed=10.0 * numbers + np.arange(N)[:, None],
    )
    t: Float = np.arange(N, dtype=np.float64) * 0.01
    return Motion(t=t, q=0.3 * DQ, dq=DQ, ddq=3.0 * DQ, others=others, rigid=rigid)


def rigid_body() -> RigidBody:
    """Link 2 is the joint's own, link 3 the last; every column a different constant."""
    weight = np.tile(np.arange(1.0, 9.0).reshape(2, 4), (N, 1, 1))
    return RigidBody(
        t=np.arange(N, dtype=np.float64) * 0.01,
        links=(2, 3),
        weight=weight,
        tilt=np.tile([20.0, 21.0], (N, 1)),
        inertial=np.full(N, 30.0),
        tip=np.tile(np.arange(40.0, 50.0), (N, 1)),
    )


E1, SIGN, TURN = np.exp(-1.0), np.sign(DQ), 2.0 * np.pi / 100.0
SPEEDS = np.array([-2.0, -0.5, 0.0, 0.5, 1.0, 2.0])
ARM, PANDA = among_three(), among_three(rigid=rigid_body())
# Transmitted: -5, 3, 4, -3, 3 N m; the joint moves backwards twice, rests, moves forwards twice.
LOADED = replace(ARM, load=np.array([-4.0, 4.0, 4.0, -4.0, 2.0]), rest=np.array([-1.0, -1.0, 0.0, 1.0, 1.0]))
T = np.arange(0.0, 10.0, 0.0025)


def name_of(value: object) -> str:
    return value if isinstance(value, str) else ""


def columns(name: str, motion: Motion, *values: float) -> Float:
    return term_of(name).columns(motion, values)


def torque(name: str, motion: Motion, *values: float) -> Float:
    return term_of(name).torque(motion, values)


# Effect, motion, nonlinear parameters, columns.
COLUMNS: list[tuple[str, Motion, Sequence[float], object]] = [
    ("stribeck", motion_of(dq=[-0.05, 0, 0.05, 0.1]), (0.05, 1.0), [[-E1], [0], [E1], [E1**2]]),
    ("stribeck", motion_of(dq=[0.1, 1e-12]), (0.05, 2.0), [[E1**4], [1.0]]),
    ("nonlinear_viscous", motion_of(dq=SPEEDS), (2.0, 1e-6, 0.0), (SPEEDS * abs(SPEEDS))[:, None]),
    ("nonlinear_viscous", motion_of(dq=SPEEDS), (0.5, 1e-6, 0.0), (np.sign(SPEEDS) * abs(SPEEDS) ** 0.5)[:, None]),
    ("nonlinear_viscous", motion_of(dq=SPEEDS), (0.0, 1e3, 0.0), SPEEDS[:, None]),
    ("nonlinear_viscous", motion_of(dq=SPEEDS), (0.0, 1e-6, 1.5), np.sign(SPEEDS)[:, None]),
    ("nonlinear_viscous", motion_of(dq=[0.75]), (0.0, 1.0, 0.0), [[0.6 * np.sqrt(2.0)]]),
    ("asymmetric_coulomb", ARM, (), abs(SIGN)[:, None]),
    ("asymmetric_viscous", ARM, (), abs(DQ)[:, None]),
    ("torque_bias", ARM, (), np.ones((N, 1))),
    ("inertia_error", ARM, (), 3.0 * DQ[:, None]),
    ("cable_spring", motion_of(q=[0.3, 0.5, 0.8, -0.2, -0.7]), (0.25, 0.25),
     [[0, 0, 1], [0, 0, 1], [0.3, 0.027, 1], [-0.2, -0.008, 1], [-0.7, -0.343, 1]]),
    ("joint_limit_stop", motion_of(q=[0.0, 1.0, 1.1, 1.2, -0.6], dq=[1.0, 1.0, 2.0, -1.0, -3.0]), (1.0, -0.5, 2.0),
     [[0, 0, 0, 0], [0, 0, 0, 0], [1, 0, 2, 2], [4, 0, -1, -4], [0, -1, -3, -3]]),
    ("friction_step", motion_of(t=[0.0, 1.0, 2.0, 3.0], dq=[2.0, 2.0, -2.0, 0.5]), (2.0, 0.0),
     [[0, 0], [0, 0], [-1, -2], [1, 0.5]]),
    ("friction_step", motion_of(t=[0.0, 3.0, 4.0, 5.0, 9.0], dq=np.ones(5)), (4.0, 4.0),
     np.array([[0, 0.25, 0.5, 0.75, 1.0]] * 2).T),
    ("position_dependent_friction", motion_of(q=[0.1, 0.1, 0.1, 0.1 + np.pi / 6], dq=[2.0, -0.1, 0.0, 1.0]),
     (3.0, 0.1, 1e6), [[1, 0], [-1, 0], [0, 0], [0, 1]]),
    ("position_dependent_friction", motion_of(q=[0.5, 0.7, 0.3, 2.5], dq=[1.0, 1.0, -1.0, 1.0]), (0.0, 0.5, 0.2),
     [[1, 0], [E1**0.5, 0], [-(E1**0.5), 0], [0, 0]]),
    ("torque_ripple", motion_of(q=[0.0, TURN / 4, TURN / 2, TURN, 7 * TURN], dq=[1.0, -1.0, 0.0, -2.0, 3.0]),
     (100.0,), [[1, 0], [0, 1], [-1, 0], [1, 0], [1, 0]]),
    ("torque_drift", motion_of(t=[100.0, 160.0, 220.0]), (0.0,),
     [[0] * 4, np.sin(np.pi * np.array([0.25, 0.75, 1.25, 1.75])), [1, -1, 1, -1]]),
    ("torque_drift", motion_of(t=[100.0, 220.0]), (2.0,), [[0] * 4, [1, -1, 0, 0]]),
    ("torque_drift", motion_of(t=[5.0, 5.0]), (0.0,), np.zeros((2, 4))),
    ("warm_up", motion_of(t=[50.0, 80.0, 110.0], dq=[0.5, -2.0, 0.0]), (30.0, 0.0),
     [[1, 0.5], [-E1, -2 * E1], [0, 0]]),
    ("warm_up", motion_of(dq=[1.0, 1.0, -1.0], temperature=[25.0, 35.0, 15.0]), (1e9, 0.1),
     [[1, 1], [E1, E1], [-1 / E1, -1 / E1]]),
    ("warm_up", motion_of(dq=[1.0, 1.0]), (10.0, 0.5), [[1, 1], [E1**0.1, E1**0.1]]),  # no temperature
    ("torque_crosstalk", ARM, (-1,), np.column_stack([np.arange(N), np.zeros(N)])),
    ("torque_crosstalk", ARM, (1,), np.column_stack([np.zeros(N), 20.0 + np.arange(N)])),
    ("torque_crosstalk", among_three(joint=0), (0,), np.column_stack([np.zeros(N), 10.0 + np.arange(N)])),
    ("torque_crosstalk", among_three(joint=2), (0,), np.column_stack([10.0 + np.arange(N), np.zeros(N)])),
    ("torque_crosstalk", motion_of(dq=[1.0, -1.0]), (0,), np.zeros((2, 2))),
    ("gravity_error", PANDA, (3.0,), np.tile([0.0, 0.0, 5.0, 6.0, 7.0, 8.0] + [0.0] * 10, (N, 1))),
    ("gravity_error", PANDA, (SEVERAL,), np.tile([0.0, 0, 1, 2, 3, 4, 0, 0, 5, 6, 7, 8, 0, 0, 0, 0], (N, 1))),
    ("gravity_error", PANDA, (TILT,), np.tile([0.0] * 6 + [20.0, 21.0] + [0.0] * 8, (N, 1))),
    ("gravity_error", PANDA, (1,), np.zeros((N, 16))),
    ("gravity_error", ARM, (SEVERAL,), np.zeros((N, 16))),
    ("unlogged_compensation", ARM, (0.5, 0.0, 0), -np.tanh(DQ / 0.5)[:, None]),
    ("unlogged_compensation", ARM, (0.6, 0.0, 1), [[1], [0], [0], [0], [-1]]),
]  # fmt: skip

# Effect, motion, all parameters, torque.
TORQUES: list[tuple[str, Motion, Sequence[float], object]] = [
    ("cable_spring", motion_of(q=[-1.0, 0.0, 0.5, 0.7]), (2.0, 0.0, 0.0, -10.0, 10.5), [0, 0, 0, 0.4]),
    ("joint_limit_stop", motion_of(q=[1.1, -1.1]), (5.0, 2.0, 0.0, 0.0, 1.0, -1.0, 1.5), [5.0, -2.0]),
    ("gravity_error", ARM, (0.4 * np.sin(0.7), 0.4 * np.cos(0.7), *([0.0] * 14), 0), 0.4 * np.sin(ARM.q + 0.7)),
    ("load_dependent_friction", LOADED, (0.1, 0.0, 1.0, 0.0, 0.0), [-0.5, -0.3, 0.0, 0.3, 0.3]),
    ("load_dependent_friction", LOADED, (0.1, 0.0, 2.0, 0.0, 0.0), [-2.5, -0.9, 0.0, 0.9, 0.9]),
    # With half of it by the direction of the power; at rest the share by power is the load itself.
    ("load_dependent_friction", LOADED, (0.1, 0.05, 1.0, 1.0, 0.0), [-0.75, -0.15, 0.05, 0.15, 0.45]),
    ("load_dependent_friction", replace(LOADED, load=None), (0.1, 0.0, 1.0, 0.0, 0.0), [-0.1, -0.1, 0.0, 0.1, 0.1]),
    ("load_dependent_friction", LOADED, (0.1, 0.0, 1.0, 0.0, 1.0), [-0.4, -0.4, 0.0, 0.4, 0.2]),
    # phi1 / (1 + exp(-phi2 (v + phi3))) - phi1 / (1 + exp(-phi2 phi3)), Gaz et al. (2019)
    ("unlogged_compensation", ARM, (0.3, 0.5, 0.2, 0),
     -(0.6 / (1 + np.exp(-4.0 * (DQ + 0.1))) - 0.6 / (1 + np.exp(-0.4)))),
]  # fmt: skip


@pytest.mark.parametrize(("name", "motion", "values", "expected"), COLUMNS, ids=name_of)
def test_columns_by_hand(name: str, motion: Motion, values: Sequence[float], expected: object) -> None:
    assert_allclose(columns(name, motion, *values), np.asarray(expected, dtype=float), rtol=2e-5, atol=1e-9)


@pytest.mark.parametrize(("name", "motion", "values", "expected"), TORQUES, ids=name_of)
def test_torques_by_hand(name: str, motion: Motion, values: Sequence[float], expected: object) -> None:
    found = torque(name, motion, *values)
    moving = motion.dq != 0.0 if name == "load_dependent_friction" else slice(None)
    assert_allclose(found[moving], np.asarray(expected, dtype=float)[moving], atol=1e-12)


@pytest.mark.parametrize(("source", "accelerations"), [(BEFORE, {0: 1.0}), (AFTER, {2: 3.0}), (BOTH, {0: 1.0, 2: 3.0})])
def test_coupling_by_accelerations_of_neighbours(source: int, accelerations: dict[int, float]) -> None:
    expected = np.zeros((N, len(term_of("inertial_coupling").coefficients)))
    for joint, value in accelerations.items():
        expected[:, joint] = value
    assert_array_equal(columns("inertial_coupling", ARM, source), expected)


def test_coupling_by_all_others_and_by_the_model_of_the_arm() -> None:
    every = columns("inertial_coupling", ARM, ALL)[0]
    assert_array_equal(every[[*range(3), *range(JOINTS, JOINTS + 3)]], [1.0, 0.0, 3.0, 4.0, 0.0, 36.0])
    share = [one.name for one in term_of("inertial_coupling").coefficients].index("inertial_torque_share")
    model, tip = columns("inertial_coupling", PANDA, MODEL), columns("inertial_coupling", PANDA, TIP)
    assert np.flatnonzero(model.any(axis=0)).tolist() == [share]
    assert_array_equal(tip[0, share:], [30.0, *range(40, 50)])
    assert not any(columns("inertial_coupling", motion_of(dq=[1.0, -1.0]), k).any() for k in range(6))


@pytest.mark.parametrize(
    ("freedom", "formula"),
    [
        (1.0, lambda x: 2.0 / np.pi * np.arctan(np.sqrt(2.0) * x)),
        (2.0, lambda x: x / np.sqrt(1.0 + x**2)),
        (4.0, lambda x: np.sin(np.arctan(x / 2**0.5)) * (1.0 + np.cos(np.arctan(x / 2**0.5)) ** 2 / 2.0)),
    ],
)
def test_bends_that_have_a_formula(freedom: float, formula: object) -> None:
    x = np.linspace(0.0, 6.0, 50)
    assert callable(formula)
    assert_allclose(bend(x, freedom), formula(x), atol=1e-6)


@given(st.floats(-1.0, 5.0), st.floats(1e-6, 1e3), st.floats(-0.7, 4.0))
def test_the_coefficient_of_curved_friction_is_the_torque_at_1_rad_per_s(
    exponent: float, speed: float, sharpness: float
) -> None:
    found = torque("nonlinear_viscous", motion_of(dq=[1.0, -1.0]), 0.3, exponent, speed, sharpness)
    assert_allclose(found, [0.3, -0.3], rtol=1e-6)


def test_slow_waves_catch_a_ramp_and_most_of_a_random_walk() -> None:
    # A ramp is sum of 2 (-1)^(i+1) / ((i - 1/2) pi)^2 waves, a random walk on average of 1 / ((i - 1/2) pi)^2 each.
    t = np.linspace(0.0, 1.0, 2001)
    waves = columns("torque_drift", motion_of(t=t), 0.0)
    walks = np.cumsum(np.random.default_rng(0).normal(size=(2001, 200)), axis=0)
    for signal, share in ((t[:, None], 0.999), (walks, 0.94)):
        left = signal - waves @ np.linalg.lstsq(waves, signal)[0]
        assert 1.0 - np.sum(left**2) / np.sum(signal**2) > share


# Rests and reversals


def test_stiction_grows_with_the_rest_and_falls_over_the_path() -> None:
    dq = np.concatenate([np.zeros(50), np.full(100, 0.2), np.zeros(190), np.full(10, -1e-4), np.full(100, -0.2)])
    t = np.arange(len(dq), dtype=np.float64) * 0.01
    column = columns("stiction", Motion(t=t, q=np.cumsum(dq) * 0.01, dq=dq, ddq=0.0 * dq), 0.5, 0.02)[:, 0]
    assert_allclose(column[50], (1 - np.exp(-0.49 / 0.5)) * np.exp(-0.002 / 0.02))
    assert_allclose(column[60], column[50] * np.exp(-0.02 / 0.02))
    # The last samples of a rest that already have the direction of the onset bear its excess.
    assert_allclose(column[340:350], -(1 - np.exp(-2.0 / 0.5)), rtol=1e-6)
    assert_array_equal(column[dq == 0.0], 0.0)


@pytest.mark.parametrize(
    ("exponent", "curve"), [(1.0, lambda x: 1.0 - np.exp(-x)), (2.0, lambda x: 1.0 - 1.0 / (1.0 + x))]
)
def test_bristles_by_hand(exponent: float, curve: object) -> None:
    x = np.linspace(0.0, 3.0, 31)
    assert callable(curve)
    assert_allclose(bristle(x, 1.0, exponent), curve(x), atol=1e-14)
    assert_allclose(bristle(np.array([0, 0.1, 0.3, 0.2, 0, -0.1]), 0.2, 0.0), [0, 0.5, 1, 0.5, -0.5, -1], atol=1e-15)


@pytest.mark.parametrize("exponent", [0.2, 0.5, 0.8])
def test_stops_in_parallel_have_the_curve_of_their_exponent(exponent: float) -> None:
    bent, x = 1.0 - exponent, np.linspace(0.0, 8.0, 801)
    missing = np.maximum(2.0**bent - bent * x, 0.0) ** (1.0 / bent)
    q = np.concatenate([np.linspace(0.0, 30.0, 300), 30.0 - x])
    assert_allclose(-bristle(q, 1.0, exponent)[300:], 1.0 - missing, atol=0.01)


paths = st.lists(st.floats(-0.1, 0.1), min_size=2, max_size=30).map(lambda steps: np.cumsum([0.0, *steps]))


@given(paths, st.sampled_from((0.0, 0.3, 0.5, 0.8, 1.0, 1.5, 2.5)))
def test_bristles_stay_below_the_level_ignore_the_rate_and_take_energy(q: Float, exponent: float) -> None:
    finer = np.interp(np.arange(0, len(q) - 0.9, 0.25), np.arange(len(q)), q)
    coarse = bristle(q, 0.02, exponent)
    assert np.all(np.abs(coarse) <= 1.0 + 1e-12)
    assert_allclose(bristle(finer, 0.02, exponent)[::4], coarse, atol=1e-9)
    finest = np.interp(np.arange(0, len(q) - 0.99, 0.01), np.arange(len(q)), q)
    loop = np.tile(np.concatenate([finest, finest[::-1]]), 3)
    z, dq = bristle(loop, 0.02, exponent), np.diff(loop)
    work = 0.5 * (z[1:] + z[:-1]) * dq
    assert work[2 * len(loop) // 3 :].sum() >= -1e-3 * np.abs(dq).sum()


def test_stops_remember_the_reversal_that_a_small_loop_interrupted() -> None:
    q = np.concatenate([np.linspace(0, 1, 50), np.linspace(1, 0.7, 30), np.linspace(0.7, 0.8, 30), [0.7, 0.6]])
    straight = np.concatenate([np.linspace(0, 1, 50), np.linspace(1, 0.7, 30), [0.6]])
    assert bristle(q, 0.5, 0.5)[-1] == pytest.approx(bristle(straight, 0.5, 0.5)[-1], abs=1e-12)


# Effects on the torque of the nominal model


def moving(dq: Float) -> Motion:
    ddq = np.gradient(dq, T)
    return Motion(
        t=T, q=np.cumsum(dq) * 0.0025, dq=dq, ddq=ddq, rest=0.3 * ddq + 0.4 * np.sign(dq) + 0.2 * dq
    )  # fmt: skip


def test_friction_lags_by_its_speed_and_by_the_excess_over_coulomb_friction() -> None:
    pole = np.exp(-0.0025 / 0.1)
    assert_allclose((2.0 * T - first_order(2.0 * T, pole, 0.0))[-100:], 0.2, rtol=0.02)
    dq = 0.5 + 0.4 * np.sin(2.0 * T)
    seen = first_order(dq, pole, dq[0])
    expected = 0.2 * (seen - dq) + 0.5 * 0.4 * (np.exp(-seen / 0.2) - np.exp(-dq / 0.2))
    assert_allclose(columns("frictional_lag", moving(dq), 0.1, 0.5, 0.2)[:, 0], expected, atol=1e-6)


@pytest.mark.parametrize("delay", [0.01, -0.02])
def test_a_delay_moves_a_jump_as_a_whole(delay: float) -> None:
    jump = np.sign(np.sin(T)) + 0.3 * np.sin(2.0 * T)
    motion = replace(moving(0.0 * T), rest=jump)
    assert_allclose(jump + torque("time_delay", motion, delay, delay, 0.0), np.interp(T - delay, T, jump), atol=1e-12)
    loaded = replace(motion, load=3.0 * np.cos(2.0 * T))
    total = jump + 3.0 * np.cos(2.0 * T)
    expected = np.interp(T - delay, T, total) - total
    assert_allclose(torque("time_delay", loaded, delay, delay, 1.0), expected, atol=1e-12)
    assert_array_equal(torque("time_delay", loaded, delay, delay, 0.0), torque("time_delay", motion, delay, delay, 0.0))
