"""The clock of a table, and that of messages: which it is, in which unit, and the exact way from there to seconds."""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.joint_log import Finding, Float

UNITS = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}  # units per second
# Name, unit if the name says it, clock; the better clock first: robot, header, log.
_NAMES: tuple[tuple[str, str | None, str], ...] = (
    (r"field\.time|robot_time|state\.time", None, "robot_time"),
    (r"(?:field\.)?header\.stamp|header_stamp|.*[./]header[./]stamp", None, "header_stamp"),
    (r"stamp", None, "header_stamp"),
    (r"%time", "ns", "log_time"),
    (r"log_?time|publish_?time|receive_?time", None, "log_time"),
    (r"duration|time|t|timestamps?|times|__time|elapsed(?:_time)?|time_since_[a-z_]+?|seconds|clock", None, "column"),
    (r"date_?time|(?:joint|robot|ros|unix|epoch|host|system|experiment)_?(?:time|stamp|timestamp)", None, "column"),
)
_UNITS_SPELLED = "milliseconds|msec|ms|nanoseconds|nsec|ns|microseconds|usec|us|µs|seconds|sec|s"
_UNIT = rf"(?:(?:[ _]+|[ _]*[\[(])(?P<unit>{_UNITS_SPELLED})[\])]?)?"
_SPELLED = {"mil": "ms", "mse": "ms", "ms": "ms", "nan": "ns", "nse": "ns", "ns": "ns", "mic": "us", "use": "us",
            "us": "us", "µs": "us"}  # fmt: skip
_SECONDS = re.compile(r"(?P<head>(?:.*[._/]|ZeitIn)?)secs?", re.IGNORECASE)
_EPOCH_S = (1.1e9, 4.1e9)  # Unix time between the years 2004 and 2099
LONGEST_BACKWARDS_S = 1.0  # a clock that goes back further was set anew
_LONGEST_S = 1e10  # three centuries: from no stamp to the last one in nanoseconds


class TimeColumn(NamedTuple):
    """The column that is the clock."""

    cells: tuple[int, ...]  # its position; two for seconds and nanoseconds kept apart
    name: str  # its name in the file
    unit: str | None  # "s", "ms", "us", "ns", or None when the median step decides
    clock: str  # "robot_time", "header_stamp", "log_time" or "column"


class Clock(NamedTuple):
    """A clock read."""

    t: Float  # time since the first sample, of messages since the earliest, shape (n,) [s]
    start_s: float | None  # unix time of that sample, or None [s]
    unit: str  # the unit found
    origin_s: float = 0.0  # reading of the clock at t = 0 [s]
    # Of messages: which clock it is, its smallest reading, and what is to be said of the clocks.
    name: str = ""
    first: Any = 0
    findings: tuple[Finding, ...] = ()


def find_time(names: Sequence[str], constant: Collection[int] = ()) -> TimeColumn | None:
    """Return the best clock among columns of these names, or None."""
    bare = [name.strip() for name in names]
    first, second, *_ = [*map(str.lower, bare[:2]), "", ""]
    if second in ("success rate", "success_rate") and first in ("duration", "time"):
        return TimeColumn(cells=(0,), name=bare[0], unit="ms", clock="robot_time")  # libfranka's logToCSV
    if (split := _split_stamp(bare)) and split.cells[1] not in constant:
        return split
    for text, unit, clock in _NAMES:
        for cell, name in enumerate(bare):
            match = re.fullmatch(rf"(?:{text}){_UNIT}", name, re.IGNORECASE)
            if match is not None and cell not in constant:
                spelled = match["unit"] and _SPELLED.get(match["unit"].lower()[:3], "s")
                return TimeColumn(cells=(cell,), name=name, unit=spelled or unit, clock=clock)
    return None


