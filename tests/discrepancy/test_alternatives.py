"""Names that cannot be told apart, the word for a joint, and the smallest effect that would have been seen."""

import numpy as np
import pytest

from friction_audit.discrepancy.alternatives import Naming, Rival, detection_limit, name_effects, verdict, vuong
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


CLEAR = Naming(name="a", rivals=(), alternatives=())
TWOFOLD = Naming(name="a", rivals=(), alternatives=("b",))


@pytest.mark.parametrize(
    ("testable", "first", "remaining", "namings", "word"),
    [
        (0, 0.001, 0.9, (), "not_testable"),
        (9, 0.3, 0.3, (), "none"),
        (9, 0.3, 0.3, (CLEAR,), "none"),
        (9, 0.001, 0.001, (), "unexplained"),
        (9, 0.001, 0.01, (CLEAR,), "unexplained"),
        (9, 0.001, 0.4, (CLEAR,), "named"),
        (9, 0.001, 0.4, (CLEAR, TWOFOLD), "ambiguous"),
    ],
)
def test_the_word_for_a_joint(
    testable: int, first: float, remaining: float, namings: tuple[Naming, ...], word: str
) -> None:
    assert verdict(testable=testable, omnibus_p=first, remaining_p=remaining, alpha=0.05, namings=namings) == word


@pytest.mark.parametrize(("candidates", "needed"), [(12, 17.17), (30, 19.57)])
def test_detection_limit_by_hand(candidates: int, needed: float) -> None:
    sign = np.tile([1.0, -1.0], 500)
    limit = detection_limit(2.0 * sign[:, None], np.ones((1000, 1)), 0.1, 400.0, candidates)
    assert 400 * (2.0 * limit[0] / 0.1) ** 2 == pytest.approx(needed, abs=0.02)


def test_what_the_base_holds_can_never_be_seen() -> None:
    base = np.random.default_rng(0).standard_normal((100, 2))
    assert np.isinf(detection_limit(base @ [[1.0], [2.0]], base, 1.0, 100.0, 12)).all()


def test_an_effect_at_its_detection_limit_is_seen_nine_times_out_of_ten() -> None:
    rng = np.random.default_rng(3)
    w = rng.standard_normal((400, 1))
    base = np.ones((400, 1))
    limit = detection_limit(w, base, 1.0, 400.0, 1)
    free = w[:, 0] - w.mean()
    z = [(free @ (limit[0] * free + rng.standard_normal(400))) / np.sqrt(free @ free) for _ in range(1000)]
    assert np.mean(np.abs(z) > 1.96) == pytest.approx(0.9, abs=0.03)
