"""Which sessions are compared; limits that users set, and the reference that they ask for."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.drift.analyse import analyse_arm
from friction_audit.drift.covariates import choose_comparable, known_by
from friction_audit.drift.report import ArmDrift, DriftSettings, judge, parse_baseline, parse_limit
from friction_audit.drift.session import Conditions, Session, put_in_order
from friction_audit.errors import UsageError
from friction_audit.reporting.drift_words import limit_sentences
from friction_audit.reporting.notices import sentence_of, text_of
from tests.drift.made_sessions import FIRST_S, HAND, make_joint, make_session, make_sessions, noisy


def session(i: int, conditions: Conditions = HAND, *, known: bool = True, speed: float = 0.7) -> Session:
    return make_session(i, [make_joint(1, 0.3 + 0.001 * i, speed=speed)], conditions=conditions, known=known)


def left_out(sessions: list[Session]) -> dict[int, str]:
    return {place: text_of(reason) for place, reason in choose_comparable(put_in_order(sessions))[1].items()}


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("drive", "robot", "drive robot, of the others hand (or its torque has the other sign)"),
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
    nameless = replace(session(1, known=False), path="run1.npz", sha256="more bytes")
    assert left_out([session(i, known=False) for i in range(3)] + [nameless]) == {2: "the same recording as run1.csv"}
    assert set(known_by(session(1))) & set(known_by(nameless))  # one of the two has a start


def test_most_without_a_start_are_ordered_by_name_few_are_left_out() -> None:
    order = put_in_order([session(10, known=False), session(9, known=False), session(1)])
    assert (order.by, [s.path for s in order.sessions]) == ("name", ["run1.csv", "run9.csv", "run10.csv"])
    assert "order of their names" in sentence_of(choose_comparable(order)[2][0])
    order = put_in_order([session(0, known=False), session(2), session(1)])
    assert [s.path for s in order.sessions] == ["run1.csv", "run2.csv", "run0.csv"]
    assert [(index, "manifest" in text_of(reason)) for index, reason in order.left_out] == [(2, True)]


def test_other_speeds_are_reported() -> None:
    order = put_in_order([session(0), session(1), session(2), session(3, speed=0.1)])
    compared, _, (warning,) = choose_comparable(order)
    assert len(compared) == 4
    assert sentence_of(warning).startswith("joint 1: 1 of 4 sessions move at other speeds than the usual 0.35 to 1 ")


@pytest.fixture(scope="module")
def stepped() -> tuple[ArmDrift]:
    level = noisy(16) * np.where(np.arange(16) >= 9, 1.15, 1.0)
    return (analyse_arm(make_sessions(level), DriftSettings(permutations=199)),)


@pytest.mark.parametrize(
    ("text", "joint", "coefficient", "size", "relative"),
    [
        ("coulomb=15%", None, "coulomb_nm", 0.15, True),
        ("viscous=0.05", None, "viscous_nms_per_rad", 0.05, False),
        ("joint3.coulomb=10%", 3, "coulomb_nm", 0.10, True),
        ("any=20 %", None, None, 0.20, True),
        (" Joint12.Any=2e1%", 12, None, 0.20, True),
    ],
)
def test_limits(text: str, joint: int | None, coefficient: str | None, size: float, relative: bool) -> None:
    found = parse_limit(text)
    assert (found.joint, found.coefficient, found.relative) == (joint, coefficient, relative)
    assert found.size == pytest.approx(size)


@pytest.mark.parametrize("text", ["coulomb=10%", "joint1.coulomb=12%", "any=10%", "coulomb=0.03"])
def test_proven_change_beyond_the_limit(stepped: tuple[ArmDrift], text: str) -> None:
    ((sentence,), _) = limit_sentences(stepped, [parse_limit(text)])
    assert sentence.startswith("arm, joint 1: Coulomb friction rose by ")
    assert sentence.endswith(f"surely beyond the limit {text}")
    below = {"coulomb=10%": "coulomb=20%", "any=10%": "joint2.coulomb=10%"}.get(text, "coulomb=0.06")
    assert "exceeded" not in {one.verdict for one in judge(stepped, [parse_limit(below)])}


@pytest.mark.parametrize(("sessions", "text", "told"), [
    (16, "coulomb=20%", True), (16, "coulomb=0.1%", False), (16, "coulomb=0%", True),
    (16, "coulomb=0.00001", False), (3, "coulomb=50%", False), (16, "joint2.coulomb=20%", False),
])  # fmt: skip
def test_a_limit_below_what_would_have_been_seen_is_not_tested(sessions: int, text: str, told: bool) -> None:
    arm = analyse_arm(make_sessions(noisy(sessions)), DriftSettings(permutations=199))
    _, sentences = limit_sentences([arm], [parse_limit(text)])
    assert len(sentences) == (not told)
    assert all(text in sentence for sentence in sentences)


def test_baselines() -> None:
    assert (parse_baseline("5"), parse_baseline("3-5,10")) == (5, (2, 3, 4, 9))
    for text in ("", "0", "first", "5-3", "-2"):
        with pytest.raises(UsageError, match=r"^--baseline .*e\.g\. 5"):
            parse_baseline(text)
