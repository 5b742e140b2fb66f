"""Torque crosstalk: a torque sensor also feels the load of the neighbouring joint."""

from collections.abc import Sequence
from dataclasses import dataclass

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import Given, HiddenEffect, Setting, Values, alike, must, strength

NEXT, PREVIOUS, BOTH = range(3)

# Which neighbours a sensor feels; the next joint is nearer to the hand.
NEIGHBOURS = {NEXT: (1,), PREVIOUS: (-1,), BOTH: (-1, 1)}


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueCrosstalk(HiddenEffect):
    """Sensitivity of a torque sensor to the load of its neighbours."""

    summary = "a torque sensor also feels the load of the neighbouring joint"
    felt_at_rest = True
    forms = ("next", "previous", "both")
    needs_neighbours = True

    share: float = strength(0.08, "share of the neighbour's torque that is read", lower=-1.0, upper=1.0)
    form: int = NEXT

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        before, after, side = values.values()
        before, after = before * (side <= 0), after * (side >= 0)
        if before == 0.0 or after == 0.0:
            return {"share": before + after, "form": "next" if before == 0.0 else "previous"}
        must(alike(before, after), "its sensors feel both neighbours alike")
        return {"share": 0.5 * (before + after), "form": "both"}


def mixed(groups: Sequence[TorqueCrosstalk], torque: Float) -> Float:
    """Return the torques as sensors with crosstalk read them; without, the same to the bit, shape (n, j). [N m]"""
    read = torque.copy()
    joints = range(torque.shape[1])
    for joint, group in enumerate(groups):
        for neighbour in (joint + offset for offset in NEIGHBOURS[group.form]):
            if group.share != 0.0 and neighbour in joints:
                read[:, joint] += group.share * torque[:, neighbour]
    return read
