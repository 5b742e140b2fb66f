"""Load-dependent friction: the predicted load on the gear, never the measured one."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape, columns_of
from friction_audit.effects.excitation import both_directions
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.terms.load_dependent_friction import TERM
from friction_audit.joint_log import Float

EXPONENTS = (1.0, 1.5, 2.0)
WHOLE: Shape = {}
STATIC: Shape = {"load_static": 1.0}
"""The load is all that goes through the gear, or what the link weighs: both are in the literature."""
LEAST_CHANGE = 0.1
"""Of a high load, what it must change by: a steady load's friction is Coulomb friction."""


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    lacking = both_directions(data, baseline)
    if lacking:
        return lacking
    if data.load is None:
        return "the load is not known: log gravity or name the arm, and carry different loads over the same motion"
    low, high = np.percentile(np.abs(data.load[data.used]), [5, 95])
    if high - low < max(LEAST_CHANGE * high, abs(baseline.coulomb_nm)):
        return f"the load varies from {low:.2g} to {high:.2g} N m only: change it threefold, by posture or payload"
    return None


def admissible(factors: Float, _shape: Shape) -> bool:
    """It resists motion, whichever way the power flows."""
    return bool(factors[0] > 0 and abs(factors[1]) <= factors[0])


CANDIDATE = Candidate(
    name=TERM.name,
    label="friction grows with load",
    shapes=tuple(
        {"load_exponent": p, "load_directed": d, **of} for d in (0.0, 1.0) for p in EXPONENTS for of in (WHOLE, STATIC)
    ),
    columns=columns_of(TERM),
    column_units=("nm", "nm"),
    untestable=untestable,
    admissible=admissible,
    axis="load",
    term=TERM,
    leans_on_model=True,
)
