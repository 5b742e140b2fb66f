"""Curves that no catalogue names: what a residual would give to any function of one quantity, for each direction."""

from dataclasses import dataclass

import numpy as np

from friction_audit.diagnosis.axes import AXES, KNOTS, Axis, curve, knots_of
from friction_audit.diagnosis.groups import Group
from friction_audit.diagnosis.omnibus import FEW_TO_TEST
from friction_audit.diagnosis.rows import Rows
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float

CYCLES_PER_COLUMN = 3
"""A curve has at most so many columns as a third of the cycles, or of their parts, or its test means nothing."""

SURFACE_KNOTS = 3


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Curve:
    """A curve over one axis as a group of columns, and the quantity itself on the rows, shape (m,)."""

    axis: Axis
    group: Group
    values: Float


def build_surface(data: JointData, rows: Rows) -> Group:
    """Friction that is viscous here and not there: slopes over the speed that change with the position, six columns."""
    knots = knots_of(data.q, data.used, SURFACE_KNOTS)
    hats = np.stack([np.interp(data.q, knots, row) for row in np.eye(len(knots))])
    slopes = np.concatenate([hats * data.dq, hats * np.abs(data.dq)])
    return Group(name="position and speed", shapes=(rows.of(slopes.T),))


def build_curves(data: JointData, rows: Rows) -> tuple[Curve, ...]:
    """One curve per axis that the log has and that varies."""
    most = min(KNOTS, max(len(np.unique(rows.cycle)), FEW_TO_TEST) // (2 * CYCLES_PER_COLUMN))
    found = []
    for axis in AXES:
        values = axis.value(data)
        knots = np.zeros(0) if values is None else knots_of(values, data.used, most)
        if values is None or len(knots) < 2:  # noqa: PLR2004 - a constant
            continue
        columns = rows.of(curve(values, knots, data.dq))
        seen = values[:: rows.every][rows.used]
        found.append(Curve(axis=axis, group=Group(name=axis.name, shapes=(columns,)), values=seen))
    return tuple(found)