@dataclass
class Stamps:
    """The stamps of a table, piece by piece: they count from the first one that is a number."""

    unit: str | None  # None until their values decide
    origin: Any = None

    def since(self, parts: Sequence[NDArray[Any]]) -> Float:
        """Return the stamps in one column, or in those of seconds and nanoseconds, less the origin, in their unit.

        Integers are subtracted before they lose digits.
        """
        whole = (one.dtype.kind in "iu" or (len(parts) > 1 and bool(np.isfinite(one).all())) for one in parts)
        kind: Any = np.int64 if all(whole) else np.float64
        raw, *rest = (part.astype(kind) for part in parts)
        raw = raw * int(UNITS["ns"]) + rest[0] if rest else raw
        if self.origin is None and np.isfinite(raw).any():
            self.origin = raw[np.isfinite(raw).argmax()]
        return np.full(len(raw), np.nan) if self.origin is None else (raw - self.origin).astype(np.float64, copy=False)

    def unit_of(self, elapsed: Float) -> float:
        """Return the units per second; the first stamps decide: a Unix time, or steps of a log of 5 Hz to 5 kHz."""
        origin = float(self.origin)
        self.unit = self.unit or next((u for u, n in UNITS.items() if _EPOCH_S[0] < origin / n < _EPOCH_S[1]), None)
        if self.unit is None:
            # The median is of stamps that differ: joints, or two recordings, may share theirs.
            in_order = not (elapsed[1:] < elapsed[:-1]).any()
            lots = (elapsed[: 1 << 16], elapsed) if in_order else (elapsed,)
            found = (steps for lot in lots if len(steps := np.diff(np.unique(lot[np.isfinite(lot)]))))
            step = float(np.median(next(found, np.zeros(1))))
            self.unit = next((unit for unit, most in (("s", 0.2), ("ms", 200.0), ("us", 2e5)) if step < most), "ns")
        return UNITS[self.unit]

    def clock(self, elapsed: Float, path: str) -> Clock:
        """Return the clock of stamps since the origin, None where no stamp is a number; works in place."""
        if len(elapsed) == 0:
            raise InputError(f"{path}: 0 samples; the table has a header and no rows; record the arm while it moves")
        if self.origin is None or not np.isfinite(elapsed).any():
            what = f"time holds no number in {len(elapsed)} rows"
            raise InputError(f"{path}: {what}; name another clock with --map t=<column>")
        if (per_second := self.unit_of(elapsed)) != 1.0:
            elapsed /= per_second
        far = max(-np.nanmin(elapsed), np.nanmax(elapsed))
        if _LONGEST_S < far < np.inf:  # before its square overflows
            row = int(np.nanargmax(np.abs(elapsed)))
            what = f"the stamp of row {row + 1} is {elapsed[row]:.3g} s from the first one; expected one recording"
            raise InputError(f"{path}: {what}; remove the row, or name another clock with --map t=<column>")
        start_s = float(self.origin) / per_second
        return Clock(elapsed, start_s if _EPOCH_S[0] < start_s < _EPOCH_S[1] else None, str(self.unit), start_s)


def _split_stamp(names: Sequence[str]) -> TimeColumn | None:
    """Find a stamp kept as whole seconds and nanoseconds, as ROS messages do."""
    lower = {name.lower(): cell for cell, name in reversed(list(enumerate(names)))}
    for name, cell in sorted(lower.items(), key=lambda item: item[1]):
        match = _SECONDS.fullmatch(name)
        partners = [f"{match['head']}{part}" for part in ("nsecs", "nsec", "nanosec", "nanosecs")] if match else []
        for partner in (lower[one] for one in partners if one in lower):
            both = f"{names[cell]} + {names[partner]}"
            return TimeColumn(cells=(cell, partner), name=both, unit="ns", clock="header_stamp")
    return None


_NANOSECONDS = 10**9
# Clocks of messages and their units, the best first: of the robot, of the source, of the recorder.
CLOCKS = {"robot_time": "s", "header_stamp": "ns", "log_time": "ns"}
Times = Mapping[str, NDArray[Any]]  # clock that all messages have -> its readings, nanoseconds as integers
_FIRST_UNIX_TIME_S = 1e9  # September 2001: below it, a clock counts from something else than 1970
_DISAGREEMENT_SD_S, _DISAGREEMENT_STEPS, _DISAGREEMENT_DRIFT = 5e-3, 2.0, 2e-4
_ROBOT_TIME_UNITS = {"ms": "milliseconds", "us": "microseconds", "ns": "nanoseconds"}
_UNIT_TOLERANCE = 0.2
_TITLES = {"robot_time": "the robot's own time", "header_stamp": "the header stamp", "log_time": "the log time"}


