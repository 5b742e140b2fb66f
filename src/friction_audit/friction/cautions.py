"""What the user must know about an estimate: negative coefficients, weak separation, two methods that disagree."""

import math
from collections.abc import Iterator

from friction_audit.friction.history import Coefficient, JointFriction
from friction_audit.interaction.interaction import Caution

HIGHEST_CORRELATION = 0.97
FEW_CYCLES = 10
LEAST_DIFFERENCE = {"coulomb": 0.02, "viscous": 0.02}
"""Differences between the two methods below this [N m, N m s/rad] matter to nobody."""

LEAST_SHARE = 0.1

MEANING = {
    "coulomb": "low-speed friction (Stribeck), friction that depends on position, or a gravity error pulls them apart",
    "viscous": "friction that is not linear in speed pulls them apart",
}


def cautions_of(joint: JointFriction) -> Iterator[Caution]:
    """Yield the cautions about one joint's estimate."""
    where = f"joint {joint.joint} ({joint.name})"
    if joint.reason:
        yield Caution(code="not_determined", joint=joint.joint, message=f"{where}: {joint.reason}")
        return
    yield from _negative(joint, where)
    if abs(joint.correlation) > HIGHEST_CORRELATION:
        message = (
            f"{where}: Coulomb and viscous coefficient are hardly separable here (correlation "
            f"{joint.correlation:.3f}); their sum at the recorded speeds is sound, each alone is not; vary the speed"
        )
        yield Caution(code="hardly_separable", joint=joint.joint, message=message)
    if joint.cycles < FEW_CYCLES:
        message = f"{where}: only {joint.cycles} cycles; intervals from so few are wide and rough"
        yield Caution(code="few_cycles", joint=joint.joint, message=message)
    yield from _disagreement(joint, where)
    yield from _change(joint, where)


def _change(joint: JointFriction, where: str) -> Iterator[Caution]:
    """Compare the first full window of the history with the last one, if they share no cycle."""
    history, cycles = joint.history, joint.cycles
    if cycles < 2 * joint.window:
        return
    first = joint.window - 1 - (cycles - len(history.cycle))
    for name, unit in (("coulomb", "nm"), ("viscous", "nms_per_rad")):
        value, low, high = (getattr(history, f"{name}{part}_{unit}") for part in ("", "_low", "_high"))
        early, late = (Coefficient(value=value[k], low=low[k], high=high[k]) for k in (first, -1))
        if _disagree(early, late, LEAST_DIFFERENCE[name]):
            message = (
                f"{where}: the {name} coefficient changes within the log, from {early.value:.3f} over the first "
                f"{joint.window} cycles to {late.value:.3f} over the last; the value for the whole log mixes both: "
                "look at the history"
            )
            yield Caution(code=f"{name}_changes", joint=joint.joint, message=message)


def _negative(joint: JointFriction, where: str) -> Iterator[Caution]:
    for name, coefficient in (("coulomb", joint.coulomb), ("viscous", joint.viscous)):
        if coefficient.value < 0:
            message = (
                f"{where}: negative {name} coefficient ({coefficient.value:.3f}); no friction is negative, so the "
                "torque holds something else: check gravity, payload, a delay, or too little spread of speed"
            )
            yield Caution(code=f"negative_{name}", joint=joint.joint, message=message)


def _disagreement(joint: JointFriction, where: str) -> Iterator[Caution]:
    if joint.regression is None:
        return
    pairs = (("coulomb", joint.coulomb, joint.regression.coulomb), ("viscous", joint.viscous, joint.regression.viscous))
    for name, energy, torque in pairs:
        if _disagree(energy, torque, LEAST_DIFFERENCE[name]):
            message = (
                f"{where}: the {name} coefficient is {energy.value:.3f} by energy and {torque.value:.3f} by torque "
                f"regression, and the intervals do not meet; the interval covers both; {MEANING[name]}"
            )
            yield Caution(code=f"{name}_disagrees", joint=joint.joint, message=message)


def _disagree(a: Coefficient, b: Coefficient, least: float) -> bool:
    apart = a.low > b.high or b.low > a.high
    return apart and math.fabs(a.value - b.value) > max(least, LEAST_SHARE * math.fabs(b.value))
