"""An effect is confirmed where the torque that it predicts is there on locked cycles."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom
from statsmodels.stats.multitest import multipletests

from friction_audit.discrepancy.confirmation import confirm, holm, rms_gain
from friction_audit.discrepancy.ground import Ground, make_ground
from friction_audit.joint_log import Float
from tests.discrepancy.moved_joint import moved_joint

CLEAN = make_ground(moved_joint(noise_nm=0.02, duration_s=40.0), None, 0)
WAVE, LINE = CLEAN.rows.of(np.column_stack([np.cos(3 * CLEAN.data.q), CLEAN.data.q])).T[:, :, None]


def ground_of(missing: Float, seed: int = 0) -> Ground:
    data = moved_joint(noise_nm=0.02, duration_s=40.0, seed=seed)
    return make_ground(replace(data, torque=data.torque + missing), None, 0)


def test_holm_is_that_of_statsmodels() -> None:
    p = np.array([0.01, 0.04, 0.03, 0.5, 0.002])
    assert holm(p) == pytest.approx(multipletests(p, method="holm")[1])


def test_an_effect_of_all_cycles_is_confirmed_and_a_needless_one_is_not() -> None:
    ground = ground_of(0.05 * np.cos(3 * CLEAN.data.q))
    there, needless = confirm(ground, [WAVE, LINE], np.random.default_rng(0)).p_value
    assert there <= 0.002
    assert needless > 0.05


def test_size_and_gain_are_those_of_the_locked_cycles() -> None:
    locked = np.isin(CLEAN.data.cycle, CLEAN.rows.cycle[CLEAN.locked])
    ground = ground_of(0.05 * np.cos(3 * CLEAN.data.q) * np.where(locked, 0.5, 1.0))
    wave = WAVE[CLEAN.locked, 0]
    base = CLEAN.base[CLEAN.locked]
    free = wave - base @ np.linalg.lstsq(base, wave)[0]
    proof = confirm(ground, [WAVE], np.random.default_rng(0))
    assert proof.size == pytest.approx([0.025 * np.sqrt(np.mean(free**2))], rel=0.1)
    # With the factor of the working cycles, twice as large, nothing would seem to be gained.
    assert proof.gain > 0.2


def test_what_is_turned_round_on_the_locked_cycles_is_not_confirmed() -> None:
    locked = np.isin(CLEAN.data.cycle, CLEAN.rows.cycle[CLEAN.locked])
    ground = ground_of(0.05 * np.cos(3 * CLEAN.data.q) * np.where(locked, -1.0, 1.0))
    assert confirm(ground, [WAVE], np.random.default_rng(0)).p_value.tolist() == [1.0]


def test_noise_is_confirmed_no_more_often_than_allowed() -> None:
    p = [confirm(ground_of(np.zeros(1), seed), [WAVE], np.random.default_rng(seed)).p_value[0] for seed in range(40)]
    assert np.sum(np.array(p) <= 0.05) <= binom.ppf(0.999, 40, 0.05)


def test_rms_gain_by_hand() -> None:
    assert rms_gain(4.0, 1.0) == pytest.approx(0.5)
    assert rms_gain(0.0, 0.0) == 0.0
