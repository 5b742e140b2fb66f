"""What a compensation method is, what it may be told, and what is varied to find out how much that matters."""

from collections.abc import Callable
from dataclasses import dataclass

from friction_audit.replay.compensators import Compensator
from friction_audit.replay.limits import PANDA_TORQUE_NM, PANDA_TORQUE_RATE_NM_S
from friction_audit.simulate.settings import JointParameters

PAPER, BEST, OTHER = "paper", "best", "other"
"""Roles of a tuning: the paper's kind, the best stable one of the sweeps, or one beside."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Joint:
    """What a method may be told about a joint.

    Attributes:
        column: Which joint of the arm, counted from 0.
        parameters: Motor and friction, as they truly are.
        max_torque_nm: What the joint can give. [N m]
        max_torque_rate_nm_s: How fast it can change. [N m/s]
    """

    column: int
    parameters: JointParameters
    max_torque_nm: float
    max_torque_rate_nm_s: float


def panda_joint(column: int, parameters: JointParameters) -> Joint:
    """Return a joint with the limits of that joint of a Panda."""
    return Joint(
        column=column,
        parameters=parameters,
        max_torque_nm=PANDA_TORQUE_NM[column],
        max_torque_rate_nm_s=PANDA_TORQUE_RATE_NM_S,
    )


Make = Callable[[Joint], Compensator]
"""Joint -> compensator."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Tuning:
    """One way to set a method up.

    Attributes:
        name: Short name.
        meaning: What it means, in words.
        make: Joint -> compensator.
    """

    name: str
    meaning: str
    make: Make


@dataclass(frozen=True, kw_only=True, slots=True)
class Sweep:
    """One setting of a method, varied.

    Attributes:
        name: What all of its tunings share.
        axis: Name of the setting with its unit.
        values: From careful to bold.
        at: Value -> tuning.
    """

    name: str
    axis: str
    values: tuple[float, ...]
    at: Callable[[float], Tuning]


@dataclass(frozen=True, kw_only=True, slots=True)
class ByHand:
    """Tuned as on a robot: bolder until it rings or diverges, then back.

    Attributes:
        sweep: Name of the sweep that is followed.
        back: The boldest stable value, times this.
    """

    sweep: str
    back: float = 0.5


@dataclass(frozen=True, kw_only=True, slots=True)
class Method:
    """A way to compensate friction.

    Attributes:
        name: As in options and documents.
        label: As in tables and figures.
        paper: The paper's kind of tuning, or how it is found.
        others: Further tunings that are reported.
        sweeps: What is varied; the best stable tuning of all sweeps is reported.
    """

    name: str
    label: str
    paper: Tuning | ByHand
    others: tuple[Tuning, ...] = ()
    sweeps: tuple[Sweep, ...] = ()
