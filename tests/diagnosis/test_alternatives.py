"""Names that cannot be told apart."""

import numpy as np
import pytest

from friction_audit.diagnosis.alternatives import Naming, Rival, name_effects, preferred, with_wholes
from friction_audit.diagnosis.cross_products import cross_products
from friction_audit.diagnosis.evidence import evidence
from friction_audit.diagnosis.groups import Group
from friction_audit.diagnosis.ranking import Ranking
from friction_audit.diagnosis.search import result_of, search
from friction_audit.joint_log import Float


def named(noise: float, *, same_as: dict[str, tuple[str, ...]] | None = None) -> Naming:
    """An effect, a near copy of it (correlation 0.95) and a stranger."""
    rng = np.random.default_rng(0)
    effect, other, stranger, e = rng.standard_normal((4, 2000))
    near = 0.95 * effect + np.sqrt(1 - 0.95**2) * other
    groups = [
        Group(name=n, shapes=(w[:, None],)) for n, w in (("effect", effect), ("near", near), ("stranger", stranger))
    ]
    products = cross_products(effect + noise * e, np.ones((2000, 1)), groups)
    found = search(products, 2000.0)
    (naming,) = name_effects(products, found, 2000.0, same_as or {})
    return naming


def test_a_near_copy_is_beaten_where_the_effect_is_large() -> None:
    naming = named(noise=2.0)
    assert (naming.name, naming.alternatives) == ("effect", ())
    near = next(r for r in naming.rivals if r.name == "near")
    assert near.correlation == pytest.approx(0.95, abs=0.01)
    assert near.delta_bic > 6


def test_a_near_copy_is_an_alternative_where_the_effect_is_small_and_a_stranger_is_not() -> None:
    naming = named(noise=8.0)
    assert {naming.name, *naming.alternatives} == {"effect", "near"}


def gain_of(y: Float, *columns: Float) -> float:
    """500 ln(RSS without / RSS with), a constant in both."""
    one = np.ones(len(y))
    rss = [np.linalg.lstsq(np.column_stack([one, *w]), y, rcond=None)[1][0] for w in ((), columns)]
    return float(500 * np.log(rss[0] / rss[1]))


def test_delta_bic_by_hand() -> None:
    rng = np.random.default_rng(1)
    a, b, c, e = rng.standard_normal((4, 2000))
    groups = [
        Group(name="a", shapes=(a[:, None],), numbers=(1,)),
        Group(name="bc", shapes=(np.column_stack([b, c]),)),
    ]
    y = 0.5 * a + 0.3 * b + 0.2 * c + e
    products = cross_products(y, np.ones((2000, 1)), groups)
    ranking = Ranking(products, 500.0)
    one, two = gain_of(y, a), gain_of(y, b, c)
    # The one has a factor and a number of its shape, the other two factors.
    assert evidence(ranking, [], 0) == pytest.approx(one - 2 * np.log(one / 2))
    found = result_of(ranking, [0])
    (naming,) = name_effects(products, found, 500.0, {})
    assert naming.rivals[0].delta_bic == pytest.approx(one - two - 2 * np.log(one / 2) + 2 * np.log(two / 2))


def test_a_number_costs_a_weak_effect_less_than_a_strong_one() -> None:
    rng = np.random.default_rng(2)
    a, other, e = rng.standard_normal((3, 2000))
    wide = np.column_stack([a, other, rng.standard_normal((2000, 2))])
    costs = []
    for size in (0.3, 3.0):
        products = cross_products(
            size * a + e,
            np.ones((2000, 1)),
            [Group(name="a", shapes=(a[:, None],)), Group(name="wide", shapes=(wide,))],
        )
        (naming,) = name_effects(products, result_of(Ranking(products, 500.0), [0]), 500.0, {})
        costs.append(naming.rivals[0].delta_bic)
    assert costs[0] < 6 < costs[1]


