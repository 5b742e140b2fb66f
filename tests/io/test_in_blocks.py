"""A log that is read block by block gives what it gives in memory."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_audit.io.readers import ReadOptions, read_log
from friction_audit.io.readers.reader import InBlocks
from friction_audit.log_in_blocks import LogInBlocks
from friction_audit.pipeline import AuditSettings, estimate_log
from friction_audit.preprocessing.settings import CycleSettings, TorqueSettings
from friction_audit.preprocessing.sign import coarse_log
from friction_audit.reporting.estimate import estimate_document
from friction_audit.robot import load_arm
from tests.io.synthetic_recordings import motion
from tests.pinned.test_pinned import same

CHANNELS = ("q", "dq", "tau_J", "gravity", "tau_interaction", "tau_compensation", "tau_passivity")


@pytest.fixture(autouse=True)
def _small_logs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_audit.io.readers.table.IN_BLOCKS_BYTES", 0)
    monkeypatch.setattr("friction_audit.io.readers.parquet._BATCH_ROWS", 5003)


@pytest.fixture(scope="module")
def frame() -> pd.DataFrame:
    """Return six joints that swing and one at rest, with a gap and every channel that a torque is made from."""
    signals = motion(25_000, 7)
    t, q, dq = signals["t"], signals["q"], signals["dq"]
    q[:, 6], dq[:, 6] = 0.3, 0.0
    rng = np.random.default_rng(0)
    gravity = load_arm(None, None, (0.0, 0.0, -9.81)).gravity(q)
    friction = 0.5 * np.tanh(dq / 0.02) + 0.3 * dq + 0.02 * rng.standard_normal(q.shape)
    dq = dq + 1e-3 * rng.standard_normal(q.shape)
    arrays = (q, dq, gravity - friction, gravity, friction, 0.01 * np.sign(dq), 0.005 * np.sign(dq))
    every = {
        f"{channel}_{j + 1}": signal[:, j]
        for channel, signal in zip(CHANNELS, arrays, strict=True)
        for j in range(q.shape[1])
    }
    return pd.DataFrame({"time": t, **every}).drop(index=range(9000, 9300))


def written(frame: pd.DataFrame, folder: Path, *channels: str) -> Path:
    kept = [name for name in frame if name == "time" or str(name).rpartition("_")[0] in channels]
    frame[kept].to_parquet(folder / "run.parquet", index=False, row_group_size=7001)
    return folder / "run.parquet"


def assert_same(found: Any, expected: Any, where: str = "") -> None:
    """Compare two documents, numbers to 1e-9."""
    if isinstance(expected, dict):
        assert found.keys() == expected.keys(), where
        for key in expected:
            assert_same(found[key], expected[key], f"{where}/{key}")
    elif isinstance(expected, list | tuple) and len(found) == len(expected):
        for number, (one, other) in enumerate(zip(found, expected, strict=True)):
            assert_same(one, other, f"{where}/{number}")
    else:
        assert same(found, expected, 1e-9), f"{where}: {expected} became {found}"


CASES: dict[str, tuple[tuple[str, ...], dict[str, Any]]] = {
    "interaction": (("q", "dq", "tau_interaction"), {}),
    "logged gravity": (("q", "dq", "tau_J", "gravity"), {}),
    "gravity in the torque": (("q", "dq", "tau_J"), {}),
    "model": (("q", "dq", "tau_J"), {"robot": "panda", "gravity": "model", "drive": "hand"}),
    "compensation": (("q", "dq", "tau_interaction", "tau_compensation", "tau_passivity"), {}),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("joints", [None, (2, 5)])
def test_the_estimate_is_the_same(
    frame: pd.DataFrame, tmp_path: Path, case: str, joints: tuple[int, ...] | None
) -> None:
    channels, torque = CASES[case]
    path = written(frame, tmp_path, *channels)
    settings = AuditSettings(
        joints=joints,
        torque=TorqueSettings(**torque),
        cycles=CycleSettings(thresholds="auto"),
    )
    found = []
    for options in (ReadOptions(), InBlocks()):
        log = read_log(path, options)
        assert isinstance(log, LogInBlocks) is isinstance(options, InBlocks)
        found.append(estimate_document(estimate_log(log, settings)))
    assert_same(found[1], found[0])


@pytest.mark.parametrize("fault", ["missing", "wild", "degrees", "dead", "turns", "order", "repeats"])
def test_a_log_with_a_fault_is_read_at_once(frame: pd.DataFrame, tmp_path: Path, fault: str) -> None:
    frame = frame.copy()
    row, joints = frame.index[5000], range(1, 8)
    if fault == "missing":
        frame.loc[row, "dq_3"] = np.nan
    elif fault == "wild":
        frame.loc[row, "q_2"] = 50.0
    elif fault == "degrees":
        frame[[f"q_{j}" for j in joints]] *= 180.0 / np.pi
    elif fault == "dead":
        frame["tau_interaction_4"] = 0.5
    elif fault == "turns":
        frame["q_1"] += 20.0
    elif fault == "order":
        frame.loc[row, "time"] -= 0.01
    else:
        names = [name for name in frame if name != "time"]
        moving = frame.index[np.flatnonzero(np.abs(frame["dq_1"]) > 0.1)[100]]
        frame.loc[moving + 1, names] = frame.loc[moving, names]
    path = written(frame, tmp_path, "q", "dq", "tau_interaction")
    usual, log = read_log(path), read_log(path, InBlocks())
    assert not isinstance(log, LogInBlocks)
    assert log.source == usual.source
    np.testing.assert_array_equal(log.dq, usual.dq)


@pytest.mark.parametrize("clock", ["seconds", "nanoseconds", "timestamps"])
def test_lists_and_exact_clocks_are_read_in_blocks(frame: pd.DataFrame, tmp_path: Path, clock: str) -> None:
    stamps = np.round(frame["time"].to_numpy() * 1e9).astype(np.int64) + 1_700_000_000_000_000_000
    t = {"seconds": frame["time"], "nanoseconds": stamps, "timestamps": pd.to_datetime(stamps)}[clock]
    lists = {
        channel: frame[[f"{channel}_{j}" for j in range(1, 8)]].to_numpy().tolist()
        for channel in ("q", "dq", "tau_interaction")
    }
    path = tmp_path / "lists.parquet"
    pd.DataFrame({"time": np.asarray(t), **lists}).to_parquet(path, index=False, row_group_size=7001)
    usual, log = read_log(path), read_log(path, InBlocks())
    assert isinstance(log, LogInBlocks)
    # The clock is compared with the motion on means of the samples, which may begin or end a window otherwise.
    assert abs(log.source.clock_windows - usual.source.clock_windows) <= 7
    assert replace(log.source, clock_windows=0) == replace(usual.source, clock_windows=0)
    parts = list(log.blocks())
    np.testing.assert_array_equal(np.concatenate([part.t for part in parts]), usual.t)
    np.testing.assert_array_equal(np.concatenate([part.dq for part in parts]), usual.dq)


@pytest.mark.parametrize("rows", [1, 7, 33, 1999, 25_000])
def test_means_are_those_of_the_whole_whatever_the_blocks(
    frame: pd.DataFrame, tmp_path: Path, rows: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("friction_audit.io.readers.parquet._BATCH_ROWS", rows)
    few = frame.iloc[:2000] if rows < 100 else frame
    path = written(few, tmp_path, "q", "dq", "tau_interaction")
    log = read_log(path, InBlocks())
    assert isinstance(log, LogInBlocks)
    whole = coarse_log(read_log(path))
    found = coarse_log(log)
    np.testing.assert_array_equal(found.t, whole.t)
    np.testing.assert_array_equal(found.dq, whole.dq)
    np.testing.assert_array_equal(found.whole, whole.whole)


def test_a_long_log_is_judged_by_stretches_that_are_spread_over_it(
    frame: pd.DataFrame, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("friction_audit.io.checks.blocks.MOST_MEANS", 600)
    monkeypatch.setattr("friction_audit.io.checks.blocks.STRETCH", 100)
    path = written(frame, tmp_path, "q", "dq", "tau_interaction")
    usual, log = read_log(path), read_log(path, InBlocks())
    assert isinstance(log, LogInBlocks)
    every = coarse_log(usual)
    found = coarse_log(log)
    assert log.numbers.tolist() == [
        *range(100),
        *range(300, 400),
        *range(600, 700),
        *range(900, 1000),
        *range(1200, 1235),
    ]
    np.testing.assert_array_equal(found.dq, every.dq[log.numbers])
    ends = np.flatnonzero(np.diff(log.numbers) > 1)
    assert not found.whole[ends].any()
    assert not found.whole[ends + 1].any()
    one, other = (estimate_log(log, AuditSettings()) for log in (usual, log))
    assert other.interaction.choice.sign_proved
    for own, same_joint in zip(other.friction.joints, one.friction.joints, strict=True):
        assert own.coulomb.value == pytest.approx(same_joint.coulomb.value, rel=1e-9, nan_ok=True)
