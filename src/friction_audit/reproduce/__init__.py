"""The paper's simulated figures: simulated, drawn, and each of their claims held against a number."""

from friction_audit.reproduce.arm import FIGURE_12, FIGURE_13, FIGURE_14
from friction_audit.reproduce.one_joint import FIGURE_8, FIGURE_9, FIGURE_10, FIGURE_11
from friction_audit.reproduce.reproduction import Claim, Reproduction, Simulations, simulate_figures
from friction_audit.reproduce.viscous import FIGURE_3, FIGURE_6, FIGURE_7

REPRODUCTIONS: tuple[Reproduction, ...] = (
    *(FIGURE_3, FIGURE_6, FIGURE_7),
    *(FIGURE_8, FIGURE_9, FIGURE_10, FIGURE_11),
    *(FIGURE_12, FIGURE_13, FIGURE_14),
)
"""The figures, in the paper's order."""

__all__ = ["REPRODUCTIONS", "Claim", "Reproduction", "Simulations", "simulate_figures"]
