"""The model's torque on a coarse grid against the same at every sample."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from friction_audit.joint_log import Float, JointLog, Source
from friction_audit.preprocessing.resampling import Grid, GridTorque, grids_of, position_on, velocity_on
from friction_audit.preprocessing.settings import TorqueSettings
from friction_audit.robot import load_arm

RATE_HZ = TorqueSettings().model_rate_hz
CENTRE = np.array([0.0, -0.8, 0.0, -2.3, 0.0, 1.5, 0.8])
AMPLITUDE = np.array([0.5, 0.4, 0.5, 0.4, 0.5, 0.5, 0.6])
FREQUENCY_HZ = np.array([0.5, 0.7, 0.9, 1.1, 0.6, 0.8, 1.0])


def moving_arm(t: Float) -> tuple[JointLog, Float]:
    """A log of smooth motion, up to 3 rad/s, and its exact acceleration."""
    omega = 2 * np.pi * FREQUENCY_HZ
    phase = t[:, None] * omega
    log = JointLog(
        t=t,
        q=np.asfortranarray(CENTRE + AMPLITUDE * np.sin(phase)),
        dq=np.asfortranarray(AMPLITUDE * omega * np.cos(phase)),
        tau_J=np.zeros((len(t), 7)),
        joint_names=tuple("1234567"),
        source=Source(path="made", sha256="", format="made"),
    )
    return log, -AMPLITUDE * omega**2 * np.sin(phase)


def at_samples(log: JointLog, torque: Callable[[Grid], Float], columns: Sequence[int] = range(7)) -> Float:
    """Return at every sample the torque of some joints that is given on grids."""
    grids, found = grids_of(log, RATE_HZ), np.zeros((len(log.t), len(columns)))
    made = GridTorque(grids=grids, values=tuple(map(torque, grids)))
    made.subtract_from(found, log.t, list(columns))
    return -found


def jittered(rate_hz: float, seconds: float) -> Float:
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.uniform(0.8, 1.2, int(rate_hz * seconds))) / rate_hz
    return np.asarray(t - t[0])


def test_inverse_dynamics_from_the_grid_is_within_a_hundredth_of_the_inertial_torque() -> None:
    log, ddq = moving_arm(jittered(1000.0, 6.0))
    arm = load_arm()
    exact = arm.inverse_dynamics(log.q, log.dq, ddq)
    torque = at_samples(
        log, lambda grid: arm.inverse_dynamics(position_on((grid,), log)[0], *velocity_on((grid,), log)[0])
    )
    inside = (log.t > 0.5) & (log.t < log.t[-1] - 0.5)
    moving = np.abs(exact - arm.gravity(log.q)).max(axis=0)
    assert (np.abs(torque - exact)[inside].max(axis=0) < np.maximum(0.01, 0.01 * moving)).all()


def test_velocity_has_no_delay_and_loses_noise() -> None:
    t = jittered(1000.0, 6.0)
    log, ddq = moving_arm(t)
    noisy = np.asfortranarray(log.dq + np.random.default_rng(5).normal(0, 0.003, log.dq.shape))
    (grid,) = grids_of(log, RATE_HZ)
    smooth, slope = velocity_on((grid,), replace(log, dq=noisy))[0]
    inside = slice(50, -50)
    for joint in range(7):
        exact = np.interp(grid.t, t, log.dq[:, joint])
        assert np.abs(smooth[inside, joint] - exact[inside]).max() < 0.01
        assert np.abs(slope[inside, joint] - np.interp(grid.t, t, ddq[:, joint])[inside]).max() < 0.3


@pytest.mark.parametrize("rate_hz", [30.0, 12.0, 3.0])
def test_a_log_slower_than_the_filter_is_still_followed(rate_hz: float) -> None:
    log, _ = moving_arm(np.arange(0.0, 8.0, 1 / rate_hz))
    (grid,) = grids_of(log, RATE_HZ)
    velocity, acceleration = velocity_on((grid,), log)[0]
    assert len(grid.t) <= len(log.t) + 1
    assert np.abs(velocity).max() < 1.2 * np.abs(log.dq).max()
    assert np.isfinite(acceleration).all()


def test_nothing_crosses_a_hole_in_the_log() -> None:
    log, _ = moving_arm(np.concatenate([np.arange(0.0, 2.0, 0.001), np.arange(1000.0, 1002.0, 0.001)]))
    grids = grids_of(log, RATE_HZ)
    assert [(round(grid.t[0]), round(grid.t[-1])) for grid in grids] == [(0, 2), (1000, 1002)]
    assert sum(len(grid.t) for grid in grids) < 410
    arm = load_arm()
    torque = at_samples(log, lambda grid: arm.gravity(position_on((grid,), log)[0]), [1, 3])
    assert np.abs(torque - arm.gravity(log.q)[:, [1, 3]]).max() < 0.01


@pytest.mark.parametrize("samples", [3, 4, 5, 40])
def test_very_short_logs_and_lone_samples(samples: int) -> None:
    log, _ = moving_arm(np.concatenate([np.arange(samples) * 0.001, [60.0]]))
    velocity = velocity_on(grids_of(log, RATE_HZ), log)
    assert all(np.isfinite(array).all() for pair in velocity for array in pair)
    np.testing.assert_allclose(at_samples(log, lambda grid: position_on((grid,), log)[0]), log.q, atol=1e-3)
