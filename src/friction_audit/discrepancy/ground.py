"""What everything about one joint is judged on: its rows, its declared model, the cycles that are locked away."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.discrepancy.candidate import Baseline
from friction_audit.discrepancy.declared import Declared, declare, least_squares
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.noise import integral_time, runs_of
from friction_audit.discrepancy.omnibus import independent_clusters
from friction_audit.discrepancy.rows import CORNER_HZ, Rows, corner_for, make_rows
from friction_audit.discrepancy.split import split_cycles
from friction_audit.joint_log import Float
from friction_audit.model.joint_model import JointModel


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Ground:
    """One joint, ready to be judged; m rows.

    Attributes:
        data: The joint on the fine grid.
        rows: Its rows.
        declared: The declared model.
        working: Rows of cycles that may be looked at, shape (m,).
        run: Number of the unbroken stretch of each row, shape (m,).
    """

    data: JointData
    rows: Rows
    declared: Declared
    working: NDArray[np.bool_]
    run: NDArray[np.int64]

    @property
    def y(self) -> Float:
        """Response, shape (m,)."""
        return self.declared.y

    @property
    def base(self) -> Float:
        """Columns of the declared model, shape (m, b)."""
        return self.declared.columns

    @property
    def locked(self) -> NDArray[np.bool_]:
        """Rows of cycles that no choice is made on, shape (m,)."""
        return ~self.working

    def residual(self, *effects: Float) -> Float:
        """What the declared model and some columns leave, fitted on the working rows, shape (m,)."""
        columns = np.hstack([self.base, *effects])
        return self.y - columns @ least_squares(columns[self.working], self.y[self.working])

    def baseline(self, *effects: Float) -> Baseline:
        """The declared model as fitted on the working rows together with some columns."""
        columns = np.hstack([self.base, *effects])
        factors = least_squares(columns[self.working], self.y[self.working])
        return self.declared.baseline(factors[: self.base.shape[1]])

    def memory(self, residual: Float) -> float:
        """Integral time of a residual over the working rows. [rows]"""
        return integral_time(residual, np.where(self.working, self.run, -1))

    def clusters(self, residual: Float, which: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Cycles of some rows, put together until they outlast the noise's memory."""
        return independent_clusters(self.rows.cycle[which], self.memory(residual))


def make_ground(data: JointData, model: JointModel | None, seed: int) -> Ground:
    """Take the rows of a joint, its declared model, and lock cycles away.

    Raises:
        AnalysisError: If there are fewer than four cycles.
    """
    rows = make_rows(data)
    declared = declare(data, rows, model)
    inertia = declared.baseline(least_squares(declared.columns, declared.y)).inertia_kg_m2
    if (corner := corner_for(data, abs(inertia))) < CORNER_HZ:
        rows = make_rows(data, corner)
        declared = declare(data, rows, model)
    numbers, place = np.unique(rows.cycle, return_inverse=True)
    speed = np.abs(data.dq[:: rows.every][rows.used])
    usual = np.bincount(place, weights=speed, minlength=len(numbers)) / np.maximum(np.bincount(place), 1)
    split = split_cycles(numbers, usual, seed)
    every = np.zeros(len(rows.used), bool)
    every[rows.used] = True
    run = runs_of(every, data.cycle[:: rows.every])[rows.used]
    return Ground(
        data=data,
        rows=rows,
        declared=declared,
        working=np.isin(rows.cycle, split.working),
        run=run,
    )
