import pytest
from hypothesis import given
from hypothesis import strategies as st

from friction_audit.cli.choices import parse_joints, parse_mapping, parse_numbers
from friction_audit.errors import UsageError


@pytest.mark.parametrize(
    ("text", "joints"),
    [("1", (1,)), ("1,3-5", (1, 3, 4, 5)), ("5,1, 3-3", (1, 3, 5)), ("2-3,3-4", (2, 3, 4)), (None, None)],
)
def test_joints(text: str | None, joints: tuple[int, ...] | None) -> None:
    assert parse_joints(text) == joints


@given(st.sets(st.integers(1, 40), min_size=1))
def test_a_list_of_joints_reads_back(joints: set[int]) -> None:
    assert parse_joints(",".join(map(str, joints))) == tuple(sorted(joints))


@pytest.mark.parametrize("text", ["", "0", "a", "1-", "-3", "1,,2", "5-3", "1.5", "²"])
def test_what_is_no_list_of_joints_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match=r"expected e\.g\. 1,3-5"):
        parse_joints(text)


def test_numbers() -> None:
    assert parse_numbers("--payload", "1, 2e-1,-3", ("a", "b", "c")) == (1.0, 0.2, -3.0)


def test_mapping() -> None:
    assert parse_mapping(["dq=a=b", "q=x,y"]) == {"dq": "a=b", "q": "x,y"}
    assert parse_mapping(None) == {}
    with pytest.raises(UsageError, match="mapped twice"):
        parse_mapping(["q=a", "q=b"])
