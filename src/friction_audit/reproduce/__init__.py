"""The paper's simulated figures: simulated, drawn, and each of their claims held against a number."""

from friction_audit.reproduce.fig3 import FIGURE_3
from friction_audit.reproduce.fig6 import FIGURE_6
from friction_audit.reproduce.fig7 import FIGURE_7
from friction_audit.reproduce.fig8 import FIGURE_8
from friction_audit.reproduce.fig9 import FIGURE_9
from friction_audit.reproduce.fig10 import FIGURE_10
from friction_audit.reproduce.fig11 import FIGURE_11
from friction_audit.reproduce.fig12 import FIGURE_12
from friction_audit.reproduce.fig13 import FIGURE_13
from friction_audit.reproduce.fig14 import FIGURE_14
from friction_audit.reproduce.reproduction import Claim, Reproduction, Simulations
from friction_audit.reproduce.run import simulate_figures

REPRODUCTIONS: tuple[Reproduction, ...] = (
    FIGURE_3,
    FIGURE_6,
    FIGURE_7,
    FIGURE_8,
    FIGURE_9,
    FIGURE_10,
    FIGURE_11,
    FIGURE_12,
    FIGURE_13,
    FIGURE_14,
)
"""The figures, in the paper's order."""

__all__ = ["REPRODUCTIONS", "Claim", "Reproduction", "Simulations", "simulate_figures"]
