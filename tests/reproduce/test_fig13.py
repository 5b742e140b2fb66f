"""Figs 13 and 14: the paper's order of methods, on a comparison that tests can afford."""

from dataclasses import replace

import pytest

from friction_audit.compensation.comparison import METHODS, SCENES, Comparison, compare
from friction_audit.reproduce import REPRODUCTIONS, Claim, Reproduction
from friction_audit.reproduce.arm import KEPT, ORDER

SEEDS = 2
COMPARED = [one for one in REPRODUCTIONS if one.figure in ("13", "14")]


@pytest.fixture(scope="module")
def short() -> Comparison:
    """Return the paper's methods on a single joint."""
    joint = SCENES[0]
    settings = replace(joint.settings, duration_s=15.0)
    scene = replace(joint, settings=settings, tuning_seeds=0, with_others=False, margin_seeds=0)
    return compare(scene, SEEDS, [replace(method, sweeps=()) for method in METHODS if method.name in ORDER])


@pytest.fixture
def claims(short: Comparison) -> dict[str, Claim]:
    """Return all claims by their sentence."""
    return {claim.claim: claim for one in COMPARED for claim in one.check({"fig13": short})}


def test_claims_of_the_paper_and_own_experiments_are_apart(claims: dict[str, Claim]) -> None:
    assert len(claims) == 6
    for sentence, claim in claims.items():
        assert claim.own == sentence.startswith("own experiment")
        assert claim.paper
        assert claim.ours
        assert claim.note
    assert sum(claim.own for claim in claims.values()) == 2


def test_the_proposed_method_keeps_the_energy_of_a_joint(claims: dict[str, Claim]) -> None:
    kept = claims["the proposed method keeps the net energy after two cycles"]
    assert kept.holds == (abs(kept.value) < KEPT)
    assert kept.holds


@pytest.mark.parametrize("one", COMPARED, ids=lambda one: one.figure)
def test_figures_are_drawn(one: Reproduction, short: Comparison) -> None:
    figure = one.draw({"fig13": short})
    assert all(axes.has_data() for axes in figure.axes if axes.get_visible())
