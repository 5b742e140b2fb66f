"""Tables of a joint, continued in a straight line beyond the fastest speed of the recording they were made from.

A compensated joint moves faster than the recorded one did. The last slope of the table over speed is taken out of it
and kept as a torque in proportion to the speed: what is left is level at its end, as tables are continued.
"""

import numpy as np

from friction_audit.model.tables import Tables


def straighten(tables: Tables, *, damping_nms_per_rad: float = 0.0) -> Tables:
    """Return tables that are right at any speed, with a damper beside what they hold.

    Args:
        tables: What a joint takes.
        damping_nms_per_rad: Of the damper. [N m s/rad]
    """
    speeds = np.asarray(tables.speed_step * np.arange(tables.speed.shape[1]), np.float64)
    slope = (tables.speed[:, -1] - tables.speed[:, -2]) / tables.speed_step
    damped = slope + damping_nms_per_rad * np.array([1.0, -1.0])
    return tables._replace(
        speed=tables.speed - slope[:, None] * speeds,
        place_per_speed=tables.place_per_speed + damped[:, None],
    )
