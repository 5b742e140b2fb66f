"""The gap in motion: a joint simulated under the measured torque, cycle by cycle, against the motion it made.

Every cycle starts at the measured position and velocity, bristles as the measured motion before has bent them, and
runs free to its end; nothing pulls it back to the measurement. A torque that is wrong by e for a time T moves the
velocity by e T / B, so errors add up over a cycle: that is what makes the gap in motion a hard test, and the noise of
the torque, added up likewise, is the floor that no model goes below.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.augmented_model import augment_model
from friction_audit.diagnosis.result import JointDiagnosis, SimulationGap
from friction_audit.dynamics.forward import simulate_along
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.joint_model import FittedTerm, JointModel, Provenance
from friction_audit.effects.transmission import FAR_SHARE
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float

SHORTEST = 3
"""Fewest samples of a cycle that is simulated."""
LEAST_S = 0.05
"""A joint that its drive alone would bring to its usual speed sooner has hardly any inertia: its velocity would follow
any error of the torque at once."""


def gap_in_motion(
    joint: JointDiagnosis,
    nominal: JointModel | None,
    data: JointData,
    cycles: NDArray[np.int64],
    *,
    known_inertia_kg_m2: float = 0.0,
) -> SimulationGap | None:
    """Simulate whole cycles of a joint that was diagnosed, without and with what was found.

    Args:
        joint: What a diagnosis says of it; its nominal and augmented numbers are those fitted.
        nominal: Its nominal model; None for inertia, Coulomb and viscous friction.
        data: The joint.
        cycles: As of ``simulate_cycles``.
        known_inertia_kg_m2: Likewise.

    Returns:
        As ``simulate_cycles``; None also where a number that was fitted is none that a model allows, as friction below
        zero.
    """
    bare = replace(joint, effects=(), augmented=joint.nominal)
    try:
        models = [augment_model(one, nominal, Provenance()) for one in (bare, joint)]
    except AnalysisError:
        return None
    return simulate_cycles(models[0], models[1], data, cycles, known_inertia_kg_m2=known_inertia_kg_m2)


def simulate_cycles(
    nominal: JointModel,
    augmented: JointModel,
    data: JointData,
    cycles: NDArray[np.int64],
    *,
    known_inertia_kg_m2: float = 0.0,
) -> SimulationGap | None:
    """Simulate whole cycles with both models.

    Args:
        nominal: The model without the effects that were found.
        augmented: The model with them.
        data: The joint.
        cycles: Numbers of the cycles, those that no choice was made on.
        known_inertia_kg_m2: Inertia whose torque was taken out of the recorded one, as by a rigid-body model; the joint
            moves with it all the same.

    Returns:
        The gap; None where no cycle is without a hole, where a model cannot be simulated, or where the joint has no
        inertia that a motion could be simulated with: then only the gap in torque is known.
    """
    pieces, models = _whole(data, cycles), [_heavier(model, known_inertia_kg_m2) for model in (nominal, augmented)]
    drive = data.torque + known_inertia_kg_m2 * data.ddq
    if not len(pieces) or any(_weightless(model, data, drive) for model in models):
        return None
    motion = replace(data.motion(), way=None)  # what is simulated has its own direction
    load = None if data.load is None else data.load - known_inertia_kg_m2 * data.ddq
    before = simulate_along(models[0], motion, drive, pieces, load)
    after = before if models[1] == models[0] else simulate_along(models[1], motion, drive, pieces, load)
    if before is None or after is None:
        return None
    inside = np.isfinite(before)
    return SimulationGap(
        before=_rms((before - data.dq)[inside]),
        after=_rms((after - data.dq)[inside]),
        unit="rad/s",
        t=_traced(data.t, pieces),
        measured=_traced(data.dq, pieces),
        nominal=_traced(before, pieces),
        augmented=_traced(after, pieces),
    )


def _heavier(model: JointModel, inertia_kg_m2: float) -> JointModel:
    """The model with more inertia, that of links, which a gear drives."""
    if inertia_kg_m2 == 0.0:
        return model
    whole = model.inertia_kg_m2 + inertia_kg_m2
    terms = tuple(_driving(term, model.inertia_kg_m2 / whole) for term in model.terms)
    return replace(model, inertia_kg_m2=whole, terms=terms)


def _driving(term: FittedTerm, own: float) -> FittedTerm:
    """A term with more inertia on its far side; `own` is the share that the model itself holds."""
    names = [parameter.name for parameter in term.effect.parameters]
    if FAR_SHARE.name not in names:
        return term
    at = names.index(FAR_SHARE.name)
    before = (1.0 - term.values[at]) * own
    return replace(term, values=(*term.values[:at], min(max(1.0 - before, 0.0), 1.0), *term.values[at + 1 :]))


def _weightless(model: JointModel, data: JointData, drive: Float) -> bool:
    """Whether the drive would bring the joint to its usual speed in no time."""
    return model.inertia_kg_m2 * _rms(data.dq) < LEAST_S * _rms(drive)


def _whole(data: JointData, cycles: NDArray[np.int64]) -> NDArray[np.int64]:
    """First and last sample of the cycles without a hole, shape (p, 2)."""
    pieces = []
    for number in cycles:
        samples = np.flatnonzero(data.cycle == number)
        if len(samples) >= SHORTEST and data.valid[samples].all():
            pieces.append((samples[0], samples[-1]))
    return np.asarray(pieces, np.int64).reshape(-1, 2)


def _traced(signal: Float, pieces: NDArray[np.int64]) -> Float:
    """Cut the pieces out and put a NaN after each but the last."""
    parts = [np.append(signal[first : last + 1], np.nan) for first, last in pieces]
    return np.concatenate(parts)[:-1]


def _rms(signal: Float) -> float:
    return float(np.sqrt(np.mean(signal**2)))
