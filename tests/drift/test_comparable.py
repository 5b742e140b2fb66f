from dataclasses import replace

import pytest

from friction_audit.drift.covariates import choose_comparable
from friction_audit.drift.session import Conditions, Session, put_in_order
from tests.drift.made_sessions import FIRST_S, HAND, make_joint, make_session


def session(i: int, conditions: Conditions = HAND, *, known: bool = True, speed: float = 0.7) -> Session:
    return make_session(i, [make_joint(1, 0.3 + 0.001 * i, speed=speed)], conditions=conditions, known=known)


def left_out(sessions: list[Session]) -> dict[int, str]:
    return choose_comparable(put_in_order(sessions))[1]


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("drive", "robot", "drive robot, of the others hand"),
        ("torque", "tau_J", "torque tau_J, of the others interaction"),
        ("gravity", "model", "gravity model, of the others removed"),
        ("inertia", "model", "inertia model, of the others none"),
        ("payload", "2 kg", "payload 2 kg, of the others none given"),
        ("rate_hz", 100.0, "100 samples a second, of the others 1000"),
    ],
)
def test_unlike_sessions_are_left_out_with_the_reason(name: str, value: object, reason: str) -> None:
    odd = replace(HAND, **{name: value})  # type: ignore[arg-type]
    assert left_out([session(0), session(1), session(2, odd), session(3)]) == {2: reason}


def test_latest_of_equal_groups_is_compared() -> None:
    odd = replace(HAND, gravity="model")
    assert set(left_out([session(0), session(1), session(2, odd), session(3, odd)])) == {0, 1}


def test_same_start_and_estimates_in_another_format_count_once() -> None:
    again = replace(session(1), path="run1.mcap", sha256="other bytes")
    assert left_out([session(0), session(1), again]) == {2: "the same recording as run1.csv"}
    assert left_out([replace(session(i), start_s=FIRST_S) for i in range(4)]) == {}  # the start alone says nothing


def test_most_without_a_start_are_ordered_by_name_few_are_left_out() -> None:
    order = put_in_order([session(10, known=False), session(9, known=False), session(1)])
    assert (order.by, [s.path for s in order.sessions]) == ("name", ["run1.csv", "run9.csv", "run10.csv"])
    assert "order of their names" in choose_comparable(order)[2][0]
    order = put_in_order([session(0, known=False), session(2), session(1)])
    assert [s.path for s in order.sessions] == ["run1.csv", "run2.csv", "run0.csv"]
    assert [(index, "manifest" in reason) for index, reason in order.left_out] == [(2, True)]


def test_other_speeds_are_told() -> None:
    order = put_in_order([session(0), session(1), session(2), session(3, speed=0.1)])
    compared, _, (warning,) = choose_comparable(order)
    assert len(compared) == 4
    assert warning.startswith("joint 1: 1 of 4 sessions move at other speeds than the usual 0.35 to 1 rad/s; ")
