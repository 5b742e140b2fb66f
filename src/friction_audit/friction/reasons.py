"""What the user must know about an estimate: negative coefficients, weak separation, two methods that disagree."""

from collections.abc import Iterator

import numpy as np

from friction_audit.friction.history import UNITS, Coefficient, JointFriction
from friction_audit.friction.settings import FEWEST_CYCLES, FrictionSettings
from friction_audit.joint_log import Float
from friction_audit.preprocessing.energy_cycles import GAP, KEPT, ONE_WAY, OPEN, SMALL, EnergyCycles
from friction_audit.preprocessing.interaction import Caution, Interaction

HIGHEST_CORRELATION = 0.97
FEW_CYCLES = 10
# Differences between two estimates below both of these are irrelevant.
LEAST_DIFFERENCE = 0.02  # N m, N m s/rad
LEAST_SHARE = 0.1
SMALLEST_SPREAD = 0.1  # coefficient of variation of the speed over the path below which a log has one speed only
LEAST_TRAVEL_RAD = 0.01  # a position that changes by less may only be noisy
SHORT_S = 5.0  # a shorter log holds no four strokes back and forth at usual speeds
STANDSTILL = 0.1  # share of the initiation threshold below which a joint stands still

MEANING = {
    "coulomb": "low-speed friction (Stribeck), friction that depends on position, or a gravity error pulls them apart",
    "viscous": "friction that is not linear in speed pulls them apart",
}


def cautions_of(joint: JointFriction) -> Iterator[Caution]:
    """Yield the cautions about one joint's estimate."""
    found = [("not_determined", joint.reason)] if joint.reason else [*_weaknesses(joint), *_disagreements(joint)]
    for code, message in found:
        yield Caution(code=code, joint=joint.joint, message=f"joint {joint.joint} ({joint.name}): {message}")


def _weaknesses(joint: JointFriction) -> Iterator[tuple[str, str]]:
    for name in UNITS:
        value = getattr(joint, name).value
        if value < 0:
            message = (
                f"negative {name} coefficient ({value:.3f}); no friction is negative, so the torque holds something "
                "else: check gravity, payload, a delay, or too little spread of speed"
            )
            yield f"negative_{name}", message
    if abs(joint.correlation) > HIGHEST_CORRELATION:
        message = (
            f"Coulomb and viscous coefficient are hardly separable here (correlation {joint.correlation:.3f}); their "
            "sum at the recorded speeds is sound, each alone is not; vary the speed"
        )
        yield "hardly_separable", message
    if joint.cycles < FEW_CYCLES:
        yield "few_cycles", f"only {joint.cycles} cycles; intervals from so few are wide and rough"


def _disagreements(joint: JointFriction) -> Iterator[tuple[str, str]]:
    """Compare the two methods, and the first full window of the history with the last, if they share no cycle."""
    for name in UNITS if joint.regression is not None else ():
        energy, torque = getattr(joint, name), getattr(joint.regression, name)
        if _disagree(energy, torque):
            message = (
                f"the {name} coefficient is {energy.value:.3f} by energy and {torque.value:.3f} by torque regression, "
                f"and the intervals do not meet; the interval covers both; {MEANING[name]}"
            )
            yield f"{name}_disagrees", message
    first = joint.window - 1 - (joint.cycles - len(joint.history.cycle))
    for name in UNITS if joint.cycles >= 2 * joint.window else ():
        columns = joint.history.of(name)
        early, late = (_at(columns, k) for k in (first, -1))
        if _disagree(early, late):
            message = (
                f"the {name} coefficient changes within the log, from {early.value:.3f} over the first {joint.window} "
                f"cycles to {late.value:.3f} over the last; the value for the whole log mixes both: look at the history"
            )
            yield f"{name}_changes", message


def _at(columns: tuple[Float, Float, Float], k: int) -> Coefficient:
    value, low, high = (float(column[k]) for column in columns)
    return Coefficient(value=value, low=low, high=high)


def _disagree(a: Coefficient, b: Coefficient) -> bool:
    apart = a.low > b.high or b.low > a.high
    return apart and abs(a.value - b.value) > max(LEAST_DIFFERENCE, LEAST_SHARE * abs(b.value))


ADVICE = {
    GAP: "a hole in the log lies in every one of these; record without dropping samples",
    OPEN: "gravity is taken to be still in the torque and no path returns to where it began; name the arm (--robot or "
    "--urdf), log gravity, say that it is removed already (--gravity removed), or move back and forth "
    "between the same postures",
    SMALL: "in none of these did every selected joint move far enough; move all joints, select fewer (--joints), or "
    "lower --min-path",
    ONE_WAY: "the joint moved one way only and never back, so there is no closed energy cycle and friction cannot be "
    "separated from gravity or a torque offset; move it there and back, several times and at different speeds",
}


