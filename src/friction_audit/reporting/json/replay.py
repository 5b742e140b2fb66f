"""LogReplay -> JSON document ``friction-audit/replay/1``."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from types import MappingProxyType

from friction_audit.compensation.compensators import Compensator, JointModelCompensation, kind_of
from friction_audit.compensation.operator_fit import FittedJoint, FittedOperator
from friction_audit.compensation.result import STATUSES, JointReplay, ReplayHistory
from friction_audit.compensation.settings import ReplaySettings
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.pipeline import LogReplay
from friction_audit.reporting.json.document import Document, new_document, settings_document, source_document, to_json
from friction_audit.reporting.json.estimate import coefficient_document
from friction_audit.reporting.terminal.plain import replay_notices
from friction_audit.reporting.units import in_unit


def replay_document(found: LogReplay, reading: Mapping[str, object] = MappingProxyType({})) -> Document:
    """Return the document of a replay.

    Args:
        found: The result.
        reading: How the log was read: options of the reader by name.
    """
    counterfactual = found.replay.counterfactual
    settings = settings_document(found.estimate, reading)
    return {
        **new_document("replay"),
        "source": source_document(found.estimate.log),
        "settings": settings | {"replay": _settings(found.settings)},
        "warnings": [notice._asdict() for notice in replay_notices(found)],
        "assume": counterfactual.name,
        "assumes": counterfactual.assumes,
        "joints": in_unit([_joint(joint) for joint in found.replay.joints], found.estimate.log.source.torque_unit),
    }


def _settings(settings: ReplaySettings) -> Document:
    """Return what was asked for; of a model file its path, for each joint has its model beside its numbers."""
    given = settings.joint_model
    return {**to_json(asdict(settings)), "joint_model": None if given is None else given.path}


def _joint(joint: JointReplay) -> Document:
    recovery = joint.recovery
    return {
        "joint": joint.joint,
        "name": joint.name,
        "reason": joint.reason or None,
        "compensator": _compensator(joint.compensator),
        "limits": to_json(asdict(joint.limits)),
        "cycles": 0 if joint.history is None else len(joint.history.status),
        **_numbers(joint),
        "joint_model": None if joint.model is None else _model(joint.model),
        "fitted_joint": None if joint.fitted is None else _fitted(joint.fitted, FITTED),
        "operator": None if joint.operator is None else _fitted(joint.operator, OPERATOR),
        "model_error": to_json(joint.model_error),
        "passivity": None if joint.passivity is None else to_json(asdict(joint.passivity)),
        "friction_step": None if recovery is None else to_json(asdict(recovery)),
        "history": [] if joint.history is None else _history(joint.history),
    }


def _compensator(compensator: Compensator) -> Document:
    settings: Document = {"kind": kind_of(compensator).name, **to_json(asdict(compensator))}
    return settings | ({"terms": _terms(compensator.terms)} if isinstance(compensator, JointModelCompensation) else {})


def _model(model: JointModel) -> Document:
    origin: Document = to_json(asdict(model.provenance))
    return {"inertia_kg_m2": model.inertia_kg_m2, "provenance": origin, "terms": _terms(model.terms)}


def _terms(terms: Iterable[FittedTerm]) -> Document:
    """Return the terms by name, each its numbers by name, as a model file has them."""
    return {
        one.name: {parameter.name: value for parameter, value in zip(one.effect.parameters, one.values, strict=True)}
        for one in terms
    }


def _numbers(joint: JointReplay) -> Document:
    """Return the numbers by name, each null where there is a reason."""
    if joint.numbers is None:
        return dict.fromkeys(NUMBERS)
    return {name: to_json(value) for name, value in asdict(joint.numbers).items()}


FITTED = {"inertia": "inertia_kg_m2", "coulomb": "coulomb_nm", "viscous": "viscous_nms_per_rad"}
OPERATOR = {"inertia": "inertia_kg_m2", "damping": "damping_nms_per_rad", "stiffness": "stiffness_nm_per_rad"}
"""Fields of ``FittedJoint`` and ``FittedOperator`` by their keys."""


def _fitted(fitted: FittedJoint | FittedOperator, keys: Mapping[str, str]) -> Document:
    """Return values and intervals; those of an impedance that was given are null."""
    found: Document = {key: coefficient_document(getattr(fitted, name)) for name, key in keys.items()}
    return found | ({"reversals": fitted.reversals} if isinstance(fitted, FittedOperator) else {})


NUMBERS: tuple[str, ...] = (
    "energy_recorded_j",
    "energy_without_j",
    "energy_with_j",
    "dissipation_removed",
    "dissipation_removed_updated",
    "peak_torque_without_nm",
    "peak_torque_with_nm",
    "rms_torque_without_nm",
    "rms_torque_with_nm",
    "peak_compensation_nm",
    "peak_rate_nm_s",
    "limited_fraction",
    "cycles_to_converge",
    "diverged_s",
)
"""Fields of ``Numbers``."""

HISTORY: tuple[str, ...] = (
    "start_s",
    "stop_s",
    "friction_j",
    "net_energy_j",
    "coulomb_applied_nm",
    "viscous_applied_nms_per_rad",
    "coulomb_estimated_nm",
    "viscous_estimated_nms_per_rad",
)
"""Fields of ``ReplayHistory`` that a document shows as they are."""


def _history(history: ReplayHistory) -> list[Document]:
    columns = zip(*(to_json(getattr(history, name)) for name in HISTORY), strict=True)
    rows = enumerate(zip(columns, history.acted.tolist(), history.status.tolist(), strict=True), start=1)
    return [
        {"cycle": cycle, **dict(zip(HISTORY, values, strict=True)), "acted": acted, "status": STATUSES[status]}
        for cycle, (values, acted, status) in rows
    ]
