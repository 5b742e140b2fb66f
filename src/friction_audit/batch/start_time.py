"""When a session started: from a manifest's cell, or from the name of the log or of the folders that it lies in."""

import re
from collections.abc import Iterable
from datetime import UTC, datetime

_DATE = r"(?P<year>(?:19|20)\d\d)(?P<s>[-_.]?)(?P<month>0[1-9]|1[0-2])(?P=s)(?P<day>0[1-9]|[12]\d|3[01])"
_CLOCK = r"(?P<hour>[01]\d|2[0-3])(?P<c>[-_.:]?)(?P<minute>[0-5]\d)(?:(?P=c)(?P<second>[0-5]\d)(?:[.,](?P<part>\d+))?)?"
_ZONE = r"(?P<zone>Z|[+-]\d\d:?\d\d)?"
_MOMENT = re.compile(rf"(?<!\d){_DATE}(?:[T _.-]+{_CLOCK}{_ZONE})?(?!\d)", re.IGNORECASE)
_EPOCH = re.compile(r"(?<!\d)(1\d{9})(?:(\d{3}|\d{6}|\d{9})|\.(\d+))?(?!\d)")
"""Seconds since 1970, from 2001 to 2033, as they are or in thousandths, millionths or billionths."""

_DATE_ONLY = re.compile(rf"(?<!\d){_DATE}(?!\d)")


def parse_time(text: str) -> float | None:
    """Return the Unix time of a cell: a date, a date and time (UTC if no zone is stated), or seconds; else None."""
    whole = _MOMENT.fullmatch(text)
    if whole is not None:
        return _unix_time(whole)
    seconds = re.fullmatch(r"\d{9,}(?:\.\d+)?", text)
    if seconds is None:
        return None
    named = _EPOCH.fullmatch(text)
    return float(text) if named is None else _seconds(named)


def time_in_name(names: Iterable[str]) -> float | None:
    """Return the Unix time in the first of the names that holds one. [s]

    A name without a zone is taken as UTC: what counts is the order and the distance of sessions.
    """
    for name in names:
        moment = _MOMENT.search(name)
        if moment is not None and (found := _unix_time(moment)) is not None:
            return found
        epoch = _EPOCH.search(name)
        if epoch is not None:
            return _seconds(epoch)
    return None


def holds_a_time(name: str) -> bool:
    """Return True if a name holds a date or a time: such a folder names a day, not a robot."""
    return _DATE_ONLY.search(name) is not None or _EPOCH.search(name) is not None


def _seconds(found: re.Match[str]) -> float:
    whole, finer, decimals = found.groups()
    if finer:
        return int(whole) + int(finer) / 10.0 ** len(finer)
    return float(f"{whole}.{decimals or 0}")


def _unix_time(found: re.Match[str]) -> float | None:
    date = f"{found['year']}-{found['month']}-{found['day']}"
    clock = f"{found['hour'] or '00'}:{found['minute'] or '00'}:{found['second'] or '00'}"
    zone = (found["zone"] or "+00:00").upper().replace("Z", "+00:00")
    try:
        moment = datetime.fromisoformat(f"{date}T{clock}{zone}").astimezone(UTC)
    except ValueError:  # 30 February
        return None
    return moment.timestamp() + float(f"0.{found['part'] or 0}")