def dead_channel(interaction: Interaction, column: int, *, dead_torque: bool) -> str:
    """Say which channel of a joint records nothing; empty if none.

    Args:
        interaction: Motion and torque.
        column: Joint, 0-based.
        dead_torque: Whether the reader found its torque dead; what is removed from a dead torque makes it move.
    """
    torque, q, dq = (channel[:, column] for channel in (interaction.torque, interaction.q, interaction.dq))
    travel, duration_s = float(np.ptp(q)), float(interaction.t[-1] - interaction.t[0])
    if dead_torque or (np.ptp(torque) == 0.0 and travel > LEAST_TRAVEL_RAD):
        level = f"is {torque[0]:.4g} N m in every sample" if np.ptp(torque) == 0.0 else "hardly changes while it moves"
        return f"its torque {level}: the channel is dead, or of another joint; check the sensor, or --map its column"
    if travel > LEAST_TRAVEL_RAD and np.abs(dq).max() * duration_s < 0.5 * travel:
        return (
            f"its velocity is at most {np.abs(dq).max():.2g} rad/s while its position changes by {travel:.3g} rad: dq "
            "is dead, or of another joint; --map its column (--map dq=NAME)"
        )
    return ""


def missing_motion(cycles: EnergyCycles, column: int, settings: FrictionSettings, duration_s: float) -> str:
    """Say why the cycles of one joint allow no estimate; empty if they do.

    Args:
        cycles: All cycles of this joint.
        column: Joint, 0-based, for its thresholds.
        settings: Settings of the estimate.
        duration_s: Length of the log. [s]
    """
    if not len(cycles.joint):
        return _no_cycle(cycles, column, duration_s)
    if not cycles.sums.path_rad.any():
        return "its position never changes while its velocity does; check that q and dq are of this joint (--map q=...)"
    kept = int((cycles.reason == KEPT).sum())
    fewest = FEWEST_CYCLES if settings.estimator == "weighted" else settings.cycles_per_point
    if kept >= fewest:
        return ""
    left_out = cycles.reason[cycles.reason != KEPT]
    advice = ADVICE.get(int(np.bincount(left_out).argmax()), "") if len(left_out) else ""
    if kept == 0:
        return f"{_count(len(left_out))} found, none usable: {advice}"
    shortage = f"only {_count(kept)} usable, at least {fewest} are needed"
    if len(left_out) > kept:
        return f"{shortage}; {len(left_out)} more were found and left out: {advice}"
    return f"{shortage}; record more strokes back and forth, or count slower ones with --thresholds auto"


def one_speed(cycles: EnergyCycles) -> str:
    """Say that Coulomb and viscous friction cannot be separated because all motion has one speed; empty if they can.

    Args:
        cycles: Cycles of one joint that count.
    """
    parts = cycles.parts
    path, square = parts.path_rad.ravel(), parts.square_speed_rad2_s.ravel()
    used = (path > 0) & (square > 0)
    path, speed = path[used], square[used] / path[used]
    mean = float(np.average(speed, weights=path))
    spread = float(np.sqrt(np.average((speed - mean) ** 2, weights=path))) / mean
    if spread >= SMALLEST_SPREAD:
        return ""
    level = float(parts.dissipated_j.sum() / path.sum())
    return (
        f"all motion has one speed ({mean:.2g} rad/s, spread {100 * spread:.0f} %): friction there is {level:.3f} N m, "
        "but its Coulomb and viscous parts cannot be separated; move at two or more speeds"
    )


def _no_cycle(cycles: EnergyCycles, column: int, duration_s: float) -> str:
    initiation, termination, fastest = (
        float(values[column]) for values in (cycles.initiation, cycles.termination, cycles.fastest)
    )
    unit = cycles.speed_unit
    speed = "its speed" if unit == "rad/s" else "the hand's speed"
    if fastest < STANDSTILL * initiation:
        return (
            f"did not move: {speed} never came near the initiation threshold {initiation:.2g} {unit}; move it back "
            "and forth"
        )
    if fastest <= initiation:
        return (
            f"moved too slowly: {speed} peaks at {fastest:.3g} {unit}, the initiation threshold is {initiation:.3g} "
            f"{unit}; move it back and forth faster, or lower the thresholds (--thresholds auto)"
        )
    if duration_s < SHORT_S:
        return f"no complete energy cycle: the log lasts {duration_s:.2g} s; record several strokes back and forth"
    return (
        f"no complete energy cycle in {duration_s:.3g} s: {speed} peaks at {fastest:.2g} {unit} but never came back "
        f"below {termination:.2g} {unit}; pause between strokes, or choose other --thresholds, as auto"
    )


def _count(cycles: int) -> str:
    return "1 cycle is" if cycles == 1 else f"{cycles} cycles are"
