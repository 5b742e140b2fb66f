"""What a figure needs of one joint, cut out of an Estimate."""

from dataclasses import dataclass, replace

import numpy as np

from friction_audit.audit import Estimate
from friction_audit.cycles.energy_cycles import EnergyCycles
from friction_audit.errors import UsageError
from friction_audit.friction.history import JointFriction
from friction_audit.joint_log import Float
from friction_audit.report.figures.names import joint_title


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointSeries:
    """One joint's signals, cycles and friction.

    Attributes:
        number: Joint number for people.
        name: Name in the log.
        t: Time, shape (n,). [s]
        dq: Velocity, shape (n,). [rad/s]
        torque: Interaction torque, shape (n,). [N m]
        compensation: Torque of a logged compensator, shape (n,), or None. [N m]
        cycles: Its cycles; start and stop are indices into the arrays above.
        friction: Its coefficients.
    """

    number: int
    name: str
    t: Float
    dq: Float
    torque: Float
    compensation: Float | None
    cycles: EnergyCycles
    friction: JointFriction

    @property
    def title(self) -> str:
        """What a panel is called: the joint's number, and its name where that says more."""
        return joint_title(self.number, self.name)

    @property
    def not_determined(self) -> str:
        """The words for a panel without an estimate, without the advice behind the semicolon; empty if there is one."""
        return f"not determined: {self.friction.reason.partition(';')[0]}" if self.friction.reason else ""

    @property
    def driving_torque(self) -> Float:
        """What acts against friction and inertia: F_m + u, shape (n,). [N m]"""
        return self.torque if self.compensation is None else self.torque + self.compensation

    def first_cycles(self, count: int) -> "JointSeries":
        """Return the stretch of the log that the first cycles fill; all of it without any cycle."""
        if not len(self.cycles.joint):
            return self
        kept = self.cycles.rows(np.arange(len(self.cycles.joint)) < count)
        begin, end = int(kept.start[0]), int(kept.stop[-1]) + 1
        return replace(
            self,
            t=self.t[begin:end],
            dq=self.dq[begin:end],
            torque=self.torque[begin:end],
            compensation=None if self.compensation is None else self.compensation[begin:end],
            cycles=replace(kept, start=kept.start - begin, stop=kept.stop - begin),
        )


def joint_series(estimate: Estimate, joint: int) -> JointSeries:
    """Return the series of a joint, given by its number for people.

    Raises:
        UsageError: If the result does not hold that joint.
    """
    numbers = estimate.interaction.joint_numbers
    if joint not in numbers:
        held = ", ".join(map(str, numbers))
        raise UsageError(f"joint {joint}: not in this result, which holds {held}; choose one of them")
    column = numbers.index(joint)
    compensation = estimate.interaction.compensation
    return JointSeries(
        number=joint,
        name=estimate.interaction.joint_names[column],
        t=estimate.interaction.t,
        dq=estimate.interaction.dq[:, column],
        torque=estimate.interaction.torque[:, column],
        compensation=None if compensation is None else compensation[:, column],
        cycles=estimate.cycles.of_joint(column),
        friction=next(found for found in estimate.friction.joints if found.joint == joint),
    )


def all_series(estimate: Estimate) -> tuple[JointSeries, ...]:
    """Return the series of every joint of a result, in order."""
    return tuple(joint_series(estimate, joint) for joint in estimate.interaction.joint_numbers)
