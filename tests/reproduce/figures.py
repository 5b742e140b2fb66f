"""The paper's figures, each simulated once, and claims by what they say."""

from functools import cache

from friction_audit.reproduce import REPRODUCTIONS, Claim, Simulations, simulate_figures

SEEDS = 3


@cache
def simulated(figure: str) -> Simulations:
    """Return what a figure needs."""
    (one,) = (each for each in REPRODUCTIONS if each.figure == figure)
    return simulate_figures([one], 1 if figure == "12" else SEEDS)


@cache
def claims(figure: str) -> dict[str, Claim]:
    """Return the claims of a figure by their sentence."""
    (one,) = (each for each in REPRODUCTIONS if each.figure == figure)
    return {claim.claim: claim for claim in one.check(simulated(figure))}
