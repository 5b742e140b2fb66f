"""The table of a batch says in eighty columns what the analysis says."""

from dataclasses import replace

import pytest
from friction_audit.reporting.batch_summary import BatchSummary
from friction_audit.reporting.terminal.batch import batch_table

from friction_audit.drift.report import ArmDrift
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.reporting.drift_words import (
    change_text,
    enumerate_words,
    format_p,
    format_percent,
    format_share,
    format_slope,
    format_start,
    iso_start,
    span_of,
    total_text,
    trend_text,
)
from tests.reporting import batch_by_hand as by_hand

ARM = by_hand.arm()
STEP = ARM.joints[1].coefficients[0]
RISE = ARM.joints[4].coefficients[0]


def lines_of(summary: BatchSummary, *, verbose: bool = False) -> list[str]:
    return [str(part) for part in batch_table(summary, verbose=verbose)]


def test_a_table_per_arm_within_eighty_columns() -> None:
    lines = lines_of(by_hand.batch(ARM, by_hand.arm(robot="panda-2", seed=1)))
    assert len([line for line in lines if line.startswith(tuple("1234567")) and "Coulomb" in line]) == 2 * 7
    table = [line for line in lines if " Coulomb " in line or " viscous " in line]
    assert max(len(line) for line in table if ": " not in line) <= 80
    assert "…" not in "".join(table)


def test_what_drifts_is_told_with_its_step() -> None:
    lines = lines_of(by_hand.batch(ARM))
    (row,) = [line for line in lines if line.startswith("2 ")]
    assert " ".join(row.split()) == "2 Coulomb drift +15.0 ± 1.5 % 13 0 ± 0.10 % 3.3 %"
    assert "  Coulomb: step at session 13 (12 to 14), 2026-03-21: +15.0 ± 1.5 %" in lines
    assert "  Coulomb: +0.0027 ± 0.0003 N m per session, +0.00178 ± 0.00019 per day" in lines


def test_what_was_left_out_exceeded_and_failed_is_told() -> None:
    text = "\n".join(lines_of(by_hand.batch(ARM)))
    assert "24 sessions of 1 arm: 20 computed, 4 known from the ledger, 1 failed" in text
    assert "not compared: session 9: payload 0.7 kg, the reference had none" in text
    assert "limit exceeded: panda-1, joint 2" in text
    assert "failed: logs/broken.bag: broken.bag: is truncated" in text


def test_more_is_told_to_those_who_ask() -> None:
    assert not any(line.startswith("joint 1:") for line in lines_of(by_hand.batch(ARM)))
    verbose = lines_of(by_hand.batch(ARM), verbose=True)
    assert any(line.startswith("joint 1: coulomb: no change above") for line in verbose)
    assert "not compared: logs/panda-1/run_009.mcap: payload 0.7 kg, the reference had none" in verbose


def test_many_sessions_left_out_for_one_reason_are_counted() -> None:
    many = replace(ARM, left_out=tuple((k, "no start") for k in range(9)))
    assert "not compared: sessions 9 of them: no start" in lines_of(by_hand.batch(many))


def test_a_batch_of_nothing_has_a_table() -> None:
    lines = lines_of(by_hand.empty())
    assert lines[0] == "0 sessions of 0 arms: 0 computed, 0 known from the ledger, 1 failed"
    assert lines[-1] == "failed: a.csv: a.csv: no column for dq"


def test_markup_of_the_terminal_is_text() -> None:
    named = replace(ARM, robot="[red]arm[/red]")
    assert any(line.startswith("[red]arm[/red]: 24 sessions") for line in lines_of(by_hand.batch(named)))


def test_near_a_level_of_zero_numbers_are_absolute() -> None:
    zero = replace(
        RISE, total=UNDETERMINED, change=Coefficient(value=0.02, low=0.01, high=0.03), smallest_drift=float("nan")
    )
    assert total_text(zero) == "+0.020 ± 0.010 N m"
    assert trend_text(zero) == "+0.0027 ± 0.0003 N m"
    change = replace(STEP.change_points[0], relative=UNDETERMINED)
    assert change_text(ARM, change).endswith("2026-03-21: 0.1520 ± 0.0023 to 0.1748 ± 0.0023")


def test_a_change_that_follows_temperature_is_no_drift() -> None:
    warm = replace(RISE, shape="temperature", drift=False)
    still = replace(ARM.joints[4], coefficients=(warm,), drift=False)
    lines = lines_of(by_hand.batch(replace(ARM, joints=(still,))))
    (row,) = [line for line in lines if line.startswith("5 ")]
    assert " temperature " in row


def test_names_are_not_said_twice() -> None:
    text = "\n".join(lines_of(by_hand.batch(ARM), verbose=True))
    assert "panda-1: 24 sessions, 2026-03-03 to 2026-04-07, 23 compared; joints 2 and 5 drift" in text
    assert "joint 1: joint 1" not in text


def test_a_change_without_an_interval_is_rounded() -> None:
    assert format_percent(Coefficient(value=30.62, low=-1.0, high=8.9e7)) == "not told"
    assert format_percent(Coefficient(value=-0.06132, low=float("nan"), high=float("nan"))) == "-6.1 %"


def test_a_step_between_two_sessions_alone_has_no_range() -> None:
    sharp = replace(STEP.change_points[0], low=12, high=12)
    assert change_text(by_hand.arm(dated=False), sharp) == "session 13: +15.0 ± 1.5 %"


@pytest.mark.parametrize(
    ("start_s", "shown", "iso"),
    [
        (0.0, "1970-01-01 00:00", "1970-01-01T00:00:00.000Z"),
        (1772550000.25, "2026-03-03 15:00", "2026-03-03T15:00:00.250Z"),
        (None, "-", None),
        (-5.0, "-", None),
        (float("nan"), "-", None),
        (1e18, "-", None),
    ],
)
def test_starts(start_s: float | None, shown: str, iso: str | None) -> None:
    assert format_start(start_s) == shown
    assert iso_start(start_s) == iso


def test_numbers_have_the_digits_that_they_deserve() -> None:
    assert format_slope(Coefficient(value=0.0026712, low=0.0024, high=0.0029424)) == "+0.0027 ± 0.0003"
    assert format_slope(Coefficient(value=-1.0, low=-1.0, high=-1.0)) == "-1"
    assert format_slope(UNDETERMINED) == format_share(float("nan")) == format_p(float("nan")) == "-"
    assert [format_share(share) for share in (0.0333, 0.132, 0.95, 9e4)] == ["3.3 %", "13 %", "95 %", ">100 %"]
    assert [format_p(p) for p in (1e-9, 0.0432, 1.0)] == ["< 0.001", "0.043", "1"]


def test_words_in_a_row() -> None:
    assert enumerate_words([1]) == "1"
    assert enumerate_words([1, 2, 3]) == "1, 2 and 3"


def test_the_span_of_sessions_is_of_those_with_a_start() -> None:
    undated = by_hand.arm(2, dated=False).sessions
    assert span_of(undated) == ""
    assert span_of([*ARM.sessions[:1], *undated]) == "2026-03-03"
    assert span_of(reversed(ARM.sessions)) == "2026-03-03 to 2026-04-07"


def test_sessions_of_a_summary_are_those_of_its_arms() -> None:
    other: ArmDrift = by_hand.arm(3, robot="panda-2")
    assert len(by_hand.batch(ARM, other).sessions) == 27
