"""BatchSummary -> JSON document ``friction-audit/batch/1``."""

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict

from friction_audit.drift.report import ArmDrift, ChangePoint, CoefficientDrift, ControlPoint, JointDrift
from friction_audit.drift.session import JointSummary, Session
from friction_audit.reporting.batch_summary import BatchSummary
from friction_audit.reporting.drift_words import arm_verdict, drift_verdict, iso_start, joint_verdict
from friction_audit.reporting.json.document import Document, new_document, to_json
from friction_audit.reporting.json.estimate import coefficient_document


def batch_document(summary: BatchSummary) -> Document:
    """Return the document of a batch; sessions count from 1 within their robot, in the order of their starts."""
    return _head(summary) | {name: list(parts) for name, parts in _lists(summary).items()}


def write_batch_document(summary: BatchSummary) -> Iterator[str]:
    """Yield the document as text in ASCII, a line for each key, robot, joint and session.

    Nobody holds the whole of it: a thousand sessions are tens of megabytes.
    """
    before = "{\n"
    for name, value in _head(summary).items():
        yield f'{before}  "{name}": {_text(value)}'
        before = ",\n"
    for name, parts in _lists(summary).items():
        yield f'{before}  "{name}": ['
        inner = "\n"
        for part in parts:
            yield f"{inner}    {_text(part)}"
            inner = ",\n"
        yield "]" if inner == "\n" else "\n  ]"
    yield "\n}\n"


def _text(value: object) -> str:
    return json.dumps(value, allow_nan=False)


def _head(summary: BatchSummary) -> Document:
    return {
        **new_document("batch"),
        "command": summary.command or None,
        "settings": to_json(dict(summary.settings)),
        "computed": summary.computed,
        "known": summary.known,
        "drift": summary.report.drift,
        "exceeded": list(summary.exceeded),
        "cannot_tell": list(summary.cannot_tell),
        "warnings": list(summary.warnings),
        "failed": [{"path": failed.path, "message": failed.message} for failed in summary.failed],
    }


def _lists(summary: BatchSummary) -> Mapping[str, Iterator[Document]]:
    """Return what is long, part by part."""
    return {
        "robots": (_robot(arm) for arm in summary.arms),
        "joints": (_joint(arm, joint) for arm in summary.arms for joint in arm.joints),
        "sessions": (_session(arm, index) for arm in summary.arms for index in range(len(arm.sessions))),
    }


def _robot(arm: ArmDrift) -> Document:
    return {
        "robot": arm.robot,
        "drift": arm.drift,
        "verdict": arm_verdict(arm),
        "message": arm.message,
        "sessions": len(arm.sessions),
        "compared": _numbers(arm.compared),
        "reference": _numbers(arm.reference),
        "left_out": [{"session": index + 1, "reason": reason} for index, reason in arm.left_out],
        "ordered_by": arm.ordered_by,
        "autocorrelation": to_json(arm.autocorrelation),
        "warnings": list(arm.warnings),
    }


def _numbers(indices: tuple[int, ...]) -> list[int]:
    """Return sessions as people count them."""
    return [index + 1 for index in indices]


def _joint(arm: ArmDrift, joint: JointDrift) -> Document:
    by_name = {found.coefficient: found for found in joint.coefficients}
    coulomb, viscous = by_name.get("coulomb_nm"), by_name.get("viscous_nms_per_rad")
    changes = sorted({change.session for found in joint.coefficients for change in found.change_points})
    return {
        "robot": arm.robot,
        "joint": joint.joint,
        "name": joint.name,
        "drift": joint.drift,
        "verdict": joint_verdict(joint),
        "message": joint.message,
        "coulomb_trend_nm_per_session": coefficient_document(coulomb.trend_per_session) if coulomb else None,
        "viscous_trend_nms_per_rad_per_session": coefficient_document(viscous.trend_per_session) if viscous else None,
        "change_points": [session + 1 for session in changes],
        "coefficients": {name: _coefficient(found) for name, found in by_name.items()},
    }


def _coefficient(found: CoefficientDrift) -> Document:
    return {
        "drift": found.drift,
        "verdict": drift_verdict(found),
        "shape": found.shape,
        "message": found.message,
        "p_value": to_json(found.p_value),
        "level": coefficient_document(found.level),
        "change": coefficient_document(found.change),
        "relative_change": coefficient_document(found.total),
        "trend_per_session": coefficient_document(found.trend_per_session),
        "trend_per_day": coefficient_document(found.trend_per_day),
        "trend_p_value": to_json(found.trend_p_value),
        "change_points": [_change_point(change) for change in found.change_points],
        "smallest_change": to_json(found.smallest_change),
        "smallest_relative_change": to_json(found.smallest_drift),
        "relative_scatter": to_json(found.scatter),
        "relative_change_within_session": coefficient_document(found.within),
        "relative_change_per_k": coefficient_document(found.temperature_slope),
        "compared_at_temperature_c": to_json(found.temperature_c),
        "isolated": _numbers(found.isolated),
        "values": [
            {"session": index + 1, "value": _number(value.value), "ci95": [_number(value.low), _number(value.high)]}
            for index, value in zip(found.sessions, found.values, strict=True)
        ],
        "control": [_control(point) for point in found.control],
    }


def _change_point(change: ChangePoint) -> Document:
    return {
        "session": change.session + 1,
        "ci95": [change.low + 1, change.high + 1],
        "before": coefficient_document(change.before),
        "after": coefficient_document(change.after),
        "relative_change": coefficient_document(change.relative),
        "p_value": to_json(change.p_value),
    }


def _control(point: ControlPoint) -> Document:
    return {
        "session": point.session + 1,
        "deviation": _number(point.deviation.value),
        "limits": [_number(point.deviation.low), _number(point.deviation.high)],
        "relative_deviation": _number(point.relative.value),
        "outside": point.outside,
    }


def _session(arm: ArmDrift, index: int) -> Document:
    session: Session = arm.sessions[index]
    return {
        "robot": session.robot,
        "session": index + 1,
        "path": session.path,
        "sha256": session.sha256,
        "start": iso_start(session.start_s),
        "start_s": to_json(session.start_s),
        "start_from": session.start_from,
        "duration_s": to_json(session.duration_s),
        "conditions": to_json(asdict(session.conditions)),
        "temperature_c": to_json(session.temperature_c),
        "note": session.note,
        "damaged": session.damaged,
        "warnings": list(session.warnings),
        "joints": [_summary(joint) for joint in session.joints],
    }


def _summary(joint: JointSummary) -> Document:
    return {
        "joint": joint.joint,
        "name": joint.name,
        **{name: coefficient_document(value) for name, value in joint.coefficients.items()},
        "cycles": joint.cycles,
        "moving_s": to_json(joint.moving_s),
        "speed_quartiles_rad_s": to_json(joint.speed_rad_s),
        "temperature_c": to_json(joint.temperature_c),
        "relative_change_within_session": {name: coefficient_document(value) for name, value in joint.within.items()},
        "reason": joint.reason or None,
        "verdict": joint.verdict,
        "effects": list(joint.effects),
        "curve": {
            "speed_rad_s": _known(joint.curve.speed_rad_s),
            "torque_nm": _known(joint.curve.torque_nm),
            "spread_nm": _known(joint.curve.spread_nm),
        },
    }


def _known(values: Iterable[float]) -> list[float | None]:
    return [_number(value) for value in values]


def _number(value: float) -> float | None:
    """Return a number, or null for NaN and infinity."""
    return value if math.isfinite(value) else None
