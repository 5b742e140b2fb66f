"""What the loops read besides the joints, and the rows that they write."""

from typing import Any, NamedTuple

from friction_audit.joint_log import Float

(
    OUTER,
    OUTER_SPEED,
    INNER,
    SPEED,
    ACCELERATION,
    PORT,
    SUPPORT,
    FRICTION,
    COMPENSATION,
    PASSIVITY,
    UNLOGGED,
    DISSIPATED,
    WARMTH,
) = range(13)
ROWS = 13
"""What is kept of every tick: positions, velocities, torques, energy and warmth of each joint."""


class Clock(NamedTuple):
    """The controller's clock.

    Attributes:
        dt: Time from tick to tick. [s]
        substeps: Steps of the integration in half a tick.
        duration: Length of the recording. [s]
    """

    dt: float
    substeps: int
    duration: float


class Loop(NamedTuple):
    """The compensator in the loop and what it sees.

    Attributes:
        settings: Records of the compensators, shape (n,).
        memory: What they remember, shape (n,); changed.
        torque_noise: Error of the torque as read, shape (ticks + 1, n). [N m]
        velocity_noise: Error of the velocity as read, shape (ticks + 1, n). [rad/s]
        position_noise: Error of the position as read, shape (ticks + 1, n); no compensator looks at it. [rad]
        torque_step: Resolution of the torque, shape (n,). [N m]
        velocity_step: Resolution of the velocity, shape (n,). [rad/s]
    """

    settings: Any
    memory: Any
    torque_noise: Float
    velocity_noise: Float
    position_noise: Float
    torque_step: Float
    velocity_step: Float


class Parts(NamedTuple):
    """What the loops work on, all of it changed in place but the joints and the clock."""

    joints: Any
    """Records of the joints, shape (n,)."""
    states: Any
    """What they remember, shape (n,)."""
    events: Float
    """Contact events, shape (n, m, 3)."""
    body: Any
    """Coordinates and matrices."""
    loop: Loop
    """The compensators and what they see."""
    clock: Clock
    """The controller's clock."""
