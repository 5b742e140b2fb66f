"""The motion of a recording as a model of the joint reads it, and what the model leaves of the recorded torque."""

import numpy as np

from friction_audit.cycles.energy_cycles import EnergyCycles
from friction_audit.cycles.velocity import filter_velocity
from friction_audit.interaction.interaction import Interaction
from friction_audit.joint_log import Float, median_step
from friction_audit.model import JointModel
from friction_audit.model.term import Motion

CUTOFF_HZ = 20.0
"""Of the velocity, as in the torque regression."""


def recorded_motion(interaction: Interaction, column: int) -> Motion:
    """Return the motion of a joint (0-based), its velocity filtered without phase shift."""
    t, dq = interaction.t, interaction.dq[:, column]
    smooth = filter_velocity(dq, rate_hz=1.0 / median_step(t), cutoff_hz=CUTOFF_HZ)
    return Motion(t=t, q=np.ascontiguousarray(interaction.q[:, column]), dq=smooth, ddq=np.gradient(smooth, t))


def lacking_torque(motion: Motion, cycles: EnergyCycles, column: int, model: JointModel, total: Float) -> Float:
    """Return what a model leaves of the recorded torque, a constant for each cycle, shape (n,). [N m]

    Offsets and errors of gravity are about constant over a stroke, and would set the joint going by themselves.

    Args:
        motion: The recording, n samples.
        cycles: Its cycles.
        column: Joint, 0-based.
        model: Of the joint.
        total: Torque S = F_m + u, shape (n,). [N m]
    """
    left = total - model.torque(motion)
    moving = np.abs(motion.dq) > cycles.standstill_rad_s[column]
    lacking = np.full(len(motion.t), float(left[moving].mean()) if moving.any() else 0.0)
    own = cycles.of_joint(column)
    for start, stop in zip(own.start.tolist(), own.stop.tolist(), strict=True):
        piece = slice(start, stop)
        if moving[piece].any():
            lacking[piece] = left[piece][moving[piece]].mean()
    return lacking
