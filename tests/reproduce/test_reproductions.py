"""What holds for every figure."""

import pytest

from friction_audit.reproduce import REPRODUCTIONS, Reproduction, simulate_figures
from tests.reproduce.figures import claims, simulated

COMPARED = ("13", "14")
"""These take a comparison; see ``test_fig13``."""

SIMULATED = [one for one in REPRODUCTIONS if one.figure not in COMPARED]
EACH = pytest.mark.parametrize("one", SIMULATED, ids=lambda one: f"fig{one.figure}")


@EACH
def test_claims_belong_to_the_figure(one: Reproduction) -> None:
    found = claims(one.figure).values()
    assert {claim.figure.rstrip("abc") for claim in found} == {one.figure}
    assert all(claim.claim and claim.paper and claim.ours for claim in found)


@EACH
def test_figures_are_drawn(one: Reproduction) -> None:
    figure = one.draw(simulated(one.figure))
    assert figure.axes
    assert all(axes.has_data() for axes in figure.axes)


def test_progress_is_told_and_seeds_are_counted() -> None:
    told: list[float] = []
    chosen = [one for one in REPRODUCTIONS if one.figure in ("3", "8")]
    simulations = simulate_figures(chosen, 2, told.append)
    assert {name: len(each) for name, each in simulations.items()} == {"fig3": 1, "fig8": 2}
    assert told == sorted(told)
    assert told[0] == 0.0
    assert told[-1] < 1.0
