"""Rows that repeat one that was lost are a tick late, and say so by the motion."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from friction_audit.audit import AuditSettings, estimate_log
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.lone_repeats import lone_repeats
from friction_audit.discrepancy.prepare import prepare
from friction_audit.joint_log import Float, JointLog
from friction_audit.simulate import BenchSettings, simulate

STEP = 1e-3
TICKS = np.arange(6000)
NOISE_RAD = 1e-5


def stamps(ticks: NDArray[np.int64]) -> Float:
    """Stamps of some ticks. [s]"""
    return np.asarray(STEP * ticks, np.float64)


def moved(seed: int = 0) -> Float:
    """Two joints in sines, the second one slowly, shape (n, 2). [rad]"""
    path = np.stack([0.5 * np.sin(3.0 * STEP * TICKS), 0.1 * np.cos(STEP * TICKS)], axis=1)
    return np.asarray(path + NOISE_RAD * np.random.default_rng(seed).standard_normal(path.shape))


def recorded(late: NDArray[np.int64], lost: NDArray[np.int64]) -> tuple[Float, Float, NDArray[np.bool_]]:
    """Stamps and positions of a recorder that wrote some states a tick late and lost some; and which are late."""
    q = moved()
    q[late] = q[late - 1]
    kept = np.setdiff1d(TICKS, lost)
    return stamps(kept), q[kept], np.isin(kept, late)


def test_a_repeat_of_a_lost_sample_is_told() -> None:
    repeated = np.arange(50, 5900, 50)
    t, q, late = recorded(repeated, repeated - 1)
    speed = np.abs(np.gradient(q[:, 0], t))
    found = lone_repeats(t, q)
    # A tick of motion at 0.1 rad/s is 0.1 mrad, ten times the noise.
    assert np.array_equal(found[speed > 0.1], late[speed > 0.1])
    assert not np.any(found & ~late)


def test_lost_samples_alone_make_none_late() -> None:
    lost = np.random.default_rng(1).choice(TICKS[1:-1], 300, replace=False)
    t, q, _ = recorded(np.array([], np.int64), lost)
    assert not lone_repeats(t, q).any()


@pytest.mark.parametrize("run", [2, 3])
def test_late_ones_in_a_row_do_not_hide_each_other(run: int) -> None:
    first = np.arange(20, 500, 40)
    q = moved()
    for row in first:
        q[row : row + run] = q[row - 1 : row - 1 + run].copy()
    kept = np.setdiff1d(TICKS, first - 1)
    late = np.isin(kept, (first[:, None] + np.arange(run)).ravel())
    assert np.array_equal(lone_repeats(stamps(kept), q[kept]), late)


def test_jitter_of_stamps_is_no_lateness() -> None:
    rng = np.random.default_rng(2)
    kept = np.sort(rng.choice(TICKS, 5700, replace=False))
    t = STEP * (kept + rng.uniform(0.0, 0.4, len(kept)))
    q = np.stack([np.interp(STEP * kept, STEP * TICKS, column) for column in moved().T], axis=1)
    assert not lone_repeats(t, q).any()


def test_a_joint_at_rest_tells_nothing() -> None:
    t = np.delete(STEP * TICKS, [100, 200])
    assert not lone_repeats(t, np.full((len(t), 1), 0.3)).any()


def test_the_motion_of_a_log_with_late_rows_is_that_of_the_log_without_them() -> None:
    log = simulate(BenchSettings(duration_s=20.0), 0).log
    moves = np.abs(log.dq[:, 0]) > 0.2
    late = np.arange(50, len(log.t) - 50, 50)
    late = late[moves[late] & moves[late - 1]]
    source = np.arange(len(log.t))
    source[late] -= 1
    kept = np.setdiff1d(np.arange(len(log.t)), late - 1)
    honest, found = (_prepared(_rows(log, rows, stamps)) for rows, stamps in ((kept, kept), (source[kept], kept)))
    off = (found.ddq - honest.ddq)[found.valid & honest.valid]
    # A tick of motion, differentiated twice, is more than all acceleration there is.
    assert np.std(off) < 0.1 * np.std(honest.ddq)


def _rows(log: JointLog, rows: NDArray[np.int64], stamps: NDArray[np.int64]) -> JointLog:
    channels: dict[str, Any] = {name: channel[rows] for name, channel in log.channels().items()}
    return replace(log, t=log.t[stamps], **channels)


def _prepared(log: JointLog) -> JointData:
    estimate = estimate_log(log, AuditSettings())
    (data,) = prepare(estimate.interaction, estimate.cycles, estimate.log)
    return data


def test_one_sample_before_its_time_makes_none_behind_it_late() -> None:
    early = np.arange(60, 5900, 500)
    q = moved()
    q[early] = q[early + 1]
    kept = np.setdiff1d(TICKS, early + 1)
    found = lone_repeats(stamps(kept), q[kept])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], found, [0]])))
    assert edges.size == 0 or np.diff(edges)[::2].max() <= 3
