"""Which clock of a message to trust: the robot's own, then the source's stamp, then the time of recording."""

from dataclasses import dataclass

import numpy as np

from friction_audit.ingest.message_stream import Int
from friction_audit.joint_log import Finding, Float

NANOSECONDS = 1e9
FIRST_UNIX_TIME_S = 1e9  # September 2001: below it, a clock counts from something else than 1970
DISAGREEMENT_SD_S = 5e-3
DISAGREEMENT_STEPS = 2.0
DISAGREEMENT_DRIFT = 2e-4
ROBOT_TIME_UNITS = ((1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds"))
UNIT_TOLERANCE = 0.2
CLOCK_TITLES = {"robot_time": "the robot's own time", "header_stamp": "the header stamp", "log_time": "the log time"}


@dataclass(frozen=True, eq=False, slots=True)
class MessageClock:
    """The clock chosen: name, t from its smallest value [s], Unix time of t = 0 or None, what was noticed."""

    name: str
    t: Float
    start_s: float | None
    findings: tuple[Finding, ...]


def choose_clock(log_time: Int, stamp: Int | None, robot_time: Float | None) -> MessageClock:
    """Choose the best clock that runs.

    Args:
        log_time: Time of recording, shape (n,). [ns]
        stamp: Time stamp of the source, if there is one. [ns]
        robot_time: The robot's own clock, if there is one. [s]
    """
    robot_time, units = (None, []) if robot_time is None else _in_seconds(robot_time, log_time)
    # Differences are taken in integers: 1.7e18 ns has no room for nanoseconds in a float64.
    offered = {
        "robot_time": None if robot_time is None else robot_time - np.min(robot_time),
        "header_stamp": None if stamp is None else (stamp - stamp.min()) / NANOSECONDS,
        "log_time": (log_time - log_time.min()) / NANOSECONDS,
    }
    clocks = {name: t for name, t in offered.items() if t is not None}
    stopped = [name for name, t in clocks.items() if not _runs(t)]
    chosen = next((name for name in clocks if name not in stopped), "log_time")
    findings = units + [_stopped_finding(name, chosen) for name in stopped if name != chosen]
    if chosen != "log_time":
        findings += _disagreement(clocks[chosen], clocks["log_time"], chosen)
    return MessageClock(chosen, clocks[chosen], _start(chosen, log_time, stamp), tuple(findings))


def _in_seconds(robot_time: Float, log_time: Int) -> tuple[Float, list[Finding]]:
    """Recognise a robot's clock that counts in milli-, micro- or nanoseconds: by that factor faster than the log."""
    logged_s = float(np.ptp(log_time)) / NANOSECONDS
    ratio = float(np.ptp(robot_time)) / logged_s if logged_s > 0.0 else 1.0
    for factor, unit in ROBOT_TIME_UNITS:
        if abs(ratio / factor - 1.0) < UNIT_TOLERANCE:
            message = (
                f"the robot's own time counts in {unit}, by comparison with the log time; it was divided by {factor:g}"
            )
            return robot_time / factor, [Finding(code="robot_time_unit", message=message, amount=factor)]
    return robot_time, []


def _runs(t: Float) -> bool:
    """Return True if a clock is finite and does not stand still; a single message cannot tell."""
    return bool(np.isfinite(t).all()) and (len(t) == 1 or bool(t.max() > 0.0))


def _stopped_finding(name: str, chosen: str) -> Finding:
    return Finding(
        code="clock_stopped",
        message=f"{CLOCK_TITLES[name]} is the same (or not a number) in all messages; {CLOCK_TITLES[chosen]} was used",
    )


def _start(chosen: str, log_time: Int, stamp: Int | None) -> float | None:
    """Return the Unix time of t = 0; the robot's clock counts from its start, so the log time stands in for it."""
    source = stamp if chosen == "header_stamp" and stamp is not None else log_time
    start_s = float(source.min()) / NANOSECONDS
    return start_s if start_s > FIRST_UNIX_TIME_S else None


def _disagreement(t: Float, log_t: Float, chosen: str) -> list[Finding]:
    """Compare the clock chosen with the log time: a drift, and what is left after it."""
    if len(t) < 3 or not log_t.max() > 0.0:  # noqa: PLR2004
        return []
    difference = log_t - t
    centred = t - t.mean()
    drift = float(centred @ difference / (centred @ centred))
    sd_s = float(np.std(difference - drift * centred))
    limit_s = max(DISAGREEMENT_SD_S, DISAGREEMENT_STEPS * float(t.max()) / (len(t) - 1))
    findings = []
    if sd_s > limit_s:
        text = f"{CLOCK_TITLES[chosen]} and the log time differ irregularly, standard deviation {sd_s * 1e3:.3g} ms"
        findings.append(Finding(code="clock_disagreement", amount=sd_s, message=f"{text}; {chosen} was used"))
    if abs(drift) > DISAGREEMENT_DRIFT and abs(drift) * t.max() > limit_s:
        text = f"the log time runs {drift * 100:+.3g} % against {CLOCK_TITLES[chosen]}"
        findings.append(Finding(code="clock_disagreement", amount=drift, message=f"{text}; {chosen} was used"))
    return findings
