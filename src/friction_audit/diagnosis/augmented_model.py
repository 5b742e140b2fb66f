"""Discrepancy -> the augmented models of an arm: the nominal ones with the effects that were found."""

from typing import NamedTuple

import numpy as np

from friction_audit.diagnosis.result import Discrepancy, JointDiagnosis
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel, Provenance
from friction_audit.effects.parameter import Parameter
from friction_audit.effects.registry import terms
from friction_audit.errors import AnalysisError
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import JointLog

METHOD = "diagnose"
FRICTION = ("coulomb_nm", "viscous_nms_per_rad")


class AugmentedModels(NamedTuple):
    """Models of the joints of a log, and effects that they lack: number of the joint and a sentence."""

    model: ArmModel
    lacking: tuple[tuple[int, str], ...]


def augment_models(found: Discrepancy, log: JointLog, nominal: ArmModel | None) -> AugmentedModels:
    """Add the effects that were found to the model of each joint.

    Args:
        found: The diagnosis.
        log: The log that was diagnosed.
        nominal: The nominal models, one per joint of the log; None for inertia, Coulomb and viscous friction.

    Returns:
        A model per joint of the log: the nominal one of a joint that was not fitted or whose numbers no model allows.
    """
    unknown: tuple[JointModel | None, ...] = (None,) * len(log.joint_names)
    joints = list(unknown if nominal is None else nominal.joints)
    lacking = []
    for joint in (joint for joint in found.joints if joint.augmented):
        cycles = 0 if joint.traces is None else len(np.unique(joint.traces.cycle))
        origin = Provenance(method=METHOD, log=log.source.path, sha256=log.source.sha256, cycles=cycles)
        try:
            joints[joint.joint - 1] = augment_model(joint, joints[joint.joint - 1], origin)
        except AnalysisError as error:
            lacking.append((joint.joint, f"no augmented model: {error}"))
        lacking += [
            (joint.joint, f"{name} is no term of a model, so the augmented one lacks it")
            for name in _without_term(joint)
        ]
    return AugmentedModels(model=ArmModel(names=log.joint_names, joints=tuple(joints)), lacking=tuple(lacking))


def augment_model(joint: JointDiagnosis, nominal: JointModel | None, origin: Provenance) -> JointModel:
    """Return the augmented model of one joint that was fitted.

    Args:
        joint: Its diagnosis.
        nominal: Its nominal model; None for inertia, Coulomb and viscous friction.
        origin: Where the model comes from.

    Raises:
        AnalysisError: If a parameter is outside of its bounds, e.g. friction below zero, or a term is there twice.
    """
    fitted = {name: _allowed(number) if name in FRICTION else number.value for name, number in joint.augmented.items()}
    augmented = [
        FittedTerm(term.name, (*(fitted.get(p.name, 0.0) for p in term.coefficients), *_nonlinear(term, nominal)))
        for term in terms()
        if term.name != "inertia" and all(p.name in fitted for p in term.coefficients if not p.optional)
    ]
    held = () if nominal is None else nominal.held
    augmented += [] if nominal is None else [term for term in nominal.terms if term.name in held]
    found = {effect.name: effect.parameters for effect in (*joint.effects, *joint.negligible)}
    augmented += [
        FittedTerm(term.name, tuple(_bounded(found[term.name].get(p.name), p) for p in term.parameters))
        for term in terms()
        if term.name in found
    ]
    inertia = fitted["inertia_kg_m2"] if nominal is None else nominal.inertia_kg_m2
    return JointModel(inertia_kg_m2=inertia, terms=tuple(augmented), provenance=origin, held=held)


def _allowed(number: Coefficient) -> float:
    """Friction that comes out below zero is zero where its interval holds zero."""
    return max(number.value, 0.0) if number.high >= 0.0 else number.value


def _bounded(number: Coefficient | None, parameter: Parameter) -> float:
    """A parameter, not below its lower bound if its interval holds that; the default of one that is not used."""
    if number is None:
        return parameter.default
    return max(number.value, parameter.lower) if number.high >= parameter.lower else number.value


def _nonlinear(term: Effect, nominal: JointModel | None) -> tuple[float, ...]:
    """Return the nonlinear parameters of a nominal term; its coefficients are fitted."""
    values = None if nominal is None else nominal.values(term.name)
    return () if values is None else values[len(term.coefficients) :]


def _without_term(joint: JointDiagnosis) -> list[str]:
    known = {term.name for term in terms()}
    return [effect.name for effect in (*joint.effects, *joint.negligible) if effect.name not in known]
