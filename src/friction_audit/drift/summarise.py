"""Parts of an estimate -> what a session keeps of them: a few numbers per joint instead of a million samples."""

from typing import TYPE_CHECKING

import numpy as np

from friction_audit.drift.regression import relative_change
from friction_audit.drift.session import BY_REGRESSION, COEFFICIENTS, JointSummary, SpeedCurve
from friction_audit.friction.history import NAN, UNDETERMINED, Coefficient, FrictionHistory, JointFriction
from friction_audit.friction.settings import FEWEST_CYCLES
from friction_audit.friction.weighted import fit_windows, set_up
from friction_audit.joint_log import Float, JointLog
from friction_audit.preprocessing.energy_cycles import KEPT, EnergyCycles
from friction_audit.preprocessing.interaction import Interaction

if TYPE_CHECKING:
    from friction_audit.diagnosis.result import Discrepancy

QUARTERS = (0.25, 0.5, 0.75)
BINS = 40  # of speed, in the curve; both directions of motion together
FEWEST_SAMPLES = 20  # a mean of fewer samples is no point of the curve
OUTERMOST = 0.002  # share of the samples beyond each end of the curve: single glitches of the velocity would stretch it


def summarise_joints(
    log: JointLog,
    interaction: Interaction,
    cycles: EnergyCycles,
    friction: FrictionHistory,
    discrepancy: "Discrepancy | None" = None,
) -> tuple[JointSummary, ...]:
    """Return the summary of every joint that was estimated."""
    diagnoses = {} if discrepancy is None else {joint.joint: joint for joint in discrepancy.joints}
    port = interaction.torque  # F_m + u moves the joint and its friction: a logged compensator's help counts [N m]
    if interaction.compensation is not None:
        port = port + interaction.compensation
    found = []
    for column, joint in enumerate(friction.joints):
        moving = np.flatnonzero(np.abs(interaction.dq[:, column]) > cycles.standstill_rad_s[column])
        velocity = interaction.dq[moving, column]
        low, median, high = np.quantile(np.abs(velocity), QUARTERS).tolist() if len(moving) else [NAN] * 3
        diagnosed = diagnoses.get(joint.joint)
        by_energy = joint.method == "energy"
        coefficients = (joint.coulomb, joint.viscous) if by_energy else (UNDETERMINED, UNDETERMINED)
        found.append(
            JointSummary(
                joint=joint.joint,
                name=joint.name,
                coefficients=dict(zip(COEFFICIENTS, coefficients, strict=True)),
                cycles=joint.cycles,
                moving_s=joint.moving_s,
                speed_rad_s=(low, median, high),
                temperature_c=None if log.temperature is None else float(log.temperature[:, joint.joint - 1].mean()),
                within=_change_within(cycles.of_joint(column), joint),
                curve=bin_torque(velocity, port[moving, column]),
                reason=joint.reason if by_energy else BY_REGRESSION,
                verdict=None if diagnosed is None else diagnosed.verdict,
                effects=() if diagnosed is None else tuple(effect.name for effect in diagnosed.effects),
            )
        )
    return tuple(found)


def bin_torque(velocity: Float, torque: Float) -> SpeedCurve:
    """Return mean and spread of the torque (n,) in equally wide bins of the velocity in motion (n,). [N m, rad/s]"""
    if len(velocity) < FEWEST_SAMPLES:
        return SpeedCurve()
    low, high = np.quantile(velocity, (OUTERMOST, 1.0 - OUTERMOST))
    inside = (velocity >= low) & (velocity <= high)
    velocity, torque = velocity[inside], torque[inside]
    width = max(float(high - low), np.finfo(np.float64).tiny)
    place = np.minimum(((velocity - low) / width * BINS).astype(np.int64), BINS - 1)
    count = np.bincount(place, minlength=BINS)

    def means(values: Float) -> Float:
        total = np.bincount(place, weights=values, minlength=BINS)
        return np.asarray(total / np.maximum(count, 1), np.float64)

    kept, mean = count >= FEWEST_SAMPLES, means(torque)
    return SpeedCurve(
        speed_rad_s=means(velocity)[kept].tolist(),
        torque_nm=mean[kept].tolist(),
        spread_nm=np.sqrt(means((torque - mean[place]) ** 2))[kept].tolist(),
    )


def _change_within(own: EnergyCycles, joint: JointFriction) -> dict[str, Coefficient]:
    """Return the relative change of each coefficient from the first third of the cycles to the last one.

    The thirds are fitted apart: points of the history share cycles, and their difference would look surer than it is.
    """
    kept = own.rows(own.reason == KEPT)
    third = len(kept.joint) // 3
    if joint.reason or third < FEWEST_CYCLES:
        return dict.fromkeys(COEFFICIENTS, UNDETERMINED)
    fit = fit_windows(set_up(kept, joint.model), third)
    ends = {
        key: (fit.coefficient(name, 0), fit.coefficient(name, -1))
        for key, name in zip(COEFFICIENTS, ("coulomb", "viscous"), strict=True)
    }
    return {key: relative_change(*both) if both[0].low > 0.0 else UNDETERMINED for key, both in ends.items()}
