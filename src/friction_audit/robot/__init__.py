"""The rigid-body model of the arm: gravity, inverse dynamics, hand velocity; payload. Pinocchio does the dynamics."""

from friction_audit.robot.arm import Arm, load_arm

__all__ = ["Arm", "load_arm"]
