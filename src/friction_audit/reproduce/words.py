"""Numbers in sentences."""

SMALLEST_PERCENT = 0.001
"""Below this, nobody needs the digits."""


def relative(share: float) -> str:
    """Return the size of a share as a percentage with two digits: 1.2e-4 -> ``0.012 %``."""
    percent = 100.0 * abs(share)
    if percent < SMALLEST_PERCENT:
        return f"less than {SMALLEST_PERCENT:g} %"
    return f"{float(f'{percent:.2g}'):.6f}".rstrip("0").rstrip(".") + " %"
