"""What everything about one joint is judged on: its rows, its declared model, the cycles that are locked away."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.curves import Curve, build_curves, build_surface
from friction_audit.diagnosis.declared import Declared, declare, least_squares
from friction_audit.diagnosis.groups import Group
from friction_audit.diagnosis.noise import integral_time, runs_of
from friction_audit.diagnosis.omnibus import cut_cycles, neighbours_remember
from friction_audit.diagnosis.rows import Rows, corner_for, make_rows
from friction_audit.diagnosis.split import split_cycles
from friction_audit.effects.joint_data import CORNER_HZ, JointData, Nominal
from friction_audit.effects.joint_model import JointModel
from friction_audit.joint_log import Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Clusters:
    """What a bootstrap takes for independent.

    Attributes:
        number: Of the cluster of each row, in the order of time, shape (m,).
        remember: Whether neighbours are not quite independent.
    """

    number: NDArray[np.int64]
    remember: bool


@dataclass(frozen=True, eq=False, kw_only=True)
class Ground:
    """One joint, ready to be judged; m rows.

    Attributes:
        data: The joint on the fine grid.
        rows: Its rows.
        declared: The declared model.
        working: Rows of cycles that may be looked at, shape (m,).
        run: Number of the unbroken stretch of each row, shape (m,).
        curves: A curve over every axis.
        surface: Slopes over the speed that change with the position.
        rigid: What the rigid-body model of the arm may get wrong, on the rows, shape (m, r).
    """

    data: JointData
    rows: Rows
    declared: Declared
    working: NDArray[np.bool_]
    run: NDArray[np.int64]
    curves: tuple[Curve, ...]
    surface: Group
    rigid: Float

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

    def fine_residual(self, effects: Sequence[Float], fine: Sequence[Float]) -> Float:
        """The same on the fine grid, from columns on the rows and on the fine grid, shape (n,). [N m]"""
        columns = np.hstack([self.base, *effects])
        factors = least_squares(columns[self.working], self.y[self.working])
        return self.data.torque - self.declared.stated - np.hstack([self.declared.fine, *fine]) @ factors

    def baseline(self, *effects: Float) -> Nominal:
        """The declared model as fitted on the working rows together with some columns."""
        columns = np.hstack([self.base, *effects])
        factors = least_squares(columns[self.working], self.y[self.working])
        return self.declared.baseline(factors[: self.base.shape[1]])

    def keep(self, kept: NDArray[np.bool_]) -> "Ground":
        """The same joint with some of its rows, shape (m,)."""
        rows = self.rows.keep(kept)
        return replace(
            self,
            rows=rows,
            declared=replace(self.declared, columns=self.base[kept], y=self.y[kept]),
            working=self.working[kept],
            run=np.cumsum(np.diff(np.flatnonzero(kept) + self.run[kept], prepend=0) != 1),
            curves=tuple(replace(c, group=c.group.keep(kept), values=c.values[kept]) for c in self.curves),
            surface=self.surface.keep(kept),
            rigid=self.rigid[kept],
        )

    def memory(self, *effects: Float) -> float:
        """Integral time of the noise over the working rows: of what a model, any curves and rigid bodies leave. [rows]

        What a model misses remembers longer than the noise, so that the shorter of two times counts.
        """
        return self._memory(*effects) if effects else self._memory_alone

    def longest_memory(self, *effects: Float) -> float:
        """The same of what a model alone leaves: longer where anything else is missing, but never too short. [rows]

        Curves over all axes at once take much of slow noise with them.
        """
        run, own = self.run[self.working], [effect[self.working] for effect in effects]
        return integral_time(self._beside[0].left(np.hstack([np.zeros((len(run), 0)), *own])), run)

    @cached_property
    def _memory_alone(self) -> float:
        return self._memory()

    def _memory(self, *effects: Float) -> float:
        # A run lies within one cycle, so that its working rows follow each other among these too.
        run, own = self.run[self.working], [effect[self.working] for effect in effects]
        columns = np.hstack([np.zeros((len(run), 0)), *own])
        return min(integral_time(beside.left(columns), run) for beside in self._beside)

    @cached_property
    def _beside(self) -> tuple[Beside, Beside]:
        """The working rows beside the declared model, and beside curves and rigid bodies too."""
        y, base = self.y[self.working], self.base[self.working]
        curves = [curve.group.shapes[0][self.working] for curve in self.curves]
        return Beside(base, y), Beside(np.hstack([base, *curves, self.rigid[self.working]]), y)

    def clusters(self, which: NDArray[np.bool_], *effects: Float) -> Clusters:
        """Cycles of some rows, put together until they outlast the noise's memory, or cut where they are few."""
        memory = self.memory(*effects)
        number = cut_cycles(self.rows.cycle[which], memory)
        return Clusters(number=number, remember=neighbours_remember(number, memory))


def make_ground(data: JointData, model: JointModel | None, seed: int, corner_hz: float | None = None) -> Ground:
    """Take the rows of a joint, its declared model, and lock cycles away.

    Args:
        data: The joint.
        model: The declared model, None for the simple one.
        seed: Which cycles are locked away.
        corner_hz: Of the rows' filter; None for what the noise allows. [Hz]

    Raises:
        AnalysisError: If there are fewer than four cycles.
    """
    rows = make_rows(data, CORNER_HZ if corner_hz is None else corner_hz)
    declared = declare(data, rows, model)
    inertia = declared.baseline(least_squares(declared.columns, declared.y)).inertia_kg_m2
    if corner_hz is None and (corner := corner_for(data, abs(inertia))) < CORNER_HZ:
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
        curves=build_curves(data, rows),
        surface=build_surface(data, rows),
        rigid=rows.of(_rigid_columns(data)),
    )


def _rigid_columns(data: JointData) -> Float:
    """Inertial torque, own weight and a tilt of the base, on the fine grid; none without a model, shape (n, r)."""
    rigid = data.rigid
    if rigid is None:
        return np.zeros((len(data.t), 0))
    known = [rigid.tilt, rigid.weight[:, 0], *([] if rigid.inertial is None else [rigid.inertial[:, None]])]
    return rigid.at(data.t, np.hstack(known))
