"""The signals, cycles and friction of one joint of an estimate, as figures draw them."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from friction_audit.friction.history import JointFriction
from friction_audit.joint_log import Float
from friction_audit.preprocessing.energy_cycles import EnergyCycles
from friction_audit.reporting.figures.panels import joint_title
from friction_audit.reporting.figures.style import REJECTED, SHADE, Look

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from friction_audit.pipeline import Estimate

MOST_SHADED = 80  # cycles in one panel above which stripes would only be grey


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class JointSeries:
    """One joint's signals of shape (n,), its cycles, whose start and stop are indices into them, and its friction."""

    title: str  # what a panel is called: the joint's number, and its name where that says more
    t: Float  # [s]
    dq: Float  # velocity [rad/s]
    torque: Float  # interaction torque F_m [N m]
    driving: Float  # what acts against friction and inertia: F_m and the torque of a logged compensator [N m]
    cycles: EnergyCycles
    friction: JointFriction
    not_determined: str  # the words for a panel without an estimate, without advice; empty if there is one


def moved(_: "Estimate", friction: JointFriction) -> bool:
    """Return whether there is motion to draw."""
    return friction.moving_s > 0.0 or not friction.reason


def series_of(estimate: "Estimate", friction: JointFriction) -> JointSeries:
    """Return the series of a joint."""
    interaction = estimate.interaction
    column = interaction.joint_numbers.index(friction.joint)
    torque, compensation = interaction.torque[:, column], interaction.compensation
    return JointSeries(
        title=joint_title(friction.joint, interaction.joint_names[column]),
        t=interaction.t,
        dq=interaction.dq[:, column],
        torque=torque,
        driving=torque if compensation is None else torque + compensation[:, column],
        cycles=estimate.cycles.of_joint(column),
        friction=friction,
        not_determined=f"not determined: {friction.reason.partition(';')[0]}" if friction.reason else "",
    )


def shade_cycles(axes: "Axes", series: JointSeries) -> None:
    """Shade every other cycle of a joint and hatch the rejected ones; end the axis with the signals."""
    cycles = series.cycles
    axes.set_xlim(series.t[0], series.t[-1])
    if len(cycles.joint) > MOST_SHADED:
        axes.plot([], [], " ", label=f"more than {MOST_SHADED} cycles are not shaded")
        return
    for row, (start, stop, reason) in enumerate(zip(cycles.start_s, cycles.stop_s, cycles.reason, strict=True)):
        if reason:
            look: Look = {"facecolor": "none", "edgecolor": REJECTED, "hatch": "/////", "label": "rejected cycle"}
            axes.axvspan(start, stop, linewidth=0, zorder=0, **look)
        elif row % 2 == 0:
            axes.axvspan(start, stop, facecolor=SHADE, linewidth=0, zorder=0, label="every other cycle")
