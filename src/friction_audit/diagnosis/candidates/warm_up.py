"""Warm-up: friction fades with the time since the start, or with the logged temperature."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.joint_data import JointData, Nominal, duration
from friction_audit.effects.terms.warm_up import TERM
from friction_audit.joint_log import Float

SHORTEST_S = 30.0
TIMES = (0.08, 0.2, 0.5, 1.5)
"""Time constants as shares of the log's length; beyond, an exponential is a straight line."""
FOREVER = 1e4
UNFELT_PER_K = 1e-6
DECAYS = (0.3, 1.5, 5.0)
"""How far friction fades over the range of the temperature, as exponents."""
LEAST_K = 0.5
"""Range of a temperature that is worth a look."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """Time constants by the length of the log; rates by the range of the temperature, where there is one."""
    length = duration(data)
    tried: list[Shape] = [{"warm_up_time_s": share * length, "warm_up_per_k": UNFELT_PER_K} for share in TIMES]
    rise = 0.0 if data.temperature is None else float(np.ptp(data.temperature))
    if rise >= LEAST_K:
        tried += [{"warm_up_time_s": FOREVER * length, "warm_up_per_k": decay / rise} for decay in DECAYS]
    return tuple(tried)


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    length = duration(data)
    if length < SHORTEST_S:
        return f"{length:.0f} s are too short: record at least {SHORTEST_S:g} s from a cold start, slow and fast"
    return both_directions(data, baseline)


def admissible(factors: Float, _shape: Shape) -> bool:
    """A cold joint has more friction of one kind at least."""
    return bool(np.any(factors > 0))


CANDIDATE = Candidate(
    name=TERM.name,
    label=TERM.label,
    shapes=shapes,
    columns=columns_of(TERM),
    column_units=("nm", "nms_per_rad"),
    untestable=untestable,
    admissible=admissible,
    axis="time",
    term=TERM,
    fading="warm_up_time_s",
)