def test_of_two_that_fit_alike_the_one_with_fewer_numbers_takes_the_place() -> None:
    rng = np.random.default_rng(2)
    a, e = rng.standard_normal((2, 2000))
    wide = np.column_stack([a, *rng.standard_normal((3, 2000))])
    groups = [Group(name="wide", shapes=(wide,)), Group(name="a", shapes=(a[:, None],))]
    products = cross_products(a + e, np.ones((2000, 1)), groups)
    found = result_of(Ranking(products, 500.0), [0])
    assert [chosen.name for chosen in preferred(products, found, 500.0).chosen] == ["a"]
    assert [chosen.name for chosen in preferred(products, preferred(products, found, 500.0), 500.0).chosen] == ["a"]


@pytest.mark.parametrize(
    ("delta_bic", "ahead", "brings", "beaten"),
    [
        (5.9, 20.0, 30.0, False),
        (6.1, 20.0, 30.0, True),
        (6.1, 10.0, 11.0, False),  # ahead, and not by more than chance
        (6.1, -1.0, 0.0, True),  # it fits better, but it took too many numbers
    ],
)
def test_a_rival_is_beaten_by_its_numbers_or_by_a_fit_that_is_no_chance(
    *, delta_bic: float, ahead: float, brings: float, beaten: bool
) -> None:
    rival = Rival(name="r", shape=0, unit=0, delta_bic=delta_bic, correlation=0.9, ahead=ahead, brings=brings)
    assert rival.beaten(15.0) is beaten


def test_what_an_effect_is_ahead_and_brings_by_hand() -> None:
    rng = np.random.default_rng(4)
    a, b, e = rng.standard_normal((3, 2000))
    groups = [Group(name="a", shapes=(a[:, None],)), Group(name="b", shapes=((a + b)[:, None],))]
    y = a + 0.1 * b + 3.0 * e
    products = cross_products(y, np.ones((2000, 1)), groups)
    (rival,) = name_effects(products, result_of(Ranking(products, 500.0), [0]), 500.0, {})[0].rivals
    assert rival.ahead == pytest.approx(gain_of(y, a) - gain_of(y, a + b))
    assert rival.brings == pytest.approx(gain_of(y, a, b) - gain_of(y, a + b))


def test_of_a_rival_s_shapes_that_counts_for_which_most_speaks() -> None:
    rng = np.random.default_rng(5)
    a, e = rng.standard_normal((2, 2000))
    bent = np.column_stack([a, *rng.standard_normal((3, 2000))])
    groups = [
        Group(name="one", shapes=(a[:, None],)),
        Group(name="other", shapes=(bent, a[:, None])),
    ]
    products = cross_products(a + e, np.ones((2000, 1)), groups)
    (rival,) = name_effects(products, result_of(Ranking(products, 500.0), [0]), 500.0, {})[0].rivals
    assert rival.shape == 1
    assert rival.delta_bic == pytest.approx(0.0, abs=1e-9)


def test_names_that_are_the_same_always_belong_to_the_set() -> None:
    assert named(noise=2.0, same_as={"effect": ("twin",)}).alternatives == ("twin",)


def test_so_do_those_that_are_the_same_as_an_alternative() -> None:
    same_as = {"near": ("twin", "effect"), "stranger": ("brother",)}
    assert named(noise=8.0, same_as=same_as).alternatives == ("near", "twin")
    assert named(noise=2.0, same_as=same_as).alternatives == ()


PARTS = {"offset": ("drift",), "uneven": ("drift",)}
"""What either of two names may be a part of."""


def set_with_drift(name: str, *alternatives: str, beside: tuple[str, ...] = ("drift",)) -> tuple[str, ...]:
    """The alternatives of an effect beside others, with those of them that it may be a part of."""
    namings = [Naming(name=one, rivals=(), alternatives=()) for one in beside]
    return with_wholes([*namings, Naming(name=name, rivals=(), alternatives=alternatives)], PARTS)[-1].alternatives


