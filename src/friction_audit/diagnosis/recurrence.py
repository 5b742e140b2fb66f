"""When a joint moves again as it did: at the same place and speed, or at the same speed and acceleration."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float

ALIKE = 0.3
"""Distance of two states of motion that are alike, in standard deviations of each coordinate."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Passes:
    """The course of a motion, n samples.

    Attributes:
        states: Its states in units of their standard deviations, of each kind, shape (n, 2) each.
        way: Sign of the velocity, shape (n,).
        cycle: Number of the energy cycle of each sample, -1 outside of any, shape (n,).
    """

    states: tuple[Float, ...]
    way: Float
    cycle: NDArray[np.int64]

    def like(self, at: int) -> list[int]:
        """Samples of other cycles, at most one of each and of each kind of state, that are alike to one sample."""
        others = np.flatnonzero((self.cycle >= 0) & (self.cycle != self.cycle[at]) & (self.way == self.way[at]))
        found: list[int] = []
        for state in self.states:
            distance = np.hypot(*(state[others] - state[at]).T)
            near = distance < ALIKE
            closest = np.lexsort((distance[near], self.cycle[others[near]]))
            places = others[near][closest]
            found += places[np.append(True, np.diff(self.cycle[places]) != 0)[: len(places)]].tolist()
        return found


def passes_of(data: JointData, every: int) -> Passes:
    """The course of a joint's motion, one of so many samples."""
    q, dq, ddq = (signal[::every] / max(float(np.std(signal)), 1e-9) for signal in (data.q, data.dq, data.ddq))
    return Passes(
        states=(np.column_stack([q, dq]), np.column_stack([dq, ddq])),
        way=np.sign(data.dq[::every]),
        cycle=data.cycle[::every],
    )
