"""What a joint is judged on: whole cycles locked away, fits on the others, the memory of the noise."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from friction_audit.diagnosis.declared import least_squares
from friction_audit.diagnosis.ground import make_ground
from friction_audit.diagnosis.rows import LOWEST_CORNER_HZ
from friction_audit.effects.joint_data import CORNER_HZ
from friction_audit.errors import AnalysisError
from tests.diagnosis.moved_joint import INERTIA_KG_M2, TRUTH, moved_joint

NOISY = make_ground(moved_joint(noise_nm=0.02), None, 0)


def test_whole_cycles_are_locked_away_and_the_same_again() -> None:
    working, locked = (set(NOISY.rows.cycle[which]) for which in (NOISY.working, NOISY.locked))
    assert not working & locked
    assert len(locked) >= 0.3 * len(working | locked)
    assert np.array_equal(make_ground(NOISY.data, None, 0).working, NOISY.working)
    assert not np.array_equal(make_ground(NOISY.data, None, 1).working, NOISY.working)


def test_locked_rows_do_not_enter_a_fit() -> None:
    bump = np.where(np.isin(NOISY.data.cycle, NOISY.rows.cycle[NOISY.locked]), 5.0, 0.0)
    spoilt = make_ground(replace(NOISY.data, torque=NOISY.data.torque + bump * NOISY.data.dq), None, 0)
    before, after = NOISY.baseline(), spoilt.baseline()
    # Only what the filter carries over from one cycle to the next.
    assert after.coulomb_nm == pytest.approx(before.coulomb_nm, abs=0.02)
    assert np.sqrt(np.mean(spoilt.residual()[spoilt.locked] ** 2)) > 1.0


def test_the_noise_is_what_the_exact_model_leaves() -> None:
    assert make_ground(moved_joint(), None, 0).residual() == pytest.approx(0.0, abs=1e-9)
    assert np.std(NOISY.residual()) == pytest.approx(0.02, rel=0.05)
    found = NOISY.baseline()
    assert found.coulomb_nm == pytest.approx(TRUTH["coulomb_nm"], rel=0.02)
    assert found.inertia_kg_m2 == pytest.approx(TRUTH["inertia_kg_m2"], rel=0.02)


def test_an_effect_takes_its_part_of_the_residual_on_both_grids() -> None:
    ground = make_ground(moved_joint(lambda data: 0.1 * np.cos(3 * data.q)), None, 0)
    fine = np.cos(3 * ground.data.q)[:, None]
    column = ground.rows.of(fine)
    assert np.std(ground.residual()) > 0.03
    assert ground.residual(column) == pytest.approx(0.0, abs=1e-9)
    assert ground.fine_residual([column], [fine]) == pytest.approx(0.0, abs=1e-9)
    assert ground.baseline(column).coulomb_nm == pytest.approx(TRUTH["coulomb_nm"])


def test_residual_by_hand() -> None:
    w = NOISY.working
    by_hand = NOISY.y - NOISY.base @ least_squares(NOISY.base[w], NOISY.y[w])
    assert NOISY.residual() == pytest.approx(by_hand)


@pytest.mark.parametrize("memory", [0.0, 0.95, 0.98])
def test_memory_is_that_of_the_noise(memory: float) -> None:
    white = np.random.default_rng(3).standard_normal(len(NOISY.data.t))
    noise = lfilter([1.0], [1.0, -memory], white)
    ground = make_ground(replace(NOISY.data, torque=moved_joint().torque + 0.02 * noise / noise.std()), None, 0)
    # Of an AR(1) at 400 Hz in rows at 100 Hz; the filter at 25 Hz alone makes two rows of white noise worth one.
    known = max((1 + memory) / (1 - memory) / 4, 2.0)
    assert ground.memory() == pytest.approx(known, rel=0.35)


def test_an_effect_that_is_missing_does_not_lengthen_the_memory() -> None:
    slow = make_ground(moved_joint(lambda data: 0.2 * np.cos(data.q), noise_nm=0.02), None, 0)
    assert slow.memory() < 2 * NOISY.memory()


def test_curves_shorten_the_memory_of_slow_noise_and_the_longest_one_is_without_them() -> None:
    white = np.random.default_rng(3).standard_normal(len(NOISY.data.t))
    noise = lfilter([1.0], [1.0, -0.98], white)
    ground = make_ground(replace(NOISY.data, torque=moved_joint().torque + 0.02 * noise / noise.std()), None, 0)
    known = (1 + 0.98) / (1 - 0.98) / 4
    assert ground.memory() < 0.9 * ground.longest_memory()
    assert ground.longest_memory() == pytest.approx(known, rel=0.35)
    wave = ground.rows.of(np.cos(3 * ground.data.q)[:, None])
    assert ground.longest_memory(wave) == pytest.approx(ground.longest_memory(), rel=0.1)


def test_the_corner_comes_down_where_inertia_is_noisy() -> None:
    assert NOISY.rows.corner_hz == CORNER_HZ
    rng = np.random.default_rng(4)
    ddq = NOISY.data.ddq + 3.0 * np.gradient(rng.standard_normal(len(NOISY.data.t)))
    loud = make_ground(replace(NOISY.data, ddq=ddq), None, 0)
    assert INERTIA_KG_M2 * 3.0 > 0.02
    assert LOWEST_CORNER_HZ <= loud.rows.corner_hz < CORNER_HZ


def test_three_cycles_are_refused() -> None:
    short = moved_joint(duration_s=5.0)
    few = replace(short, cycle=np.minimum(short.cycle, 2))
    with pytest.raises(AnalysisError, match="3 cycles"):
        make_ground(few, None, 0)
