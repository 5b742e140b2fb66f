"""The signals, cycles and friction of one joint of an estimate, as figures draw them."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.friction.history import JointFriction
from friction_audit.joint_log import Float
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.reporting.figures.panels import Chosen, Numbers, choose, joint_title
from friction_audit.reporting.figures.style import REJECTED, SHADE, Look

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from friction_audit.pipeline import Estimate

MOST_SHADED = 80  # cycles in one panel above which stripes would only be grey


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointSeries:
    """One joint's signals, cycles and friction.

    Attributes:
        joint: Joint number, 1..n.
        name: Name in the log.
        t: Time, shape (n,). [s]
        dq: Velocity, shape (n,). [rad/s]
        torque: Interaction torque, shape (n,). [N m]
        compensation: Torque of a logged compensator, shape (n,), or None. [N m]
        cycles: Its cycles; start and stop are indices into the arrays above.
        friction: Its coefficients.
    """

    joint: int
    name: str
    t: Float
    dq: Float
    torque: Float
    compensation: Float | None
    cycles: EnergyCycles
    friction: JointFriction

    @property
    def title(self) -> str:
        """What a panel is called: the joint's number, and its name where that says more."""
        return joint_title(self.joint, self.name)

    @property
    def not_determined(self) -> str:
        """The words for a panel without an estimate, without advice; empty if there is one."""
        return f"not determined: {self.friction.reason.partition(';')[0]}" if self.friction.reason else ""

    @property
    def driving_torque(self) -> Float:
        """What acts against friction and inertia: F_m + u, shape (n,). [N m]"""
        return self.torque if self.compensation is None else self.torque + self.compensation

    @property
    def net_energy_j(self) -> Float:
        """Integral of F_m dq dt, zero at the first cycle's start (at t = 0 without one), shape (n,). [J]"""
        from scipy.integrate import cumulative_trapezoid

        energy = cumulative_trapezoid(self.torque * self.dq, self.t, initial=0)
        return np.asarray(energy - energy[self.cycles.start[0] if len(self.cycles.start) else 0], dtype=np.float64)

    @property
    def is_crowded(self) -> bool:
        """Whether the joint has too many cycles to tell them apart in one panel."""
        return len(self.cycles.joint) > MOST_SHADED

    def first_cycles(self, count: int) -> "JointSeries":
        """Return the stretch of the log that the first cycles fill; all of it without any cycle."""
        if not len(self.cycles.joint):
            return self
        kept = self.cycles.rows(np.arange(len(self.cycles.joint)) < count)
        begin, end = int(kept.start[0]), int(kept.stop[-1]) + 1
        return replace(
            self,
            t=self.t[begin:end],
            dq=self.dq[begin:end],
            torque=self.torque[begin:end],
            compensation=None if self.compensation is None else self.compensation[begin:end],
            cycles=replace(kept, start=kept.start - begin, stop=kept.stop - begin),
        )


def moved(friction: JointFriction) -> bool:
    """Return whether there is motion to draw."""
    return friction.moving_s > 0.0 or not friction.reason


def estimated(friction: JointFriction) -> bool:
    """Return whether there are coefficients to draw."""
    return not friction.reason


def choose_series(
    estimate: "Estimate", numbers: Numbers, has: Callable[[JointFriction], bool] = moved
) -> Chosen[JointSeries]:
    """Return the series of the joints to be drawn, see ``choose``."""
    why = "did not move" if has is moved else "no estimate"
    found = choose(estimate.friction.joints, numbers, has, why)
    return Chosen(tuple(_series(estimate, found.joints)), found.sheet, found.note)


def _series(estimate: "Estimate", joints: Iterable[JointFriction]) -> Iterator[JointSeries]:
    interaction = estimate.interaction
    columns = {number: column for column, number in enumerate(interaction.joint_numbers)}
    for friction in joints:
        column = columns[friction.joint]
        yield JointSeries(
            joint=friction.joint,
            name=interaction.joint_names[column],
            t=interaction.t,
            dq=interaction.dq[:, column],
            torque=interaction.torque[:, column],
            compensation=None if interaction.compensation is None else interaction.compensation[:, column],
            cycles=estimate.cycles.of_joint(column),
            friction=friction,
        )


def shade_cycles(axes: "Axes", series: JointSeries) -> None:
    """Shade every other cycle of a joint and hatch the rejected ones."""
    if series.is_crowded:
        axes.plot([], [], " ", label=f"more than {MOST_SHADED} cycles are not shaded")
        return
    cycles = series.cycles
    for row, (start, stop, reason) in enumerate(zip(cycles.start_s, cycles.stop_s, cycles.reason, strict=True)):
        if reason:
            look: Look = {"facecolor": "none", "edgecolor": REJECTED, "hatch": "/////", "label": "rejected cycle"}
            axes.axvspan(start, stop, linewidth=0, zorder=0, **look)
        elif row % 2 == 0:
            axes.axvspan(start, stop, facecolor=SHADE, linewidth=0, zorder=0, label="every other cycle")


def shade_stretches(axes: "Axes", starts: Iterable[float], stops: Iterable[float], t: Float) -> None:
    """Shade every other stretch of time and end the axis with the signals."""
    for start, stop in list(zip(starts, stops, strict=False))[::2]:
        axes.axvspan(start, stop, facecolor=SHADE, linewidth=0, zorder=0)
    axes.set_xlim(t[0], t[-1])
