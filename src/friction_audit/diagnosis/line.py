"""A line in what a model leaves: one sine in time, or in the path travelled, that stands out of the noise beside it.

A hum has one frequency wherever the joint goes; balls, belts and hoses that slip come round after the same path
whichever way it went. Both look like noise to every curve over position and speed, and to the periodogram like what
they are: over noise of any colour its values are about exponential about their local mean (P. Bloomfield, Fourier
analysis of time series, 2000), so that the largest of m is below ln(m / p) of it with probability 1 - p. The mean is
that of neighbours, taken from their median, which a line does not move.
"""

from dataclasses import dataclass

import numpy as np

from friction_audit.joint_log import Float

CHANCE = 1e-5
"""Probability of a line where none is; the mean of few neighbours errs, so that one in thousands is the truth."""
FEWEST_PERIODS = 5.0
OVERSAMPLED = 4
NEIGHBOURS = 10.0
"""As many independent frequencies on either side, or half as high and as low again, tell the noise; of noise that is
stronger at low frequencies those below tell more."""
KEPT = 0.5
"""What is slower than this share of the lowest frequency is taken away; what is not tells the noise there."""
OWN = 2.0
"""So many independent frequencies on either side belong to the line itself."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Line:
    """A sine.

    Attributes:
        frequency: Per unit of what it runs along.
        resolution: Frequencies closer than this are not told apart.
        rms_nm: Root mean square of its torque. [N m]
    """

    frequency: float
    resolution: float
    rms_nm: float


def find_line(
    left: Float, along: Float, low: float, high: float, least_rms: float, weight: Float | None = None
) -> Line | None:
    """Find the strongest line.

    Args:
        left: Torque that is left, shape (m,). [N m]
        along: Time or path of each row, ascending, shape (m,).
        low: Lowest frequency, per unit of ``along``; higher where that comes round less than five times.
        high: Highest one.
        least_rms: A line of less is not worth a word. [N m]
        weight: How far ``along`` goes in each row, shape (m,); None where that is alike in all. Without it slow noise,
            heard longest where the joint turns, would come round with the strokes.

    Returns:
        The line; None where nothing stands out.
    """
    length = float(along[-1] - along[0]) if len(along) else 0.0
    low = max(low, FEWEST_PERIODS / length) if length > 0.0 else high
    if high <= low:
        return None
    power = _periodogram(left, along, (KEPT * low, high), np.ones(len(left)) if weight is None else weight)
    resolution = 1.0 / length
    frequency = np.arange(len(power)) * resolution / OVERSAMPLED
    inside = (frequency >= low) & (frequency <= high)
    at = int(np.argmax(np.where(inside, power, 0.0)))
    rms = float(np.sqrt(2.0 * power[at]))
    apart = np.abs(frequency - frequency[at])
    reach = max(NEIGHBOURS * resolution, 0.5 * float(frequency[at]))
    beside = (apart > OWN * resolution) & (apart <= reach) & (frequency >= KEPT * low)
    usual = float(np.median(power[beside])) / np.log(2.0)
    tried = (high - low) / resolution
    if rms < least_rms or power[at] < np.log(tried / CHANCE) * usual:
        return None
    return Line(frequency=float(frequency[at]), resolution=resolution, rms_nm=rms)


def _periodogram(left: Float, along: Float, band: tuple[float, float], weight: Float) -> Float:
    """|sum of w r exp(-2 pi i f x)|^2 / (sum of w)^2 at multiples of a quarter of the resolution, to above the band.

    What is slower than the band is taken away first: rests and turns that come round would move it into the band.
    """
    from scipy.signal import fftconvolve

    length = float(along[-1] - along[0])
    bins = int(np.ceil(4.0 * band[1] * length))
    place = np.minimum(((along - along[0]) / length * bins).astype(np.int64), bins - 1)
    there, total = (np.bincount(place, weights=each, minlength=bins) for each in (weight, weight * left))
    bell = np.hanning(2 * int(bins / (band[0] * length)) + 3)
    slow = fftconvolve(total, bell, mode="same") / np.maximum(fftconvolve(there, bell, mode="same"), 1e-9)
    return np.asarray(np.abs(np.fft.rfft(total - there * slow, OVERSAMPLED * bins)) ** 2 / np.sum(weight) ** 2)
