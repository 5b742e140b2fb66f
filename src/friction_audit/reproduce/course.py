"""Simulation -> the course of a joint, as the log and the compensator in it know it."""

import numpy as np

from friction_audit.compensation.compensators import EnergyCompensator
from friction_audit.compensation.replay import run
from friction_audit.joint_log import Float
from friction_audit.reporting.figures.paper import Course
from friction_audit.simulation.settings import CONTROL_RATE_HZ
from friction_audit.simulation.simulation import Simulation

SHOWN = ("energy_j", "cycle", "coulomb_nm", "viscous_nms_per_rad", "damping_nms_per_rad")


def make_course(simulation: Simulation, joint: int = 0, *, zero_crossings: bool = False) -> Course:
    """Return the course of a joint, counted from 0, as the log and the compensator in it know it.

    Args:
        simulation: Log and truth.
        joint: Column of the joint.
        zero_crossings: Where no compensator was in the loop: True if cycles end where the velocity changes its sign,
            False if they are found by the thresholds of the paper's section V.
    """
    log, torque = simulation.log, interaction_nm(simulation)[:, joint]
    traces = _known(simulation, joint) or _observed(log.t, log.dq[:, joint], torque, zero_crossings=zero_crossings)
    ends = np.flatnonzero(np.diff(traces["cycle"])) + 1
    return Course(
        t=log.t,
        dq=log.dq[:, joint],
        interaction_nm=torque,
        energy_j=traces["energy_j"],
        ends_s=log.t[ends],
        ends_j=traces["energy_j"][ends],
        coulomb_nm=traces["coulomb_nm"],
        viscous_nms_per_rad=traces["viscous_nms_per_rad"],
        damping_nms_per_rad=traces["damping_nms_per_rad"],
    )


def interaction_nm(simulation: Simulation) -> Float:
    """Return the interaction torque as logged, shape (n, j). [N m]"""
    log = simulation.log
    if log.tau_interaction is not None:
        return log.tau_interaction
    if log.gravity is None or log.tau_J is None:
        raise AssertionError("simulated logs hold the interaction torque, or the sensor's and gravity")
    return np.asarray(log.gravity - log.tau_J)


def _known(simulation: Simulation, joint: int) -> dict[str, Float]:
    """Return what the compensator in the loop knew at the stamps of the log; nothing if none was there."""
    compensators = simulation.truth.compensators
    if not compensators:
        return {}
    ticks = np.rint(simulation.log.t * CONTROL_RATE_HZ).astype(np.intp)
    return {name: compensators[name][ticks, joint] for name in SHOWN}


def _observed(t: Float, dq: Float, torque: Float, *, zero_crossings: bool) -> dict[str, Float]:
    """Return what a compensator that does nothing would have seen: energy and cycles."""
    observer = EnergyCompensator(zero_crossings=zero_crossings, passivity=False, factor=0.0)
    traces = run(observer, t, dq, torque)
    nothing = np.zeros_like(t)
    idle = dict.fromkeys(("coulomb_nm", "viscous_nms_per_rad", "damping_nms_per_rad"), nothing)
    return {"energy_j": traces["energy_j"], "cycle": traces["cycle"], **idle}
