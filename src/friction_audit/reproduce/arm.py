"""Fig. 12: seven joints, cycles from the speed of the hand, all coefficients updated at once."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.reporting.figures import paper
from friction_audit.reproduce.course import make_course
from friction_audit.reproduce.one_joint import BAND, SECOND
from friction_audit.reproduce.reproduction import Claim, Reproduction, Simulations, each, share, spread
from friction_audit.simulation.simulation import Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Slope of the cyclic energies, over that of the first two cycles, up to which they count as no longer rising.
SLOPE_BOUND = 0.1


def check_12(simulations: Simulations) -> tuple[Claim, ...]:
    """Check that the cycles of all joints end at once, and what the energies do after the second."""
    arms = simulations["fig12"]
    return (_updated_at_once(arms), _arm_stops(arms), _joints_stop(arms), _keeps(arms))


def _updated_at_once(arms: Sequence[Simulation]) -> Claim:
    alone = sum(map(ends_alone, arms))
    return Claim(
        figure="12",
        claim="the coefficients of all joints are updated at the same instants",
        paper="synchronously",
        ours=f"{alone} cycles end in some joints only",
        value=float(alone),
        holds=alone == 0,
    )


def _arm_stops(arms: Sequence[Simulation]) -> Claim:
    slopes = each(arms, lambda arm: float(slope_ratios(of_the_arm(arm))[0]))
    return Claim(
        figure="12b",
        claim="after two cycles the net energy of the arm stops rising",
        paper="cyclic energies stop increasing",
        ours=f"slope over that of the first two cycles: {spread(slopes, '')}; "
        f"below {SLOPE_BOUND:g} in {share(slopes < SLOPE_BOUND)}",
        value=float(slopes.max()),
        holds=bool((slopes < SLOPE_BOUND).all()),
    )


def _joints_stop(arms: Sequence[Simulation]) -> Claim:
    slopes = np.array([slope_ratios(cyclic_energies(arm)) for arm in arms])
    stopped, joint = slopes < SLOPE_BOUND, int(np.argmax(slopes.max(axis=0)))
    return Claim(
        figure="12b",
        claim="and so does that of every single joint",
        paper="cyclic energies of the joints stop increasing",
        ours=f"{int(stopped.sum())} of {stopped.size} joints; worst {slopes.max():.2f}, joint {joint + 1}",
        value=float(slopes.max()),
        holds=bool(stopped.all()),
        note="a joint need not rest when the hand does, and two cycles may be too alike to separate its coefficients",
    )


def _keeps(arms: Sequence[Simulation]) -> Claim:
    leaves = each(arms, arm_leaves_by)
    negative = np.mean([negative_share(arm) for arm in arms])
    return Claim(
        figure="12b",
        claim="and keeps its value for the remaining cycles",
        paper="maintained their values",
        ours=f"within {BAND:.0%} of that of cycle 2 in {share(leaves < BAND)}: {spread(leaves, 'of it')}",
        value=float(leaves.max()),
        holds=bool((leaves < BAND).all()),
        note=f"{negative:.0%} of the pairs of cycles give a joint one negative coefficient, which is not applied",
    )


def ends_alone(simulation: Simulation) -> int:
    """Return the number of instants at which some joints ended a cycle and others did not."""
    ended = np.diff(simulation.truth.compensators["cycle"], axis=0) != 0
    return int((ended.any(axis=1) & ~ended.all(axis=1)).sum())


def cyclic_energies(simulation: Simulation) -> tuple[Float, Float]:
    """Return when cycles end, shape (m,) [s], and the net energies of the joints then, shape (m, j) [J]."""
    traces = simulation.truth.compensators
    ends = np.flatnonzero(np.diff(traces["cycle"][:, 0])) + 1
    return simulation.truth.motion.t[ends], traces["energy_j"][ends]


def of_the_arm(simulation: Simulation) -> tuple[Float, Float]:
    """Return the same for all joints together, shape (m, 1). [J]"""
    t, energies = cyclic_energies(simulation)
    return t, energies.sum(axis=1, keepdims=True)


def arm_leaves_by(simulation: Simulation) -> float:
    """Return how far the energy of the arm at later ends of cycles is from that of the second, over that."""
    energy = of_the_arm(simulation)[1][:, 0]
    return float(np.abs(energy[SECOND + 1 :] / energy[SECOND] - 1.0).max())


def negative_share(simulation: Simulation) -> float:
    """Return the share of the estimates of which a coefficient is negative."""
    traces = simulation.truth.compensators
    ends = np.flatnonzero(np.diff(traces["cycle"][:, 0])) + 1
    coulomb, viscous = (traces[f"estimated_{name}"][ends] for name in ("coulomb_nm", "viscous_nms_per_rad"))
    known = np.isfinite(coulomb)
    return float(((coulomb < 0.0) | (viscous < 0.0))[known].mean())


def slope_ratios(cyclic: tuple[Float, Float]) -> Float:
    """Return the slope of the cyclic energies from the second on, over that up to it, shape (j,)."""
    t, energies = cyclic
    before = energies[SECOND] / t[SECOND]
    after = np.polyfit(t[SECOND:], energies[SECOND:], 1)[0]
    return np.asarray(after / before)


def _draw_12(simulations: Simulations) -> "Figure":
    arm = simulations["fig12"][0]
    return paper.draw_whole_arm([make_course(arm, joint) for joint in range(len(arm.log.joint_names))])


FIGURE_12 = Reproduction(
    figure="12",
    title="A Panda guided by a hand, combined friction of all joints compensated from two cycles of the hand",
    scenarios=("fig12",),
    most_seeds=5,
    check=check_12,
    draw=_draw_12,
)
