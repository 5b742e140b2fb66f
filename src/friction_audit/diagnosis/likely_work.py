"""Which joints are likely to take long: begun first, they are not waited for while nothing else is left to do."""

from collections.abc import Sequence

import numpy as np

from friction_audit.effects.joint_data import JointData

FEWEST = 10
"""Samples from which anything is said."""


def longest_first(prepared: Sequence[JointData]) -> list[int]:
    """Return the joints by what simple friction leaves of their torque over its noise: there is more to look for."""
    return sorted(range(len(prepared)), key=lambda joint: -_left_over(prepared[joint]))


def _left_over(data: JointData) -> float:
    """Rms of what inertia, Coulomb and viscous friction leave, over how it scatters from sample to sample."""
    used, torque = data.used, data.torque
    if np.count_nonzero(used) < FEWEST:
        return 0.0
    simple = np.stack([data.ddq, data.dq, np.sign(data.dq), np.ones(len(data.t))], axis=1)[used]
    left = torque[used] - simple @ np.linalg.lstsq(simple, torque[used], rcond=None)[0]
    scatter = float(np.median(np.abs(np.diff(left, n=2))))
    return float(np.std(left)) / scatter if scatter > 0 else 0.0
