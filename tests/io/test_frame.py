"""A log from memory: the names, units and checks of a file; motor currents become torques."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest

import friction_audit
from friction_audit.errors import InputError, UsageError
from friction_audit.joint_log import JointLog
from tests.io.synthetic_recordings import refused

SAMPLES = Path(__file__).parents[2] / "sample_logs"
RIG = SAMPLES / "bench_rig.csv"


@pytest.fixture(scope="module")
def frame() -> pd.DataFrame:
    return pd.read_csv(RIG, comment="#")


def assert_same(found: JointLog, expected: JointLog) -> None:
    assert found.channels().keys() == expected.channels().keys()
    np.testing.assert_array_equal(found.t, expected.t)
    for name, array in expected.channels().items():
        np.testing.assert_array_equal(found.channels()[name], array)


def test_a_frame_is_read_as_its_file_is(frame: pd.DataFrame) -> None:
    expected = friction_audit.read_log(RIG)
    before = frame.copy()
    found = friction_audit.log_from_frame(frame)
    assert_same(found, expected)
    pd.testing.assert_frame_equal(frame, before)
    assert (found.source.path, found.source.format) == ("frame", "frame")
    assert [one.code for one in found.source.findings] == [one.code for one in expected.source.findings]
    assert_same(friction_audit.log_from_frame(pa.table(frame)), expected)
    assert_same(friction_audit.log_from_frame({str(name): frame[name].to_numpy() for name in frame}), expected)
    numbers = friction_audit.estimate_log(found).friction.joints[0].coulomb
    assert numbers == friction_audit.estimate_log(expected).friction.joints[0].coulomb


def test_channels_may_be_arrays_or_lists_of_all_joints() -> None:
    expected = friction_audit.read_log(SAMPLES / "hand_guided.parquet")
    arrays: dict[str, Any] = {"t": expected.t, **expected.channels()}
    assert_same(friction_audit.log_from_frame(arrays), expected)
    lists = pd.DataFrame({name: list(array) for name, array in arrays.items()})
    assert_same(friction_audit.log_from_frame(lists), expected)
    ragged = lists.assign(q=[row[: 6 + number % 2] for number, row in enumerate(lists["q"])])
    with pytest.raises(InputError, match=r"run 7: q holds lists of 2 lengths; expected .* lists of one length"):
        friction_audit.log_from_frame(ragged, name="run 7")


@pytest.mark.parametrize("zone", [None, "Asia/Tokyo"])
def test_an_index_of_times_is_the_clock(frame: pd.DataFrame, zone: str | None) -> None:
    expected = friction_audit.log_from_frame(frame)
    begin = pd.Timestamp("2026-03-01T12:00:00", tz=zone)
    seconds, rest = frame["time"].to_numpy(), frame.iloc[:, 1:]
    found = friction_audit.log_from_frame(rest.set_index(pd.DatetimeIndex(begin + pd.to_timedelta(seconds, unit="s"))))
    np.testing.assert_allclose(found.t, expected.t, atol=1e-8)
    assert found.source.start_s == pytest.approx(begin.timestamp())
    found = friction_audit.log_from_frame(rest.set_index(pd.to_timedelta(seconds, unit="s").rename("time")))
    np.testing.assert_allclose(found.t, expected.t, atol=1e-8)


def test_options_are_those_of_a_file(frame: pd.DataFrame) -> None:
    renamed = frame.rename(columns={frame.columns[1]: "winkel"})
    refused(r"frame: no column for q; found", friction_audit.log_from_frame, renamed)
    part = friction_audit.log_from_frame(renamed, mapping={"q": "winkel"}, t_start_s=1.0, t_end_s=3.0)
    assert part.duration_s == pytest.approx(2.0, abs=0.02)
    assert part.source.window == (1.0, 3.0)
    with pytest.raises(UsageError, match="log_from_frame: no option maping"):
        friction_audit.log_from_frame(frame, maping={})  # type: ignore[call-arg]


def test_missing_numbers_are_found(frame: pd.DataFrame) -> None:
    gap = frame.astype("Float64")
    gap.iloc[100:103, 1:] = pd.NA
    assert "non_finite" in {one.code for one in friction_audit.log_from_frame(gap).source.findings}


@pytest.mark.parametrize("wrong", [3.0, "run.csv", np.zeros((3, 4)), [1, 2]])
def test_what_is_no_frame_is_refused(wrong: object) -> None:
    with pytest.raises(UsageError, match="expected a pandas or polars DataFrame, or a dict of arrays by name"):
        friction_audit.log_from_frame(wrong)
    with pytest.raises(UsageError, match="found a dict, expected a path; log_from_frame"):
        friction_audit.read_log({})  # type: ignore[arg-type]


def test_an_empty_frame_is_refused(frame: pd.DataFrame) -> None:
    empties: tuple[Any, ...] = (frame.iloc[:0], {}, pd.DataFrame())
    for empty in empties:
        refused(r"0 samples in .* expected one row per sample", friction_audit.log_from_frame, empty)
    short = {str(name): frame[name].to_numpy()[: 500 if name == frame.columns[1] else 800] for name in frame}
    with pytest.raises(InputError, match=r"has shape \(500,\), .* has 800 samples; expected one row per sample"):
        friction_audit.log_from_frame(short)


def table(**more: Any) -> dict[str, Any]:
    t = np.arange(0.0, 4.0, 0.002)
    rate = 2.0 * np.pi * np.array([0.5, 0.5])
    current = np.sign(np.cos(rate * t[:, None])) * [2.0, -3.0] + 0.01 * np.sin(300.0 * t[:, None])
    columns: dict[str, Any] = {"timestamp": t}
    for j in range(2):
        columns[f"actual_q_{j}"] = np.sin(rate[j] * t)
        columns[f"actual_qd_{j}"] = rate[j] * np.cos(rate[j] * t)
        columns[f"actual_current_{j}"] = current[:, j]
        columns[f"target_moment_{j}"] = 40.0 * np.ones(len(t))
    return columns | more


def test_a_table_of_rtde_is_in_ampere_until_a_constant_is_given() -> None:
    plain = friction_audit.log_from_frame(table())
    assert plain.source.torque_unit == "A"
    assert plain.tau_J_d is None
    given = friction_audit.log_from_frame(table(), torque_constant=(0.1, 0.2), gear_ratio=(101.0,), flip=(2,))
    assert given.source.torque_unit == "N m"
    assert plain.tau_J is not None
    assert given.tau_J is not None
    np.testing.assert_allclose(given.tau_J, plain.tau_J * [10.1, -20.2])
    (found,) = (one for one in given.source.findings if one.code == "torque_converted")
    for part in ("actual_current_{i}", "0.1, 0.2 N m/A", "gear ratio 101", "-1 in joint 2"):
        assert part in found.message


def test_a_torque_is_preferred_to_its_current() -> None:
    torque = {f"actual_current_as_torque_{j}": table()[f"actual_current_{j}"] * 9.0 for j in range(2)}
    log = friction_audit.log_from_frame(table(**torque), torque_scale=(2.0,))
    assert log.source.torque_unit == "N m"
    assert log.source.channels["tau_J"] == "actual_current_as_torque_{i}"
    assert log.tau_J is not None
    assert np.abs(log.tau_J[:, 0]).max() == pytest.approx(2.0 * 9.0 * 2.01, rel=1e-3)
