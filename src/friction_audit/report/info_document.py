"""LogSummary -> JSON document ``friction-audit/info/1``."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass

from friction_audit.interaction.interaction import TorqueChoice
from friction_audit.report.document import Document, new_document, source_document, to_json
from friction_audit.report.log_summary import LogSummary


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
