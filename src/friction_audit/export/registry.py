"""All targets of an export, and the file that each one makes."""

from pathlib import Path

from friction_audit.errors import InputError, UsageError
from friction_audit.export import cpp_header, csv_table, isaac_lab, mjcf, ros2_control, sdf, urdf, usd
from friction_audit.export.target import Target
from friction_audit.export.xml_text import XmlText

TARGETS: tuple[Target, ...] = (
    urdf.TARGET,
    mjcf.TARGET,
    sdf.TARGET,
    usd.TARGET,
    isaac_lab.TARGET,
    cpp_header.TARGET,
    ros2_control.TARGET,
    csv_table.TARGET,
)


def choose_target(out: Path) -> Target:
    """Return the target whose suffix a file has.

    Raises:
        UsageError: If there is none.
    """
    found = next((target for target in TARGETS if target.suffix == out.suffix.lower()), None)
    if found is None:
        known = ", ".join(f"{target.suffix} ({target.name})" for target in TARGETS)
        raise UsageError(f"{out}: the suffix {out.suffix!r} names no format of an export; expected {known}")
    return found


def read_into(target: Target, path: Path) -> XmlText:
    """Read the user's file that friction is written into.

    Raises:
        UsageError: If the format takes no such file.
        InputError: If it cannot be read or is no XML.
    """
    if target.joints_of is None:
        takers = ", ".join(one.suffix for one in TARGETS if one.joints_of is not None)
        raise UsageError(f"--into {path}: {target.name} makes a new file; --into is for {takers}")
    try:
        return XmlText(path.read_bytes(), str(path))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; give the file of the robot") from error
