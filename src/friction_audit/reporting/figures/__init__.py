"""The kinds of figures of each result, in the order in which they are read; drawing one loads its module."""

from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
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
