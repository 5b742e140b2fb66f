"""Colours of figures on a dark ground: greys turned over, colours lightened until they can be seen."""

import colorsys
from collections.abc import Iterable

DARK_GROUND = "#14181d"
READABLE = 4.5
"""Contrast that text needs against its ground (WCAG 2.2, level AA)."""
GREY = 0.3
"""Saturation below which a colour counts as grey, or as the tint of a ground."""
LIGHTEST, DARKEST = 0.92, 0.12
"""Lightness of what is black on white, and of what is white."""
STEP = 0.02


def dark_colour(colour: str) -> str:
    """Return what ``#rrggbb`` on white becomes on the dark ground, of the same hue."""
    hue, lightness, saturation = colorsys.rgb_to_hls(*_channels(colour))
    if saturation < GREY or lightness in (0.0, 1.0):
        return _hex(colorsys.hls_to_rgb(hue, LIGHTEST + (DARKEST - LIGHTEST) * lightness, saturation))
    while contrast(_hex(colorsys.hls_to_rgb(hue, lightness, saturation)), DARK_GROUND) < READABLE:
        lightness += STEP
    return _hex(colorsys.hls_to_rgb(hue, lightness, saturation))


def contrast(colour: str, ground: str) -> float:
    """Return the contrast ratio of two colours, 1 to 21 (WCAG 2.2)."""
    light, dark = sorted((_luminance(colour), _luminance(ground)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def colour_rules(colours: Iterable[str], *, dark: bool) -> str:
    """Return the page's names of figures' colours: ``--c-004c80:#004c80;...``."""
    return "".join(f"--c-{one[1:]}:{dark_colour(one) if dark else one};" for one in sorted(set(colours)))


def _luminance(colour: str) -> float:
    red, green, blue = (_linear(channel) for channel in _channels(colour))
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def _linear(channel: float) -> float:
    return channel / 12.92 if channel <= 0.04045 else ((channel + 0.055) / 1.055) ** 2.4  # noqa: PLR2004 - sRGB


def _channels(colour: str) -> tuple[float, float, float]:
    red, green, blue = (int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue


def _hex(channels: Iterable[float]) -> str:
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in channels)
