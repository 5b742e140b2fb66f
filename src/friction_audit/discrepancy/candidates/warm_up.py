"""Warm-up: s and v times exp(-t/T), or exp(-k dT) with a temperature."""

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.candidates.direction import direction
from friction_audit.discrepancy.candidates.excitation import both_directions
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.joint_log import Float

SHORTEST_S = 30.0


def columns(data: JointData, _baseline: Baseline, shape: Shape) -> Float:
    """Warm-up, shape (n, p)."""
    if "time_constant_s" in shape:
        cold = np.exp(-(data.t - data.t[0]) / shape["time_constant_s"])
    elif data.temperature is not None:
        cold = np.exp(-shape["per_degc"] * (data.temperature - data.temperature[0]))
    else:
        cold = np.zeros(len(data.t))
    return np.column_stack([direction(data) * cold, data.dq * cold])


def untestable(data: JointData, baseline: Baseline) -> str | None:
    """The motion that is lacking."""
    duration = float(data.t[-1] - data.t[0])
    if duration < SHORTEST_S:
        return f"{duration:.0f} s are too short: record at least {SHORTEST_S:g} s from a cold start, slow and fast"
    return both_directions(data, baseline)


def admissible(factors: Float, _shape: Shape) -> bool:
    """Sign and size that are physically possible."""
    return bool(np.any(factors > 0))


CANDIDATE = Candidate(
    name="warm_up",
    label="friction falls as the joint warms",
    shapes=(
        *({"time_constant_s": float(s)} for s in np.geomspace(15.0, 1200.0, 8)),
        *({"per_degc": k} for k in (0.01, 0.03, 0.1)),
    ),
    columns=columns,
    column_units=("nm", "nms_per_rad"),
    untestable=untestable,
    admissible=admissible,
    axis="time",
)
