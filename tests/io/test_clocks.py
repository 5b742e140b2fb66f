"""The clock of a table and of messages: which one, in which unit, to the last digit."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.io.checks.columns import Thinned
from friction_audit.io.readers.message_samples import MessageClock, choose_clock
from friction_audit.io.readers.time_column import find_time, to_clock

START_NS = 1_700_000_000_000_000_123
LOG = START_NS + np.arange(1000, dtype=np.int64) * 1_000_000
SECONDS = np.linspace(0.0, 0.999, 1000)


def chosen(log_time: Any, header_stamp: Any = None, robot_time: Any = None) -> MessageClock:
    times = {"log_time": log_time, "header_stamp": header_stamp, "robot_time": robot_time}
    return choose_clock({name: readings for name, readings in times.items() if readings is not None})


@pytest.mark.parametrize(
    ("names", "name", "unit", "clock"),
    [
        (["q", "time"], "time", None, "column"),
        (["duration", " success rate"], "duration", "ms", "robot_time"),
        (["time", "success_rate"], "time", "ms", "robot_time"),
        (["%time", "field.header.stamp"], "field.header.stamp", None, "header_stamp"),
        (["%time", "field.header.stamp", "field.time"], "field.time", None, "robot_time"),
        (["%time", "field.data"], "%time", "ns", "log_time"),
        (["time_ms"], "time_ms", "ms", "column"),
        (["t [s]"], "t [s]", "s", "column"),
        (["timestamp_ns"], "timestamp_ns", "ns", "column"),
        (["Time", "header.stamp.secs", "header.stamp.nsecs"], "header.stamp.secs + header.stamp.nsecs", "ns",
         "header_stamp"),
    ],
)  # fmt: skip
def test_columns_in_use(names: list[str], name: str, unit: str | None, clock: str) -> None:
    found = find_time(names)
    assert found is not None
    assert (found.name, found.unit, found.clock) == (name, unit, clock)


def test_columns_that_are_no_clock() -> None:
    found = find_time(["%time", "field.header.stamp"], constant={1})
    assert found is not None
    assert found.name == "%time"
    assert find_time(["q_1", "dq_1", "stamina"]) is None


@pytest.mark.parametrize(
    ("step", "unit"), [(0.001, "s"), (0.0333, "s"), (1.0, "ms"), (33.0, "ms"), (1000.0, "us"), (1e6, "ns")]
)
def test_unit_from_the_median_step(step: float, unit: str) -> None:
    stamps = np.arange(5000, dtype=np.float64) * step + 3.0
    clock = to_clock(stamps.copy(), None, path="log")
    assert (clock.unit, clock.t[0], clock.start_s) == (unit, 0.0, None)
    if stamps[-1] < 1e9:  # a larger first stamp may be a Unix time
        assert to_clock(np.random.default_rng(1).permutation(stamps), None, path="log").unit == unit


@pytest.mark.parametrize(("per_second", "unit"), [(1.0, "s"), (1e3, "ms"), (1e6, "us"), (1e9, "ns")])
def test_unit_from_a_unix_time(per_second: float, unit: str) -> None:
    clock = to_clock((1.7e9 + np.arange(5, dtype=np.float64) * 0.5) * per_second, None, path="log")
    assert clock.unit == unit
    assert clock.start_s == pytest.approx(1.7e9)


def test_nanoseconds_since_1970_keep_their_last_digit() -> None:
    clock = to_clock(1_700_000_000_123_456_789 + np.arange(4, dtype=np.int64), "ns", path="log")
    np.testing.assert_array_equal(clock.t, np.arange(4) / 1e9)
    stamped = chosen(LOG, LOG + 7)
    assert (stamped.name, stamped.findings) == ("header_stamp", ())
    np.testing.assert_array_equal(stamped.t, np.arange(1000) / 1000)
    assert stamped.start_s == pytest.approx(START_NS / 1e9)


def test_robot_time_comes_first_and_takes_its_date_from_the_log() -> None:
    clock = chosen(LOG, LOG, 12.0 + SECONDS)
    assert clock.name == "robot_time"
    assert clock.start_s == pytest.approx(START_NS / 1e9)


@pytest.mark.parametrize(("factor", "unit"), [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")])
def test_robot_time_in_another_unit(factor: float, unit: str) -> None:
    clock = chosen(LOG, None, SECONDS * factor)
    np.testing.assert_allclose(clock.t, np.arange(1000) * 1e-3)
    assert [finding.code for finding in clock.findings] == ["robot_time_unit"]
    assert unit in clock.findings[0].message


@pytest.mark.parametrize("robot_time", [0.0, np.nan])
def test_clocks_that_stand_still_are_passed_over(robot_time: float) -> None:
    clock = chosen(LOG, np.zeros(1000, np.int64), np.full(1000, robot_time))
    assert clock.name == "log_time"
    assert [finding.code for finding in clock.findings] == ["clock_stopped", "clock_stopped"]


def test_drift_between_clocks() -> None:
    drifting = START_NS + np.arange(100_000, dtype=np.int64) * 1_010_000
    stamps = START_NS + np.arange(100_000, dtype=np.int64) * 1_000_000
    (finding,) = chosen(drifting, stamps).findings
    assert finding.code == "clock_disagreement"
    assert finding.amount == pytest.approx(0.01)


def test_irregular_difference_between_clocks() -> None:
    late = LOG + np.random.default_rng(0).uniform(0.0, 1e8, 1000).astype(np.int64)
    (finding,) = chosen(late, LOG).findings
    assert finding.code == "clock_disagreement"
    assert finding.amount == pytest.approx(0.1 / np.sqrt(12), rel=0.1)


def test_no_date_and_a_single_message() -> None:
    assert chosen(LOG - START_NS).start_s is None
    clock = chosen(LOG[:1], LOG[:1])
    assert (clock.t.tolist(), clock.findings) == ([0.0], ())


@given(sizes=st.lists(st.integers(1, 90), min_size=1, max_size=30))
def test_numbers_are_thinned_evenly_however_they_are_cut(sizes: list[int]) -> None:
    numbers, thinned = np.arange(float(sum(sizes))), Thinned()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Thinned, "MOST", 100)
        for piece in np.split(numbers, np.cumsum(sizes)[:-1]):
            thinned.take(piece)
    every = int(thinned.values[1] - thinned.values[0]) if len(numbers) > 1 else 1
    np.testing.assert_array_equal(thinned.values, numbers[::every])
    assert len(thinned.values) <= 100
    assert every == 1 or len(thinned.values) > 49  # no more is left out than has to be
