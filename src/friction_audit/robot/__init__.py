"""The rigid-body model of the arm: gravity, inverse dynamics, hand velocity; payload. MuJoCo does the dynamics."""

from friction_audit.robot.arm import STANDARD_GRAVITY, Arm, load_arm, read_urdf

__all__ = ["STANDARD_GRAVITY", "Arm", "load_arm", "read_urdf"]
