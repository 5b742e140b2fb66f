"""Names in the order in which people count: run2 before run10."""

import re

_NUMBER = re.compile(r"(\d+)")


def natural_key(name: str) -> tuple[tuple[int, int, str], ...]:
    """Return a key that sorts names by their words and numbers, and last by their spelling."""
    parts = _NUMBER.split(name)
    words = tuple((1, int(part), "") if part.isdecimal() else (0, 0, part.lower()) for part in parts)
    return (*words, (0, 0, name))
