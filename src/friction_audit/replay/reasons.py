"""Why a replay means nothing for a joint, in a sentence with the motion that would help."""

import numpy as np

from friction_audit.friction.history import JointFriction
from friction_audit.replay.compensators import Compensator, EnergyCompensator
from friction_audit.replay.records import ESTIMATED, GAP, NOT_MOVED, TOO_ALIKE
from friction_audit.replay.result import ReplayHistory

ADVICE = {
    GAP: "holes in the log; record without dropping samples",
    NOT_MOVED: "the joint hardly moved; move it farther",
    TOO_ALIKE: "they are too alike to tell Coulomb from viscous friction; vary the speed, raise --window, or choose "
    "--model coulomb or viscous",
}


def missing_estimate(history: ReplayHistory, friction: JointFriction, compensator: Compensator) -> str:
    """Say why there was nothing to apply; empty if there was.

    Args:
        history: Per cycle of the compensator.
        friction: What the whole log says.
        compensator: What ran.
    """
    cycles = len(history.status)
    if not cycles:
        return friction.reason or (
            "no energy cycle ended while a controller would have watched; pause between strokes, or choose other "
            "--thresholds"
        )
    if not isinstance(compensator, EnergyCompensator) or compensator.forced is not None:
        return ""
    if (history.status == ESTIMATED).any():
        return ""
    some = "1 cycle" if cycles == 1 else f"{cycles} cycles"
    refused = history.status[history.status >= NOT_MOVED]
    if len(refused):
        return f"no estimate in {some}: {ADVICE[int(np.bincount(refused).argmax())]}"
    return f"only {some}, and the compensator needs {compensator.cycles_per_estimate}; record more strokes"
