"""Numbers of a hidden effect beside those that the detector gives, where both mean the same quantity."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import hypot
from typing import Any

from benchmarks.hidden_effects.draw import Case

Numbers = Mapping[str, tuple[float, float, float]]
"""Value and ends of the interval, by name."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Quantity:
    """One quantity.

    Attributes:
        effect: Name of the effect.
        form: Index of the generator's form in which it has that meaning; None for every form.
        parameter: Name that the detector gives it.
        hidden: ``hidden(group, case)``: its true value; the sign is a matter of convention and is left aside.
    """

    effect: str
    form: int | None
    parameter: str
    hidden: Callable[[Any, Case], float]


QUANTITIES: tuple[Quantity, ...] = (
    Quantity(
        effect="asymmetric_coulomb",
        form=None,
        parameter="coulomb_half_difference_nm",
        hidden=lambda group, _case: group.half_difference_nm,
    ),
    Quantity(
        effect="asymmetric_viscous",
        form=None,
        parameter="viscous_half_difference_nms_per_rad",
        hidden=lambda group, _case: group.half_difference_nms_per_rad,
    ),
    Quantity(effect="stribeck", form=0, parameter="stribeck_excess_nm", hidden=lambda group, _case: group.excess_nm),
    Quantity(
        effect="stribeck", form=0, parameter="stribeck_speed_rad_s", hidden=lambda group, _case: group.speed_rad_s
    ),
    Quantity(
        effect="torque_ripple",
        form=0,
        parameter="ripple_order",
        hidden=lambda group, _case: group.cycles_per_rev,
    ),
    Quantity(effect="torque_ripple", form=0, parameter="amplitude", hidden=lambda group, _case: group.torque_nm),
    Quantity(effect="gravity_error", form=None, parameter="amplitude", hidden=lambda group, _case: group.torque_nm),
    Quantity(effect="torque_bias", form=None, parameter="torque_bias_nm", hidden=lambda group, _case: group.torque_nm),
    Quantity(effect="time_delay", form=None, parameter="delay_s", hidden=lambda group, _case: group.delay_s),
    Quantity(
        effect="joint_elasticity",
        form=0,
        parameter="compliance_rad_per_nm",
        hidden=lambda group, _case: group.compliance_rad_per_nm,
    ),
    Quantity(effect="backlash", form=None, parameter="gap_rad", hidden=lambda group, _case: group.gap_rad),
    Quantity(
        effect="friction_step",
        form=0,
        parameter="step_time_s",
        hidden=lambda group, case: group.at_share * case.duration_s,
    ),
    Quantity(
        effect="friction_step",
        form=0,
        parameter="step_coulomb_nm",
        hidden=lambda group, case: group.change * case.joint.coulomb_nm,
    ),
    Quantity(effect="warm_up", form=0, parameter="warm_up_time_s", hidden=lambda group, _case: group.time_s),
    Quantity(
        effect="cable_spring",
        form=0,
        parameter="cable_stiffness_nm_per_rad",
        hidden=lambda group, _case: group.stiffness_nm_per_rad,
    ),
    Quantity(
        effect="inertia_error",
        form=None,
        parameter="extra_inertia_kg_m2",
        hidden=lambda group, _case: group.extra_kg_m2,
    ),
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
            truth = abs(quantity.hidden(group, case))
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
