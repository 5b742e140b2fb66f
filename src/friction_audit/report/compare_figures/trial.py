"""What figures show of a trial."""

from dataclasses import dataclass

from friction_audit.joint_log import Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class TrialCourse:
    """A method in one trial; n samples, up to where the loop was lost.

    Attributes:
        method: Name of the method.
        label: As in the legend.
        t: Time, shape (n,). [s]
        dq: Velocity of the joint shown, shape (n,). [rad/s]
        interaction_nm: Its interaction torque, shape (n,). [N m]
        energy_j: Net energy that the person has put into all joints, shape (n,). [J]
        from_s: End of the second cycle. [s]
        lost: Whether the loop was lost.
    """

    method: str
    label: str
    t: Float
    dq: Float
    interaction_nm: Float
    energy_j: Float
    from_s: float
    lost: bool
