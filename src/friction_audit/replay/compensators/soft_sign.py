"""A sign that does not chatter at standstill."""

import math

from friction_audit.compiled import compiled


@compiled()
def soft_sign(dq: float, dead_band_rad_s: float, ramp_rad_s: float) -> float:
    """Return the sign of the velocity, 0 in the dead-band, with a ramp between."""
    beyond = abs(dq) - dead_band_rad_s
    if beyond <= 0.0:
        return 0.0
    return math.copysign(1.0 if beyond >= ramp_rad_s else beyond / ramp_rad_s, dq)
