"""The kinds of figures of each result, in the order in which they are read; drawing one loads its module."""

from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

from friction_audit.errors import UsageError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class FigureKind(NamedTuple):
    """A kind of figure."""

    name: str  # as ``--figures`` takes it, and the first part of its files' names
    result: str  # what it draws: ``estimate``, ``replay``, ``diagnosis``, ``drift`` or ``diff``
    module: str  # whose ``Layout`` of this name, in capitals, draws it
    title: str  # what it shows, in a line
    panel: bool = False  # whether one panel holds a joint, so that it can be drawn into given axes

    def draw(self, result: Any, joint: int | tuple[int, ...] | None = None) -> "Figure":
        """Draw one joint, given by its number (1..n), at column width, or some or all joints on a sheet."""
        drawing: Figure = self.layout()(result, joint)
        return drawing

    def layout(self) -> Any:
        """Return what draws it: a ``panels.Layout``, or a function like one."""
        return getattr(import_module(f"{__package__}.{self.module}"), self.name.replace("-", "_").upper())


FIGURES = (
    FigureKind("coefficients", "estimate", "estimate", "Coefficients over time"),
    FigureKind("velocity-torque", "estimate", "estimate", "Velocity-torque curves", panel=True),
    FigureKind("energy", "estimate", "estimate", "Net energy and cycles"),
    FigureKind("signals", "estimate", "estimate", "Velocity and interaction torque over time"),
    FigureKind("replay", "replay", "replay", "Torque, net energy and coefficients with the compensator"),
    FigureKind("replay-velocity-torque", "replay", "replay", "Velocity-torque curves with the compensator", panel=True),
    FigureKind("ladder", "diagnosis", "profiles", "Residual torque after each effect", panel=True),
    FigureKind("residual", "diagnosis", "profiles", "Where model and measurement disagree"),
    FigureKind("effects", "diagnosis", "profiles", "The effects named"),
    FigureKind("simulation", "diagnosis", "simulation", "Measured and simulated"),
    FigureKind("changes", "drift", "drift", "Change of each joint"),
    FigureKind("drift", "drift", "drift", "Coefficients over the sessions"),
    FigureKind("control", "drift", "drift", "Control chart"),
    FigureKind("curves", "drift", "drift", "Velocity-torque curves"),
    FigureKind("sides", "diff", "drift", "Velocity-torque curves before and after"),
    FigureKind("law-change", "diff", "drift", "Change of the friction torque over the speed"),
)


def figures_of(*results: str) -> tuple[FigureKind, ...]:
    """Return the kinds of figures of some results."""
    return tuple(figure for figure in FIGURES if figure.result in results)


def draw_result(result: Any, of: str, kind: str | None, joint: int | None, axes: "Axes | None") -> "Figure | Axes":
    """Draw a kind of figure of a result (None: the first of one panel), or one joint of it into axes."""
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
            drawn: Figure | Axes = figure.draw(result, joint)
        finally:
            STYLE.reset(token)
    else:
        held = [one.joint for one in estimate.friction.joints]
        if joint is None and len(held) > 1:
            raise UsageError(f"plot: {len(held)} joints and one panel; choose one with joint={held[0]} ... {held[-1]}")
        figure.layout().into(axes, result, held[0] if joint is None else joint)
        drawn = axes
    return label_in_unit(drawn, estimate.log.source.torque_unit)
