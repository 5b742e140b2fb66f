"""What a log calls its arm: the name before its joints, else the namespace of its topic."""

from collections.abc import Sequence

from friction_audit.ingest.joint_order import arm_name, arms_in
from friction_audit.ingest.topic_choice import namespace
from friction_audit.joint_log import Source


def arm_told_by(source: Source, joint_names: Sequence[str]) -> str:
    """Return the serial number or the name of the arm of a log, or nothing where the log tells neither.

    ``left`` of joints called ``left_joint1``, or of a topic ``/left/joint_states``; nothing of ``panda_joint1``, which
    every Panda's are called.
    """
    if source.serial:
        return source.serial
    prefixes = list(arms_in(joint_names))
    named = arm_name(prefixes[0]) if len(prefixes) == 1 else ""
    return named or namespace(source.topic or "")
