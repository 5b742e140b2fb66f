"""Slow noise is known for what it is, and a joint made news is the same joint with a noise that hardly remembers."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.signal import lfilter

from friction_audit.diagnosis.alternatives import Naming
from friction_audit.diagnosis.confirmation import confirm
from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.library import Library, build_library, prewhitened_library
from friction_audit.diagnosis.naming import Names
from friction_audit.diagnosis.ripple_scan import with_scanned_orders
from friction_audit.diagnosis.slow_noise import news_of, prewhitened, slow_noise, told_by_both
from friction_audit.effects.torque_ripple import EFFECT as RIPPLE
from friction_audit.joint_log import Float
from tests.diagnosis.found_effect import found_effect
from tests.diagnosis.moved_joint import TRUTH, moved_joint
from tests.diagnosis.toy_candidates import BUMP

QUIET = moved_joint()
MEMORY_S = 0.1
NOISE_NM = 0.02
ORDER = 33.3


def slow(memory_s: float, seed: int = 3) -> Float:
    """Noise of one memory on the fine grid, of a standard deviation of 1."""
    left = float(np.exp(-QUIET.step_s / memory_s)) if memory_s else 0.0
    noise = lfilter([1.0], [1.0, -left], np.random.default_rng(seed).standard_normal(len(QUIET.t)))
    return np.asarray(noise / noise.std())


def ground_with(torque: Float) -> Ground:
    return make_ground(replace(QUIET, torque=QUIET.torque + torque), None, 0)


def news(ground: Ground, *effects: Float) -> Ground:
    noise = slow_noise(ground, effects)
    assert noise is not None
    return prewhitened(ground, news_of(ground, noise))


SLOW = ground_with(NOISE_NM * slow(MEMORY_S))


def test_a_slow_noise_is_known_by_its_share_and_memory() -> None:
    noise = slow_noise(SLOW, [])
    assert noise is not None
    assert noise.memory * SLOW.rows.step_s == pytest.approx(MEMORY_S, rel=0.4)
    assert noise.share > 0.9
    mixed = slow_noise(ground_with(NOISE_NM * (slow(MEMORY_S) + 1.5 * slow(0.0, seed=4))), [])
    assert mixed is not None
    assert mixed.share < noise.share - 0.03


@pytest.mark.parametrize("memory_s", [0.0, 0.01, 0.025])
def test_a_fast_noise_is_not_slow(memory_s: float) -> None:
    assert slow_noise(ground_with(NOISE_NM * slow(memory_s)), []) is None


def test_where_nothing_is_left_or_no_stretch_is_long_no_noise_is_slow() -> None:
    silent = replace(SLOW, declared=replace(SLOW.declared, y=np.zeros_like(SLOW.y)))
    assert slow_noise(silent, []) is None
    scattered = replace(SLOW, run=np.arange(len(SLOW.run)))
    assert slow_noise(scattered, []) is None


def test_what_is_missing_makes_no_noise_slow_once_it_was_found_or_a_curve_takes_it() -> None:
    missing = 0.1 * np.cos(QUIET.q)
    ground = ground_with(missing + NOISE_NM * slow(0.0))
    assert slow_noise(ground, []) is None
    hum = np.sin(2.0 * np.pi * 0.37 * QUIET.t)
    humming = ground_with(0.1 * hum + NOISE_NM * slow(0.0))
    assert slow_noise(humming, []) is not None
    assert slow_noise(humming, [humming.rows.of(hum)[:, None]]) is None


def test_news_hardly_remember_and_are_no_noisier_than_the_rows() -> None:
    fast = news(SLOW)
    assert fast.memory() < 0.5 * SLOW.memory()
    assert 0.5 * np.std(SLOW.residual()) < np.std(fast.residual()) < np.std(SLOW.residual())


def test_every_column_is_news_as_the_torque_is() -> None:
    fast = news(SLOW)
    assert_allclose(fast.y, fast.rows.of(fast.data.torque), rtol=1e-6, atol=1e-12)
    noise = NOISE_NM * slow(MEMORY_S)
    assert_allclose(fast.residual(fast.rows.of(noise)[:, None]), 0.0, atol=1e-9)
    for curve, own in zip(fast.curves, SLOW.curves, strict=True):
        assert curve.values is own.values


def test_friction_that_jumps_at_reversals_is_known_better_from_news() -> None:
    grounds = [ground_with(NOISE_NM * slow(MEMORY_S, seed)) for seed in range(8)]
    coulomb = np.array([[one.baseline().coulomb_nm for one in (ground, news(ground))] for ground in grounds])
    plain, fast = np.sqrt(np.mean((coulomb - TRUTH["coulomb_nm"]) ** 2, axis=0))
    assert fast < 0.85 * plain


def test_locked_rows_are_no_news_of_working_ones() -> None:
    noise = slow_noise(SLOW, [])
    assert noise is not None
    steps = news_of(SLOW, noise)
    spoilt = SLOW.y + np.where(SLOW.locked, 5.0, 0.0)
    assert SLOW.locked.any()
    assert np.array_equal(steps.of(spoilt)[SLOW.working], steps.of(SLOW.y)[SLOW.working])


def test_an_effect_that_slow_noise_hides_stands_out_of_news() -> None:
    hidden = 0.004 * np.cos(ORDER * QUIET.q)
    ground = ground_with(hidden + NOISE_NM * slow(MEMORY_S))
    column = np.column_stack([np.cos(ORDER * QUIET.q), np.sin(ORDER * QUIET.q)])
    seen = [
        float(confirm(one, [one.rows.of(column)], np.random.default_rng(0)).evidence[0])
        for one in (ground, news(ground))
    ]
    assert seen[1] > 3.0 * seen[0]


EMPTY = Library(entries=(), untestable={})


def named(ground: Ground, order: float) -> Names:
    """A ripple of one order as it is found in the news of a joint."""
    found = found_effect(news(ground), RIPPLE, {"ripple_order": order})
    return Names(found=(found,), library=EMPTY, baseline=ground.baseline())


def nothing(ground: Ground) -> Names:
    return Names(found=(), library=EMPTY, baseline=ground.baseline())


RIPPLING = ground_with(0.01 * np.cos(ORDER * QUIET.q) + NOISE_NM * slow(MEMORY_S))


def test_what_the_rows_tell_too_stays_with_its_columns_on_them() -> None:
    (kept,) = told_by_both(RIPPLING, EMPTY, nothing(RIPPLING), named(RIPPLING, ORDER)).found
    column = RIPPLE.regressor(RIPPLING.data, RIPPLING.baseline(), {"ripple_order": ORDER})
    assert kept.columns == pytest.approx(RIPPLING.rows.of(column))


def test_what_the_rows_do_not_tell_is_no_name_of_news() -> None:
    orders = np.linspace(20.0, 60.0, 40)
    kept = [len(told_by_both(SLOW, EMPTY, nothing(SLOW), named(SLOW, order)).found) for order in orders]
    assert sum(kept) <= 3  # one time in a hundred by chance


@pytest.mark.parametrize("instead", [(), (BUMP.name,)])
def test_what_is_no_news_stands_beside_it_unless_that_may_be_it(instead: tuple[str, ...]) -> None:
    place = 0.05 * np.exp(-(((QUIET.q - 0.2) / 0.2) ** 2))
    ground = ground_with(place + 0.02 * np.cos(ORDER * QUIET.q) + NOISE_NM * slow(MEMORY_S))
    plain = replace(nothing(ground), found=(found_effect(ground, BUMP, {"place_rad": 0.2, "width_rad": 0.2}),))
    (ripple,) = named(ground, ORDER).found
    either = replace(ripple, naming=Naming(name=RIPPLE.name, rivals=(), alternatives=instead))
    kept = told_by_both(ground, EMPTY, plain, replace(plain, found=(either,))).found
    assert [f.candidate.name for f in kept] == [RIPPLE.name, *([] if instead else [BUMP.name])]


def test_names_of_both_have_the_whole_library() -> None:
    whole = ripples(RIPPLING)
    names = told_by_both(RIPPLING, whole, nothing(RIPPLING), named(RIPPLING, ORDER))
    assert names.library is whole


def test_without_a_name_of_news_the_others_stay_as_they_are() -> None:
    plain = replace(nothing(SLOW), found=(found_effect(SLOW, BUMP, {"place_rad": 0.2, "width_rad": 0.2}),))
    assert told_by_both(SLOW, EMPTY, plain, nothing(SLOW)) is plain


def ripples(ground: Ground) -> Library:
    return build_library((RIPPLE,), ground.data, ground.baseline(), ground.rows)


def test_a_library_is_news_of_its_columns() -> None:
    fast = news(SLOW)
    assert fast.rows.prewhitening is not None
    made, built = prewhitened_library(ripples(SLOW), fast.rows.prewhitening), ripples(fast)
    for one, other in zip(made.entries[0].columns, built.entries[0].columns, strict=True):
        assert_allclose(one, other, rtol=0.0, atol=1e-9)


def test_a_scan_of_news_finds_the_order_that_is_there() -> None:
    fast = news(ground_with(0.02 * np.cos(ORDER * QUIET.q) + NOISE_NM * slow(MEMORY_S)))
    library = ripples(fast)
    before = len(library.entries[0].shapes)
    orders = [shape["ripple_order"] for shape in with_scanned_orders(fast, library).entries[0].shapes[before:]]
    assert min(abs(order - ORDER) for order in orders) < 0.3
