import numpy as np
import pytest

from friction_audit.drift.analyse import analyse_drift
from friction_audit.drift.report import DriftReport, DriftSettings, judge, parse_baseline, parse_limit
from friction_audit.errors import UsageError
from friction_audit.reporting.drift_text import limit_sentences
from tests.drift.made_sessions import make_sessions, noisy


@pytest.fixture(scope="module")
def stepped() -> DriftReport:
    level = noisy(16) * np.where(np.arange(16) >= 9, 1.15, 1.0)
    return analyse_drift(make_sessions(level), DriftSettings(permutations=199))


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


@pytest.mark.parametrize(
    "text",
    ["", "coulomb", "coulomb=", "coulomb=x%", "coulomb=-3%", "coulomb=nan%", "any=0.1", "joint0.any=3%", "gap=3%"],
)
def test_what_is_no_limit_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match=r"^--fail-on .*expected .*any=20%"):
        parse_limit(text)


@pytest.mark.parametrize("text", ["coulomb=10%", "joint1.coulomb=12%", "any=10%", "coulomb=0.03"])
def test_proven_change_beyond_the_limit(stepped: DriftReport, text: str) -> None:
    ((sentence,), _) = limit_sentences(stepped, [parse_limit(text)])
    assert sentence.startswith("arm, joint 1: Coulomb friction rose by ")
    assert sentence.endswith(f"surely beyond the limit {text}")
    below = {"coulomb=10%": "coulomb=20%", "any=10%": "joint2.coulomb=10%"}.get(text, "coulomb=0.06")
    assert "exceeded" not in {one.verdict for one in judge(stepped, [parse_limit(below)])}


@pytest.mark.parametrize(
    ("sessions", "text", "told"),
    [
        (16, "coulomb=20%", True),
        (16, "coulomb=0.1%", False),
        (16, "coulomb=0%", True),
        (16, "coulomb=0.00001", False),
        (3, "coulomb=50%", False),
        (16, "joint2.coulomb=20%", False),
    ],
)
def test_a_limit_below_what_would_have_been_seen_is_not_tested(sessions: int, text: str, told: bool) -> None:
    report = analyse_drift(make_sessions(noisy(sessions)), DriftSettings(permutations=199))
    _, sentences = limit_sentences(report, [parse_limit(text)])
    assert len(sentences) == (not told)
    assert all(text in sentence for sentence in sentences)


def test_baselines() -> None:
    assert (parse_baseline("5"), parse_baseline("3-5,10")) == (5, (2, 3, 4, 9))
    for text in ("", "0", "first", "5-3", "-2"):
        with pytest.raises(UsageError, match=r"^--baseline .*e\.g\. 5"):
            parse_baseline(text)
