"""Warm-up: friction fades with the time since the start, or with the logged temperature."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape, columns_of
from friction_audit.discrepancy.candidates.excitation import both_directions
from friction_audit.discrepancy.candidates.extent import duration
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float
from friction_audit.model.terms.warm_up import TERM

SHORTEST_S = 30.0
TIMES = (0.08, 0.2, 0.5, 1.5)
"""Time constants as shares of the log's length; beyond, an exponential is a straight line."""
FOREVER = 1e4
UNFELT_PER_K = 1e-6
DECAYS = (0.3, 1.5, 5.0)
"""How far friction fades over the range of the temperature, as exponents."""
LEAST_STEEP, MOST_STEEP = 1e-3, 3.0
"""Logarithm of the friction of a cold joint over that of a warm one: below, both laws are one; twenty times as much is
more than a joint has that is moved."""
LEAST_K = 0.5
"""Range of a temperature that is worth a look."""


_BY_TIME = columns_of(TERM)


def shapes(data: JointData) -> tuple[Shape, ...]:
    """Time constants by the length of the log; rates by the range of the temperature, where there is one."""
    length = duration(data)
    tried: list[Shape] = [{"warm_up_time_s": share * length, "warm_up_per_k": UNFELT_PER_K} for share in TIMES]
    rise = 0.0 if data.temperature is None else float(np.ptp(data.temperature))
    if rise >= LEAST_K:
        tried += [{"warm_up_time_s": FOREVER * length, "warm_up_per_k": decay / rise} for decay in DECAYS]
    return tuple(tried)


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    length = duration(data)
    if length < SHORTEST_S:
        return f"{length:.0f} s are too short: record at least {SHORTEST_S:g} s from a cold start, slow and fast"
    return both_directions(data, baseline)


def admissible(factors: Float, _shape: Shape) -> bool:
    """A cold joint has more friction of one kind at least."""
    return bool(np.any(factors > 0))


def by_viscosity(data: JointData, baseline: Baseline, shape: Shape, factors: Float) -> Float:
    """Friction that falls exponentially with a temperature that rises with the time, as a lubricant's does.

    With f the excess of the cold joint over the friction F of the warm one, ln(1 + f / F) falls exponentially with the
    time, and no longer f, as it does where friction is linear in the temperature (O. Reynolds, Philosophical
    Transactions 177 (1886) 157).
    """
    exponential = _BY_TIME(data, baseline, shape)
    warm = np.maximum([baseline.coulomb_nm, baseline.viscous_nms_per_rad], np.finfo(float).tiny)
    steep = np.clip(np.log1p(np.maximum(factors, 0.0) / warm), LEAST_STEEP, MOST_STEEP)
    cold = np.exp(-(data.t - data.t[0]) / shape["warm_up_time_s"])[:, None]
    return np.asarray(exponential * np.expm1(steep * cold) / (np.maximum(cold, np.finfo(float).tiny) * np.expm1(steep)))


CANDIDATE = Candidate(
    name=TERM.name,
    label=TERM.label,
    shapes=shapes,
    columns=_BY_TIME,
    column_units=("nm", "nms_per_rad"),
    untestable=untestable,
    admissible=admissible,
    axis="time",
    term=TERM,
    fading="warm_up_time_s",
    other_law=by_viscosity,
)
