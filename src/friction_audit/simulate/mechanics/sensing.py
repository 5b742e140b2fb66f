"""What a sensor makes of one value inside a compiled loop; import this module only where such a loop runs."""

import numpy as np

from friction_audit.compiled import compiled
from friction_audit.simulate.sensors import BINARY_NOISE_DIGITS

SCALE = 10.0**BINARY_NOISE_DIGITS


@compiled()
def quantised(value: float, step: float) -> float:
    """Round to a multiple of a step, to the bit as ``sensors.quantise`` does it; a step of 0 changes nothing."""
    if step == 0.0:
        return value
    return float(np.rint(np.rint(value / step) * step * SCALE) / SCALE)
