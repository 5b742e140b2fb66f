"""Cautions about an estimate, and reasons for none: negative coefficients, weak separation, methods that disagree."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from friction_audit.friction.history import UNITS, Coefficient, JointFriction
from friction_audit.friction.settings import FEWEST_CYCLES, FrictionSettings
from friction_audit.preprocessing.energy_cycles import KEPT, REASONS, EnergyCycles
from friction_audit.preprocessing.interaction import Caution, Interaction, Reason

HIGHEST_CORRELATION = 0.97
FEW_CYCLES = 10
ALIKE = 1e-6  # relative difference of sums over a cycle that only the rounding of the clock makes
# Differences between two estimates below both of these are irrelevant.
LEAST_DIFFERENCE = 0.02  # N m, N m s/rad
LEAST_SHARE = 0.1
SMALLEST_SPREAD = 0.1  # coefficient of variation of the speed over the path below which a log has one speed only
LEAST_TRAVEL_RAD = 0.01  # a position that changes by less may only be noisy
SHORT_S = 5.0  # a shorter log holds no four strokes back and forth at usual speeds
SIGN = ("clear", "uncertain")  # of a negative coefficient
ENOUGH = 1 << 16  # samples of a root mean square: it is right to a percent, enough for a bound
STANDSTILL = 0.1  # share of the initiation threshold below which a joint stands still


def timing_cautions(joint: JointFriction) -> Iterator[Caution]:
    """Yield a caution where the torque is certainly late after the motion, or early, or slow at reversals."""
    if joint.regression is None:
        return
    delay_s, turning = joint.regression.delay_s, joint.regression.turning
    if np.isfinite(delay_s):
        numbers = {"ms": 1e3 * abs(delay_s), "late": "late" if delay_s > 0.0 else "early"}
        yield Caution(code="torque_delayed", joint=joint.joint, numbers=numbers)
    elif turning is not None:
        yield Caution(code="slow_reversals", joint=joint.joint, numbers=dict(zip(UNITS, turning, strict=True)))


def repeated_cycles(joint: JointFriction, kept: EnergyCycles) -> Iterator[Caution]:
    """Yield a caution where cycles repeat earlier ones, energies and paths alike, though noise makes all others differ.

    A simulated periodic motion without noise has few cycles that differ: these are no copies.
    """
    sums = kept.sums
    columns = np.column_stack([sums.work_j, sums.path_rad, sums.square_speed_rad2_s])
    order = np.argsort(columns[:, 2])
    same = np.isclose(columns[order][1:], columns[order][:-1], rtol=ALIKE, atol=0.0).all(axis=1)
    count = int(np.count_nonzero(same))
    if FEWEST_CYCLES <= count <= len(order) // 2 and len(order) - count >= FEW_CYCLES:
        yield Caution(code="cycles_repeated", joint=joint.joint, numbers={"count": count})


def cautions_of(joint: JointFriction) -> tuple[Caution, ...]:
    """Return the cautions about one joint's estimate, or why there is none.

    Compare also the two methods, and the first full window of the history with the last, if they share no cycle.
    """
    if joint.reason:
        return (Caution("not_determined", joint=joint.joint, numbers={"reason": joint.reason}),)
    both = {f"negative_{name}": getattr(joint, name) for name in UNITS}
    found: dict[str, dict[str, Any]] = {n: {"case": SIGN[one.high >= 0]} for n, one in both.items() if one.value < 0}
    if abs(joint.correlation) > HIGHEST_CORRELATION:
        found["hardly_separable"] = {"most": HIGHEST_CORRELATION}
    if joint.cycles < FEW_CYCLES:
        found["few_cycles"] = {"fewest": FEW_CYCLES}
    for name in UNITS if joint.regression is not None else ():
        if _disagree(getattr(joint, name), getattr(joint.regression, name)):
            found[f"{name}_disagrees"] = {}
    first = joint.window - 1 - (joint.cycles - len(joint.history.cycle))
    for name in UNITS if joint.cycles >= 2 * joint.window else ():
        ends = np.column_stack(getattr(joint.history, name))[[first, -1]].tolist()
        early, late = (Coefficient(value=value, low=low, high=high) for value, low, high in ends)
        if _disagree(early, late):
            found[f"{name}_changes"] = {"early": early.value, "late": late.value, "cycles": joint.window}
    return tuple(Caution(code=code, joint=joint.joint, numbers=numbers) for code, numbers in found.items())


def _disagree(a: Coefficient, b: Coefficient) -> bool:
    apart = a.low > b.high or b.low > a.high
    return apart and abs(a.value - b.value) > max(LEAST_DIFFERENCE, LEAST_SHARE * abs(b.value))


class SignalRange:
    """Extremes and some samples of one joint's signals, gathered from parts of a log that follow each other."""

    def __init__(self, column: int, samples: int) -> None:
        """Take the joint (0-based) and the number of samples of the log."""
        self._column, self._every = column, max(samples // ENOUGH, 1)
        self.low, self.high = np.full(3, np.inf), np.full(3, -np.inf)  # of torque, q and dq
        self.first_torque, self.duration_s = np.nan, 0.0
        self._speed, self._torque = np.empty((2, -(-samples // self._every)))

    def take(self, part: Interaction) -> None:
        """Take the next samples."""
        torque, q, dq = (channel[:, self._column] for channel in (part.torque, part.q, part.dq))
        if np.isnan(self.first_torque):
            self.first_torque = float(torque[0])
        self.duration_s = float(part.t[-1])
        self.low = np.minimum(self.low, [one.min() for one in (torque, q, dq)])
        self.high = np.maximum(self.high, [one.max() for one in (torque, q, dq)])
        thin = slice(-part.first % self._every, None, self._every)
        own = slice(*(-(-row // self._every) for row in (part.first, part.first + len(part.t))))
        self._torque[own], self._speed[own] = part.driving(self._column, thin), dq[thin]

    def in_motion(self, standstill_rad_s: float) -> tuple[float, float]:
        """Return root mean squares of the torque [N m] and the speed [rad/s] of the samples that move."""
        moving = np.abs(self._speed) > standstill_rad_s
        torque, speed = (float(np.sqrt(np.mean(one[moving] ** 2))) for one in (self._torque, self._speed))
        return torque, speed


def dead_channel(seen: SignalRange, *, dead_torque: bool) -> Reason:
    """Say which channel of a joint records nothing; what is removed from a dead torque makes it move."""
    (changes, travel, _), fastest = seen.high - seen.low, max(seen.high[2], -seen.low[2])
    if dead_torque or (changes == 0.0 and travel > LEAST_TRAVEL_RAD):
        case = "constant" if changes == 0.0 else "noisy"
        return (Caution("dead_torque", numbers={"case": case, "level": seen.first_torque + 0.0}),)
    if travel > LEAST_TRAVEL_RAD and fastest * seen.duration_s < 0.5 * travel:
        return (Caution("dead_velocity", numbers={"fastest": fastest, "travel": travel}),)
    return ()


def missing_motion(cycles: EnergyCycles, settings: FrictionSettings, seen: SignalRange) -> Reason:
    """Say why all cycles of one joint, with its thresholds alone, allow no estimate; empty if they do."""
    if not len(cycles.start):
        initiation, fastest, travel_rad = cycles.initiation, cycles.fastest, float(seen.high[1] - seen.low[1])
        cases = {
            "did_not_move": fastest < STANDSTILL * initiation,
            "hardly_moved": fastest <= initiation and travel_rad < LEAST_TRAVEL_RAD,
            "moved_too_slowly": fastest <= initiation,
            "short_log": seen.duration_s < SHORT_S,
            "no_pause": True,
        }
        numbers: dict[str, Any] = {"initiation": initiation, "termination": cycles.termination, "fastest": fastest}
        numbers |= {"unit": cycles.speed_unit, "duration": seen.duration_s, "travel": travel_rad}
        return (Caution(next(code for code, holds in cases.items() if holds), numbers=numbers),)
    if not cycles.sums.path_rad.any():
        return (Caution("constant_position"),)
    kept = int((cycles.reason == KEPT).sum())
    fewest = FEWEST_CYCLES if settings.estimator == "weighted" else settings.cycles_per_point
    if kept >= fewest:
        return ()
    left_out = cycles.reason[cycles.reason != KEPT]
    case = REASONS[int(np.bincount(left_out).argmax())] if len(left_out) else ""
    code = "all_rejected" if kept == 0 else "most_rejected" if len(left_out) > kept else "few_usable"
    return (Caution(code, numbers={"fewest": fewest, "case": case}),)


def one_speed(cycles: EnergyCycles) -> Reason:
    """Say that all motion has one speed, which cannot separate Coulomb and viscous friction; empty if it can."""
    path, first, second = cycles.speeds.sum(axis=0).tolist()
    mean = first / path
    spread = max(second / path - mean**2, 0.0) ** 0.5 / mean
    numbers = {"mean": mean, "percent": 100 * spread, "level": float(cycles.sums.dissipated_j.sum()) / path}
    return () if spread >= SMALLEST_SPREAD else (Caution("one_speed", numbers=numbers),)
