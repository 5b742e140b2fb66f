"""Gravity error: of the joint's own angle, of a link whose mass is wrong, of several links, of a tilted base."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.candidate import Candidate, Shape
from friction_audit.effects.excitation import span
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.terms.gravity_error import OF_LINKS, OF_ONE, OWN_ANGLE, SEVERAL, TERM, TILT
from friction_audit.joint_log import Float

SOURCE = "gravity_error_source"
PLACES = np.concatenate([np.arange(where.start, where.stop) for where in OF_LINKS])
"""Columns of several links."""
NEWS = 0.01
"""Of the largest column: what one must add to the others. A kg m, more than any arm's model is off, pulls with 10 N m;
what a hundredth of that makes of a tenth of a kg m, the usual error, drowns in the noise of a good sensor."""
ROUNDING = 1e-9
"""What is less per kg or kg m is no weight. [N m]"""
MOST_KG = 10.0
"""And kg m: what columns that nearly cancel may make of a link is no body."""


def shapes(data: JointData) -> tuple[Shape, ...]:
    """The joint's angle, and what the model of the arm lets pull at it."""
    rigid = data.rigid
    links = () if rigid is None else tuple(k for n, k in enumerate(rigid.links) if rigid.weight[:, n].any())
    several = (SEVERAL,) if np.count_nonzero(told_apart(data).reshape(len(OF_LINKS), -1).any(axis=1)) > 1 else ()
    tilt = () if rigid is None else (TILT,)
    return tuple({SOURCE: float(source)} for source in (OWN_ANGLE, *links, *several, *tilt))


def columns(data: JointData, baseline: Nominal, shape: Shape) -> Float:
    """The columns of one source; of several links those that this motion tells apart, the others zero."""
    source = round(shape[SOURCE])
    found = TERM.regressor(data.motion(baseline.torque), (source,))
    if source != SEVERAL:
        return found[:, :OF_ONE]
    found[:, PLACES[~told_apart(data)]] = 0.0
    return found


def told_apart(data: JointData) -> NDArray[np.bool_]:
    """Which columns of several links the motion tells apart, shape (12,); none without a model of the arm.

    By QR with pivoting: of columns that nearly depend on each other the larger one stays (P. Businger, G. H. Golub,
    Linear least squares solutions by Householder transformations, Numerische Mathematik 7 (1965) 269).
    """
    from scipy.linalg import qr

    told = np.zeros(len(PLACES), bool)
    if data.rigid is None or not data.used.any():
        return told
    pulls = TERM.regressor(data.motion(), (SEVERAL,))[data.used][:, PLACES]
    factor, order = qr(pulls / np.sqrt(len(pulls)), mode="r", pivoting=True)
    adds = np.abs(np.diag(factor))
    told[order[: len(adds)]] = adds > max(NEWS * adds[0], ROUNDING)
    return told


def untestable(data: JointData, baseline: Nominal) -> str | None:
    """The motion that is lacking."""
    return span(data, baseline, 0.3)


def admissible(factors: Float, shape: Shape) -> bool:
    """Either sign is possible; of several links not what no arm carries."""
    return not richer(shape) or bool(np.all(np.abs(factors) <= MOST_KG))


def richer(shape: Shape) -> bool:
    """Whether several links are wrong: moments of inertia of one, which its columns lack, must not pass for others."""
    return round(shape[SOURCE]) == SEVERAL


CANDIDATE = Candidate(
    name=TERM.name,
    label="gravity not fully compensated",
    shapes=shapes,
    columns=columns,
    column_units=tuple(p.unit for p in TERM.coefficients),
    untestable=untestable,
    admissible=admissible,
    axis="position",
    term=TERM,
    richer=richer,
)
