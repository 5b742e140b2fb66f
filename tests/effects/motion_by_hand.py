"""Motions by hand, a few samples each."""

from collections.abc import Sequence

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.joint_log import Float


def motion_of(
    *,
    t: Sequence[float] | Float | None = None,
    q: Sequence[float] | Float | None = None,
    dq: Sequence[float] | Float | None = None,
    temperature: Sequence[float] | None = None,
) -> Motion:
    """A motion of which only some things are told; a second between samples, all else at rest at zero."""
    given = [values for values in (t, q, dq, temperature) if values is not None]
    n = len(given[0])
    return Motion(
        t=np.arange(n, dtype=np.float64) if t is None else np.asarray(t, dtype=np.float64),
        q=np.zeros(n) if q is None else np.asarray(q, dtype=np.float64),
        dq=np.zeros(n) if dq is None else np.asarray(dq, dtype=np.float64),
        ddq=np.zeros(n),
        temperature=None if temperature is None else np.asarray(temperature, dtype=np.float64),
    )
