"""What a pass over a recording finds of each column: range, largest jump, and a sample of its values and changes."""

import numpy as np

from friction_audit.joint_log import Float, Int

MOST_SAMPLES = 1 << 16  # from which quantiles are taken, for speed
LAG = 3  # changes are taken over three rows: neighbouring rows of a slow or coarse channel are often equal


def sample_rows(rows: int, first: int = 0) -> Int:
    """Return the rows, from this one on, that are taken of a recording with so many, spread evenly, shape (m,)."""
    return np.arange(first, rows, max(rows // MOST_SAMPLES, 1))


class Picked:
    """Values at some rows of a recording, gathered piece by piece."""

    def __init__(self, places: Int, *shape: int) -> None:
        self.places, self.values = places, np.empty((len(places), *shape), order="F")

    def take(self, first: int, piece: Float) -> None:
        """Take those of a piece whose first row has this number."""
        start, stop = np.searchsorted(self.places, (first, first + len(piece)))
        self.values[start:stop] = piece[self.places[start:stop] - first]


class Thinned:
    """At most so many of a long series of numbers, evenly spread over it, however it is cut into pieces."""

    MOST = 1 << 20

    def __init__(self) -> None:
        self._pieces: list[Float] = []
        self._kept, self._every, self._seen = 0, 1, 0

    def take(self, values: Float) -> None:
        """Take the numbers that come next."""
        self._pieces.append(values[-self._seen % self._every :: self._every].copy())
        self._kept, self._seen = self._kept + len(self._pieces[-1]), self._seen + len(values)
        while self._kept > self.MOST:
            self._pieces, self._every = [self.values[::2].copy()], 2 * self._every
            self._kept = len(self._pieces[0])

    @property
    def values(self) -> Float:
        """The numbers that were kept."""
        return np.concatenate(self._pieces)


class Column:
    """What a pass finds of one channel of all joints."""

    def __init__(self, rows: int, joints: int, to_zero: float) -> None:
        """Take the least jump to or from zero that is to be noticed."""
        # Values of rows spread evenly over the recording, and values after changes over LAG rows, shape (m, j).
        self._picked = [Picked(sample_rows(rows, first), joints) for first in (0, LAG)]
        self.sample, self.changed = (one.values for one in self._picked)
        self.lowest, self.highest = np.full(joints, np.inf), np.full(joints, -np.inf)  # range, shape (j,)
        self.jump = np.zeros(joints)  # largest change between neighbouring rows, shape (j,)
        self.zeroed = np.zeros(joints, np.bool_)  # true where a large jump begins or ends at zero, shape (j,)
        self._to_zero = to_zero

    def take(self, first: int, before: Float, piece: Float, lowest: Float, highest: Float) -> None:
        """Take the rows of a piece, given the row before it and its range."""
        self.lowest, self.highest = np.minimum(self.lowest, lowest), np.maximum(self.highest, highest)
        steps = np.empty_like(piece)
        steps[0] = piece[0] - before
        np.subtract(piece[1:], piece[:-1], out=steps[1:])
        jump = np.maximum(steps.max(axis=0), -steps.min(axis=0))
        self.jump = np.maximum(self.jump, jump)
        for joint in np.flatnonzero((jump > self._to_zero) & (lowest <= 0.0) & (highest >= 0.0)):
            large = np.flatnonzero(np.abs(steps[:, joint]) > self._to_zero)
            column = piece[large, joint]
            self.zeroed[joint] |= bool(((column == 0.0) | (column == steps[large, joint])).any())
        for picked in self._picked:
            picked.take(first, piece)

    def changes(self, joint: int) -> Float:
        """Changes over LAG rows that are spread evenly over the recording, shape (m,)."""
        return np.asarray(self.changed[:, joint] - self.sample[: len(self.changed), joint])
