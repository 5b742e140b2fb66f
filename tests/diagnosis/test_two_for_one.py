"""Pairs of simple effects that one name may stand for."""

import numpy as np

from friction_audit.diagnosis.alternatives import name_effects
from friction_audit.diagnosis.cross_products import CrossProducts, cross_products
from friction_audit.diagnosis.groups import Group
from friction_audit.diagnosis.ranking import Ranking
from friction_audit.diagnosis.search import result_of
from friction_audit.diagnosis.two_for_one import two_for_one
from friction_audit.joint_log import Float

T = np.linspace(0.0, 60.0, 4000)
SINE = 0.6 * np.sin(1.7 * T)
TWO_SINES = 0.5 * np.sin(1.7 * T) + 0.3 * np.sin(4.1 * T)


def acceleration(q: Float) -> Float:
    return np.asarray(np.gradient(np.gradient(q, T), T))


def seen_with(q: Float, torque: Float) -> CrossProducts:
    """A weight of two numbers, an offset, a wrong inertia and a slope over time, held against a torque and noise."""
    noise = 0.1 * np.random.default_rng(3).standard_normal(len(T))
    columns = {
        "weight": np.column_stack([np.cos(q), np.sin(q)]),
        "offset": np.ones((len(T), 1)),
        "inertia": acceleration(q)[:, None],
        "slope": T[:, None] - 30.0,
    }
    base = np.gradient(q, T)[:, None]
    return cross_products(torque + noise, base, [Group(name=n, shapes=(c,)) for n, c in columns.items()])


def pairs(products: CrossProducts, unit: int = 0) -> tuple[tuple[str, str], ...]:
    return two_for_one(Ranking(products, 1000.0), [unit], unit, 6.0)


def test_on_one_sinusoid_a_weight_may_be_an_offset_and_a_wrong_inertia() -> None:
    assert pairs(seen_with(SINE, 0.1 - 0.05 * acceleration(SINE))) == (("offset", "inertia"),)


def test_on_two_sinusoids_it_is_not_and_a_weight_over_a_wide_span_neither() -> None:
    assert pairs(seen_with(TWO_SINES, 0.3 * np.cos(TWO_SINES) + 0.3 * np.sin(TWO_SINES))) == ()
    wide = 2.0 * SINE
    assert pairs(seen_with(wide, 0.5 * np.cos(wide) + 0.5 * np.sin(wide))) == ()


def test_both_of_a_pair_are_needed() -> None:
    """An offset alone runs like this weight: with anything else it is no other answer than that."""
    assert pairs(seen_with(SINE, np.full(len(T), 0.3))) == ()


def test_one_number_stands_for_no_two() -> None:
    assert pairs(seen_with(SINE, 0.1 - 0.05 * acceleration(SINE)), unit=1) == ()


def test_names_of_a_pair_are_alternatives_that_are_told_together() -> None:
    products = seen_with(SINE, 0.1 - 0.05 * acceleration(SINE))
    (naming,) = name_effects(products, result_of(Ranking(products, 1000.0), [0]), 1000.0, {})
    assert set(naming.alternatives) == {"offset", "inertia"}
    assert naming.together == (("offset", "inertia"),)
