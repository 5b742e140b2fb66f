"""Warnings about a replay."""

from collections.abc import Iterator
from math import isnan

import numpy as np

from friction_audit.compensation.compensators.model_based import PUBLISHED
from friction_audit.compensation.result import JointReplay
from friction_audit.compensation.settings import PANDAS
from friction_audit.friction.history import JointFriction
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.preprocessing.interaction import Caution, Interaction

FAR_BELOW = 0.25  # share of the published friction of its kind that no healthy joint falls below
# Mean friction torque over the rms torque below which no joint with a gear is; one moved fast by hand has 0.3.
NEXT_TO_NOTHING = 0.03
GONE = 0.1  # friction in the later half of a log over that of its beginning: joints that warm up keep half of it
UNCOMPENSATED = 2  # cycles before the compensator of the paper has an estimate
FEWEST_CYCLES = 4


def cautions_of(joint: JointReplay) -> Iterator[Caution]:
    """Yield the cautions about the replay of one joint."""

    def caution(code: str, **numbers: object) -> Caution:
        return Caution(code=code, joint=joint.joint, numbers={"name": joint.name, **numbers})

    if joint.reason:
        yield caution("not_replayed", reason=joint.reason)
        return
    numbers, passivity = joint.numbers, joint.passivity
    assert numbers is not None
    assert passivity is not None
    if not isnan(numbers.diverged_s):
        yield caution("diverged", at_s=numbers.diverged_s)
    if passivity.hidden:
        hidden = -passivity.lowest_since_activation_j
        yield caution("over_compensation_hidden", reserve=passivity.reserve_j, hidden=hidden)
    if numbers.limited_fraction > 0:
        percent = 100 * numbers.limited_fraction
        yield caution("torque_limited", torque=joint.limits.torque_nm, rate=joint.limits.rate_nm_s, percent=percent)


def square_in_cycles(part: Interaction, cycles: EnergyCycles, column: int) -> float:
    """Return the sum of the squared interaction torque over those samples of a part that lie in cycles of a joint."""
    own = cycles.joint == column
    borders = np.clip(np.stack([cycles.start[own], cycles.stop[own]]) - part.first, 0, len(part.t))
    start, stop = np.append(0.0, np.cumsum(part.torque[:, column] ** 2))[borders]
    return float((stop - start).sum())


def seems_compensated(
    interaction: Interaction, cycles: EnergyCycles, friction: JointFriction, robot: str, square: float
) -> Iterator[Caution]:
    """Yield a caution where friction looks as if a compensator had been active, and no column has its torque.

    ``square`` is the sum of the squared torque over the samples of all cycles.
    """
    if interaction.compensation is not None or interaction.choice.drive != "hand" or friction.reason:
        return
    coefficients = {"Coulomb": friction.coulomb, "viscous": friction.viscous}
    negative = [name for name, found in coefficients.items() if found.high < 0]
    if negative:
        found: dict[str, object] = {"sign": "negative"}
    elif interaction.choice.sign_turned and interaction.choice.source == "interaction":
        found = {"sign": "sign"}
    else:
        found = _vanishing(interaction, cycles, friction.joint, square) or _far_below(friction, robot)
    if found:
        numbers = {"name": friction.name, "names": " and ".join(negative), **found}
        yield Caution(code="seems_compensated", joint=friction.joint, numbers=numbers)


def _vanishing(interaction: Interaction, cycles: EnergyCycles, joint: int, square: float) -> dict[str, object]:
    """Return that friction is gone, from the start or after the first cycles; nothing where it is not."""
    own = cycles.joint == interaction.joint_numbers.index(joint)
    work, path, samples = cycles.work_j[own], cycles.sums.path_rad[own], (cycles.stop - cycles.start)[own]
    if len(work) < FEWEST_CYCLES or interaction.choice.gravity_in_torque:
        return {}
    little = NEXT_TO_NOTHING * np.sqrt(square / samples.sum())
    half = len(work) // 2
    before = float(work[:UNCOMPENSATED].sum() / path[:UNCOMPENSATED].sum())
    after = float(work[half:].sum() / path[half:].sum())
    if before > little and after < -GONE * before:
        return {"sign": "gives_out", "after": after}
    if before > little and after < GONE * before:
        return {"sign": "vanishes", "before": before, "after": after}
    return {"sign": "nothing"} if abs(work.sum()) < little * path.sum() else {}


def _far_below(friction: JointFriction, robot: str) -> dict[str, object]:
    """Return that friction is far below that of such a joint; nothing where it is not, or the arm is unknown."""
    if robot not in PANDAS or not 1 <= friction.joint <= len(PUBLISHED):
        return {}
    usual = min(PUBLISHED[friction.joint - 1].plateaus_nm)
    if not friction.coulomb.high < FAR_BELOW * usual:
        return {}
    return {"sign": "far_below", "coulomb": friction.coulomb.value, "usual": usual}


def log_cautions(interaction: Interaction) -> Iterator[Caution]:
    """Yield cautions where the arm was not moved by hand, or gravity is still in the torque."""
    if interaction.choice.drive != "hand":
        yield Caution(code="arm_moves_itself")
    if interaction.choice.gravity_in_torque:
        yield Caution(code="gravity_in_replay")
