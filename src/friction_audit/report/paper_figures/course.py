"""What the paper's figures show of one joint."""

from dataclasses import dataclass

from friction_audit.joint_log import Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Course:
    """One joint over time; n samples, m ends of cycles.

    Attributes:
        t: Time, shape (n,). [s]
        dq: Velocity, shape (n,). [rad/s]
        interaction_nm: Interaction torque F_m, shape (n,). [N m]
        energy_j: Net energy E_m, shape (n,). [J]
        ends_s: When cycles end, shape (m,). [s]
        ends_j: Net energy then, shape (m,). [J]
        coulomb_nm: Coulomb friction compensated, shape (n,). [N m]
        viscous_nms_per_rad: Viscous friction compensated, shape (n,). [N m s/rad]
        damping_nms_per_rad: Damping of the passivity controller, shape (n,). [N m s/rad]
    """

    t: Float
    dq: Float
    interaction_nm: Float
    energy_j: Float
    ends_s: Float
    ends_j: Float
    coulomb_nm: Float
    viscous_nms_per_rad: Float
    damping_nms_per_rad: Float
