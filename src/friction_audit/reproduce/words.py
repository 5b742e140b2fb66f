"""Numbers in sentences."""


def relative(share: float) -> str:
    """Return a share as a percentage with two digits: 1.2e-05 -> ``0.0012 %``."""
    percent = 100.0 * share
    return "0 %" if percent == 0 else f"{_plain(percent)} %"


def _plain(number: float) -> str:
    """Return a number with two digits and without an exponent, unless it is tiny."""
    return f"{number:.1e}" if abs(number) < 1e-4 else f"{float(f'{number:.2g}'):f}".rstrip("0").rstrip(".")  # noqa: PLR2004
