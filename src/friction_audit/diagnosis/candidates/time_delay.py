"""Delay: the predicted torque, read at another time."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import reversals
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.terms.time_delay import TERM
from friction_audit.joint_log import Float

STEPS_S = np.geomspace(1e-3, 0.1, 13)
LEAST_SHARE, LARGEST_SHARE = 0.5, 1.6
"""Delay found over the delay for which jumps are right; a shorter delay than the shortest looks just like it."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """All delays, of friction and inertia alone and, where there is a load, of all that the sensor bears."""
    loads = (0.0,) if data.load is None else (0.0, 1.0)
    return tuple(
        {"delay_step_s": float(sign * step), "delayed_load": load}
        for load in loads
        for sign in (1.0, -1.0)
        for step in STEPS_S
    )


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking: jumps of friction show it, at equally fast strokes too."""
    return reversals(data, baseline)


def admissible(factors: Float, shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    share = factors[0] / shape["delay_step_s"]
    least = 0.0 if abs(shape["delay_step_s"]) <= STEPS_S[0] else LEAST_SHARE
    return bool(least < share <= LARGEST_SHARE)


CANDIDATE = Candidate(
    name="time_delay",
    label="torque and velocity are not simultaneous",
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("s",),
    untestable=untestable,
    admissible=admissible,
    axis="acceleration",
    term=TERM,
    leans_on_model=True,
)
