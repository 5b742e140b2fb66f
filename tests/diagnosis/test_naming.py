"""What a search finds is refined, and holds on locked cycles or is dropped."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.cross_products import cross_products
from friction_audit.diagnosis.evidence import evidence
from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.library import build_library
from friction_audit.diagnosis.naming import Names, find_names, with_moments_of_all_cycles, worth
from friction_audit.diagnosis.ranking import Ranking
from friction_audit.effects.effect import Nonlinear, Trait
from friction_audit.effects.joint_data import JointData, Nominal, mean_sign
from friction_audit.effects.registry import effect_of
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import TRUTH, moved_joint
from tests.diagnosis.toy_candidates import BUMP, SQUARE, STEP, TOYS, altered


def bump(data: JointData) -> Float:
    return 0.1 * np.exp(-(((data.q - 0.2) / 0.2) ** 2))


def square(data: JointData) -> Float:
    return 0.05 * data.dq * np.abs(data.dq)


def ground_of(missing: Callable[[JointData], Float] | None) -> Ground:
    return make_ground(moved_joint(missing, noise_nm=0.02, duration_s=40.0), None, 0)


def names_of(ground: Ground) -> Names:
    library = build_library(TOYS, ground.data, ground.baseline(), ground.rows)
    return find_names(ground, TOYS, library, 0.05, np.random.default_rng(0))


def test_an_effect_is_named_and_its_shape_refined() -> None:
    names = names_of(ground_of(bump))
    (found,) = names.found
    assert found.candidate is BUMP
    assert found.shape["place_rad"] == pytest.approx(0.2, abs=0.02)
    assert found.p_value < 0.01
    assert found.naming.alternatives == ()


def test_two_effects_are_named_the_strongest_first_and_the_declared_model_is_fitted_beside_them() -> None:
    names = names_of(ground_of(lambda data: bump(data) + 2.0 * square(data)))
    assert [found.candidate.name for found in names.found] == ["bump", "square"]
    assert names.baseline.viscous_nms_per_rad == pytest.approx(TRUTH["viscous_nms_per_rad"], rel=0.2)
    assert names.baseline.inertia_kg_m2 == pytest.approx(TRUTH["inertia_kg_m2"], rel=0.01)


@pytest.mark.parametrize(("rejected", "named"), [(True, True), (False, False)])
def test_what_the_test_over_cycles_does_not_see_must_be_plain_by_itself(
    rejected: bool, named: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    ground = ground_of(bump)
    library = build_library(TOYS, ground.data, ground.baseline(), ground.rows)
    monkeypatch.setattr(Ground, "longest_memory", lambda _self, *_effects: 1e4)
    found = find_names(ground, TOYS, library, 0.05, np.random.default_rng(0), rejected=rejected).found
    assert bool(found) is named


def test_what_is_plain_needs_no_test_over_cycles() -> None:
    ground = ground_of(bump)
    library = build_library(TOYS, ground.data, ground.baseline(), ground.rows)
    (found,) = find_names(ground, TOYS, library, 0.05, np.random.default_rng(0), rejected=False).found
    assert found.candidate is BUMP


def test_noise_has_no_name() -> None:
    assert names_of(ground_of(None)).found == ()


def test_what_was_there_on_the_working_cycles_only_is_dropped() -> None:
    ground = ground_of(None)
    working = np.isin(ground.data.cycle, ground.rows.cycle[ground.working])
    spoilt = make_ground(replace(ground.data, torque=ground.data.torque + bump(ground.data) * working), None, 0)
    assert np.array_equal(spoilt.working, ground.working)
    names = names_of(spoilt)
    assert names.found == ()
    assert names.disproved == ("bump",)


def spring(data: JointData, _baseline: Nominal, _shape: Nonlinear) -> Float:
    return np.column_stack([data.q, np.ones(len(data.q))])


SPRING = altered(SQUARE, name="spring", regressor=spring, units=("nm_per_rad", "nm"))
SPRING = altered(SPRING, admissible=lambda factors, _shape: bool(factors[0] > 0), axis="position")
OFFSET = altered(SQUARE, name="offset", regressor=lambda data, _baseline, _shape: np.ones((len(data.q), 1)))


@pytest.mark.parametrize(("elsewhere", "name"), [(1.0, "spring"), (-8.0, "offset")])
def test_an_effect_that_cannot_be_gives_way_to_what_it_holds(elsewhere: float, name: str) -> None:
    """A spring that pushes away in the locked cycles is none; the offset that its preload was is there in all."""
    ground = ground_of(None)
    locked = np.isin(ground.data.cycle, ground.rows.cycle[ground.locked])
    stiffness = 0.02 * np.where(locked, elsewhere, 1.0)
    missing = stiffness * ground.data.q + 0.1
    ground = make_ground(replace(ground.data, torque=ground.data.torque + missing), None, 0)
    library = build_library((SPRING, OFFSET), ground.data, ground.baseline(), ground.rows)
    names = find_names(ground, (SPRING, OFFSET), library, 0.05, np.random.default_rng(0))
    assert [found.candidate.name for found in names.found] == [name]
    assert names.disproved == ()


def test_an_effect_that_is_small_beside_another_is_not_named() -> None:
    def missing(data: JointData) -> Float:
        return 20.0 * bump(data) + square(data)

    names = names_of(ground_of(missing))
    (found,) = names.found
    assert found.candidate is BUMP
    assert names.disproved == ()
    # What was dropped may be what the other is instead: it is held against it, without itself in the model.
    assert SQUARE.name in {rival.name for rival in found.naming.rivals}


def test_one_that_is_small_beside_an_offset_is_for_an_offset_has_no_formula_to_be_wrong() -> None:
    ground = ground_of(lambda data: 2.0 + bump(data))
    toys = (altered(OFFSET, traits=Trait.EXACT), BUMP)
    library = build_library(toys, ground.data, ground.baseline(), ground.rows)
    names = find_names(ground, toys, library, 0.05, np.random.default_rng(0))
    assert [found.candidate.name for found in names.found] == ["offset", "bump"]


@pytest.mark.parametrize(("names", "kept"), [(("gravity_error", "stribeck"), 2), (("presliding", "stribeck"), 1)])
def test_friction_that_is_small_beside_what_knows_no_direction_is_named(names: tuple[str, str], kept: int) -> None:
    """Gravity that nobody took away is ten times what the joint misses; it turns with no direction."""
    large, small = (
        altered(toy, name=name, traits=effect_of(name).traits) for toy, name in zip((BUMP, SQUARE), names, strict=True)
    )
    ground = ground_of(lambda data: 20.0 * bump(data) + square(data))
    library = build_library((large, small), ground.data, ground.baseline(), ground.rows)
    found = find_names(ground, (large, small), library, 0.05, np.random.default_rng(0)).found
    assert [one.candidate.name for one in found] == list(names)[:kept]


@pytest.mark.parametrize(("share", "rich"), [(0.02, False), (0.5, True)])
def test_a_richer_shape_is_told_where_it_adds_a_good_deal(share: float, rich: bool) -> None:
    def both(data: JointData) -> Float:
        return 3.0 * bump(data) + share * 3.0 * wave(data)

    def columns(data: JointData, _baseline: Nominal, shape: Nonlinear) -> Float:
        return np.column_stack([bump(data), shape["form"] * wave(data)])

    def wave(data: JointData) -> Float:
        return 0.1 * np.sin(9.0 * data.q)

    forms = altered(
        SQUARE,
        name="forms",
        grid=({"form": 0.0}, {"form": 1.0}),
        regressor=columns,
        units=("1", "1"),
        admissible=lambda _factors, _shape: True,
        needs_gain=lambda shape: shape["form"] > 0.0,
    )
    ground = make_ground(moved_joint(both, noise_nm=0.01, duration_s=40.0), None, 0)
    for toy, told in ((forms, rich), (altered(forms, needs_gain=lambda _shape: False), True)):
        library = build_library((toy,), ground.data, ground.baseline(), ground.rows)
        (found,) = find_names(ground, (toy,), library, 0.05, np.random.default_rng(0)).found
        assert (found.shape["form"] > 0.0) == told


@pytest.mark.parametrize(("size", "alternatives"), [(2.0, ("bump",)), (0.0, ())])
def test_what_an_effect_may_be_a_part_of_is_an_alternative_where_it_was_found(
    size: float, alternatives: tuple[str, ...]
) -> None:
    ground = ground_of(lambda data: 2.0 + size * bump(data))
    toys = (altered(OFFSET, traits=Trait.EXACT, part_of=("bump",)), BUMP)
    library = build_library(toys, ground.data, ground.baseline(), ground.rows)
    found = find_names(ground, toys, library, 0.05, np.random.default_rng(0)).found
    assert {one.candidate.name: one.naming.alternatives for one in found}["offset"] == alternatives


def test_twins_are_alternatives() -> None:
    ground = ground_of(square)
    toys = (altered(SQUARE, indistinguishable=("bump",)), BUMP)
    library = build_library(toys, ground.data, ground.baseline(), ground.rows)
    (found,) = find_names(ground, toys, library, 0.05, np.random.default_rng(0)).found
    assert found.naming.alternatives == ("bump",)


def test_rivals_are_judged_on_all_cycles() -> None:
    cube = altered(SQUARE, name="cube", regressor=lambda data, _baseline, _shape: data.dq[:, None] ** 3)
    ground, toys = ground_of(square), (SQUARE, cube)
    library = build_library(toys, ground.data, ground.baseline(), ground.rows)
    (found,) = find_names(ground, toys, library, 0.05, np.random.default_rng(0)).found
    (rival,) = found.naming.rivals
    products = cross_products(ground.y, ground.base, [entry.group for entry in library.entries])
    ranking = Ranking(products, len(ground.y) / ground.memory(found.columns))
    assert rival.delta_bic == pytest.approx(evidence(ranking, [], 0) - evidence(ranking, [], 1))


def test_a_moment_in_a_locked_cycle_is_told_from_all_cycles() -> None:
    clean = ground_of(None)
    cycle = int(np.median(clean.rows.cycle[clean.locked]))
    inside = clean.data.t[clean.data.cycle == cycle]
    assert np.isin(cycle, clean.rows.cycle[clean.locked])
    moment = float(inside[0] + 0.3 * (inside[-1] - inside[0]))
    ground = ground_of(lambda data: 0.1 * np.sign(data.dq) * (data.t >= moment))
    toys = (STEP, BUMP)
    library = build_library(toys, ground.data, ground.baseline(), ground.rows)
    names = find_names(ground, toys, library, 0.05, np.random.default_rng(0))
    (told,) = with_moments_of_all_cycles(ground, names)
    assert told.shape["moment_s"] == pytest.approx(moment, abs=0.1)
    # So is the one that the gap is measured with, or the locked cycles would be missed for not having been asked.
    assert names.found[0].shape["moment_s"] == pytest.approx(moment, abs=0.1)


def test_what_is_no_function_of_time_is_told_as_it_was_proven() -> None:
    ground = ground_of(bump)
    names = names_of(ground)
    assert with_moments_of_all_cycles(ground, names) == names.found


def test_rows_are_worth_their_number_over_the_memory() -> None:
    ground = ground_of(None)
    assert worth(ground) == pytest.approx(ground.working.sum() / ground.memory())


@pytest.mark.parametrize(("factor", "named"), [(0.5, True), (3.0, False)])
def test_no_effect_makes_coulomb_friction_drive(factor: float, named: bool) -> None:
    """Three times a curve that starts at 1 N m, with less than nothing beside it, is no friction."""

    def curve(data: JointData) -> Float:
        return mean_sign(data.t, data.dq, data.ddq) * (1.0 + 0.1 * data.dq**2)

    def missing(data: JointData) -> Float:
        return factor * curve(data) - max(factor - 0.5, 0.0) * mean_sign(data.t, data.dq, data.ddq)

    toy = altered(SQUARE, name="curve", regressor=lambda data, _baseline, _shape: curve(data)[:, None])
    ground = ground_of(missing)
    library = build_library((toy,), ground.data, ground.baseline(), ground.rows)
    found = find_names(ground, (toy,), library, 0.05, np.random.default_rng(0)).found
    assert bool(found) == named
