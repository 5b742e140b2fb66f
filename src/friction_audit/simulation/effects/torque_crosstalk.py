"""Torque crosstalk: a torque sensor also feels the load of the neighbouring joint."""

from collections.abc import Sequence
from dataclasses import dataclass

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import Effect, Parameter

NEXT, PREVIOUS, BOTH = range(3)

NEIGHBOURS = {NEXT: (1,), PREVIOUS: (-1,), BOTH: (-1, 1)}
"""Which neighbours a sensor feels; the next joint is nearer to the hand."""


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueCrosstalk:
    """Sensitivity of a torque sensor to the load of its neighbours.

    Attributes:
        share: Of the neighbour's torque that it reads.
        form: Index into the forms of the effect.
    """

    share: float = 0.0
    form: int = NEXT


def mixed(groups: Sequence[TorqueCrosstalk], torque: Float) -> Float:
    """Return the torques as sensors with crosstalk read them; without, the same to the bit, shape (n, j). [N m]

    Args:
        groups: The crosstalk of every sensor, j of them.
        torque: True torques, shape (n, j). [N m]
    """
    read = torque.copy()
    joints = range(torque.shape[1])
    for joint, group in enumerate(groups):
        for neighbour in (joint + offset for offset in NEIGHBOURS[group.form]):
            if group.share != 0.0 and neighbour in joints:
                read[:, joint] += group.share * torque[:, neighbour]
    return read


EFFECT = Effect(
    name="torque_crosstalk",
    family="sensors",
    summary="a torque sensor also feels the load of the neighbouring joint",
    group=TorqueCrosstalk,
    strength="share",
    parameters=(
        Parameter(name="share", usual=0.08, meaning="share of the neighbour's torque that is read", low=-1.0, high=1.0),
    ),
    forms=("next", "previous", "both"),
    needs_neighbours=True,
)
