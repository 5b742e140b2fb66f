"""The clock chosen from those that a message offers."""

import numpy as np
import pytest

from friction_audit.io.readers.message_clock import choose_clock

START_NS = 1_700_000_000_000_000_123
LOG = START_NS + np.arange(1000, dtype=np.int64) * 1_000_000
SECONDS = np.linspace(0.0, 0.999, 1000)


def test_nanoseconds_are_kept() -> None:
    clock = choose_clock(LOG, LOG + 7, None)
    assert clock.name == "header_stamp"
    np.testing.assert_array_equal(clock.t, np.arange(1000) / 1000)
    assert clock.start_s == pytest.approx(START_NS / 1e9)
    assert clock.findings == ()


def test_robot_time_comes_first_and_takes_its_date_from_the_log() -> None:
    clock = choose_clock(LOG, LOG, 12.0 + SECONDS)
    assert clock.name == "robot_time"
    assert clock.start_s == pytest.approx(START_NS / 1e9)


@pytest.mark.parametrize(("factor", "unit"), [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")])
def test_robot_time_in_another_unit(factor: float, unit: str) -> None:
    clock = choose_clock(LOG, None, SECONDS * factor)
    np.testing.assert_allclose(clock.t, np.arange(1000) * 1e-3)
    assert [finding.code for finding in clock.findings] == ["robot_time_unit"]
    assert unit in clock.findings[0].message


@pytest.mark.parametrize("robot_time", [np.zeros(1000), np.full(1000, np.nan)], ids=["zero", "nan"])
def test_clocks_that_stand_still_are_passed_over(robot_time: np.ndarray[tuple[int], np.dtype[np.float64]]) -> None:
    clock = choose_clock(LOG, np.zeros(1000, np.int64), robot_time)
    assert clock.name == "log_time"
    assert [finding.code for finding in clock.findings] == ["clock_stopped", "clock_stopped"]


def test_drift_between_clocks() -> None:
    drifting = START_NS + np.arange(100_000, dtype=np.int64) * 1_010_000
    stamps = START_NS + np.arange(100_000, dtype=np.int64) * 1_000_000
    (finding,) = choose_clock(drifting, stamps, None).findings
    assert finding.code == "clock_disagreement"
    assert finding.amount == pytest.approx(0.01)


def test_clock_that_does_not_count_from_1970_tells_no_date() -> None:
    assert choose_clock(LOG - START_NS, None, None).start_s is None


def test_single_message() -> None:
    clock = choose_clock(LOG[:1], LOG[:1], None)
    assert clock.t.tolist() == [0.0]
    assert clock.findings == ()
