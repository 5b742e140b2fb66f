"""Many persons: what one number per seed comes to."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float
from friction_audit.simulate.simulation import Simulation


def each(simulations: Sequence[Simulation], measure: Callable[[Simulation], float]) -> Float:
    """Return one number per simulation, shape (seeds,)."""
    return np.array([measure(simulation) for simulation in simulations])


def spread(values: Float, unit: str, *, worst: Callable[[Float], float] = np.max) -> str:
    """Return median and worst in words; of one seed only that."""
    if len(values) == 1:
        return f"{values[0]:.3f} {unit}".rstrip()
    return f"median {np.median(values):.3f}, worst {worst(values):.3f} {unit}".rstrip()


def share(holds: "NDArray[np.bool_]") -> str:
    """Return in how many seeds something holds, in words."""
    return f"{int(holds.sum())} of {len(holds)} seeds"
