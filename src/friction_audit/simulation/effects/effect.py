"""Hidden effects: deviations of real joints and sensors from the nominal model, with the simulator's own formulas."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import field, fields
from functools import partial
from math import inf, isclose, nan, sqrt
from typing import Any, ClassVar, NamedTuple, Self

from friction_audit.compensation.law import Checked
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.registry import effect_of
from friction_audit.errors import UsageError, kind_name, near_misses
from friction_audit.simulation.settings import JointParameters

FORM = "form"
LARGEST = 1e4  # of a parameter, in any unit: far above those of any joint

Values = Mapping[str, float]  # parameters of a term of a joint model, by name
Given = dict[str, float | str]  # parameters of a hidden effect, the form as its word

ALIKE = 0.05  # numbers that differ by a smaller share are taken for equal, for a fit never gives them exactly
alike = partial(isclose, rel_tol=ALIKE)


class Setting(NamedTuple):
    """Joint and recording, on which the parameters that equal a term of a joint model depend."""

    joint: JointParameters  # inertia and friction of the joint
    start_rad: float  # where the joint is at the start; the simulator counts some positions from there [rad]
    driven: bool  # true if the joint moves by itself
    duration_s: float  # length of the recording [s]
    outer_kg_m2: float = inf  # inertia on the measured side; infinite where it is not one number, as of an arm [kg m^2]

    def with_both_sides_free(self, damping_ratio: float) -> float:
        """Return the damping ratio with both sides free that is this one with the measured side held."""
        return damping_ratio * sqrt(1.0 + self.joint.inertia_kg_m2 / self.outer_kg_m2)


class NoEqualError(Exception):
    """Why the simulator has no equal of a term of a joint model."""


def number(usual: float, meaning: str, unit: str = "1", *, off: bool = False, **bounds: Any) -> Any:  # noqa: ANN401
    """Return a field of a hidden effect: usual value, meaning, unit and bounds, by default at least zero.

    Unit and bounds are those of the parameter ``like`` of the effect of the same name, where there is one.
    """
    about = {"default": usual, "unit": unit, "meaning": meaning, "like": "", "lower": 0.0, "upper": inf} | bounds
    return field(default=0.0 if off else usual, metadata=about)


strength = partial(number, off=True)  # the first field: at zero, where it is not named, the effect does nothing


class HiddenEffect(Checked):
    """Parameters of a hidden effect; with their defaults it has no influence.

    Its name is that of its class and of the effect in a diagnosis, from which it has bounds.
    """

    summary: ClassVar[str] = ""  # one line
    forms: ClassVar[tuple[str, ...]] = ()  # functional forms in the literature, the usual one first
    needs_neighbours: ClassVar[bool] = False  # if True, it takes an arm of several joints
    felt_at_rest: ClassVar[bool] = False  # if True, it shows in a joint that stands still, its neighbours too
    # the form whose formula equals that of the effect in a joint model; None where none does
    same_law: ClassVar[str | None] = None
    stands_for: ClassVar[tuple[str, ...]] = ()  # other terms of a joint model that it equals
    name: ClassVar[str] = ""
    strength_name: ClassVar[str]  # of the parameter that switches it off at zero

    form: int = 0  # index into ``forms``

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        cls.name = kind_name(cls)
        cls.strength_name = fields(cls)[1].name

    @classmethod
    def parameters(cls) -> tuple[Parameter, ...]:
        """Return all parameters, in the order of the documentation, the strength first."""
        alike, found = {one.name: one for one in effect_of(cls.name).parameters}, []
        for item in fields(cls)[1:]:
            about = dict(item.metadata)
            if like := alike.get(about.pop("like")):
                # The strength may be zero: then there is no effect.
                about["lower"] = min(like.lower, 0.0) if item.name == cls.strength_name else like.lower
                about["upper"] = like.upper if like.upper == inf else min(like.upper, LARGEST)
                about["unit"] = like.unit
            found.append(Parameter(item.name, **about))
        return tuple(found)

    @classmethod
    def make(cls, given: Mapping[str, str | float]) -> Self:
        """Return the effect with the given parameters by name, ``form`` among them, the others as usual."""
        known = {parameter.name: parameter for parameter in cls.parameters()}
        names = [*known, *([FORM] if cls.forms else [])]
        numbers: dict[str, Any] = {name: parameter.default for name, parameter in known.items()}
        for name, value in given.items():
            where = f"--effect {cls.name}: {name}={value}"
            if name not in names:
                near = near_misses(name, names)
                raise UsageError(f"--effect {cls.name}: no parameter {name}; expected {', '.join(names)}{near}")
            if name == FORM:
                if value not in cls.forms:
                    raise UsageError(f"{where}: expected one of {', '.join(cls.forms)}")
                numbers[FORM] = cls.forms.index(str(value))
                continue
            low, high = max(known[name].lower, -LARGEST), min(known[name].upper, LARGEST)
            numbers[name] = nan
            with suppress(ValueError):
                numbers[name] = float(value)
            if not low <= numbers[name] <= high:
                about = described(known[name])
                raise UsageError(f"{where}: expected a number from {low:g} to {high:g}: {about}")
        return cls(**numbers)

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        """Return the parameters, form among them, that equal a term of a joint model, or raise NoEqualError."""
        if cls.same_law is None:
            raise NoEqualError("its own formulas differ")
        given: Given = dict(zip((item.name for item in fields(cls)[1:]), values.values(), strict=True))
        return given | ({FORM: cls.same_law} if cls.same_law else {})

    def values(self) -> dict[str, Any]:
        """Return its parameters by name, the form as its word."""
        numbers = {item.name: getattr(self, item.name) for item in fields(self)[1:]}
        return numbers | ({FORM: self.forms[self.form]} if self.forms else {})


def described(parameter: Parameter) -> str:
    """Return meaning and unit of a parameter."""
    return parameter.meaning + ("" if parameter.unit == "1" else f" [{parameter.unit}]")


def must(holds: bool, reason: str) -> None:
    """Raise the reason as ``NoEqualError`` unless something holds."""
    if not holds:
        raise NoEqualError(reason)
