"""What holds for every figure."""

import pytest

from friction_audit.reproduce import REPRODUCTIONS, Reproduction, simulate_figures
from friction_audit.reproduce.reproduction import relative
from friction_audit.simulation import SCENARIOS
from tests.reproduce.conftest import simulated

COMPARED = ("13", "14")
"""These take a comparison; see ``test_fig13``."""

SIMULATED = [one for one in REPRODUCTIONS if one.figure not in COMPARED]
EACH = pytest.mark.parametrize("one", SIMULATED, ids=lambda one: f"fig{one.figure}")


@EACH
def test_scenarios_have_their_name_and_figure(one: Reproduction) -> None:
    named = {scenario.name: scenario for scenario in SCENARIOS}
    assert all(named[name].figure for name in one.scenarios)


@EACH
def test_claims_belong_to_the_figure(one: Reproduction) -> None:
    claims = one.check(simulated(one.figure))
    assert claims
    assert {claim.figure.rstrip("abc") for claim in claims} == {one.figure}
    assert all(claim.claim and claim.paper and claim.ours for claim in claims)


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


@pytest.mark.parametrize(
    ("share", "text"),
    [(0.0, "less than 0.001 %"), (1.234e-4, "0.012 %"), (-0.5, "50 %"), (1.0, "100 %"), (1e-9, "less than 0.001 %")],
)
def test_shares_in_words(share: float, text: str) -> None:
    assert relative(share) == text
