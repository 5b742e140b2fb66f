"""Whole cycles to work on, and whole cycles locked away before anything is chosen."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

Index = NDArray[np.int64]
LOCKED_SHARE = 0.3
BLOCK = 10
"""Cycles that follow each other and give up the same number of locked ones, so that both cover the recording."""
FEWEST_CYCLES = 4


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Split:
    """Numbers of the cycles of each kind, ascending.

    Attributes:
        working: Cycles that may be looked at.
        locked: Cycles that are used once, at the end.
    """

    working: Index
    locked: Index


def split_cycles(cycles: Index, speed: Float, seed: int, *, share: float = LOCKED_SHARE) -> Split:
    """Lock away at least a share of the cycles, spread over the recording and over the speeds.

    The cycles are cut into blocks in the order of the recording. In each block they are sorted by speed and cut into
    as many groups as are to be locked; of each group chance locks one.

    Args:
        cycles: Numbers of the cycles that count, ascending, shape (m,).
        speed: Typical speed of each, shape (m,). [rad/s]
        seed: Of the chance; the same seed gives the same split.
        share: Smallest share that is locked.

    Raises:
        AnalysisError: With fewer than four cycles.
    """
    if len(cycles) < FEWEST_CYCLES:
        raise AnalysisError(
            f"diagnose: {len(cycles)} cycles; at least {FEWEST_CYCLES} are needed to lock some away for the proof; "
            "record more strokes"
        )
    rng = np.random.default_rng(seed)
    picked: list[int] = []
    for block in np.array_split(np.arange(len(cycles)), max(len(cycles) // BLOCK, 1)):
        by_speed = block[np.argsort(speed[block], kind="stable")]
        wanted = int(np.ceil(share * len(block) - 1e-9))
        picked += [int(rng.choice(group)) for group in np.array_split(by_speed, wanted)]
    locked = np.isin(np.arange(len(cycles)), picked)
    return Split(working=cycles[~locked], locked=cycles[locked])