def test_an_offset_beside_a_drift_may_be_what_was_drifted_before() -> None:
    assert set_with_drift("offset", "uneven") == ("uneven", "drift")
    assert set_with_drift("offset") == ("drift",)


def test_so_may_what_has_an_offset_among_its_alternatives() -> None:
    assert set_with_drift("spring", "stop", "offset") == ("stop", "offset", "drift")


def test_without_a_drift_an_offset_is_none_nor_is_another_effect_beside_one() -> None:
    assert set_with_drift("offset", "uneven", beside=()) == ("uneven",)
    assert set_with_drift("offset", "uneven", beside=("spring",)) == ("uneven",)
    assert set_with_drift("spring", "stop") == ("stop",)


def test_no_effect_is_a_part_of_itself_nor_stands_twice() -> None:
    assert set_with_drift("drift", "offset", beside=()) == ("offset",)
    assert set_with_drift("offset", "drift") == ("drift",)


def spring_or_offset(stiffness: float, offset: float) -> Naming:
    """A spring with a preload, in a log where an offset might be."""
    rng = np.random.default_rng(3)
    q, e = rng.standard_normal((2, 2000))
    one = np.ones(2000)
    groups = [Group(name="spring", shapes=(np.column_stack([q, one]),)), Group(name="offset", shapes=(one[:, None],))]
    products = cross_products(stiffness * q + offset + e, rng.standard_normal((2000, 1)), groups)
    (naming,) = name_effects(products, result_of(Ranking(products, 500.0), [0]), 500.0, {})
    return naming


def test_what_an_effect_holds_is_an_alternative_where_it_gives_most_of_the_torque() -> None:
    mostly, hardly = spring_or_offset(0.5, 1.0), spring_or_offset(1.0, 0.5)
    assert all(naming.rivals[0].beaten(10.0) and naming.rivals[0].held for naming in (mostly, hardly))
    assert (mostly.alternatives, hardly.alternatives) == (("offset",), ())


def test_what_only_resembles_an_effect_is_not_held_by_it() -> None:
    assert not next(rival for rival in named(noise=2.0).rivals if rival.name == "near").held


def named_with_a_richer_form(share: float, noise: float) -> Naming:
    """An offset of 1, and a form with a column more, which has so large a share in the torque."""
    rng = np.random.default_rng(7)
    more, other, e = rng.standard_normal((3, 2000))
    one = np.ones(2000)
    groups = [
        Group(name="offset", shapes=(one[:, None],)),
        Group(name="spring", shapes=(np.column_stack([one, more]),)),
    ]
    products = cross_products(one + share * more + noise * e, other[:, None], groups)
    (naming,) = name_effects(products, result_of(Ranking(products, 500.0), [0]), 500.0, {})
    return naming


def test_a_richer_form_that_adds_nothing_to_a_strong_effect_is_no_other_name() -> None:
    naming = named_with_a_richer_form(share=0.0, noise=0.3)
    (spring,) = naming.rivals
    assert spring.idle
    assert naming.alternatives == ()


def test_one_that_adds_a_fifth_is_one_and_so_is_one_of_a_weak_effect() -> None:
    assert not named_with_a_richer_form(share=0.2, noise=2.0).rivals[0].idle
    assert not named_with_a_richer_form(share=0.1, noise=6.0).rivals[0].idle


def test_a_column_that_is_nearly_the_base_s_is_not_held_for_that() -> None:
    """A curve that is hardly bent is nearly the line that is fitted anyway, and no part of any effect."""
    rng = np.random.default_rng(8)
    line, bent, e = rng.standard_normal((3, 2000))
    step = 0.9 * bent + 0.4 * rng.standard_normal(2000)
    groups = [Group(name="step", shapes=(step[:, None],)), Group(name="curve", shapes=((line + 3e-4 * bent)[:, None],))]
    products = cross_products(step + 0.3 * e, line[:, None], groups)
    (naming,) = name_effects(products, result_of(Ranking(products, 500.0), [0]), 500.0, {})
    assert not naming.rivals[0].held
    assert naming.alternatives == ()
