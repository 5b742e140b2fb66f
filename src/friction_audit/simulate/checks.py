"""Checks that the settings of the motions share."""

from math import inf

from friction_audit.errors import UsageError


def require_positive(where: str, **numbers: float) -> None:
    """Refuse numbers that are not finite and above zero.

    Raises:
        UsageError: At the first such number.
    """
    for name, number in numbers.items():
        if not 0 < number < inf:
            raise UsageError(f"{where}: {name} {number:g}: expected a number above zero")


def require_within(where: str, low: float, high: float, **numbers: float) -> None:
    """Refuse numbers outside of [low, high].

    Raises:
        UsageError: At the first such number.
    """
    for name, number in numbers.items():
        if not low <= number <= high or number == inf:
            least = "zero or more" if low == 0 else f"{low:g} or more"
            expected = least if high == inf else f"a number from {low:g} to {high:g}"
            raise UsageError(f"{where}: {name} {number:g}: expected {expected}")


def require_order(where: str, **pairs: tuple[float, float]) -> None:
    """Refuse pairs that do not put the smaller of two finite numbers first.

    Raises:
        UsageError: At the first such pair.
    """
    for name, (low, high) in pairs.items():
        if not -inf < low <= high < inf:
            raise UsageError(f"{where}: {name} {low:g}, {high:g}: expected the smaller number first")


def require_room(where: str, range_rad: tuple[float, float], low: float, high: float) -> None:
    """Refuse a range about the start at 0 that leaves less room than low below it and high above it.

    Raises:
        UsageError: If it does.
    """
    if -range_rad[0] < low or range_rad[1] < high:
        raise UsageError(
            f"{where}: range_rad {range_rad[0]:g}, {range_rad[1]:g}: expected a range around the start at 0, "
            f"from {-low:g} or less to {high:g} or more"
        )
