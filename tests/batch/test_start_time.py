from datetime import UTC, datetime

import pytest

from friction_audit.batch.identity import holds_a_time, parse_time, time_in_name

DAY = datetime(2026, 3, 1, tzinfo=UTC).timestamp()
MOMENT = datetime(2026, 3, 1, 14, 30, 5, tzinfo=UTC).timestamp()


@pytest.mark.parametrize(
    ("name", "start"),
    [
        ("2026-03-01.csv", DAY),
        ("run_20260301.mcap", DAY),
        ("20260301_143005.bag", MOMENT),
        ("2026-03-01T14-30-05.csv", MOMENT),
        ("2026-03-01 14:30:05.25.csv", MOMENT + 0.25),
        ("rosbag2_2026_03_01-14_30_05", MOMENT),
        ("2026-03-01T16:30:05+02:00.csv", MOMENT),
        ("panda_2026.03.01_14.30.05.parquet", MOMENT),
        ("log_1772375405.csv", MOMENT),
        ("log_1772375405123.csv", MOMENT + 0.123),
        ("1772375405.5.csv", MOMENT + 0.5),
        ("20260301T143005Z.csv", MOMENT),
    ],
)
def test_names_tell_when(name: str, start: float) -> None:
    assert time_in_name([name]) == pytest.approx(start, abs=1e-3)


@pytest.mark.parametrize("name", ["run7.csv", "2026-02-30.csv", "12345678901234.csv", "joint_20261301.csv", ""])
def test_other_numbers_are_no_dates(name: str) -> None:
    assert time_in_name([name]) is None


def test_the_name_comes_before_the_folders() -> None:
    assert time_in_name(["run.csv", "2026-03-01"]) == DAY
    assert time_in_name(["2026-03-01.csv", "2025-01-01"]) == DAY


@pytest.mark.parametrize(
    ("cell", "start"),
    [
        ("2026-03-01", DAY),
        ("2026-03-01 14:30:05", MOMENT),
        ("2026-03-01T14:30:05Z", MOMENT),
        ("1772375405.5", MOMENT + 0.5),
    ],
)
def test_cells_of_a_manifest(cell: str, start: float) -> None:
    assert parse_time(cell) == start


@pytest.mark.parametrize("cell", ["yesterday", "1.3.2026", "12", "2026-03-01 25:00", ""])
def test_cells_that_are_no_time(cell: str) -> None:
    assert parse_time(cell) is None


def test_folders_named_after_days() -> None:
    assert holds_a_time("2026-03-01")
    assert holds_a_time("week_20260301")
    assert not holds_a_time("panda2")
