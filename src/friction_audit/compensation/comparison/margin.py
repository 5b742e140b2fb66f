"""Stability margin: by which factor a method's gain may grow before the loop is lost."""

from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from math import inf, sqrt

from friction_audit.compensation.comparison.methods import Joint, Tuning
from friction_audit.compensation.compensators import (
    Compensator,
    DisturbanceObserver,
    EnergyCompensator,
    FixedCompensation,
    JointModelCompensation,
    LugreCompensation,
    SigmoidCompensation,
    TorqueRegulation,
)
from friction_audit.errors import UsageError

LARGEST = 32.0  # nobody asks for more
HALVINGS = 4  # the limit is then known to 2^(1/16), 4 %


def amplified(tuning: Tuning, factor: float) -> Tuning:
    """Return a tuning with its gain times a factor."""

    def make(joint: Joint) -> Compensator:
        return amplify(tuning.make(joint), factor)

    return replace(tuning, make=make)


def amplify(compensator: Compensator, factor: float) -> Compensator:
    """Return a compensator with its gain times a factor.

    The gain is what stands between what is measured and the torque: the whole law of a model, the factor on the
    estimate of the energy method, the bandwidth of an observer, the torque gain B / B_theta - 1 of a torque regulation.

    Raises:
        UsageError: For the terms of a model file, which run in a replay only.
    """
    match compensator:
        case FixedCompensation() | SigmoidCompensation() | LugreCompensation():
            return compensator.scaled(factor)
        case EnergyCompensator():
            return replace(compensator, factor=factor * compensator.factor)
        case DisturbanceObserver():
            return replace(compensator, observer_gain_per_s=factor * compensator.observer_gain_per_s)
        case TorqueRegulation():
            inertia = compensator.inertia_kg_m2 / (1.0 + factor * compensator.torque_gain)
            return replace(compensator, desired_inertia_kg_m2=inertia)
        case JointModelCompensation():
            raise UsageError("margin: the terms of a model file have no gain; expected a compensator of compare")


def search_margin() -> Generator[float, bool, float]:
    """Search the largest stable factor by doubling and bisection.

    Yields:
        A factor; expects to be sent whether the loop holds with it.

    Returns:
        The largest stable factor; infinity if ``LARGEST`` is stable, 0 if 1 is not.
    """
    if not (yield 1.0):
        return 0.0
    low, high = 1.0, 2.0
    while (yield high):
        if high >= LARGEST:
            return inf
        low, high = high, 2.0 * high
    for _ in range(HALVINGS):
        middle = sqrt(low * high)
        low, high = (middle, high) if (yield middle) else (low, middle)
    return low


def find_margins(searches: int, hold: Callable[[Sequence[tuple[int, float]]], Sequence[bool]]) -> list[float]:
    """Return several margins, searched for side by side.

    Args:
        searches: How many.
        hold: Numbers of searches, each with a factor -> whether their loops hold.
    """
    margins = [0.0] * searches
    under_way = {number: search_margin() for number in range(searches)}
    asked = {number: next(search) for number, search in under_way.items()}
    while asked:
        answers = hold(tuple(asked.items()))
        following: dict[int, float] = {}
        for number, answer in zip(asked, answers, strict=True):
            try:
                following[number] = under_way[number].send(answer)
            except StopIteration as end:
                margins[number] = end.value
        asked = following
    return margins
