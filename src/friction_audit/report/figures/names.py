"""Names that a log gives, as a figure can write them."""

from friction_audit.report.estimate_table import joint_label


def joint_title(joint: int, name: str) -> str:
    """Return what a panel of a figure calls a joint."""
    return f"joint {printable(joint_label(joint, name))}"


def printable(name: str) -> str:
    """Return a name without characters that no font can draw and no drawing can hold."""
    return "".join(letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in name)
