"""What was recorded of one joint."""

from typing import NamedTuple

import numpy as np

from friction_audit.joint_log import Float, read_only
from friction_audit.preprocessing.interaction import Interaction


class Port(NamedTuple):
    """One joint's recording, n samples.

    Attributes:
        t: Time. [s]
        dq: Velocity. [rad/s]
        torque: Interaction torque F_m. [N m]
        logged: Torque of a compensator that was active, shape (n,), or empty. [N m]
    """

    t: Float
    dq: Float
    torque: Float
    logged: Float

    @property
    def total(self) -> Float:
        """Torque S = F_m + u that drove the inner side, shape (n,). [N m]"""
        return self.torque + self.logged if len(self.logged) else self.torque


class Course(NamedTuple):
    """Torques that come out of a replay, n samples; a torque at sample i is the one in force at t[i].

    Attributes:
        interaction: Torque of the person. [N m]
        compensation: Torque of the compensator's law. [N m]
        passivity: Torque of its passivity controller. [N m]
    """

    interaction: Float
    compensation: Float
    passivity: Float


def port_of(interaction: Interaction, column: int) -> Port:
    """Return the recording of a joint (0-based), column after column in memory."""
    logged = np.empty(0) if interaction.compensation is None else interaction.compensation[:, column]
    return Port(*map(read_only, (interaction.t, interaction.dq[:, column], interaction.torque[:, column], logged)))


def empty_course(samples: int) -> Course:
    """Return the place for the torques of a replay."""
    return Course(np.empty(samples), np.empty(samples), np.empty(samples))
