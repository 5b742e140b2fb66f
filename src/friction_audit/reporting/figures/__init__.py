"""Estimate -> figures; the order is that of the command line."""

from friction_audit.reporting.figures.coefficients import draw_coefficients
from friction_audit.reporting.figures.energy import draw_energy
from friction_audit.reporting.figures.figure_kind import FigureKind
from friction_audit.reporting.figures.replay import draw_replay, draw_replay_velocity_torque
from friction_audit.reporting.figures.style import save_figure
from friction_audit.reporting.figures.velocity_torque import draw_signals, draw_velocity_torque

FIGURES = (
    FigureKind(
        name="velocity-torque",
        draw=draw_velocity_torque,
        summary="interaction torque against velocity, raw and filtered, with the fitted friction on it",
    ),
    FigureKind(
        name="energy",
        draw=draw_energy,
        summary="net energy over time, the cycles shaded, their zero-velocity points marked",
    ),
    FigureKind(
        name="coefficients",
        draw=draw_coefficients,
        summary="friction coefficients over time with their 95 % intervals",
    ),
    FigureKind(
        name="signals",
        draw=draw_signals,
        summary="velocity and interaction torque over time, the cycles shaded",
    ),
)

REPLAY_FIGURES = (
    FigureKind(
        name="replay",
        draw=draw_replay,
        summary="torque, net energy and coefficients with a compensator and without, its cycles shaded",
    ),
    FigureKind(
        name="replay-velocity-torque",
        draw=draw_replay_velocity_torque,
        summary="interaction torque against velocity with a compensator and without, raw and filtered",
    ),
)
"""What the default compensator would have done; ``replay`` draws the same with any settings."""

__all__ = ["FIGURES", "REPLAY_FIGURES", "FigureKind", "save_figure"]
