import numpy as np
import pytest

from friction_audit.io.readers.time_column import find_time, to_clock


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
        (
            ["Time", "header.stamp.secs", "header.stamp.nsecs"],
            "header.stamp.secs + header.stamp.nsecs",
            "ns",
            "header_stamp",
        ),
    ],
)
def test_clocks_in_use(names: list[str], name: str, unit: str | None, clock: str) -> None:
    found = find_time(names)
    assert found is not None
    assert (found.name, found.unit, found.clock) == (name, unit, clock)


def test_a_stamp_that_nobody_set_is_no_clock() -> None:
    found = find_time(["%time", "field.header.stamp"], constant={1})
    assert found is not None
    assert found.name == "%time"


def test_no_clock() -> None:
    assert find_time(["q_1", "dq_1", "stamina"]) is None


@pytest.mark.parametrize(
    ("step", "unit"), [(0.001, "s"), (0.0333, "s"), (1.0, "ms"), (33.0, "ms"), (1000.0, "us"), (1e6, "ns")]
)
def test_unit_from_the_median_step(step: float, unit: str) -> None:
    clock = to_clock(np.arange(10, dtype=np.float64) * step + 3.0, None, path="log")
    assert clock.unit == unit
    assert clock.t[0] == 0.0
    assert clock.start_s is None


@pytest.mark.parametrize("step", [0.001, 1.0])
def test_the_unit_does_not_depend_on_the_order_of_the_rows(step: float) -> None:
    ordered = np.arange(5000, dtype=np.float64) * step
    shuffled = np.random.default_rng(1).permutation(ordered)
    assert to_clock(shuffled, None, path="log").unit == to_clock(ordered, None, path="log").unit


@pytest.mark.parametrize(("per_second", "unit"), [(1.0, "s"), (1e3, "ms"), (1e6, "us"), (1e9, "ns")])
def test_unit_from_a_unix_time(per_second: float, unit: str) -> None:
    clock = to_clock((1.7e9 + np.arange(5, dtype=np.float64) * 0.5) * per_second, None, path="log")
    assert clock.unit == unit
    assert clock.start_s == pytest.approx(1.7e9)


def test_nanoseconds_since_1970_keep_their_last_digit() -> None:
    clock = to_clock(1_700_000_000_123_456_789 + np.arange(4, dtype=np.int64), "ns", path="log")
    np.testing.assert_array_equal(clock.t, np.arange(4) / 1e9)
