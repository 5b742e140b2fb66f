"""``diff``: numbers known by hand from two results, logs end to end, limits, and what it refuses."""

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import stdtrit
from scipy.stats import t as student
from statsmodels.stats.multitest import multipletests

from friction_audit.drift.session import LOST_JOINT, Session
from friction_audit.drift.two_sides import compare_sides
from friction_audit.friction.history import UNDETERMINED, Coefficient
from tests.drift.made_sessions import make_joint, make_session
from tests.each_case import thorough
from tests.in_this_process import Run

Pair = tuple[float, float]
SPEED = 1.0  # rad/s: of the friction law of results, which hold no speeds


def joint(number: int, coulomb: Pair | None, viscous: Pair | None, cycles: int, **changes: Any) -> dict[str, Any]:
    """Return a joint of a result; a coefficient is a value and the half width of its interval."""
    found = [one and {"value": one[0], "ci95": [one[0] - one[1], one[0] + one[1]]} for one in (coulomb, viscous)]
    own = {"joint": number, "name": f"joint{number}", "cycles": cycles, "moving_s": 9.0, "method": "energy"}
    estimate = {"coulomb_nm": found[0], "viscous_nms_per_rad": found[1], "correlation": -0.8, "reason": None}
    return own | estimate | changes


def result(path: Path, *joints: dict[str, Any], count: int = 2, **changes: Any) -> Path:
    """Write a result of two joints; changes are of what its torque was made from, or its hash and unit."""
    chosen = {"drive": "hand", "source": "tau_J", "gravity": "logged", "inertia": "none"}
    source = {"sha256": path.stem, "robot": "panda", "start_s": None, "duration_s": 60.0, "rate_hz": 1000.0}
    source |= {"joints": count, "torque_unit": changes.pop("unit", "N m")}
    settings = {"torque": {"payload": None}, "friction": {"model": "combined", "estimator": "weighted"}}
    settings["torque_chosen"] = chosen | changes
    document = {"schema": "friction-audit/estimate/1", "source": source, "settings": settings, "joints": joints}
    path.parent.mkdir(exist_ok=True, parents=True)
    path.write_text(json.dumps(document))
    return path


@pytest.fixture
def pair(tmp_path: Path) -> tuple[Path, Path]:
    before = result(tmp_path / "a.json", joint(1, (0.30, 0.02), (0.10, 0.03), 11), joint(2, (0.20, 0.05), None, 6))
    after = result(tmp_path / "b.json", joint(1, (0.36, 0.03), (0.09, 0.02), 21), joint(2, (0.21, 0.04), (0.1, 0.1), 9))
    return before, after


def welch(before: Pair, after: Pair, cycles: Pair) -> tuple[float, float, float]:
    """Return standard error, degrees of freedom and p value of a difference."""
    error = [one[1] / student.ppf(0.975, n - 1) for one, n in zip((before, after), cycles, strict=True)]
    total = float(np.linalg.norm(error))
    freedom = total**4 / sum(e**4 / (n - 1) for e, n in zip(error, cycles, strict=True))
    return total, freedom, float(2 * student.sf(abs(after[0] - before[0]) / total, freedom))


def test_numbers_of_two_results_are_those_of_welch_and_holm(run: Run, pair: tuple[Path, Path]) -> None:
    document = run("diff", *pair, "--json").document()
    known = [((0.30, 0.02), (0.36, 0.03), (11, 21)), ((0.10, 0.03), (0.09, 0.02), (11, 21))]
    known += [((0.20, 0.05), (0.21, 0.04), (6, 9))]
    tests = [welch(*one) for one in known]
    adjusted = multipletests([p for *_, p in tests], method="holm")[1]
    first, second = document["joints"]
    rows = zip((first["coulomb"], first["viscous"], second["coulomb"]), known, tests, adjusted, strict=True)
    for found, (before, after, _), (error, freedom, p), q in rows:
        unit = "nms_per_rad" if found is first["viscous"] else "nm"
        difference, half = after[0] - before[0], student.ppf(0.975, freedom) * error
        assert found[f"difference_{unit}"]["value"] == pytest.approx(difference)
        assert found[f"difference_{unit}"]["ci95"] == pytest.approx([difference - half, difference + half])
        assert found["relative_change"]["value"] == pytest.approx(difference / before[0])
        assert (found["single_p_value"], found["p_value"]) == (pytest.approx(p), pytest.approx(q))
        least = (student.ppf(1 - 0.05 / 6, freedom) + student.ppf(0.9, freedom)) * error
        assert found[f"smallest_detectable_{unit}"] == pytest.approx(least)
    assert first["coulomb"]["changed"]
    assert second["viscous"]["difference_nms_per_rad"] is None
    assert second["law"] is None
    errors = [np.array([0.02, 0.03]) / student.ppf(0.975, 10), np.array([0.03, 0.02]) / student.ppf(0.975, 20)]
    variances = [c**2 + v**2 - 1.6 * c * v for c, v in errors]
    freedom = sum(variances) ** 2 / (variances[0] ** 2 / 10 + variances[1] ** 2 / 20)
    law = first["law"]
    assert law["speed_rad_s"][-1] == SPEED
    assert law["change_nm"][-1] == pytest.approx(0.05)
    assert law["high_nm"][-1] - 0.05 == pytest.approx(student.ppf(0.975, freedom) * np.sqrt(sum(variances)))


