"""Ripple: a wave in the position; every order tried is a trial.

R. B. Davies, Hypothesis testing when a nuisance parameter is present only under the alternative, Biometrika 74 (1987)
33.
"""

from collections.abc import Callable

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of, columns_together
from friction_audit.effects.excitation import span
from friction_audit.effects.joint_data import CORNER_HZ, JointData, Nominal, reach, speeds
from friction_audit.effects.terms.torque_ripple import TERM
from friction_audit.joint_log import Float

FINEST, COARSEST = 1.0, 1.4
"""Distance of orders times the standard deviation of the position: a phase is off by half of it, rms, at most."""
MOST_ORDERS = 120
"""As many as the time of a search allows; where they do not reach, they lie as far apart as they may.

The others are scanned (``ripple_scan``)."""
LEVEL = 25.0
"""About the chi squared at which one of hundreds of orders is worth a name."""


def order_range(data: JointData) -> tuple[float, float]:
    """From two periods over the range up to where a slow motion leaves the band."""
    low, high = reach(data)
    (slow,) = speeds(data, 25.0)
    first = 4.0 * np.pi / max(high - low, 1e-3)
    return first, max(2.0 * np.pi * CORNER_HZ / float(slow), first)


def spread_of(data: JointData) -> float:
    """Standard deviation of the position while the joint moves; orders that differ by one over it are others. [rad]"""
    return max(float(np.std(data.q[data.used])) if data.used.any() else 0.0, 1e-3)


def shapes(data: JointData) -> tuple[Shape, ...]:
    """Orders of the range, as far as they reach."""
    (first, last), spread = order_range(data), spread_of(data)
    step = np.clip((last - first) / MOST_ORDERS, FINEST / spread, COARSEST / spread)
    orders = np.arange(first, last, step)[:MOST_ORDERS]
    return tuple({"ripple_order": float(order)} for order in orders) or ({"ripple_order": first},)


def trials(data: JointData) -> Callable[[Shape], float]:
    """All orders up to one beyond the grid: as many as a largest chi squared is worth over them (Davies 1987).

    It rises above u by chance (l u / 2 pi)^1/2 exp(-u / 2) times per order, l the variance of the position.
    """
    (first, _), spread = order_range(data), spread_of(data)
    last = shapes(data)[-1]["ripple_order"] + COARSEST / spread
    per_order = float(np.sqrt(LEVEL / (2.0 * np.pi)) * spread)

    def of(shape: Shape) -> float:
        order = shape["ripple_order"]
        return per_order * (order - first) if order > last else 0.0

    return of


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    return span(data, baseline, 0.5)


def admissible(_factors: Float, _shape: Shape) -> bool:
    """Any phase."""
    return True


CANDIDATE = Candidate(
    name=TERM.name,
    label=TERM.label,
    shapes=shapes,
    columns=columns_of(TERM),
    together=columns_together(TERM),
    column_units=("nm", "nm"),
    untestable=untestable,
    admissible=admissible,
    trials=trials,
    axis="position",
    term=TERM,
)
