"""The model of the arm of a log, where it is known, whatever the torque was made of."""

from importlib.util import find_spec

from friction_audit.interaction.interaction import TorqueChoice
from friction_audit.interaction.plan import PANDA_JOINTS, known_robot
from friction_audit.interaction.settings import TorqueSettings
from friction_audit.joint_log import JointLog
from friction_audit.robot import Arm, load_arm


def known_arm(log: JointLog, settings: TorqueSettings, choice: TorqueChoice) -> Arm | None:
    """Return the model that the torque was made with, or that the log or the user names; None where none is known.

    Raises:
        UsageError: If a URDF was given that cannot be read.
    """
    robot = known_robot(log, settings)
    panda = robot == "panda" and len(log.joint_names) == PANDA_JOINTS
    if not (robot == "urdf" or panda or choice.robot != "none") or find_spec("pinocchio") is None:
        return None
    arm = load_arm(settings.urdf, settings.payload, settings.gravity_vector)
    return arm.matched(log.joint_names, log.source.path)
