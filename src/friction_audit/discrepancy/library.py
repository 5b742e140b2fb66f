"""The candidates that a log can show, as columns on the rows of a joint."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Candidate, Shape
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.rows import Rows
from friction_audit.discrepancy.search import Group
from friction_audit.joint_log import Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Entry:
    """A candidate with the shapes that are tried and their columns on the rows."""

    candidate: Candidate
    shapes: tuple[Shape, ...]
    group: Group


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Library:
    """All that may be named on a joint.

    Attributes:
        entries: Candidates that the log can show.
        untestable: Why it cannot show the others, by name.
    """

    entries: tuple[Entry, ...]
    untestable: dict[str, str]

    def entry(self, name: str) -> Entry:
        """The entry of a name."""
        return next(entry for entry in self.entries if entry.candidate.name == name)


def build_library(candidates: Sequence[Candidate], data: JointData, baseline: Baseline, rows: Rows) -> Library:
    """Ask every candidate whether the log can show it, and build its columns."""
    untestable = {candidate.name: candidate.untestable(data, baseline) for candidate in candidates}
    return Library(
        entries=tuple(_entry(c, data, baseline, rows) for c in candidates if untestable[c.name] is None),
        untestable={name: reason for name, reason in untestable.items() if reason is not None},
    )


def rebuild_library(library: Library, data: JointData, baseline: Baseline, rows: Rows) -> Library:
    """Build again what leans on the declared model, whose factors are better known."""
    entries = (
        _entry(entry.candidate, data, baseline, rows) if entry.candidate.leans_on_model else entry
        for entry in library.entries
    )
    return Library(entries=tuple(entries), untestable=library.untestable)


def _entry(candidate: Candidate, data: JointData, baseline: Baseline, rows: Rows) -> Entry:
    shapes = candidate.tried(data)
    every = [rows.of(candidate.columns(data, baseline, shape)) for shape in shapes]
    there = [np.any(columns != 0.0, axis=0) for columns in every]

    def admissible(factors: Float, shape: int) -> bool:
        whole = np.zeros(len(there[shape]))
        whole[there[shape]] = factors
        return candidate.admissible(whole, shapes[shape])

    # A column that is zero throughout has no factor that could be fitted and none to be paid for.
    kept = tuple(columns[:, which] for columns, which in zip(every, there, strict=True))
    return Entry(
        candidate=candidate, shapes=shapes, group=Group(name=candidate.name, shapes=kept, admissible=admissible)
    )
