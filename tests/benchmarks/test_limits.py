"""What a log holds of one effect or of two, where it is known by hand."""

import numpy as np
import pytest

from benchmarks.hidden_effects.limits import PRICE, held_by, integral_time, judged, same_times, samples_of, visible
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float
from tests.effects.joint_data_by_hand import moved_joint, started_and_stopped

NOISE_NM = 0.1


def pull(data: JointData) -> Float:
    return np.asarray(0.05 * np.sin(7.0 * data.q))


def test_a_log_holds_n_eff_times_the_square_of_the_strength_and_nothing_of_what_is_absent() -> None:
    samples = samples_of(moved_joint(pull, noise_nm=NOISE_NM), None)
    torques = [samples.rows.of(one) for one in (pull(samples.data), 0.05 * np.sin(0.4 * samples.data.t))]
    here, absent = held_by(samples, torques, 0), held_by(samples, torques, 1)
    n_eff = len(samples.rows.t) / integral_time(samples.residual(*torques), samples.rows)
    assert here == pytest.approx(n_eff * np.mean(torques[0] ** 2) / NOISE_NM**2, rel=0.3)
    assert absent < PRICE < here


def test_of_two_effects_that_run_alike_neither_is_held() -> None:
    samples = samples_of(moved_joint(pull, noise_nm=NOISE_NM), None)
    torque = samples.rows.of(pull(samples.data))
    assert held_by(samples, [torque, 2.0 * torque], 0) == pytest.approx(0.0, abs=1e-6)


def test_the_integral_time_is_that_of_an_autoregressive_noise() -> None:
    rows = samples_of(moved_joint(duration_s=400.0), None).rows
    rng, noise = np.random.default_rng(2), np.zeros(len(rows.t))
    for k in range(1, len(noise)):
        noise[k] = 0.8 * noise[k - 1] + rng.standard_normal()
    assert integral_time(noise, rows) == pytest.approx((1 + 0.8) / (1 - 0.8), rel=0.2)


def test_the_same_times_and_the_same_starts() -> None:
    one, other = (samples_of(started_and_stopped(starts=starts), None, 25.0).rows for starts in (8, 6))
    here, there = same_times(one, other)
    assert np.abs(one.t[here] - other.t[there]).max() < 0.05
    assert len(np.unique(there)) == len(there) == len(here)
    first, second = (rows.breakaway[at] for rows, at in ((one, here), (other, there)))
    assert np.array_equal(first, second)
    assert first.any()


def test_a_pair_is_visible_where_its_log_can_show_and_holds_both() -> None:
    def of(seed: int, holds: float, testable: bool = True) -> dict[str, str]:
        return {"truth": "a+b", "seed": str(seed), "holds": str(holds * PRICE), "testable": str(testable)}

    limits = [of(0, 4.0), of(0, 1.5), of(1, 4.0), of(1, 0.5), of(2, 4.0), of(2, 3.0, testable=False)]
    assert visible(limits) == {("a+b", "0")}
    assert visible(limits, 2.0) == set()


def test_logs_that_hide_effects_of_the_catalogue_are_measured_once() -> None:
    rows = [
        {"truth": "stribeck", "seed": "0", "scales": "0.5"},
        {"truth": "stribeck", "seed": "1", "scales": "-"},
        {"truth": "none", "seed": "2", "scales": ""},
        {"truth": "hum", "seed": "3", "scales": ""},
        *({"truth": "torque_crosstalk", "seed": "4", "scales": "0.2", "joint": str(joint)} for joint in range(1, 8)),
    ]
    assert [(row["truth"], row["seed"]) for row in judged(rows)] == [("stribeck", "0"), ("torque_crosstalk", "4")]