def test_the_spread_between_recordings_of_a_side_counts(run: Run, tmp_path: Path) -> None:
    one = result(tmp_path / "one.json", joint(1, (0.3, 0.001), (0.1, 0.001), 30), count=1)
    alone = run("diff", one, result(tmp_path / "x.json", joint(1, (0.33, 0.001), (0.1, 0.001), 30), count=1), "--json")
    for k, value in enumerate((0.30, 0.33, 0.36)):
        result(tmp_path / "many" / str(k) / "estimate.json", joint(1, (value, 0.001), (0.1, 0.001), 30), count=1)
    several = run("diff", one, tmp_path / "many", "--json").document()
    (found,) = several["joints"]
    assert len(several["after"]) == 3
    assert found["coulomb"]["after_nm"]["value"] == pytest.approx(0.33, abs=1e-5)
    half = found["coulomb"]["after_nm"]["ci95"][1] - 0.33
    assert half == pytest.approx(student.ppf(0.975, 2) * 0.03 / np.sqrt(3), rel=1e-3)
    assert not found["coulomb"]["changed"]
    assert alone.document()["joints"][0]["coulomb"]["changed"]


def test_limits_and_their_exit_codes(run: Run, pair: tuple[Path, Path]) -> None:
    assert run("diff", *pair).code == 0
    exceeded = run("diff", *pair, "--fail-on", "joint1.coulomb=10%")
    assert (exceeded.code, "limit exceeded" in exceeded.out) == (5, True)
    assert run("diff", *pair, "--fail-on", "joint1.coulomb=30%").code == 0
    unknown = run("diff", *pair, "--fail-on", "joint2.coulomb=10%")
    assert (unknown.code, "cannot test" in unknown.out) == (7, True)
    assert run("diff", *pair, "--fail-on", "coulomb=10").code == 0
    assert run("diff", *pair, "--fail-on", "friction=1%").code == 2
    nothing = result(pair[0].parent / "zero.json", joint(1, (0.001, 0.02), (0.10, 0.03), 11))
    relative = run("diff", nothing, pair[1], "--fail-on", "coulomb=10%")
    assert (relative.code, "near zero" in relative.out) == (7, True)
    assert run("diff", nothing, pair[1], "--fail-on", "coulomb=0.1").code == 5


def test_two_logs_end_to_end(run: Run, tmp_path: Path) -> None:
    (tmp_path / "before").mkdir()
    higher = ("--set", "joints.coulomb_nm=0.36")
    for name, seed, change in (("before/a", 1, ()), ("before/b", 2, ()), ("after", 3, higher)):
        words = ("simulate", "joint", "-o", f"{name}.csv", "--seed", str(seed), "--duration", "40", *change, "-q")
        assert run(*words).code == 0
    (tmp_path / "before" / "broken.csv").write_text("t,q\n")
    answer = run("diff", "before", "after.csv", "-o", "out", "--json")
    document = answer.document()
    assert answer.code == 6
    assert [one["code"] for one in document["warnings"]] == ["log_left_out"]
    (found,) = document["joints"]
    assert found["coulomb"]["relative_change"]["value"] == pytest.approx(0.2, abs=0.05)
    assert max(found["law"]["speed_rad_s"]) < 3.0
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"diff.json", "diff.csv", "sides.png", "law-change.png"}
    rows = list(csv.DictReader((tmp_path / "out" / "diff.csv").read_text().splitlines()))
    assert [row["coefficient"] for row in rows] == ["coulomb_nm", "viscous_nms_per_rad"]
    assert run("diff", "before", "after.csv", "-o", "out").code == 2
    assert run("estimate", "after.csv", "-o", "results", "-q").code == 0
    same = run("diff", "results", "after.csv", "-q", "--json").document()
    assert [one["code"] for one in same["warnings"]] == ["same_recording"]
    assert same["joints"][0]["coulomb"]["difference_nm"]["value"] == 0.0
    table = run("diff", "before/a.csv", "after.csv")
    assert table.code == 0
    assert max(map(len, table.out.splitlines()[3:7])) <= 100


