"""Ranges of the numbers in a compensator's settings."""

from math import isfinite

from friction_audit.errors import UsageError


def require_not_negative(where: str, settings: object, *names: str) -> None:
    """Raise UsageError unless every named number is zero or more."""
    for name in names:
        if not getattr(settings, name) >= 0:
            raise UsageError(f"{where}: {name} {getattr(settings, name):g}: expected zero or more")


def require_positive(where: str, settings: object, *names: str) -> None:
    """Raise UsageError unless every named number is above zero."""
    for name in names:
        if not getattr(settings, name) > 0:
            raise UsageError(f"{where}: {name} {getattr(settings, name):g}: expected a number above zero")


def require_finite(where: str, settings: object, *names: str) -> None:
    """Raise UsageError unless every named number is finite."""
    for name in names:
        if not isfinite(getattr(settings, name)):
            raise UsageError(f"{where}: {name} {getattr(settings, name):g}: expected a finite number")
