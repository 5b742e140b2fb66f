"""Gravity and offsets that are left in the torque that friction sees.

The constants of a gravity error are ill-determined over a short range: two of hundreds of newton metres may cancel.
What a log determines is their torque over the range that the joint moved, and whether that depends on the position.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from friction_audit.interaction.interaction import Caution
from friction_audit.interaction.sign import CoarseLog, strokes_of
from friction_audit.joint_log import Float

LARGEST_NM = 1.5
"""An identified model errs by a few tenths of a newton metre, the vendor's by up to two on the heaviest joints; a
forgotten hand makes two to three."""
LEAST_RANGE_RAD = 0.3
"""Over less, gravity looks like an offset or a spring."""
LEAST_ACROSS = 0.1
"""Share of gravity across an axis below which the axis is vertical: a payload does not load it."""
LEAST_STROKES = 10
ENOUGH = 20_000
"""Means of 20 ms; more tell nothing of what changes with the position alone."""
SIGNIFICANCE = 0.01


@dataclass(frozen=True, kw_only=True, slots=True)
class _Left:
    """What is left beside friction on one joint: mean and rms over the range moved [N m], the friction [N m]."""

    column: int
    mean_nm: float
    rms_nm: float
    range_rad: float
    friction_nm: float
    by_position: bool


def gravity_cautions(
    coarse: CoarseLog, torque: Float, direction: Float | None, columns: list[int], names: tuple[str, ...], gravity: str
) -> tuple[Caution, ...]:
    """Say on which joints gravity or an offset is left in the torque.

    Args:
        coarse: Motion.
        torque: F_m + u of all joints, shape (m, j). [N m]
        direction: Direction of gravity across the axes of the joints, shape (m, len(columns), 2), or None.
        columns: Joints to look at, 0-based.
        names: Their names.
        gravity: Where gravity came from, as in ``TorqueChoice``.
    """
    found = [
        one
        for place, column in enumerate(columns)
        for one in _left(coarse, torque, None if direction is None else direction[:, place], column)
    ]
    several = sum(one.rms_nm > one.friction_nm for one in found) > 1
    labels = dict(zip(columns, names, strict=True))
    return tuple(_caution(one, labels[one.column], gravity if several else "") for one in found)


def _left(coarse: CoarseLog, torque: Float, direction: Float | None, column: int) -> Iterator[_Left]:
    moving, way, stroke = strokes_of(coarse, column)
    if not stroke.size or stroke[-1] + 1 < LEAST_STROKES:
        return
    rows = np.flatnonzero(moving)
    thin = slice(None, None, max(len(rows) // ENOUGH, 1))
    rows, way = rows[thin], way[thin]
    q, dq = coarse.q[rows, column], coarse.dq[rows, column]
    ddq = np.gradient(coarse.dq[:, column], coarse.t)[rows]
    across = np.column_stack([np.sin(q), np.cos(q)]) if direction is None else direction[rows]
    plain = np.column_stack([way, dq, ddq, np.ones(len(q))])
    factors, square, square_plain = _fit(plain, across, torque[rows, column])
    at_rest = factors[3] + across @ factors[4:]
    freedom = int(stroke[-1] + 1) - len(factors)
    wide = np.ptp(q) >= LEAST_RANGE_RAD and float(np.hypot(*across.T).max()) >= LEAST_ACROSS
    by_position = bool(wide and _significant(square_plain, square, freedom))
    mean, rms = float(at_rest.mean()), float(np.sqrt(np.mean(at_rest**2)))
    if (rms if by_position else abs(mean)) > LARGEST_NM:
        yield _Left(
            column=column,
            mean_nm=mean,
            rms_nm=rms,
            range_rad=float(np.ptp(q)),
            friction_nm=abs(float(factors[0])),
            by_position=by_position,
        )


def _significant(without: float, with_gravity: float, freedom: int) -> bool:
    """F test of the columns of gravity; strokes are independent, not samples."""
    from scipy.special import fdtrc

    ratio = (without - with_gravity) / 2.0 / max(with_gravity / freedom, np.finfo(float).tiny)
    return bool(fdtrc(2.0, freedom, max(ratio, 0.0)) < SIGNIFICANCE)


def _fit(plain: Float, across: Float, torque: Float) -> tuple[Float, float, float]:
    """Return the factors of all columns, and the sums of squares that these and the plain ones alone leave."""
    columns = np.column_stack([plain, across])
    scale = np.linalg.norm(columns, axis=0).clip(min=np.finfo(float).tiny)
    # Both fits on the triangular factor: a decomposition of all samples takes most of the time.
    triangle = np.asarray(np.linalg.qr(np.column_stack([columns / scale, torque]), "r"), np.float64)
    fits = []
    for count in (columns.shape[1], plain.shape[1]):
        design, right = triangle[:, :count], triangle[:, -1]
        factors = np.linalg.lstsq(design, right, rcond=1e-8)[0]
        fits.append((factors, float(np.sum((right - design @ factors) ** 2))))
    (factors, square), (_, square_plain) = fits
    return factors / scale, square, square_plain


def _caution(one: _Left, name: str, gravity: str) -> Caution:
    where = f"joint {one.column + 1} ({name})"
    if not one.by_position:
        message = (
            f"{where}: the torque holds a constant {one.mean_nm:.1f} N m that is not friction; over the "
            f"{one.range_rad:.2g} rad that the joint moves an offset of the sensor cannot be separated from gravity"
        )
        return Caution(code="torque_offset", joint=one.column + 1, message=message)
    cause = {
        "model": "; several joints have it, so a payload is probably missing from the model (--payload mass,x,y,z), or "
        "another arm is modelled",
        "logged": "; several joints have it, so the payload was probably not set on the robot",
    }.get(gravity, "; check the gravity that was removed, and its direction")
    message = (
        f"{where}: gravity of at least {one.rms_nm:.1f} N m rms over the {one.range_rad:.2g} rad that the joint moves "
        f"is left in the torque{cause}"
    )
    return Caution(code="gravity_error", joint=one.column + 1, message=message)