def test_a_warning_of_both_sides_is_one_line_with_both_names(run: Run, logs: Path) -> None:
    copy = Path("copy.csv")
    copy.write_text((logs / "damaged.csv").read_text())
    assert f"warning: {logs / 'damaged.csv'}, copy.csv: " in run("diff", logs / "damaged.csv", copy).err


def test_conditions_that_differ_are_named(run: Run, tmp_path: Path) -> None:
    one, still = joint(1, (0.3, 0.02), (0.1, 0.03), 20), joint(3, None, None, 0, reason="did not move")
    before = result(tmp_path / "a.json", one, joint(2, (0.3, 0.02), None, 20, reason="moved too little"), still)
    after = result(tmp_path / "b.json", one, still, drive="robot", inertia="model")
    found = {one["code"]: one["joint"] for one in run("diff", before, after, "--json").document()["warnings"]}
    assert found == {"not_comparable": None, "conditions_differ": None, "joint_on_one_side": 2, "not_compared": 3}
    answer = run("diff", before, after)
    assert "drive: hand before, robot after" in answer.err
    assert answer.out.splitlines()[-1] == "not compared: joint 3: did not move"


@pytest.mark.parametrize(("words", "code", "message"), [
    (("a.json", "ampere.json"), 2, "in N m and in A"),
    (("a.json", "seven.json"), 2, "2 and 7 joints"),
    (("a.json", "second.json"), 4, "on both sides; joints that have one: 1 before, 2 after"),
    (("a.json", "none.json"), 4, "moved too little"),
    (("a.json", "regression.json"), 4, "regression"),
    (("a.json", "half.json"), 3, "no whole document"),
    (("a.json", "empty"), 3, "no log there or below"),
    (("a.json", "nowhere.csv"), 3, "nowhere.csv"),
    (("a.json", "model.toml"), 2, "estimate.json"),
])  # fmt: skip
def test_what_cannot_be_compared(words: tuple[str, ...], code: int, message: str, run: Run, tmp_path: Path) -> None:
    one = joint(1, (0.3, 0.02), (0.1, 0.03), 20)
    result(tmp_path / "a.json", one)
    result(tmp_path / "ampere.json", one, unit="A")
    result(tmp_path / "seven.json", one, count=7)
    result(tmp_path / "second.json", one | {"joint": 2})
    result(tmp_path / "none.json", joint(1, None, None, 0, reason="moved too little"))
    result(tmp_path / "regression.json", one | {"method": "regression"})
    (tmp_path / "half.json").write_text(json.dumps({"schema": "friction-audit/estimate/1", "joints": []}))
    (tmp_path / "model.toml").write_text("")
    (tmp_path / "empty").mkdir()
    answer = run("diff", *words, "-o", "out")
    assert (answer.code, message in answer.err) == (code, True), answer
    assert not (tmp_path / "out").exists()


def test_a_recording_that_lost_a_joint_is_compared_by_the_names_of_the_others() -> None:
    whole, lost = (make_session(i, [make_joint(1, 0.3), make_joint(2, 0.4 - 0.1 * i)]) for i in range(2))
    whole = replace(whole, joints=(*whole.joints, make_joint(3, 0.3)), log_joints=3)
    lost = replace(lost, joints=(lost.joints[0], replace(lost.joints[1], name="joint3")), codes=(LOST_JOINT,))
    sides = compare_sides([lost], [whole])
    assert ([joint.joint for joint in sides.joints], sides.one_sided) == ([1, 3], ((2, False),))
    assert sides.joints[1].coefficients[0].found.change.value == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("first", "second", "between"), [(1, 3, 3.0), (3, 3, 1.0), *thorough([(1, 3, 0.0), (1, 5, 1.0)])]
)
def test_the_interval_holds_the_scatter_between_recordings(first: int, second: int, between: float) -> None:
    rng, freedom, runs = np.random.default_rng(5), 20, 200
    known = float(stdtrit(freedom, 0.975))

    def recorded() -> Session:
        value = 10.0 + between * rng.normal() + rng.normal()
        half = known * (rng.chisquare(freedom) / freedom) ** 0.5
        own = make_joint(1, value)
        found = Coefficient(value=value, low=value - half, high=value + half)
        coefficients = {"coulomb_nm": found, "viscous_nms_per_rad": UNDETERMINED}
        return make_session(0, [replace(own, coefficients=coefficients, cycles=freedom + 1)])

    held = 0
    for _ in range(runs):
        sides = compare_sides([recorded() for _ in range(first)], [recorded() for _ in range(second)])
        change = sides.joints[0].coefficients[0].found.change
        held += change.low <= 0.0 <= change.high
    assert held >= 0.92 * runs  # 95 % less two standard errors of this many
