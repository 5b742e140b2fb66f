import pytest

from friction_audit.drift.settings import DriftSettings, parse_baseline
from friction_audit.errors import UsageError


def test_baselines() -> None:
    assert parse_baseline("5") == 5
    assert parse_baseline("3-5,10") == (2, 3, 4, 9)


@pytest.mark.parametrize("text", ["", "0", "first", "5-3", "-2"])
def test_what_is_no_baseline_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match=r"^--baseline .*e\.g\. 5"):
        parse_baseline(text)


@pytest.mark.parametrize(
    "wrong", [{"baseline": 0}, {"baseline": ()}, {"alpha": 0.0}, {"power": 1.0}, {"permutations": 9}]
)
def test_settings_out_of_range_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(UsageError, match="expected"):
        DriftSettings(**wrong)  # type: ignore[arg-type]
