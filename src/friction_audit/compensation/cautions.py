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

    def caution(code: str, message: str) -> Caution:
        return Caution(code=code, joint=joint.joint, message=f"joint {joint.joint} ({joint.name}): {message}")

    if joint.reason:
        yield caution("not_replayed", joint.reason)
        return
    numbers, passivity = joint.numbers, joint.passivity
    assert numbers is not None
    assert passivity is not None
    if not isnan(numbers.diverged_s):
        yield caution(
            "diverged",
            f"the compensated loop diverges at {numbers.diverged_s:.4g} s; everything is given up to there; "
            "lower its gain, its factor, or its desired inertia's distance from the true one",
        )
    if passivity.hidden:
        yield caution(
            "over_compensation_hidden",
            f"at times over-compensated, and the passivity controller does not notice: the first cycles left "
            f"{passivity.reserve_j:.3g} J in its ledger, which hides the {-passivity.lowest_since_activation_j:.3g} J "
            "that the joint has given out since the compensator acts",
        )
    if numbers.limited_fraction > 0:
        yield caution(
            "torque_limited",
            f"the compensator is at a limit ({joint.limits.torque_nm:g} N m, {joint.limits.rate_nm_s:g} N m/s) in "
            f"{100 * numbers.limited_fraction:.2g} % of the samples; what is beyond is left out",
        )


def seems_compensated(
    interaction: Interaction, cycles: EnergyCycles, friction: JointFriction, robot: str
) -> Iterator[Caution]:
    """Yield a caution where friction looks as if a compensator had been active, and no column has its torque."""
    if interaction.compensation is not None or interaction.choice.drive != "hand" or friction.reason:
        return
    coefficients = {"Coulomb": friction.coulomb, "viscous": friction.viscous}
    negative = [name for name, found in coefficients.items() if found.high < 0]
    if negative:
        what = f"negative {' and '.join(negative)} friction"
    elif interaction.choice.sign_turned and interaction.choice.source == "interaction":
        what = "with the usual sign of the torque the joint gives out energy, as negative friction would"
    else:
        what = _vanishing(interaction, cycles, friction.joint) or _far_below(friction, robot)
    if what:
        message = (
            f"joint {friction.joint} ({friction.name}): {what}, as if a friction compensator had been active, and no "
            "column says so; the replay then means little; map its torque "
            "(--map tau_compensation=NAME), or record with it switched off"
        )
        yield Caution(code="seems_compensated", joint=friction.joint, message=message)


def _vanishing(interaction: Interaction, cycles: EnergyCycles, joint: int) -> str:
    """Say that friction is gone, from the start or after the first cycles; nothing where it is not."""
    column = interaction.joint_numbers.index(joint)
    own = cycles.of_joint(column)
    if len(own.start) < FEWEST_CYCLES or interaction.choice.gravity_in_torque:
        return ""
    work, path = own.work_j, own.sums.path_rad
    moving = np.concatenate(
        [interaction.torque[start:stop, column] for start, stop in zip(own.start, own.stop, strict=True)]
    )
    little = NEXT_TO_NOTHING * np.sqrt(np.mean(moving**2))
    half = len(work) // 2
    before, after = work[:UNCOMPENSATED].sum() / path[:UNCOMPENSATED].sum(), work[half:].sum() / path[half:].sum()
    if before > little and after < -GONE * before:
        return f"the joint gives out energy in the later half of the log ({after:.3f} N m on average)"
    if before > little and after < GONE * before:
        return f"friction all but vanishes within the log, from {before:.3f} to {after:.3f} N m"
    if abs(work.sum()) < little * path.sum():
        return "friction takes next to nothing of the work that moves the joint"
    return ""


def _far_below(friction: JointFriction, robot: str) -> str:
    """Say that friction is far below what a joint of this arm has; nothing where it is not, or the arm is unknown."""
    if robot not in PANDAS or not 1 <= friction.joint <= len(PUBLISHED):
        return ""
    usual = min(PUBLISHED[friction.joint - 1].plateaus_nm)
    if not friction.coulomb.high < FAR_BELOW * usual:
        return ""
    return f"Coulomb friction of {friction.coulomb.value:.3f} N m, far below the {usual:.2f} N m of such a joint"


def log_cautions(interaction: Interaction) -> Iterator[Caution]:
    """Yield cautions where the arm was not moved by hand, or gravity is still in the torque."""
    if interaction.choice.drive != "hand":
        message = "the arm moved by itself: torque and energy are those of its own drive, which is compensated for"
        yield Caution(code="arm_moves_itself", message=message)
    if interaction.choice.gravity_in_torque:
        message = (
            "gravity is still in the torque: a compensator would take what it gives and takes within a cycle for "
            "friction; remove it (--gravity model with --robot or --urdf, or log it)"
        )
        yield Caution(code="gravity_in_replay", message=message)
