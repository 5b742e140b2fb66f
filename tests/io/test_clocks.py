"""The clock of a table and of messages: which one, in which unit, to the last digit."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from friction_audit.io.readers.clocks import Clock, Stamps, choose_clock, find_time
from friction_audit.io.recording import Thinned

START_NS = 1_700_000_000_000_000_123
LOG = START_NS + np.arange(1000, dtype=np.int64) * 1_000_000
SECONDS = np.linspace(0.0, 0.999, 1000)


@pytest.mark.parametrize(
    ("names", "found"),
    [
        ("q|time", ("time", None, "column")),
        ("q|time_since_start_ms", ("time_since_start_ms", "ms", "column")),
        ("duration| success rate", ("duration", "ms", "robot_time")),
        ("time|success_rate", ("time", "ms", "robot_time")),
        ("%time|field.header.stamp", ("field.header.stamp", None, "header_stamp")),
        ("%time|field.header.stamp|field.time", ("field.time", None, "robot_time")),
        ("%time|field.data", ("%time", "ns", "log_time")),
        ("time_ms", ("time_ms", "ms", "column")),
        ("t [s]", ("t [s]", "s", "column")),
        ("timestamp_ns", ("timestamp_ns", "ns", "column")),
        ("Time|header.stamp.secs|header.stamp.nsecs", ("header.stamp.secs + header.stamp.nsecs", "ns", "header_stamp")),
        ("q|sec|nanosec", ("sec + nanosec", "ns", "header_stamp")),
        ("ZeitInSec|ZeitInNanoSec", ("ZeitInSec + ZeitInNanoSec", "ns", "header_stamp")),
        ("q_1|dq_1|stamina|sec", None),
        ("%time|field.header.stamp=", ("%time", "ns", "log_time")),  # "=": it stands still
    ],
)  # fmt: skip
def test_columns_in_use(names: str, found: tuple[str, str | None, str] | None) -> None:
    columns = names.split("|")
    time = find_time([one.rstrip("=") for one in columns], {k for k, one in enumerate(columns) if one[-1] == "="})
    assert (time and (time.name, time.unit, time.clock)) == found


def to_clock(stamps: Any, unit: str | None) -> Any:
    own = Stamps(unit)
    return own.clock(own.since([stamps]), "log")


@pytest.mark.parametrize(
    ("step", "unit"), [(0.001, "s"), (0.0333, "s"), (1.0, "ms"), (33.0, "ms"), (1000.0, "us"), (1e6, "ns")]
)
def test_unit_from_the_median_step(step: float, unit: str) -> None:
    stamps = np.arange(5000, dtype=np.float64) * step + 3.0
    clock = to_clock(stamps, None)
    assert (clock.unit, clock.t[0], clock.start_s) == (unit, 0.0, None)
    if stamps[-1] < 1e9:  # a larger first stamp may be a Unix time
        assert to_clock(np.random.default_rng(1).permutation(stamps), None).unit == unit


@pytest.mark.parametrize(("per_second", "unit"), [(1.0, "s"), (1e3, "ms"), (1e6, "us"), (1e9, "ns")])
def test_unit_from_a_unix_time(per_second: float, unit: str) -> None:
    clock = to_clock((1.7e9 + np.arange(5, dtype=np.float64) * 0.5) * per_second, None)
    assert (clock.unit, clock.start_s) == (unit, pytest.approx(1.7e9))


def chosen(log_time: Any, **others: Any) -> Clock:
    return choose_clock({"log_time": log_time, **others})


def test_nanoseconds_since_1970_keep_their_last_digit() -> None:
    clock = to_clock(1_700_000_000_123_456_789 + np.arange(4, dtype=np.int64), "ns")
    np.testing.assert_array_equal(clock.t, np.arange(4) / 1e9)
    stamped = chosen(LOG, header_stamp=LOG + 7)
    assert (stamped.name, stamped.findings) == ("header_stamp", ())
    np.testing.assert_array_equal(stamped.t, np.arange(1000) / 1000)
    assert stamped.start_s == pytest.approx(START_NS / 1e9)


@pytest.mark.parametrize(
    ("factor", "unit"), [(1.0, ""), (1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")]
)
def test_robot_time_comes_first_in_any_unit_and_takes_its_date_from_the_log(factor: float, unit: str) -> None:
    clock = chosen(LOG, header_stamp=LOG, robot_time=SECONDS * factor)
    assert clock.name == "robot_time"
    assert clock.start_s == pytest.approx(START_NS / 1e9)
    np.testing.assert_allclose(clock.t, np.arange(1000) * 1e-3)
    assert [finding.code for finding in clock.findings if unit in finding.message] == ["robot_time_unit"] * bool(unit)


@pytest.mark.parametrize("robot_time", [0.0, np.nan, SECONDS - 2.0 * (SECONDS > 0.5)])
def test_clocks_that_stand_still_or_were_set_anew_are_passed_over(robot_time: Any) -> None:
    clock = chosen(LOG, header_stamp=np.zeros(1000, np.int64), robot_time=np.full(1000, robot_time))
    assert clock.name == "log_time"
    assert [finding.code for finding in clock.findings] == ["clock_stopped", "clock_stopped"]


NUMBERS = np.arange(100_000, dtype=np.int64)
LATE = np.random.default_rng(0).uniform(0.0, 1e8, 1000).astype(np.int64)


@pytest.mark.parametrize(
    ("log_time", "stamps", "amount"),
    [
        (START_NS + NUMBERS * 1_010_000, START_NS + NUMBERS * 1_000_000, pytest.approx(0.01)),  # a drift
        (LOG + LATE, LOG, pytest.approx(0.1 / np.sqrt(12), rel=0.1)),  # an irregular difference
    ],
)
def test_clocks_that_disagree(log_time: Any, stamps: Any, amount: Any) -> None:
    (finding,) = chosen(log_time, header_stamp=stamps).findings
    assert (finding.code, finding.amount) == ("clock_disagreement", amount)


def test_no_date_and_a_single_message() -> None:
    assert chosen(LOG - START_NS).start_s is None
    clock = chosen(LOG[:1], header_stamp=LOG[:1])
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
