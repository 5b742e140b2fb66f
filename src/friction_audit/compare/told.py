"""Comparison -> plain numbers for documents and tables."""

from operator import attrgetter

from friction_audit.compare.interval import Interval
from friction_audit.compare.result import Comparison, Curve, Point, Row

MEASURES = (
    "energy_slope_w",
    "peak_torque_nm",
    "rms_torque_nm",
    "vibration_nm",
    "standstill_rad_s",
    "chatter_nm",
    "coulomb_left",
    "viscous_left",
    "inertia_left",
)
"""Fields of an outcome that are told with their interval."""

Told = dict[str, object]


def tell_rows(comparison: Comparison) -> list[Told]:
    """Return every method and tuning with its measures."""
    return [_tell_row(row) for row in comparison.rows]


def tell_curves(comparison: Comparison) -> list[Told]:
    """Return every sweep with its points."""
    return [_tell_curve(curve) for curve in comparison.curves]


def _tell_row(row: Row) -> Told:
    return {
        "method": row.method,
        "label": row.label,
        "tuning": row.tuning.name,
        "meaning": row.tuning.meaning,
        "role": row.role,
        "tuning_losses": row.tuning_losses,
        **{name: _tell_interval(row.interval(attrgetter(name))) for name in MEASURES},
        "stable_share": row.stable_share,
        "lost_s": list(row.lost_s),
        "stability_margin": _tell_interval(row.margin),
        "stability_margins": list(row.margins),
    }


def _tell_curve(curve: Curve) -> Told:
    return {
        "method": curve.method,
        "label": curve.label,
        "sweep": curve.name,
        "axis": curve.axis,
        "boldest_stable": curve.boldest_stable,
        "points": [_tell_point(point) for point in curve.points],
    }


def _tell_point(point: Point) -> Told:
    return {
        "value": point.value,
        "tuning": point.tuning.name,
        "stable": point.stable,
        "stable_share": 1.0 - point.losses / len(point.outcomes),
        "energy_slope_w": _tell_interval(point.energy_slope_w),
        "rms_torque_nm": _tell_interval(point.rms_torque_nm),
    }


def _tell_interval(interval: Interval) -> Told:
    return {"value": interval.value, "ci95": [interval.low, interval.high]}
