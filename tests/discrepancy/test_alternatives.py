"""Names that cannot be told apart."""

import numpy as np
import pytest

from friction_audit.discrepancy.alternatives import Naming, Rival, name_effects, vuong
from friction_audit.discrepancy.search import Group, cycle_products, search

CYCLES = np.repeat(np.arange(20), 100)


def named(noise: float, *, alike: float = 0.9, same_as: dict[str, tuple[str, ...]] | None = None) -> Naming:
    """An effect, a near copy of it (correlation 0.95) and a stranger."""
    rng = np.random.default_rng(0)
    effect, other, stranger, e = rng.standard_normal((4, 2000))
    near = 0.95 * effect + np.sqrt(1 - 0.95**2) * other
    groups = [
        Group(name=n, shapes=(w[:, None],)) for n, w in (("effect", effect), ("near", near), ("stranger", stranger))
    ]
    products = cycle_products(effect + noise * e, np.ones((2000, 1)), groups, CYCLES)
    found = search(products, 2000.0)
    (naming,) = name_effects(products, found, 2000.0, same_as or {}, alike=alike)
    return naming


def test_a_near_copy_is_beaten_where_the_effect_is_large() -> None:
    naming = named(noise=2.0)
    assert (naming.name, naming.alternatives) == ("effect", ())
    near = next(r for r in naming.rivals if r.name == "near")
    assert near.correlation == pytest.approx(0.95, abs=0.01)
    assert near.delta_bic > 6
    assert near.vuong_z > 2


def test_a_near_copy_is_an_alternative_where_the_effect_is_small_and_a_stranger_is_not() -> None:
    naming = named(noise=8.0)
    assert {naming.name, *naming.alternatives} == {"effect", "near"}


def test_delta_bic_by_hand() -> None:
    rng = np.random.default_rng(1)
    a, b, e = rng.standard_normal((3, 2000))
    groups = [Group(name=n, shapes=(w[:, None],)) for n, w in (("a", a), ("b", b))]
    y = 0.3 * a + e
    products = cycle_products(y, np.ones((2000, 1)), groups, CYCLES)
    (naming,) = name_effects(products, search(products, 500.0), 500.0, {})
    rss = [np.linalg.lstsq(np.column_stack([np.ones(2000), w]), y, rcond=None)[1][0] for w in (a, b)]
    assert naming.rivals[0].delta_bic == pytest.approx(500 * np.log(rss[1] / rss[0]))


def test_names_that_are_the_same_always_belong_to_the_set() -> None:
    assert named(noise=2.0, same_as={"effect": ("twin",)}).alternatives == ("twin",)


def test_vuong_by_hand_changes_sign_with_the_models_and_is_0_between_equals() -> None:
    samples = np.full(4, 100.0)
    first, second = np.array([90.0, 100.0, 95.0, 115.0]), np.array([100.0, 105.0, 110.0, 125.0])
    s1, s2 = first.sum() / 400, second.sum() / 400
    d = 50 * np.log(s2 / s1) + second / (2 * s2) - first / (2 * s1)
    assert vuong(first, second, samples, 400.0) == pytest.approx(d.sum() / (2 * d.std(ddof=1)))
    assert vuong(second, first, samples, 400.0) == pytest.approx(-vuong(first, second, samples, 400.0))
    assert vuong(first, first, samples, 400.0) == 0.0
    assert vuong(first, second, samples, 400.0, extra_columns=1) < vuong(first, second, samples, 400.0)


def test_the_rule_may_ask_for_both_tests() -> None:
    rival = Rival(name="x", shape=0, delta_bic=7.0, correlation=0.95, vuong_z=1.0)
    assert rival.beaten()
    assert not rival.beaten(1.64)
