"""The same joint written down otherwise has the same diagnosis: other units of torque, a turned axis, other zeros."""

from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from friction_audit.api import diagnose_log, estimate_log
from friction_audit.diagnosis.result import JointDiagnosis
from friction_audit.io.readers import read_log
from friction_audit.joint_log import Float
from tests.effects.joint_data_by_hand import STROKES, sines

Columns = dict[str, Float]

RATE_HZ, DURATION_S = 500.0, 40.0
COUNT_RAD = 2.0**-17
CANDIDATES = ("stribeck", "presliding", "cable_spring", "gravity_error", "time_delay")


def rising(dq: Float) -> Float:
    return np.asarray(np.sign(dq) * np.exp(-((dq / 0.1) ** 2)))


@cache
def columns() -> Columns:
    """Strokes of three sines, with more friction at low speed."""
    t = np.arange(0.0, DURATION_S, 1.0 / RATE_HZ)
    q, dq, ddq = sines(t, *STROKES)
    friction = 0.3 * np.sign(dq) + 0.15 * rising(dq) + 0.1 * dq
    noise = 0.02 * np.random.default_rng(5).standard_normal(len(t))
    return {"t": t, "q_1": np.round(q / COUNT_RAD) * COUNT_RAD, "dq_1": dq, "tau_1": 0.2 * ddq + friction + noise}


def diagnosed_all(log: Columns, folder: Path) -> tuple[JointDiagnosis, ...]:
    path = folder / "log.csv"
    np.savetxt(path, np.column_stack(list(log.values())), "%.17g", ",", header=",".join(log), comments="")
    return diagnose_log(estimate_log(read_log(path), gravity="removed"), candidates=CANDIDATES).joints


def diagnosed(log: Columns, folder: Path) -> JointDiagnosis:
    (found,) = diagnosed_all(log, folder)
    return found


@pytest.fixture(scope="module")
def as_written(tmp_path_factory: pytest.TempPathFactory) -> JointDiagnosis:
    return diagnosed(columns(), tmp_path_factory.mktemp("as_written"))


def heavier(log: Columns, factor: float) -> Columns:
    return {**log, "tau_1": factor * log["tau_1"]}


def turned_far_round(log: Columns) -> Columns:
    """Turned, another zero, columns in another order."""
    return {"tau_1": -log["tau_1"], "dq_1": -log["dq_1"], "t": log["t"], "q_1": 2.0**7 - log["q_1"]}


def by_the_wall_clock(log: Columns) -> Columns:
    return {**log, "t": log["t"] + 1.7e9}


def numbers(found: Any, factor: float) -> dict[str, float]:
    """All numbers told of a joint, those that are torques as if they were those of the joint as written."""
    told = {name: one.value for effect in found.effects for name, one in effect.parameters.items()}
    told |= {name: one.value for name, one in found.nominal.items()}
    told |= {"gap_before_nm": found.gap.before, "gap_after_nm": found.gap.after}
    return {name: value / (factor if "_nm" in name or "_kg" in name else 1.0) for name, value in told.items()}


def test_repeats_of_lost_samples_change_nothing(as_written: JointDiagnosis, tmp_path: Path) -> None:
    """A recorder that stalls repeats a sample; where that sample is lost, nothing shows the repeat but the motion."""
    log = {name: column.copy() for name, column in columns().items()}
    repeats = np.sort(np.random.default_rng(1).choice(np.arange(2, len(log["t"]), 2), 100, replace=False))
    for name in log.keys() - {"t"}:
        log[name][repeats] = log[name][repeats - 1]
    found = diagnosed({name: np.delete(column, repeats - 1) for name, column in log.items()}, tmp_path)
    assert (found.verdict, [effect.name for effect in found.effects]) == ("named", ["stribeck"])
    assert found.gap is not None
    assert as_written.gap is not None
    assert found.gap.after == pytest.approx(as_written.gap.after, rel=0.02)


def test_rests_that_prevail_change_nothing(tmp_path: Path) -> None:
    """Positions of uneven moments are noisier than the velocity in motion, and quieter at rest."""
    log, rng = columns(), np.random.default_rng(7)
    moving = {**log, "q_1": log["q_1"] + 2e-4 * rng.standard_normal(len(log["t"])) * log["dq_1"]}
    moving["dq_1"] = log["dq_1"] + 2e-3 * rng.standard_normal(len(log["t"]))
    rest = {"t": log["t"] + DURATION_S, "q_1": np.full_like(log["t"], moving["q_1"][-1])}
    rest |= {name: noise * rng.standard_normal(len(log["t"])) for name, noise in (("dq_1", 2e-3), ("tau_1", 0.02))}
    late = {name: column if name != "t" else column + DURATION_S for name, column in rest.items()}
    both = {name: np.concatenate([column, rest[name], late[name]]) for name, column in moving.items()}
    alone, rested = diagnosed(moving, tmp_path), diagnosed(both, tmp_path)
    assert [effect.name for effect in rested.effects] == [effect.name for effect in alone.effects] == ["stribeck"]
    assert rested.gap is not None
    assert alone.gap is not None
    # The corner of the low-pass is that of other noise; by the position's noise at rest it is 26 times as much.
    assert rested.gap.after == pytest.approx(alone.gap.after, rel=0.25)


def test_half_of_the_rate_has_the_same_names_and_nearly_the_same_numbers(
    as_written: JointDiagnosis, tmp_path: Path
) -> None:
    found = diagnosed({name: column[::2] for name, column in columns().items()}, tmp_path)
    assert (found.verdict, [effect.name for effect in found.effects]) == ("named", ["stribeck"])
    for name, number in as_written.effects[0].parameters.items():
        other = found.effects[0].parameters[name]
        assert other.low <= number.high
        assert number.low <= other.high


def test_a_clean_first_joint_changes_nothing_of_the_second(as_written: JointDiagnosis, tmp_path: Path) -> None:
    log = columns()
    clean = {"q_1": log["q_1"], "dq_1": log["dq_1"], "tau_1": log["tau_1"] - 0.15 * rising(log["dq_1"])}
    second = {f"{name[:-1]}2": log[name] for name in clean}
    adequate, lacking = diagnosed_all({"t": log["t"]} | clean | second, tmp_path)
    assert (lacking.verdict, adequate.verdict) == (as_written.verdict, "adequate")
    assert numbers(lacking, 1.0) == pytest.approx(numbers(as_written, 1.0), rel=1e-6)


@pytest.mark.parametrize(
    ("change", "factor", "close"),
    [
        (partial(heavier, factor=2.0**-7), 2.0**-7, 1e-3),
        pytest.param(partial(heavier, factor=2.0**7), 2.0**7, 1e-3, marks=pytest.mark.thorough),
        (turned_far_round, 1.0, 1e-3),
        # Stamps of today are rounded to 0.2 us: a cycle may begin a sample sooner.
        (by_the_wall_clock, 1.0, 2e-2),
    ],
)
def test_a_joint_written_down_otherwise_has_the_same_diagnosis(
    as_written: JointDiagnosis, change: Callable[[Columns], Columns], factor: float, close: float, tmp_path: Path
) -> None:
    found = diagnosed(change(columns()), tmp_path)
    assert [effect.name for effect in as_written.effects] == ["stribeck"]
    assert found.verdict == as_written.verdict
    assert [effect.name for effect in found.effects] == [effect.name for effect in as_written.effects]
    assert [effect.alternatives for effect in found.effects] == [one.alternatives for one in as_written.effects]
    assert numbers(found, factor) == pytest.approx(numbers(as_written, 1.0), rel=close)
