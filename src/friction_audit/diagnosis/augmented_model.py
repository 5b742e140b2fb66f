"""The augmented models of an arm, the nominal ones with the effects that were found, and the gap in motion.

For that gap a joint is simulated under the measured torque, cycle by cycle, against the motion it made. Every cycle
starts at the measured position and velocity, bristles as the measured motion before has bent them, and runs free to
its end. A torque that is wrong by e for a time T moves the velocity by e T / B: errors add up over a cycle, and so does
the noise of the torque, the floor that no model goes below.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from friction_audit.diagnosis.prepare import Subject
from friction_audit.diagnosis.result import JointDiagnosis, SimulationGap
from friction_audit.dynamics.forward import simulate_segments
from friction_audit.dynamics.torque_tables import rms
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel, Provenance
from friction_audit.effects.registry import terms
from friction_audit.effects.transmission import FAR_SHARE
from friction_audit.errors import AnalysisError
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Int, JointLog
from friction_audit.preprocessing.interaction import Caution

FRICTION = ("coulomb_nm", "viscous_nms_per_rad")
SHORTEST = 3  # fewest samples of a cycle that is simulated
# A joint that its drive alone would bring to its usual speed sooner has hardly any inertia: its velocity would follow
# any error of the torque at once.
LEAST_S = 0.05


def augment_models(
    found: Sequence[JointDiagnosis], log: JointLog, nominal: ArmModel | None
) -> tuple[ArmModel, list[Caution]]:
    """Add the effects that were found to the nominal model of each joint of the log that was diagnosed.

    A joint that was not fitted, or whose numbers no model allows, keeps its nominal one. With the models come the
    effects that they lack: a caution of the joint.
    """
    joints: list[JointModel | None] = [None] * len(log.joint_names) if nominal is None else [*nominal.joints]
    lacking, known = [], {term.name for term in terms()}
    for joint in (joint for joint in found if joint.augmented):
        cycles = 0 if joint.traces is None else len(np.unique(joint.traces.cycle))
        origin = Provenance(method="diagnose", log=log.source.path, sha256=log.source.sha256, cycles=cycles)
        try:
            joints[joint.joint - 1] = augment_model(joint, joints[joint.joint - 1], origin)
        except AnalysisError as error:
            lacking.append(Caution("no_augmented_model", joint.joint, {"error": str(error)}))
        lacking += [
            Caution("no_term", joint.joint, {"name": effect.name})
            for effect in (*joint.effects, *joint.negligible)
            if effect.name not in known
        ]
    return ArmModel(names=log.joint_names, joints=tuple(joints)), lacking


def augment_model(joint: JointDiagnosis, nominal: JointModel | None, origin: Provenance) -> JointModel:
    """Return the augmented model of one joint that was fitted, its nominal model and its origin given.

    Raises:
        AnalysisError: If a parameter is outside of its bounds, e.g. friction below zero, or a term is there twice.
    """
    fitted = {name: _within(one, 0.0) if name in FRICTION else one.value for name, one in joint.augmented.items()}
    augmented = []
    for term in terms():
        if term.name != "inertia" and all(p.name in fitted for p in term.coefficients if not p.optional):
            # Of a nominal term the coefficients are fitted, its nonlinear parameters stay.
            stated = (nominal and nominal.values(term.name)) or ()
            coefficients = (fitted.get(p.name, 0.0) for p in term.coefficients)
            augmented.append(FittedTerm(term.name, (*coefficients, *stated[len(term.coefficients) :])))
    held = () if nominal is None else nominal.held
    augmented += [term for term in (nominal.terms if nominal else ()) if term.name in held]
    found = {effect.name: effect.parameters for effect in (*joint.effects, *joint.negligible)}
    for term in terms():
        if (own := found.get(term.name)) is not None:
            values = (_within(own[p.name], p.lower) if p.name in own else p.default for p in term.parameters)
            augmented.append(FittedTerm(term.name, tuple(values)))
    inertia = fitted["inertia_kg_m2"] if nominal is None else nominal.inertia_kg_m2
    return JointModel(inertia_kg_m2=inertia, terms=tuple(augmented), provenance=origin, held=held)


def _within(number: Coefficient, lower: float) -> float:
    """A number, not below a bound if its interval holds that."""
    return max(number.value, lower) if number.high >= lower else number.value


def simulate_cycles(
    nominal: JointModel,
    augmented: JointModel,
    data: JointData,
    cycles: Int,
    known_inertia_kg_m2: float = 0.0,
) -> SimulationGap | None:
    """Simulate whole cycles, of some numbers, without and with the effects that were found.

    Inertia whose torque was taken out of the recorded one, as by a rigid-body model, is known: the joint moves with it
    all the same. None where no cycle is without a gap, where a model cannot be simulated, or where the joint has no
    inertia that a motion could be simulated with: then only the gap in torque is known.
    """
    every = (np.flatnonzero(data.cycle == number) for number in cycles)
    whole = [(own[0], own[-1]) for own in every if len(own) >= SHORTEST and data.valid[own].all()]
    pieces = np.asarray(whole, np.int64).reshape(-1, 2)
    models = [_heavier(model, known_inertia_kg_m2) for model in (nominal, augmented)]
    drive = data.torque + known_inertia_kg_m2 * data.ddq
    lightest = LEAST_S * rms(drive) / max(rms(data.dq), 1e-300)
    if not len(pieces) or any(model.inertia_kg_m2 < lightest for model in models):
        return None
    motion = replace(data.motion(), smooth_direction=None)  # what is simulated has its own direction
    load = None if data.load is None else data.load - known_inertia_kg_m2 * data.ddq
    before = simulate_segments(models[0], motion, drive, pieces, load)
    after = before if models[1] == models[0] else simulate_segments(models[1], motion, drive, pieces, load)
    if before is None or after is None:
        return None
    inside, traces = np.isfinite(before), {}
    for name, signal in {"t": data.t, "measured": data.dq, "nominal": before, "augmented": after}.items():
        parts = [np.append(signal[first : last + 1], np.nan) for first, last in pieces]
        traces[name] = np.concatenate(parts)[:-1]  # a NaN after each piece but the last
    return SimulationGap(before=rms((before - data.dq)[inside]), after=rms((after - data.dq)[inside]), **traces)


def gap_in_motion(joint: JointDiagnosis, subject: Subject, cycles: Int) -> SimulationGap | None:
    """Do the same for a diagnosis; None also where a fitted number is none that a model allows, as friction below 0."""
    bare = replace(joint, effects=(), augmented=joint.nominal)
    try:
        models = [augment_model(one, subject.model, Provenance()) for one in (bare, joint)]
    except AnalysisError:
        return None
    return simulate_cycles(models[0], models[1], subject.data, cycles, subject.known_inertia_kg_m2)


def _heavier(model: JointModel, inertia_kg_m2: float) -> JointModel:
    """The model with more inertia, that of links, which a gear drives: on the far side of a link."""
    if inertia_kg_m2 == 0.0:
        return model
    whole, heavier = model.inertia_kg_m2 + inertia_kg_m2, []
    for term in model.terms:
        names, values = [parameter.name for parameter in term.effect.parameters], list(term.values)
        if FAR_SHARE.name in names:
            at = names.index(FAR_SHARE.name)
            values[at] = float(np.clip(1.0 - (1.0 - values[at]) * model.inertia_kg_m2 / whole, 0.0, 1.0))
        heavier.append(replace(term, values=tuple(values)))
    return replace(model, inertia_kg_m2=whole, terms=tuple(heavier))
