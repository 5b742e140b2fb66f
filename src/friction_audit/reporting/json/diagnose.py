"""Diagnosis -> JSON document ``friction-audit/diagnose/1``."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from types import MappingProxyType

from friction_audit.diagnosis.gap import Gap
from friction_audit.diagnosis.result import Effect, JointDiscrepancy, Profile, SimulationGap
from friction_audit.friction.history import Coefficient
from friction_audit.pipeline import Diagnosis
from friction_audit.reporting.json.document import Document, new_document, settings_document, source_document, to_json
from friction_audit.reporting.json.estimate import coefficient_document
from friction_audit.reporting.terminal.plain import diagnose_notices
from friction_audit.reporting.units import in_unit


def diagnose_document(found: Diagnosis, reading: Mapping[str, object] = MappingProxyType({})) -> Document:
    """Return the document of a diagnosis.

    Args:
        found: The result.
        reading: How the log was read: options of the reader by name.
    """
    settings = settings_document(found.estimate, reading)
    return {
        **new_document("diagnose"),
        "source": source_document(found.estimate.log),
        "settings": settings | {"diagnosis": to_json(asdict(found.settings))},
        "warnings": [notice._asdict() for notice in diagnose_notices(found)],
        "joints": in_unit([_joint(joint) for joint in found.discrepancy.joints], found.estimate.log.source.torque_unit),
    }


def _joint(joint: JointDiscrepancy) -> Document:
    return {
        "joint": joint.joint,
        "name": joint.name,
        "verdict": joint.verdict,
        "message": joint.message,
        "effects": [_effect(effect) for effect in joint.effects],
        "gap": None if joint.gap is None else _gap(joint.gap),
        "simulation_gap": None if joint.simulation is None else _simulation_gap(joint.simulation),
        "detection_limit_nm": to_json(joint.detection_limit_nm),
        "omnibus_p_value": to_json(joint.omnibus_p),
        "remaining_p_value": to_json(joint.remaining_p),
        "declared": {name: coefficient_document(value) for name, value in joint.declared.items()},
        "grown": {name: coefficient_document(value) for name, value in joint.grown.items()},
        "disagreements": list(joint.disagreements),
        "from_energy": {name: coefficient_document(value) for name, value in joint.from_energy.items()},
        "ladder": [{"step": step, "rms_nm": to_json(rms)} for step, rms in joint.ladder],
        "profiles": _profiles(joint.profiles),
        "remaining": _profiles(joint.remaining),
        "vibration": None if joint.vibration is None else to_json(asdict(joint.vibration)),
        "scatter_nm": joint.scatter_nm,
        "untestable": dict(joint.untestable),
        "findings": [to_json(asdict(finding)) for finding in joint.findings],
    }


def _effect(effect: Effect) -> Document:
    return {
        "name": effect.name,
        "label": effect.label,
        "alternatives": list(effect.alternatives),
        "alternatives_together": [list(pair) for pair in effect.together],
        "decide": effect.decide or None,
        "parameters": {name: to_json(number.value) for name, number in effect.parameters.items()},
        "parameters_ci95": {name: _interval(number) for name, number in effect.parameters.items()},
        "p_value": to_json(effect.p_value),
        "where": effect.where,
        "axis": effect.axis,
        "gap_before_nm": to_json(effect.gap_before_nm),
        "gap_after_nm": to_json(effect.gap_after_nm),
        "partial_rms_nm": to_json(effect.partial_nm),
        "evidence": [to_json(asdict(rival)) for rival in effect.evidence],
        "curve": _curve(effect.curve),
    }


def _interval(number: Coefficient) -> list[float | None]:
    return [to_json(number.low), to_json(number.high)]


def _gap(gap: Gap) -> Document:
    return {
        "baseline_rms_nm": to_json(gap.before),
        "final_rms_nm": to_json(gap.after),
        "noise_floor_rms_nm": to_json(gap.floor),
        "shrink": to_json(gap.shrink),
        "shrink_standard_error": to_json(gap.shrink_se),
        "final_over_floor": to_json(gap.over_floor),
        "held_out_cycles": int(gap.cycles),
    }


def _simulation_gap(gap: SimulationGap) -> Document:
    return {"before": to_json(gap.before), "after": to_json(gap.after), "unit": gap.unit}


def _profiles(profiles: Sequence[Profile]) -> list[Document]:
    """Return what the residual depends on, the most telling first, with the curve of that one."""
    return [_profile(profile, curve=k == 0) for k, profile in enumerate(profiles)]


def _profile(profile: Profile, *, curve: bool) -> Document:
    return {
        "axis": profile.axis,
        "label": profile.label,
        "share": to_json(profile.share),
        "p_value": to_json(profile.p_value),
        "where": profile.where,
        "curve": _curve(profile) if curve else None,
    }


def _curve(profile: Profile) -> Document:
    return {name: to_json(getattr(profile, field)) for name, field in CURVE.items()}


CURVE = {
    "centre": "centre",
    "forwards_nm": "forwards",
    "backwards_nm": "backwards",
    "forwards_se_nm": "forwards_se",
    "backwards_se_nm": "backwards_se",
}
"""Keys of a curve and the fields of ``Profile`` behind them."""
