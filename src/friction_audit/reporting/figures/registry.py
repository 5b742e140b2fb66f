"""The kinds of figures of each result, in the order in which they are read; drawing one loads its module."""

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

from friction_audit.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as MatplotlibFigure


@dataclass(frozen=True, kw_only=True, slots=True)
class Figure:
    """A kind of figure.

    Attributes:
        name: As ``--figures`` takes it, and the first part of its files' names.
        result: What it draws: ``estimate``, ``replay``, ``diagnosis``, ``drift`` or ``diff``.
        draws: Module and function, with a dot between them.
        title: What it shows, in a line.
        caption: How to read it; empty if it stands on no page.
        panel: Module and function that draw one joint into given axes; empty if it takes more than one panel.
    """

    name: str
    result: str
    draws: str
    title: str
    caption: str = ""
    panel: str = ""

    def draw(self, result: Any, joint: int | tuple[int, ...] | None = None) -> "MatplotlibFigure":
        """Draw one joint, given by its number (1..n), at column width, or some or all joints on a sheet.

        Raises:
            UsageError: If the result does not hold that joint.
        """
        drawing: MatplotlibFigure = _function(self.draws)(result, joint)
        return drawing


def _function(place: str) -> "Callable[..., Any]":
    module, _, function = place.rpartition(".")
    found: Callable[..., Any] = getattr(import_module(f"{__package__}.{module}"), function)
    return found


FIGURES = (
    Figure(
        name="coefficients",
        result="estimate",
        draws="over_time.draw_coefficients",
        title="Coefficients over time",
        caption="Coefficients of a window of cycles that moves over the log, with their 95 % interval; dashed those of "
        "the whole log with theirs. Intervals that are far wider than the rest are clipped.",
    ),
    Figure(
        name="velocity-torque",
        result="estimate",
        draws="velocity_torque.draw_velocity_torque",
        title="Velocity-torque curves",
        caption="Interaction torque against velocity. Loops are inertia, which cancels between two moments of rest; "
        "the fitted line is friction.",
        panel="velocity_torque.draw_panel",
    ),
    Figure(
        name="energy",
        result="estimate",
        draws="over_time.draw_energy",
        title="Net energy and cycles",
        caption="Energy put into the joint. At zero velocity nothing is stored in the inertia, so that the rise from "
        "dot to dot is what friction dissipated. Hatched cycles were rejected.",
    ),
    Figure(
        name="signals",
        result="estimate",
        draws="over_time.draw_signals",
        title="Velocity and interaction torque over time",
    ),
    Figure(
        name="replay",
        result="replay",
        draws="replay.draw_replay",
        title="Torque, net energy and coefficients with the compensator",
        caption="Solid with the compensator, dashed without it; the coefficients are those that it would have applied. "
        "Flat energy means that friction is compensated.",
    ),
    Figure(
        name="replay-velocity-torque",
        result="replay",
        draws="replay.draw_replay_velocity_torque",
        title="Velocity-torque curves with the compensator",
        panel="replay.draw_panel",
    ),
    Figure(
        name="ladder",
        result="diagnosis",
        draws="profiles.draw_ladder",
        title="Residual torque after each effect",
        panel="profiles.draw_panel",
    ),
    Figure(
        name="residual",
        result="diagnosis",
        draws="profiles.draw_residual",
        title="Where model and measurement disagree",
        caption="Residual of the nominal model, and with the effects named, against the quantity that shows the "
        "largest effect; dots are samples, markers means of bins with two standard errors.",
    ),
    Figure(
        name="effects",
        result="diagnosis",
        draws="profiles.draw_effects",
        title="The effects named",
        caption="Each effect as the log shows it, over the quantity that shows most of it, and the fitted effect.",
    ),
    Figure(name="simulation", result="diagnosis", draws="simulation.draw_simulation", title="Measured and simulated"),
    Figure(
        name="changes",
        result="drift",
        draws="sessions.draw_changes",
        title="Change of each joint",
        caption="Change from the reference to the last sessions with its 95 % interval. The grey bar holds the changes "
        "that this many sessions would not have shown with 90 % power.",
    ),
    Figure(
        name="drift",
        result="drift",
        draws="drift.draw_drift",
        title="Coefficients over the sessions",
        caption="Each session with its 95 % interval, as compared (at like temperature where it is known). Solid lines "
        "are levels between steps or a significant trend; a dashed line is a trend that is not significant. Hollow "
        "circles are sessions that were not compared.",
    ),
    Figure(
        name="control",
        result="drift",
        draws="sessions.draw_control",
        title="Control chart",
        caption="Deviation of each session from the level of the reference. The grey band holds all sessions of a "
        "joint that does not change, together with 95 % probability; the panel cuts the band of uncertain sessions.",
    ),
    Figure(
        name="curves",
        result="drift",
        draws="drift.draw_curves",
        title="Velocity-torque curves",
        caption="Mean interaction torque in bins of velocity: the first session, the mean of the reference with the "
        "range of its sessions, and the last session.",
    ),
    Figure(
        name="sides", result="diff", draws="drift.draw_side_curves", title="Velocity-torque curves before and after"
    ),
    Figure(
        name="law-change",
        result="diff",
        draws="drift.draw_law_change",
        title="Change of the friction torque over the speed",
    ),
)


def figures_of(*results: str) -> tuple[Figure, ...]:
    """Return the kinds of figures of some results."""
    return tuple(figure for figure in FIGURES if figure.result in results)


def figure_names(*results: str) -> tuple[str, ...]:
    """Return the names of the kinds of figures of some results."""
    return tuple(figure.name for figure in figures_of(*results))


def draw_result(
    result: Any, of: str, kind: str | None, joint: int | None, axes: "Axes | None"
) -> "MatplotlibFigure | Axes":
    """Draw a kind of figure of a result, or one joint of it into axes.

    Args:
        result: What it draws.
        of: What that is called in FIGURES.
        kind: Name of the figure, or None for the first one that fits into one panel.
        joint: Number of the joint (1..n), or None.
        axes: Axes to draw into, or None for a figure.

    Raises:
        UsageError: If there is no such figure or joint, or the axes do not suffice.
    """
    own = {figure.name: figure for figure in figures_of(of)}
    panels = [name for name, figure in own.items() if figure.panel]
    figure = own.get(kind or panels[0])
    if figure is None or (axes is not None and not figure.panel):
        reason = f"expected one of {', '.join(own)}" if figure is None else f"into axes goes {', '.join(panels)} alone"
        raise UsageError(f"plot: {kind}: {reason}")
    estimate = result if of == "estimate" else result.estimate
    from friction_audit.reporting.figures.panels import label_in_unit  # loads numerics, which the help does not need

    if axes is None:
        from friction_audit.reporting.figures.style import STYLE, style_in_force

        token = STYLE.set(style_in_force())
        try:
            drawn: MatplotlibFigure | Axes = figure.draw(result, joint)
        finally:
            STYLE.reset(token)
    else:
        held = [one.joint for one in estimate.friction.joints]
        if joint is None and len(held) > 1:
            raise UsageError(f"plot: {len(held)} joints and one panel; choose one with joint={held[0]} ... {held[-1]}")
        _function(figure.panel)(axes, result, held[0] if joint is None else joint)
        drawn = axes
    return label_in_unit(drawn, estimate.log.source.torque_unit)
