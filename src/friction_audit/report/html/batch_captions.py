"""Captions of the figures of a batch, and what each shows in words for those who do not see it."""

from friction_audit.drift.report import ArmDrift, JointDrift
from friction_audit.report.drift_words import (
    change_text,
    coefficient_name,
    count_of,
    drift_verdict,
    joint_verdict,
    total_text,
)
from friction_audit.report.estimate_table import joint_label

CAPTIONS = {
    "changes": "Change from the reference to the last sessions with its 95 % interval. The grey bar holds the straight "
    "changes that so many sessions would not have shown with 90 % power.",
    "drift": "Each session with its 95 % interval, as compared (at like temperature where it is known). Solid lines "
    "are levels between steps or a significant trend; a dashed line is a trend that is not significant. Hollow circles "
    "are sessions that were not compared.",
    "control": "Deviation of each session from the level of the reference. The grey band holds all sessions of a joint "
    "that does not change, together with 95 % probability; where a session tells too little, it is cut by the panel.",
    "curves": "Mean interaction torque in bins of velocity: the first session, the mean of the reference with the "
    "range of its sessions, and the last session.",
}
"""How to read each figure."""
TITLES = {
    "changes": "Change of each joint",
    "drift": "Coefficients over the sessions",
    "control": "Control chart",
    "curves": "Velocity-torque curves",
}
"""Title of each figure, in the order in which they are read."""
LEADS = {
    "changes": "Change of the coefficients of each joint",
    "drift": "Friction coefficients of each joint over the sessions",
    "control": "Deviation of each session from the reference, joint by joint",
    "curves": "Torque against velocity of each joint in the first session, the reference and the last session",
}


def describe(arm: ArmDrift, figure: str) -> str:
    """Return what a figure shows in words: of how many sessions, and what became of each joint."""
    said = "; ".join(_joint(arm, joint, figure) for joint in arm.joints)
    return f"{LEADS[figure]}, {count_of(len(arm.sessions), 'session')} of arm {arm.robot}. {said}."


def _joint(arm: ArmDrift, joint: JointDrift, figure: str) -> str:
    name = f"joint {joint_label(joint.joint, joint.name)}"
    if figure == "curves":
        return f"{name}: {joint_verdict(joint)}"
    if figure == "control":
        outside = sum(point.outside for found in joint.coefficients for point in found.control)
        return f"{name}: {count_of(outside, 'point')} outside the limits"
    return f"{name}: {', '.join(_coefficients(arm, joint))}"


def _coefficients(arm: ArmDrift, joint: JointDrift) -> list[str]:
    """Return what became of each coefficient, with its change and steps."""
    words = []
    for found in joint.coefficients:
        steps = "".join(f", step at {change_text(arm, change)}" for change in found.change_points)
        words.append(f"{coefficient_name(found.coefficient)} {drift_verdict(found)}, {total_text(found)}{steps}")
    return words
