"""Text of an option -> its value."""

from friction_audit.errors import UsageError
from friction_audit.joint_numbers import parse_joint_numbers


def parse_joints(text: str | None) -> tuple[int, ...] | None:
    """Return the joints of ``"1,3-5"``, in order and each once, or None for all.

    Raises:
        UsageError: If the text is not numbers and ranges from 1.
    """
    if text is None:
        return None
    return parse_joint_numbers(text, f"--joints {text}")


def parse_numbers(option: str, text: str, names: tuple[str, ...]) -> tuple[float, ...]:
    """Return the numbers of ``"0.2,0.05"``, one per name.

    Raises:
        UsageError: If there are more or fewer of them, or one is no number.
    """
    parts = text.split(",")
    try:
        numbers = tuple(float(part) for part in parts)
    except ValueError as error:
        raise UsageError(f"{option} {text}: expected numbers {','.join(names)}") from error
    if len(numbers) != len(names):
        raise UsageError(f"{option} {text}: {len(numbers)} numbers; expected {len(names)}: {','.join(names)}")
    return numbers


def parse_mapping(entries: list[str] | None) -> dict[str, str]:
    """Return the mapping of ``["dq=vel_{i}", ...]``: channel -> name in the file.

    Raises:
        UsageError: If an entry is not CHANNEL=NAME, or a channel comes twice.
    """
    mapping: dict[str, str] = {}
    for entry in entries or []:
        channel, equals, name = entry.partition("=")
        if not equals or not channel or not name:
            raise UsageError(f"--map {entry}: expected CHANNEL=NAME, e.g. --map dq=velocity_{{i}}")
        if channel in mapping:
            raise UsageError(f"--map {entry}: {channel} is mapped twice; give its names separated by commas")
        mapping[channel] = name
    return mapping