def choose_clock(times: Times) -> Clock:
    """Choose the best clock that runs."""
    units, findings = dict(CLOCKS), list[Finding]()
    logged_s = float(np.ptp(times["log_time"])) / _NANOSECONDS
    if "robot_time" in times and logged_s > 0.0:  # one in milli-, micro- or nanoseconds is so much faster than the log
        ratio = float(np.ptp(times["robot_time"])) / logged_s
        for unit, spelled in _ROBOT_TIME_UNITS.items():
            if abs(ratio / (factor := UNITS[unit]) - 1.0) < _UNIT_TOLERANCE:
                units["robot_time"] = unit
                text = f"the robot's own time counts in {spelled} by the log time; it was divided by {factor:g}"
                findings.append(Finding("robot_time_unit", text, amount=factor))
    # Differences are taken in integers: 1.7e18 ns has no room for nanoseconds in a float64.
    first = {name: times[name].min() for name in units if name in times}
    clocks: dict[str, Float] = {name: (times[name] - low) / UNITS[units[name]] for name, low in first.items()}
    # How far each goes back; a single message cannot show that a clock runs.
    is_running = (n for n, t in clocks.items() if np.isfinite(t).all() and (len(t) == 1 or t.max() > 0.0))
    running = {n: float((np.maximum.accumulate(clocks[n]) - clocks[n]).max()) for n in is_running}
    chosen = next((n for n, s in running.items() if s <= LONGEST_BACKWARDS_S), next(iter(running), "log_time"))
    texts = {n: f"goes back by {running[n]:.4g} s" for n in [*running][: [*running, chosen].index(chosen)]}
    texts |= {n: "is the same (or not a number) in all messages" for n in clocks if n not in (*running, chosen)}
    used = f"{_TITLES[chosen]} was used"
    findings += [Finding("clock_stopped", f"{_TITLES[n]} {text}; {used}") for n, text in texts.items()]
    if chosen != "log_time":
        findings += _disagreement(clocks[chosen], clocks["log_time"], chosen)
    # The robot's clock counts from its start, so the log time stands in for it.
    start_s = float(first["log_time" if chosen == "robot_time" else chosen]) / _NANOSECONDS
    unix_s = start_s if start_s > _FIRST_UNIX_TIME_S else None
    return Clock(clocks[chosen], unix_s, units[chosen], start_s, chosen, first[chosen], tuple(findings))


def _disagreement(t: Float, log_t: Float, chosen: str) -> list[Finding]:
    """Compare the clock chosen with the log time: a drift, and what is left after it."""
    if len(t) < 3 or not log_t.max() > 0.0:  # noqa: PLR2004
        return []
    rest, centred = log_t - t, t - t.mean()
    # Not by BLAS: the threads that it begins for long vectors would keep the other core busy for a while.
    drift = float(np.einsum("i,i", centred, rest) / np.einsum("i,i", centred, centred))
    centred *= drift
    rest -= centred
    sd_s = float(np.std(rest))
    limit_s = max(_DISAGREEMENT_SD_S, _DISAGREEMENT_STEPS * float(t.max()) / (len(t) - 1))
    texts = {}
    if sd_s > limit_s:
        texts[f"{_TITLES[chosen]} and the log time differ irregularly, standard deviation {sd_s * 1e3:.3g} ms"] = sd_s
    if abs(drift) > _DISAGREEMENT_DRIFT and abs(drift) * t.max() > limit_s:
        texts[f"the log time runs {drift * 100:+.3g} % against {_TITLES[chosen]}"] = drift
    return [Finding("clock_disagreement", f"{text}; {chosen} was used", amount=one) for text, one in texts.items()]
