"""What an effect is: something real joints and sensors do, hidden in a synthetic log."""

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from friction_audit.errors import UsageError

FORM = "form"

LARGEST = 1e4
"""What no parameter of a joint comes near, in whatever unit: larger ones are slips, infinite ones no numbers."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Parameter:
    """A number that an effect can be told.

    Attributes:
        name: Its name, the unit as suffix; a field of the effect's group.
        usual: What it is when nothing is said.
        meaning: One line, with the unit in brackets.
        low: Smallest value that makes sense.
        high: Largest value that makes sense.
    """

    name: str
    usual: float
    meaning: str
    low: float = 0.0
    high: float = float("inf")


@dataclass(frozen=True, kw_only=True, slots=True)
class Effect:
    """One effect: its name, its parameters and the group of numbers that the mechanics read.

    Attributes:
        name: As in design and documentation; also the field of ``Hidden`` that holds its group.
        family: ``velocity``, ``load and place``, ``sensors``, ``structure`` or ``slow and events``.
        summary: One line.
        group: Frozen dataclass of its numbers; made without arguments it does nothing.
        strength: The parameter that switches it off at zero.
        parameters: All of them, in the order of the documentation.
        forms: Functional forms in the literature; the group's ``form`` is an index into them.
        needs_neighbours: If True, it takes an arm of several joints.
    """

    name: str
    family: str
    summary: str
    group: type[Any]
    strength: str
    parameters: tuple[Parameter, ...]
    forms: tuple[str, ...] = ()
    needs_neighbours: bool = False

    def make(self, given: Mapping[str, str]) -> Any:  # noqa: ANN401 - every effect has its own group
        """Return the group with the given parameters, the others as usual.

        Args:
            given: Values by parameter name, ``form`` among them, as text.

        Raises:
            UsageError: If a name, a number or a form is wrong.
        """
        known = {parameter.name: parameter for parameter in self.parameters}
        self._refuse_unknown(given, [*known, *([FORM] if self.forms else [])])
        numbers = {name: self._number(known[name], text) for name, text in given.items() if name != FORM}
        usual = {name: parameter.usual for name, parameter in known.items()}
        form = {FORM: self._form(given[FORM])} if FORM in given else {}
        return self.group(**(usual | numbers | form))

    def _refuse_unknown(self, given: Mapping[str, str], names: list[str]) -> None:
        for name in given:
            if name not in names:
                near = difflib.get_close_matches(name, names, 1)
                hint = f"; did you mean {near[0]}?" if near else ""
                raise UsageError(f"--effect {self.name}: no parameter {name}; expected {', '.join(names)}{hint}")

    def _number(self, parameter: Parameter, text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        low, high = max(parameter.low, -LARGEST), min(parameter.high, LARGEST)
        if not low <= value <= high:
            raise UsageError(
                f"--effect {self.name}: {parameter.name}={text}: expected a number from {low:g} to {high:g}: "
                f"{parameter.meaning}"
            )
        return value

    def _form(self, text: str) -> int:
        if text not in self.forms:
            raise UsageError(f"--effect {self.name}: form={text}: expected one of {', '.join(self.forms)}")
        return self.forms.index(text)

    def is_hidden(self, group: object) -> bool:
        """Return True if a group of this effect does anything."""
        return bool(getattr(group, self.strength) != 0.0)

    def values(self, group: Any) -> dict[str, float | str]:  # noqa: ANN401
        """Return the parameters of a group by name, the form as its word."""
        numbers = {item.name: getattr(group, item.name) for item in fields(group) if item.name != FORM}
        return numbers | ({FORM: self.forms[group.form]} if self.forms else {})
