"""The candidates that a log can show, as columns on the rows of a joint."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.find_contacts import contact_grid
from friction_audit.diagnosis.groups import Group, not_zero
from friction_audit.diagnosis.prewhitening import Prewhitening
from friction_audit.diagnosis.rows import Rows
from friction_audit.effects.contact_event import EFFECT as CONTACT
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.joint_log import Float

ROOM_BYTES = 2**22
"""Larger arrays come from the system each time, which clears them page by page."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Entry:
    """A candidate with the shapes that are tried, their columns on the rows, and what a search takes of them.

    ``trials`` tells of how many trials a shape was the best where the grid's are fewer.
    """

    candidate: Effect
    shapes: tuple[Nonlinear, ...]
    columns: tuple[Float, ...]
    group: Group
    trials: Callable[[Nonlinear], float] | None = None


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Library:
    """All that may be named on a joint.

    Attributes:
        entries: Candidates that the log can show.
        untestable: Why it cannot show the others, or some of their shapes, by name.
    """

    entries: tuple[Entry, ...]
    untestable: dict[str, str]

    def entry(self, name: str) -> Entry:
        """The entry of a name."""
        return next(entry for entry in self.entries if entry.candidate.name == name)


def build_library(candidates: Sequence[Effect], data: JointData, baseline: Nominal, rows: Rows) -> Library:
    """Ask every candidate whether the log can show it, and build its columns."""
    untestable = {candidate.name: candidate.not_identifiable(data, baseline) for candidate in candidates}
    shapes = {c.name: _grid(c, data) if untestable[c.name] is None else c.identifiable_part(data) for c in candidates}
    return Library(
        entries=tuple(_entry(c, shapes[c.name], data, baseline, rows) for c in candidates if shapes[c.name]),
        untestable={name: reason for name, reason in untestable.items() if reason is not None},
    )


def rebuild_library(library: Library, data: JointData, baseline: Nominal, rows: Rows) -> Library:
    """Build again what leans on the declared model, whose factors are better known."""
    entries = (
        _entry(entry.candidate, _grid(entry.candidate, data), data, baseline, rows)
        if entry.candidate.needs_nominal
        else entry
        for entry in library.entries
    )
    return Library(entries=tuple(entries), untestable=library.untestable)


def extend_library(library: Library, found: Iterable[tuple[str, Nonlinear, Float]]) -> Library:
    """Add a shape and its columns, zero columns included, to entries by name."""
    more: dict[str, list[tuple[Nonlinear, Float]]] = {}
    for name, shape, columns in found:
        more.setdefault(name, []).append((shape, columns))
    entries = (_with(entry, more.get(entry.candidate.name, [])) for entry in library.entries)
    return Library(entries=tuple(entries), untestable=library.untestable)


def without(library: Library, name: str) -> Library:
    """The library without one candidate."""
    kept = tuple(entry for entry in library.entries if entry.candidate.name != name)
    return Library(entries=kept, untestable=library.untestable)


def plainer(library: Library, name: str) -> Library:
    """The library without the richer shapes of one candidate."""
    entries = (_plainer(entry) if entry.candidate.name == name else entry for entry in library.entries)
    return Library(entries=tuple(entries), untestable=library.untestable)


def keep_rows(library: Library, kept: NDArray[np.bool_]) -> Library:
    """The library on some of the rows, shape (m,)."""
    entries = (
        _made(e.candidate, e.shapes, [columns[kept] for columns in e.columns], e.trials) for e in library.entries
    )
    return Library(entries=tuple(entries), untestable=library.untestable)


def prewhitened_library(library: Library, prewhitening: Prewhitening) -> Library:
    """The library as news of its rows."""
    entries = (
        _made(e.candidate, e.shapes, [prewhitening.of(columns) for columns in e.columns], e.trials)
        for e in library.entries
    )
    return Library(entries=tuple(entries), untestable=library.untestable)


def _plainer(entry: Entry) -> Entry:
    kept = [k for k, shape in enumerate(entry.shapes) if not entry.candidate.needs_gain(shape)]
    shapes, columns = tuple(entry.shapes[k] for k in kept), [entry.columns[k] for k in kept]
    return _made(entry.candidate, shapes, columns, entry.trials)


def _with(entry: Entry, more: Sequence[tuple[Nonlinear, Float]]) -> Entry:
    shapes, columns = (*entry.shapes, *(s for s, _ in more)), [*entry.columns, *(c for _, c in more)]
    return _made(entry.candidate, shapes, columns, entry.trials) if more else entry


def _grid(candidate: Effect, data: JointData) -> tuple[Nonlinear, ...]:
    return contact_grid(data) if candidate.name == CONTACT.name else candidate.grid(data)


def _entry(candidate: Effect, shapes: tuple[Nonlinear, ...], data: JointData, baseline: Nominal, rows: Rows) -> Entry:
    columns = _columns_on_rows(candidate.regressors(data, baseline, shapes), len(shapes), rows)
    return _made(candidate, shapes, columns, candidate.trials(data))


def _columns_on_rows(each: Iterator[tuple[int, Float]], shapes: int, rows: Rows) -> list[Float]:
    """Columns of each shape on the rows, shape (m, p) each, those of neighbours one behind the other in one array.

    There cross products read them at one go. Should shapes differ in width, those unlike the first have their own.
    """
    columns: dict[int, Float] = {}
    together: list[Float] = []
    for place, fine in each:
        if not columns:
            together = _room_for(shapes, fine.shape[1], len(rows.t))
        alike = together[place].shape[0] == fine.shape[1]
        columns[place] = rows.of(fine, together[place] if alike else None)
    return [columns[place] for place in range(shapes)]


def _room_for(shapes: int, width: int, samples: int) -> list[Float]:
    """Room for the columns of each shape, (p, m) each, in arrays so small that memory is used again for them."""
    many = max(ROOM_BYTES // max(8 * width * samples, 1), 1)
    arrays = [np.empty((min(many, shapes - first), width, samples)) for first in range(0, shapes, many)]
    return [room for array in arrays for room in array]


def _made(
    candidate: Effect,
    shapes: tuple[Nonlinear, ...],
    every: list[Float],
    trials: Callable[[Nonlinear], float] | None,
) -> Entry:
    there = [not_zero(columns) for columns in every]

    def admissible(factors: Float, shape: int) -> bool:
        whole = np.zeros(len(there[shape]))
        whole[there[shape]] = factors
        return candidate.admissible(whole, shapes[shape])

    # A column that is zero throughout has no factor that could be fitted and none to be paid for.
    kept = tuple(columns if which.all() else columns[:, which] for columns, which in zip(every, there, strict=True))
    tried = () if trials is None else tuple(trials(shape) for shape in shapes)
    group = Group(name=candidate.name, shapes=kept, admissible=admissible, tried=tried)
    return Entry(candidate=candidate, shapes=shapes, columns=tuple(every), group=group, trials=trials)
