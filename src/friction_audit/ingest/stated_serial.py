"""The serial number of an arm among the notes that a file carries beside its data."""

from collections.abc import Mapping

KEYS = frozenset({"serial", "serial_number", "robot_serial", "robot_serial_number", "arm_serial", "arm_serial_number"})


def serial_in(notes: Mapping[str, str]) -> str:
    """Return the serial number among notes by name, or nothing; names are taken whatever their case and dashes."""
    found = {key.strip().lower().replace("-", "_").replace(" ", "_"): value.strip() for key, value in notes.items()}
    return next((found[key] for key in sorted(KEYS & found.keys()) if found[key]), "")
