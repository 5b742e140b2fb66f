"""LogReport -> JSON document ``friction-audit/report/1``: the documents of its parts without what they share."""

from collections.abc import Mapping
from dataclasses import asdict

from friction_audit.reporting.json.diagnose import diagnose_document
from friction_audit.reporting.json.document import Document, new_document, settings_document, source_document, to_json
from friction_audit.reporting.json.estimate import estimate_document
from friction_audit.reporting.json.replay import replay_document
from friction_audit.reporting.log_report import LogReport, report_notices
from friction_audit.reporting.log_words import lead_sentence, verdict_sentence, verdict_word
from friction_audit.reporting.units import in_unit

SHARED = ("schema", "version", "source", "settings", "warnings")
"""Keys of the documents of the parts that the whole document has once."""


def log_document(report: LogReport) -> Document:
    """Return the document of a report."""
    diagnosis, replay = report.diagnosis, report.replay
    document = {
        **new_document("report"),
        "command": report.command or None,
        "source": source_document(report.estimate.log),
        "settings": report_settings(report),
        "warnings": [notice._asdict() for notice in report_notices(report)],
        "message": lead_sentence(report),
        "unanswered": [{"part": one.part, "message": one.message} for one in report.unanswered],
        "joints": [
            {
                "joint": one.friction.joint,
                "name": one.friction.name,
                "verdict": verdict_word(one),
                "message": verdict_sentence(one),
            }
            for one in report.joints
        ],
        "estimate": _part(estimate_document(report.estimate)),
        "diagnose": None if diagnosis is None else _part(diagnose_document(diagnosis)),
        "replay": None if replay is None else _part(replay_document(replay)),
    }
    in_its_unit: Document = in_unit(document, report.estimate.log.source.torque_unit)
    return in_its_unit


def report_settings(report: LogReport) -> Document:
    """Return every setting of every part, defaults included."""
    settings = settings_document(report.estimate, report.reading)
    if report.diagnosis is not None:
        settings |= {"diagnosis": to_json(asdict(report.diagnosis.settings))}
    if report.replay is not None:
        settings |= {"replay": to_json(asdict(report.replay.settings))}
    return settings


def _part(document: Mapping[str, object]) -> Document:
    return {key: value for key, value in document.items() if key not in SHARED}
