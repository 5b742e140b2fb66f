"""Names that a log gives, as a figure can write them."""

from friction_audit.report.estimate_table import joint_label


def joint_title(joint: int, name: str) -> str:
    """Return what a panel of a figure calls a joint."""
    return f"joint {joint_label(joint, name)}"
