"""The clock of messages: the robot's own time, the header stamp, or the time of recording."""

from dataclasses import dataclass

import numpy as np

from friction_audit.io.readers.message_stream import Int
from friction_audit.joint_log import Finding, Float

_NANOSECONDS = 1e9
_FIRST_UNIX_TIME_S = 1e9  # September 2001: below it, a clock counts from something else than 1970
_DISAGREEMENT_SD_S = 5e-3
_DISAGREEMENT_STEPS = 2.0
_DISAGREEMENT_DRIFT = 2e-4
_ROBOT_TIME_UNITS = ((1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds"))
_UNIT_TOLERANCE = 0.2
_TITLES = {"robot_time": "the robot's own time", "header_stamp": "the header stamp", "log_time": "the log time"}


@dataclass(frozen=True, eq=False, slots=True)
class MessageClock:
    """The clock chosen: name, t from its smallest value [s], its reading at t = 0, and that if it is Unix time."""

    name: str
    t: Float
    origin_s: float
    start_s: float | None
    findings: tuple[Finding, ...]


def choose_clock(log_time: Int, stamp: Int | None, robot_time: Float | None) -> MessageClock:
    """Choose the best clock that runs.

    Args:
        log_time: Time of recording, shape (n,) [ns]
        stamp: Time stamp of the source, if there is one. [ns]
        robot_time: The robot's own clock, if there is one. [s]
    """
    robot_time, findings = (None, []) if robot_time is None else _in_seconds(robot_time, log_time)
    # Differences are taken in integers: 1.7e18 ns has no room for nanoseconds in a float64.
    offered = {
        "robot_time": None if robot_time is None else robot_time - np.min(robot_time),
        "header_stamp": None if stamp is None else (stamp - stamp.min()) / _NANOSECONDS,
        "log_time": (log_time - log_time.min()) / _NANOSECONDS,
    }
    clocks = {name: t for name, t in offered.items() if t is not None}
    # A single message cannot show that a clock runs.
    running = [n for n, t in clocks.items() if np.isfinite(t).all() and (len(t) == 1 or t.max() > 0.0)]
    chosen = next(iter(running), "log_time")
    for name in (name for name in clocks if name not in (*running, chosen)):
        text = f"{_TITLES[name]} is the same (or not a number) in all messages; {_TITLES[chosen]} was used"
        findings.append(Finding(code="clock_stopped", message=text))
    if chosen != "log_time":
        findings += _disagreement(clocks[chosen], clocks["log_time"], chosen)
    # The robot's clock counts from its start, so the log time stands in for it.
    source = stamp if chosen == "header_stamp" and stamp is not None else log_time
    start_s = float(source.min()) / _NANOSECONDS
    unix_s = start_s if start_s > _FIRST_UNIX_TIME_S else None
    return MessageClock(chosen, clocks[chosen], start_s, unix_s, tuple(findings))


def _in_seconds(robot_time: Float, log_time: Int) -> tuple[Float, list[Finding]]:
    """Recognise a robot's clock that counts in milli-, micro- or nanoseconds: by that factor faster than the log."""
    logged_s = float(np.ptp(log_time)) / _NANOSECONDS
    ratio = float(np.ptp(robot_time)) / logged_s if logged_s > 0.0 else 1.0
    for factor, unit in _ROBOT_TIME_UNITS:
        if abs(ratio / factor - 1.0) < _UNIT_TOLERANCE:
            text = (
                f"the robot's own time counts in {unit}, by comparison with the log time; it was divided by {factor:g}"
            )
            return robot_time / factor, [Finding(code="robot_time_unit", message=text, amount=factor)]
    return robot_time, []


def _disagreement(t: Float, log_t: Float, chosen: str) -> list[Finding]:
    """Compare the clock chosen with the log time: a drift, and what is left after it."""
    if len(t) < 3 or not log_t.max() > 0.0:  # noqa: PLR2004
        return []
    difference = log_t - t
    centred = t - t.mean()
    drift = float(centred @ difference / (centred @ centred))
    sd_s = float(np.std(difference - drift * centred))
    limit_s = max(_DISAGREEMENT_SD_S, _DISAGREEMENT_STEPS * float(t.max()) / (len(t) - 1))
    findings = []
    if sd_s > limit_s:
        text = f"{_TITLES[chosen]} and the log time differ irregularly, standard deviation {sd_s * 1e3:.3g} ms"
        findings.append(Finding(code="clock_disagreement", amount=sd_s, message=f"{text}; {chosen} was used"))
    if abs(drift) > _DISAGREEMENT_DRIFT and abs(drift) * t.max() > limit_s:
        text = f"the log time runs {drift * 100:+.3g} % against {_TITLES[chosen]}"
        findings.append(Finding(code="clock_disagreement", amount=drift, message=f"{text}; {chosen} was used"))
    return findings
