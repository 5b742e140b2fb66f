"""The order of the sessions: by start, or by name where starts are not known."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from friction_audit.drift.session import Session


@dataclass(frozen=True, kw_only=True, slots=True)
class Order:
    """Sessions in order.

    Attributes:
        sessions: All of them.
        by: ``"start"`` or ``"name"``.
        left_out: Index of each one that has no place among the others, with the reason.
    """

    sessions: tuple[Session, ...]
    by: str
    left_out: tuple[tuple[int, str], ...] = ()


def put_in_order(sessions: Sequence[Session]) -> Order:
    """Order the sessions of one arm; most have a start or their names have to tell."""
    named = sorted(sessions, key=lambda session: (natural(session.path), session.sha256))
    known = [session for session in named if session.start_s is not None]
    if 2 * len(known) <= len(named):
        return Order(sessions=tuple(named), by="name")
    known.sort(key=lambda session: session.start_s or 0.0)
    unknown = [session for session in named if session.start_s is None]
    reason = "nothing tells when it was recorded, as is known of the others; give its start in the manifest"
    left_out = tuple((len(known) + i, reason) for i in range(len(unknown)))
    return Order(sessions=(*known, *unknown), by="start", left_out=left_out)


def natural(path: str) -> tuple[tuple[int, int, str], ...]:
    """Return what sorts ``run2`` before ``run10``."""
    parts = re.split(r"(\d+)", path)
    return tuple((1, int(part), "") if part.isdecimal() else (0, 0, part.casefold()) for part in parts if part)
