"""Fig. 14: velocity against interaction torque, compensated by five methods."""

from typing import TYPE_CHECKING

from friction_audit.compensation.comparison import Comparison
from friction_audit.reproduce.course import (
    MOST_SEEDS,
    ROLES,
    SCENARIO,
    compared,
    draw_compared,
    in_words,
    is_ranked,
    rows_of,
    steps_down,
)
from friction_audit.reproduce.reproduction import Claim, Reproduction, Simulations

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def check(simulations: Simulations) -> tuple[Claim, ...]:
    """Check the order of the largest torques and what is left of Coulomb friction, with both kinds of tuning."""
    comparison = compared(simulations)
    return tuple(
        claim
        for role, words in ROLES
        for claim in (_peaks(comparison, role, words), _plateaus(comparison, role, words))
    )


def _peaks(comparison: Comparison, role: str, words: str) -> Claim:
    rows = rows_of(comparison, role)[:-1]
    peaks = [row.interval(lambda outcome: outcome.peak_torque_nm).value for row in rows]
    return Claim(
        figure="14",
        claim=f"the largest torque falls from none to model-based, disturbance observer, torque regulation; {words}",
        paper="none > model > DOB > torque regulation",
        ours=in_words(rows, peaks, 1.0, "N m"),
        value=float(steps_down(peaks)),
        holds=is_ranked(peaks),
        note="the largest torque is mostly inertia: what makes the motor lighter wins, what removes friction alone "
        "cannot",
    )


def _plateaus(comparison: Comparison, role: str, words: str) -> Claim:
    rows = rows_of(comparison, role)
    left = [abs(row.interval(lambda outcome: outcome.coulomb_left).value) for row in rows]
    return Claim(
        figure="14",
        claim=f"the proposed method leaves least of the plateaus of Coulomb friction; {words}",
        paper="significantly reduced, outperforms the others",
        ours=in_words(rows, left, 1.0, "of it left"),
        value=left[-1],
        holds=left[-1] == min(left) and rows[-1].stable_share == 1.0,
        note="an observer that knows the motor's inertia within 20 % leaves as little or less",
    )


def draw(simulations: Simulations) -> "Figure":
    """Draw the curves of all methods."""
    return draw_compared(simulations, "velocity-torque")


FIGURE_14 = Reproduction(
    figure="14",
    title="Velocity and interaction torque of a joint of a Panda, with five compensation methods",
    scenarios=(SCENARIO,),
    most_seeds=MOST_SEEDS,
    check=check,
    draw=draw,
)
