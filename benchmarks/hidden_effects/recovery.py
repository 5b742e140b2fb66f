"""Numbers of a hidden effect next to those that the detector gives, where both mean the same quantity."""

from collections.abc import Callable, Mapping
from math import hypot
from typing import Any, NamedTuple

from benchmarks.hidden_effects.draw import Case

Numbers = Mapping[str, tuple[float, float, float]]
"""Value and ends of the interval, by name."""


class Quantity(NamedTuple):
    """One quantity."""

    effect: str
    form: int | None  # index of the generator's form in which it has that meaning; None for every form
    parameter: str  # name that the detector gives it
    hidden: str | Callable[[Any, Case], float]  # its true value, or the generator's name of it; its sign is left aside


QUANTITIES = (
    Quantity("asymmetric_coulomb", None, "coulomb_half_difference_nm", "half_difference_nm"),
    Quantity("asymmetric_viscous", None, "viscous_half_difference_nms_per_rad", "half_difference_nms_per_rad"),
    Quantity("stribeck", 0, "stribeck_excess_nm", "excess_nm"),
    Quantity("stribeck", 0, "stribeck_speed_rad_s", "speed_rad_s"),
    Quantity("torque_ripple", 0, "ripple_order", "cycles_per_rev"),
    Quantity("torque_ripple", 0, "amplitude", "torque_nm"),
    Quantity("gravity_error", None, "amplitude", "torque_nm"),
    Quantity("torque_bias", None, "torque_bias_nm", "torque_nm"),
    Quantity("time_delay", None, "delay_s", "delay_s"),
    Quantity("joint_elasticity", 0, "compliance_rad_per_nm", "compliance_rad_per_nm"),
    Quantity("backlash", None, "gap_rad", "gap_rad"),
    Quantity("friction_step", 0, "step_time_s", lambda group, case: group.at_share * case.duration_s),
    Quantity("friction_step", 0, "step_coulomb_nm", lambda group, case: group.change * case.joint.coulomb_nm),
    Quantity("warm_up", 0, "warm_up_time_s", "time_s"),
    Quantity("cable_spring", 0, "cable_stiffness_nm_per_rad", "stiffness_nm_per_rad"),
    Quantity("inertia_error", None, "extra_inertia_kg_m2", "extra_kg_m2"),
)

WAVES = {"torque_ripple": ("ripple_cos_nm", "ripple_sin_nm"), "gravity_error": ("gravity_cos_nm", "gravity_sin_nm")}
"""Two factors of a wave, whose amplitude is compared and has no interval of its own."""


def compared(effect: str, group: Any, case: Case, found: Numbers) -> list[dict[str, object]]:  # noqa: ANN401
    """Truth, estimate, half of the interval and whether it holds the truth, of every quantity that both sides know."""
    rows: list[dict[str, object]] = []
    for quantity in QUANTITIES:
        if quantity.effect != effect or quantity.form not in {None, getattr(group, "form", None)}:
            continue
        estimate = _estimate(quantity, found)
        if estimate is not None:
            value, low, high = estimate
            hidden = quantity.hidden
            truth = abs(getattr(group, hidden) if isinstance(hidden, str) else hidden(group, case))
            holds = None if low != low else low <= truth <= high  # noqa: PLR0124 - not a number
            half = None if holds is None else (high - low) / 2.0
            numbers = {"truth": truth, "estimate": value, "half_width": half}
            rows.append({"parameter": quantity.parameter, **numbers, "holds": holds})
    return rows


def _estimate(quantity: Quantity, found: Numbers) -> tuple[float, float, float] | None:
    """Value and interval without their sign; an amplitude without an interval; None where it was not found."""
    nan = float("nan")
    if quantity.parameter == "amplitude":
        one, two = WAVES[quantity.effect]
        return (hypot(found[one][0], found[two][0]), nan, nan) if one in found and two in found else None
    if quantity.parameter not in found:
        return None
    value, low, high = found[quantity.parameter]
    return (value, low, high) if value >= 0 else (-value, -high, -low)
