"""Estimate -> JSON document ``friction-audit/estimate/1``."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from types import MappingProxyType

from friction_audit.friction.history import Coefficient, CoefficientHistory, JointFriction, TorqueRegression
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.interaction import TorqueChoice
from friction_audit.reporting.json.document import Document, new_document, settings_document, source_document, to_json
from friction_audit.reporting.log_summary import LogSummary
from friction_audit.reporting.terminal.plain import estimate_notices
from friction_audit.reporting.units import in_unit


def estimate_document(estimate: Estimate, reading: Mapping[str, object] = MappingProxyType({})) -> Document:
    """Return the document of an estimate.

    Args:
        estimate: The result.
        reading: How the log was read: options of the reader by name.
    """
    return {
        **new_document("estimate"),
        "source": source_document(estimate.log),
        "settings": settings_document(estimate, reading),
        "warnings": [notice._asdict() for notice in estimate_notices(estimate)],
        "estimator": estimate.friction.estimator,
        "joints": in_unit([_joint(joint) for joint in estimate.friction.joints], estimate.log.source.torque_unit),
    }


def _joint(joint: JointFriction) -> Document:
    return {
        "joint": joint.joint,
        "name": joint.name,
        "model": joint.model,
        "method": joint.method,
        "cycles": joint.cycles,
        "rejected_cycles": joint.rejected_cycles,
        "moving_s": to_json(joint.moving_s),
        "coulomb_nm": coefficient_document(joint.coulomb),
        "viscous_nms_per_rad": coefficient_document(joint.viscous),
        "offset_nm": to_json(joint.offset_nm),
        "gravity_error_nm": to_json(joint.gravity_error_nm),
        "condition_number": to_json(joint.condition_number),
        "correlation": to_json(joint.correlation),
        "reason": joint.reason or None,
        "regression": _regression(joint.regression),
        "history": _history(joint.history),
    }


def coefficient_document(coefficient: Coefficient) -> Document | None:
    """Return value and interval; null for a coefficient that the model lacks or the log cannot determine."""
    value = to_json(coefficient.value)
    return None if value is None else {"value": value, "ci95": to_json([coefficient.low, coefficient.high])}


def _regression(regression: TorqueRegression | None) -> Document | None:
    if regression is None:
        return None
    return {
        "coulomb_nm": coefficient_document(regression.coulomb),
        "viscous_nms_per_rad": coefficient_document(regression.viscous),
        "offset_nm": to_json(regression.offset_nm),
        "inertia_kg_m2": to_json(regression.inertia_kg_m2),
        "inertia_kg_m2_ci95": to_json([regression.inertia.low, regression.inertia.high]),
        "residual_rms_nm": to_json(regression.residual_rms_nm),
        "samples": int(regression.samples),
    }


def _history(history: CoefficientHistory) -> list[Document]:
    rows = zip(
        history.cycle.tolist(),
        to_json(history.start_s),
        to_json(history.stop_s),
        to_json(history.coulomb_nm),
        zip(to_json(history.coulomb_low_nm), to_json(history.coulomb_high_nm), strict=True),
        to_json(history.viscous_nms_per_rad),
        zip(to_json(history.viscous_low_nms_per_rad), to_json(history.viscous_high_nms_per_rad), strict=True),
        to_json(history.net_energy_j),
        to_json(history.dissipated_j),
        strict=True,
    )
    return [
        {
            "cycle": int(cycle),
            "start_s": start,
            "stop_s": stop,
            "coulomb_nm": coulomb,
            "coulomb_nm_ci95": list(coulomb_interval),
            "viscous_nms_per_rad": viscous,
            "viscous_nms_per_rad_ci95": list(viscous_interval),
            "net_energy_j": energy,
            "dissipated_j": dissipated,
        }
        for cycle, start, stop, coulomb, coulomb_interval, viscous, viscous_interval, energy, dissipated in rows
    ]


@dataclass(frozen=True, kw_only=True, slots=True)
class TopicSummary:
    """A topic (or table) found in a file; ``messages`` is None where counting would mean reading all of it."""

    name: str
    type: str
    messages: int | None
    readable: bool


@dataclass(frozen=True, kw_only=True, slots=True)
class InfoEntry:
    """One file asked about: its topics, and its summary or the message of why there is none."""

    path: str
    topics: tuple[TopicSummary, ...] = ()
    summary: LogSummary | None = None
    message: str = ""


def info_document(entries: Iterable[InfoEntry]) -> Document:
    """Return the document on some logs; those that could not be read are listed apart, with their message."""
    logs, failed = [], []
    for entry in entries:
        head: Document = {"path": entry.path, "topics": [asdict(topic) for topic in entry.topics]}
        if entry.summary is None:
            failed.append({**head, "message": entry.message})
        else:
            logs.append({**head, **_summary(entry.summary)})
    return {**new_document("info"), "logs": logs, "failed": failed}


def _summary(summary: LogSummary) -> Document:
    source = source_document(summary.log)
    count = source.pop("joints")
    return {
        **source,
        "joint_count": count,
        "jitter_s": to_json(summary.jitter_s),
        "gaps": summary.gaps,
        "longest_gap_s": to_json(summary.longest_gap_s),
        "stale_samples": summary.stale_samples,
        "clock_windows": summary.log.source.clock_windows,
        "torque": _torque(summary.torque),
        "joints": [to_json(asdict(joint)) for joint in summary.joints],
        "warnings": [notice._asdict() for notice in summary.notices],
    }


def _torque(choice: TorqueChoice | None) -> Document | None:
    return None if choice is None else to_json(asdict(choice))
