"""The paper's figures, each simulated once, and claims by what they say."""

from collections.abc import Callable
from functools import cache

import pytest

from friction_audit.reproduce import REPRODUCTIONS, Claim, Simulations, simulate_figures

SEEDS = 3

Check = Callable[[str], dict[str, Claim]]


@cache
def simulated(figure: str) -> Simulations:
    """Return what a figure needs."""
    (one,) = (each for each in REPRODUCTIONS if each.figure == figure)
    return simulate_figures([one], 1 if figure == "12" else SEEDS)


@pytest.fixture(scope="session")
def claims() -> Check:
    """Return the claims of a figure by their sentence."""

    def check(figure: str) -> dict[str, Claim]:
        (one,) = (each for each in REPRODUCTIONS if each.figure == figure)
        return {claim.claim: claim for claim in one.check(simulated(figure))}

    return check
