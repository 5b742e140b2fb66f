"""Two effects at once, drawn by seed among those that one scenario can show together."""

from itertools import combinations

import numpy as np

from benchmarks.hidden_effects.draw import MOTIONS, ONE_JOINT
from friction_audit.effects.registry import effects

NOT_PAIRED = ("unlogged_compensation", "contact_event")
"""Not to be seen without a declared model; hidden as an event, not as torque."""


def can_be_seen_together() -> list[str]:
    """All pairs of effects that share a scenario of one joint, as ``first+second``."""
    names = [c.name for c in effects() if c.name not in NOT_PAIRED]
    places = {name: set(MOTIONS.get(name, ONE_JOINT)) & set(ONE_JOINT) for name in names}
    same = {c.name: set(c.indistinguishable) for c in effects()}
    return [
        f"{one}+{two}"
        for one, two in combinations(names, 2)
        if places[one] & places[two] and two not in same[one] and one not in same[two]
    ]


def draw_pairs(first: int, seeds: int) -> list[tuple[str, int]]:
    """One pair for each seed."""
    every = can_be_seen_together()
    return [(str(np.random.default_rng([seed, 3]).choice(every)), seed) for seed in range(first, first + seeds)]
