"""Random numbers: one stream for each thing that draws, so that none of them disturbs another."""

from dataclasses import dataclass

import numpy as np


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
