"""The paper's figures in simulation: how each is simulated, drawn, and its claims checked."""

from friction_audit.reporting.figures import paper
from friction_audit.reporting.figures.comparison import draw_comparison
from friction_audit.reproduce import checks
from friction_audit.reproduce.checks import compare_methods, compensated, last_period
from friction_audit.reproduce.claims import Claim, Reproduction, Simulations, make_course, simulate_figure
from friction_audit.simulation.bench import PANDA_JOINTS

__all__ = ["REPRODUCTIONS", "Claim", "Reproduction", "Simulations", "simulate_figure"]

MANY = 1000  # no practical limit of the seeds
FEW = 5  # of an arm; ``compare --arm panda`` takes more
REPRODUCTIONS = (  # the figures, in the paper's order
    Reproduction(
        "3", "Net energy, kinetic and dissipated energy of a joint with viscous friction", ("fig3",),
        checks.check_3, lambda done: paper.draw_exchange(*checks.energies(done)),
    ),
    Reproduction(
        "6", "Viscous friction that doubles at 6 s, compensated by its estimate", ("fig6",),
        checks.check_6, checks.draw_6,
    ),
    Reproduction(
        "7", "Viscous friction compensated by half as much again, without and with the passivity controller",
        ("fig7-unprotected", "fig7"), checks.check_7,
        lambda done: paper.draw_overcompensation(make_course(*done["fig7-unprotected"]), make_course(*done["fig7"])),
    ),
    Reproduction(
        "8", "One joint moved by a person, without compensation", ("fig8",),
        checks.check_8, lambda done: paper.draw_uncompensated(make_course(done["fig8"][0])), MANY,
    ),
    Reproduction(
        "9", "Interaction torque over velocity: combined friction, and the same perfectly compensated",
        ("fig9-friction", "fig9-compensated"), checks.check_9,
        lambda done: paper.draw_plateaus(last_period(*done["fig9-friction"]), last_period(*done["fig9-compensated"])),
    ),
    Reproduction(
        "10", "One joint moved by a person, combined friction compensated from two cycles", checks.FIG_10,
        checks.check_10, lambda done: paper.draw_compensated(make_course(done["fig10"][0])), MANY,
    ),
    Reproduction(
        "11", "Interaction torque over velocity, combined friction compensated", ("fig8", "fig10"), checks.check_11,
        lambda done: paper.draw_compensated_loop(
            compensated(make_course(done["fig10"][0])), make_course(done["fig8"][0])
        ),
        MANY,
    ),
    Reproduction(
        "12", "A Panda guided by a hand, combined friction of all joints compensated from two cycles of the hand",
        ("fig12",), checks.check_12,
        lambda done: paper.draw_whole_arm([make_course(done["fig12"][0], j) for j in range(len(PANDA_JOINTS))]), FEW,
    ),
    Reproduction(
        "13", "Net energy of a Panda guided by a hand, with five compensation methods", ("fig13",),
        lambda done: checks.check_13(done["fig13"]),
        lambda done: draw_comparison(done["fig13"], ["energy"])["energy"], FEW, compare_methods,
    ),
    Reproduction(
        "14", "Velocity and interaction torque of a joint of a Panda, with five compensation methods", ("fig13",),
        lambda done: checks.check_14(done["fig13"]),
        lambda done: draw_comparison(done["fig13"], ["velocity-torque"])["velocity-torque"], FEW, compare_methods,
    ),
)  # fmt: skip
