"""An effect is confirmed where the torque that it predicts is there on locked cycles."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom, norm
from statsmodels.stats.multitest import multipletests

from friction_audit.diagnosis import confirmation
from friction_audit.diagnosis.confirmation import Confirmed, confirm, holm, rms_gain
from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import moved_joint

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


def test_a_curve_that_is_hardly_bent_is_confirmed_by_its_bend() -> None:
    ground = ground_of(0.05 * np.cos(3 * CLEAN.data.q))
    hardly_bent = WAVE + 1e5 * CLEAN.base[:, [1]]
    assert confirm(ground, [hardly_bent], np.random.default_rng(0)).p_value <= 0.002


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


@pytest.mark.parametrize(("there", "misleads"), [(1.0, False), (0.6, False), (0.3, True), (0.0, True)])
def test_a_prediction_that_makes_locked_cycles_worse_misleads(there: float, misleads: bool) -> None:
    """What is left goes with (1 - there)^2 where the effect is predicted, with there^2 where it is not."""
    locked = np.isin(CLEAN.data.cycle, CLEAN.rows.cycle[CLEAN.locked])
    ground = ground_of(0.1 * np.cos(3 * CLEAN.data.q) * np.where(locked, there, 1.0))
    proof = confirm(ground, [WAVE], np.random.default_rng(0))
    assert proof.misleads.tolist() == [misleads]
    assert (float(proof.cost[0]) < 0.0) is not misleads


@pytest.mark.parametrize(
    ("p_value", "gain", "evidence", "gain_of_all", "again", "proven", "shown"),
    [
        (0.04, 0.01, 0.0, 0.0, 1.0, True, False),  # proven where nothing was chosen
        (0.04, 0.004, 0.0, 0.01, 1.0, False, False),  # too small there, and all cycles do not pay its price
        (0.19, 0.001, 12.1, 0.01, 0.6, False, True),  # all pay, and the locked ones do not object
        (0.21, 0.001, 12.1, 0.01, 1.0, False, False),  # they do
        (0.11, 0.001, 20.0, 0.01, 1.0, False, True),  # z of 1.2 for 2.4: one time in nine
        (0.11, 0.001, 50.0, 0.01, 1.0, False, False),  # z of 1.2 for 3.9: hardly ever
        (0.09, 0.001, 50.0, 0.01, 1.0, False, True),  # signs of few clusters tell no better
        (0.19, 0.001, 11.9, 0.01, 1.0, False, False),  # not worth its price
        (0.09, 0.001, 50.0, 0.004, 1.0, False, False),  # too small for a word
        (0.09, 0.001, 50.0, 0.01, 0.4, False, False),  # what was predicted makes the locked cycles worse
    ],
)
def test_locked_cycles_prove_or_all_pay(
    p_value: float, gain: float, evidence: float, gain_of_all: float, again: float, proven: bool, shown: bool
) -> None:
    one = np.array([[p_value], [gain], [0.01], [evidence], [gain_of_all], [again]])
    proof = Confirmed(
        p_value=one[0],
        gain=one[1],
        size=one[2],
        evidence=one[3],
        least_evidence=one[3],
        expected=0.3 * one[3],
        gain_of_all=one[4],
        factors=(np.ones(1),),
        tolerated=(np.ones(1),),
        again=one[5],
        doubt=one[0],
        cost=np.zeros(1),
    )
    assert proof.proven(0.05).tolist() == [proven]
    assert proof.shown(np.array([12.0])).tolist() == [shown]


def test_evidence_counts_all_cycles_beside_the_other_effects() -> None:
    ground = ground_of(0.01 * np.cos(3 * CLEAN.data.q))
    proof = confirm(ground, [WAVE, LINE], np.random.default_rng(0))
    fits = [np.linalg.lstsq(np.hstack([ground.base, *some]), ground.y) for some in ([LINE], [WAVE, LINE])]
    left = [fit[1][0] for fit in fits]
    n_eff = len(ground.y) / ground.memory(WAVE, LINE)
    assert proof.evidence[0] == pytest.approx(n_eff * np.log(left[0] / left[1]))
    assert proof.gain_of_all[0] == pytest.approx(1.0 - np.sqrt(left[1] / left[0]))
    assert np.concatenate(proof.factors) == pytest.approx(fits[1][0][-2:])


@pytest.mark.parametrize("there", [1.0, 0.7, 0.0])
def test_factors_move_towards_those_of_the_working_cycles_by_what_chance_allows(there: float) -> None:
    locked = np.isin(CLEAN.data.cycle, CLEAN.rows.cycle[CLEAN.locked])
    ground = ground_of(0.1 * np.cos(3 * CLEAN.data.q) * np.where(locked, there, 1.0))
    proof = confirm(ground, [WAVE], np.random.default_rng(0))
    columns, w = np.hstack([ground.base, WAVE]), ground.working
    working = np.linalg.lstsq(columns[w], ground.y[w])[0][-1]
    every, near = proof.factors[0][0], proof.tolerated[0][0]
    torques = [ground.y - factor * WAVE[:, 0] for factor in (every, near)]
    left = [float(np.linalg.lstsq(ground.base, torque)[1][0]) for torque in torques]
    cost = len(ground.y) / ground.memory(WAVE) * np.log(left[1] / left[0])
    if there == 1.0:
        assert near == pytest.approx(working)
        assert cost < confirmation.WORSE_BY_CHANCE
    else:
        assert min(every, working) < near < max(every, working)
        assert cost == pytest.approx(confirmation.WORSE_BY_CHANCE)


def rare(ground: Ground, cycles: int, *, locked: bool) -> tuple[Float, Float]:
    """The wave in a few cycles only, on the rows, shape (m, 1), and on the fine grid, shape (n,)."""
    kind = ground.locked if locked else ground.working
    chosen = np.unique(ground.rows.cycle[kind])[-cycles:]
    return WAVE * np.isin(ground.rows.cycle, chosen)[:, None], np.isin(ground.data.cycle, chosen).astype(float)


def test_of_what_no_locked_cycle_holds_each_cycle_is_predicted_from_the_others() -> None:
    columns, there = rare(CLEAN, 5, locked=False)
    ground = ground_of(0.05 * np.cos(3 * CLEAN.data.q) * there)
    proof = confirm(ground, [columns], np.random.default_rng(0))
    assert proof.p_value == pytest.approx([1.0])
    assert proof.again == pytest.approx([1.0], abs=0.2)
    assert proof.shown(np.array([20.0])).tolist() == [True]
    assert proof.size[0] > 0.005
    # In one cycle only it follows from no other one.
    alone, there = rare(CLEAN, 1, locked=False)
    once = confirm(ground_of(0.2 * np.cos(3 * CLEAN.data.q) * there), [alone], np.random.default_rng(0))
    assert once.evidence[0] > 20.0
    assert once.shown(np.array([20.0])).tolist() == [False]


def test_beside_many_wide_effects_there_are_clusters_left_to_test() -> None:
    columns, there = rare(CLEAN, 5, locked=False)
    ground = ground_of(0.05 * np.cos(3 * CLEAN.data.q) * there)
    needless = np.random.default_rng(1).standard_normal((6, len(ground.y), 8))
    clusters = len(np.unique(ground.clusters(np.ones_like(ground.working)).number))
    assert clusters < 6 * 8 + ground.base.shape[1] + 1
    proof = confirm(ground, [columns, *needless], np.random.default_rng(0))
    assert proof.shown(np.full(7, 20.0)).tolist() == [True, *6 * [False]]


def test_of_what_few_locked_cycles_hold_the_rows_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(confirmation, "FEWEST_LIVELY", np.inf)
    ground = ground_of(0.01 * np.cos(3 * CLEAN.data.q))
    proof = confirm(ground, [WAVE], np.random.default_rng(0))
    told = -2.0 * float(ground.locked.sum()) / ground.memory(WAVE) * np.log(1.0 - proof.gain)
    assert proof.doubt == pytest.approx(norm.sf(np.sqrt(told)))


def test_noise_is_confirmed_no_more_often_than_allowed() -> None:
    p = [confirm(ground_of(np.zeros(1), seed), [WAVE], np.random.default_rng(seed)).p_value[0] for seed in range(40)]
    assert np.sum(np.array(p) <= 0.05) <= binom.ppf(0.999, 40, 0.05)


def test_rms_gain_by_hand() -> None:
    assert rms_gain(4.0, 1.0) == pytest.approx(0.5)
    assert rms_gain(0.0, 0.0) == 0.0


def test_least_evidence_counts_as_few_samples_as_the_longest_memory_allows() -> None:
    ground = ground_of(0.01 * np.cos(3 * CLEAN.data.q))
    proof = confirm(ground, [WAVE], np.random.default_rng(0))
    shorter = ground.memory(WAVE) / ground.longest_memory(WAVE)
    assert shorter <= 1.0
    assert proof.least_evidence == pytest.approx(shorter * proof.evidence)
