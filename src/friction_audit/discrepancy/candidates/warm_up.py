"""Warm-up: friction fades with the time since the start, or with the logged temperature."""

from functools import partial

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Law, Shape, columns_of
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
STEEPNESSES = (0.5, 1.0, 1.7, 3.0)
"""Logarithm of the friction of a cold joint over that of a warm one, tried."""
HALF = 0.5
"""Of that friction: what a warm joint has is told by a log that ends before, and no law is exact."""
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


def by_viscosity(data: JointData, baseline: Baseline, shape: Shape, steepness: float) -> Float:
    """Friction that falls exponentially with a temperature that rises with the time, as a lubricant's does.

    The logarithm of the friction over that of the warm joint falls exponentially with the time, from the steepness on,
    and no longer the friction, as it does where that is linear in the temperature (O. Reynolds, Philosophical
    Transactions 177 (1886) 157).
    """
    cold = np.exp(-(data.t - data.t[0]) / shape["warm_up_time_s"])
    faster = np.expm1(steepness * cold) / (np.maximum(cold, np.finfo(float).tiny) * np.expm1(steepness))
    return np.asarray(_BY_TIME(data, baseline, shape) * faster[:, None])


def warm_enough(factors: Float, baseline: Baseline, steepness: float) -> bool:
    """Whether a cold joint has half as much more friction of one kind, or more, than a warm one."""
    warm = np.array([baseline.coulomb_nm, baseline.viscous_nms_per_rad])
    return bool(np.any(factors >= HALF * np.expm1(steepness) * np.maximum(warm, 0.0)))


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
    other_laws=tuple(
        Law(columns=partial(by_viscosity, steepness=one), holds=partial(warm_enough, steepness=one))
        for one in STEEPNESSES
    ),
)
