"""What a log holds of one effect or of two, by hand."""

import numpy as np
import pytest
from friction_audit.diagnosis.ground import make_ground

from benchmarks.hidden_effects.limits import PRICE, held_by, judged, same_moments, summary
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint
from tests.diagnosis.started_and_stopped import started_and_stopped

NOISE_NM = 0.1


def pull(data: JointData) -> Float:
    return np.asarray(0.05 * np.sin(7.0 * data.q))


def wave(data: JointData) -> Float:
    return np.asarray(0.05 * np.sin(0.4 * data.t))


def test_a_log_holds_n_eff_times_the_square_of_the_strength_and_nothing_of_what_is_not_there() -> None:
    data = moved_joint(pull, noise_nm=NOISE_NM)
    ground = make_ground(data, None, 0)
    torques = [ground.rows.of(torque(data)) for torque in (pull, wave)]
    here, absent = held_by(ground, torques, 0), held_by(ground, torques, 1)
    n_eff = len(ground.y) / ground.memory(*(torque[:, None] for torque in torques))
    assert here == pytest.approx(n_eff * np.mean(torques[0] ** 2) / NOISE_NM**2, rel=0.3)
    assert absent < PRICE < here


def test_what_runs_alike_is_held_by_neither() -> None:
    data = moved_joint(pull, noise_nm=NOISE_NM)
    ground = make_ground(data, None, 0)
    torque = ground.rows.of(pull(data))
    assert held_by(ground, [torque, 2.0 * torque], 0) == pytest.approx(0.0, abs=1e-6)


def test_an_effect_alone_is_held_as_beside_one_that_is_not_there() -> None:
    data = moved_joint(pull, noise_nm=NOISE_NM)
    ground = make_ground(data, None, 0)
    torques = [ground.rows.of(torque(data)) for torque in (pull, wave)]
    assert held_by(ground, torques[:1], 0) == pytest.approx(held_by(ground, torques, 0), rel=0.1)


def test_the_same_moments_and_the_same_starts() -> None:
    one = make_ground(started_and_stopped(starts=8), None, 0).rows
    other = make_ground(started_and_stopped(starts=6), None, 0).rows
    here, there = same_moments(one, other)
    assert np.abs(one.t[here] - other.t[there]).max() < 0.05
    assert len(np.unique(there)) == len(there) == len(here)
    starts = [np.isin(np.flatnonzero(rows.used)[at], rows.breakaway_row) for rows, at in ((one, here), (other, there))]
    first, second = starts
    assert np.array_equal(first, second)
    assert first.any()


def test_effects_and_pairs_are_sorted_by_what_their_logs_hold() -> None:
    pairs = [
        {"truth": "stribeck+torque_drift", "seed": str(seed), "sets": sets, "partial": "0.5"}
        for seed, sets in ((0, "stribeck;torque_drift"), (1, "stribeck"), (2, "stribeck"))
    ]
    limits = [
        {"truth": "stribeck+torque_drift", "seed": str(seed), "partial": "0.5", "holds": str(holds),
         "untestable": str(seed == 2 and name == "torque_drift"),
         "in_the_answer": str(name == "stribeck" or seed == 0)}
        for seed, drift in ((0, 1.5 * PRICE), (1, 0.5 * PRICE), (2, 3.0 * PRICE))
        for name, holds in (("stribeck", 4.0 * PRICE), ("torque_drift", drift))
    ]  # fmt: skip
    rows = summary(pairs, limits).splitlines()[2:]
    numbers = [row.split(" | ")[1:] for row in rows]
    assert [(number, share.split(" ")[0]) for number, share in numbers] == [
        ("1", "0"),
        ("1", "0"),
        ("1", "100"),
        ("3", "100"),
        ("1", "100"),
    ]


def alone(seed: int, truth: str, partial: str, **others: str) -> dict[str, str]:
    row = {"truth": truth, "seed": str(seed), "partial": partial, "verdict": "named", "sets": truth, "joint": "1"}
    return row | others


def test_effects_alone_are_sorted_at_the_strength_that_is_asked_for() -> None:
    limits = [
        {"truth": "stribeck", "seed": str(seed), "partial": partial, "holds": str(holds * PRICE), "untestable": "False",
         "in_the_answer": str(told)}
        for seed, partial, holds, told in (
            (0, "0.2", 0.5, False), (5, "0.2", 0.9, True), (10, "0.2", 1.5, False), (15, "0.2", 2.5, True),
            (1, "0.3", 0.5, False),
        )
    ]  # fmt: skip

    def told(strength: float | None) -> list[tuple[str, str]]:
        rows = summary([], limits, strength).splitlines()[2:]
        assert all(row.startswith("| one effect, ") for row in rows)
        return [(number, share.split(" ")[0]) for number, share in (row.split(" | ")[1:] for row in rows)]

    assert told(0.2) == [("0", "-"), ("2", "50"), ("1", "0"), ("1", "100")]
    assert told(None) == [("0", "-"), ("1", "0"), ("0", "-"), ("0", "-")]


def test_rows_that_hold_an_effect_of_the_catalogue_are_judged_in_the_joint_that_hides_it() -> None:
    rows = [
        alone(0, "stribeck", "0.2"),
        alone(1, "stribeck", "0.3"),
        alone(5, "stribeck+torque_bias", "0.2"),
        alone(5, "stribeck", "0.2", verdict=""),
        alone(5, "none", "0.2"),
        alone(5, "hum", "0.2"),
        *(alone(5, "torque_crosstalk", "0.2", joint=str(joint)) for joint in range(1, 8)),
    ]
    assert [row["truth"] for row in judged(rows, 0.2)] == ["stribeck", "stribeck+torque_bias", "torque_crosstalk"]
    assert [row["seed"] for row in judged(rows, None)] == ["1"]
