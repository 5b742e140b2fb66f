"""How long a recording is and how often its states are kept."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.errors import UsageError
from friction_audit.simulation.settings import require_positive

CONTROL_RATE_HZ = 1000.0
"""Rate at which the controller reads its sensors and sets its torques. [Hz]"""

HALF_SUBSTEPS = 5
"""Integration steps in half a tick of the controller."""

FEWEST_TICKS = 2

LONGEST_S = 7200.0
"""Every tick is kept in memory: two hours of one joint take about a gigabyte. [s]"""


def count_ticks(duration_s: float, rate_hz: float) -> int:
    """Return the number of the controller's ticks in a recording, after checking its length and its rate.

    Raises:
        UsageError: If the recording is too short or too long, or the rate is above that of the controller.
    """
    require_positive("simulation", duration_s=duration_s, rate_hz=rate_hz)
    if rate_hz > CONTROL_RATE_HZ:
        raise UsageError(
            f"simulation: rate_hz {rate_hz:g}: expected at most {CONTROL_RATE_HZ:g}, the rate of the controller"
        )
    if duration_s > LONGEST_S:
        raise UsageError(f"simulation: duration_s {duration_s:g}: expected at most {LONGEST_S:g}; make several logs")
    if duration_s * rate_hz < FEWEST_TICKS:
        raise UsageError(
            f"simulation: {duration_s:g} s at {rate_hz:g} Hz: expected at least {FEWEST_TICKS} sampling intervals"
        )
    return round(duration_s * CONTROL_RATE_HZ)


def sampled_ticks(ticks: int, rate_hz: float) -> NDArray[np.int64]:
    """Return the ticks whose states are logged at a lower rate, the first one always."""
    samples = int(ticks * rate_hz / CONTROL_RATE_HZ + 1e-9)
    ticks_of_samples: NDArray[np.int64] = np.rint(np.arange(samples + 1) * (CONTROL_RATE_HZ / rate_hz)).astype(np.int64)
    return ticks_of_samples


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Streams:
    """The streams of one simulation.

    Attributes:
        person: Draws the motion.
        sensors: Draws the noise of the sensors.
        recorder: Draws losses and jitter.
        events: Draw the contact events, one per joint.
        drifts: Draw the torque drifts, one per joint.
    """

    person: np.random.Generator
    sensors: np.random.Generator
    recorder: np.random.Generator
    events: tuple[np.random.Generator, ...]
    drifts: tuple[np.random.Generator, ...]


def make_streams(seed: int, joints: int) -> Streams:
    """Return the streams of a seed."""
    *first, hidden = np.random.SeedSequence(seed).spawn(4)
    person, sensors, recorder = (np.random.default_rng(part) for part in first)
    parts = [np.random.default_rng(part) for part in hidden.spawn(2 * joints)]
    return Streams(
        person=person, sensors=sensors, recorder=recorder, events=tuple(parts[::2]), drifts=tuple(parts[1::2])
    )
