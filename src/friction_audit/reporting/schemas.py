"""JSON Schemas of the documents."""

from typing import Any

from friction_audit.reporting.table import Document

KINDS = (
    "estimate", "info", "plot", "replay", "diagnose", "convert", "simulate", "truth", "reproduce", "compare", "batch",
    "report", "export", "diff", "plan",
)  # fmt: skip


def document_of(kind: str) -> Document:
    """Return the specification of a kind of document, one of KINDS."""
    from friction_audit.reporting import compare, diagnosis, documents, drift, estimate, export, info, replay, report
    from friction_audit.reporting.diff import DIFF
    from friction_audit.reporting.plan import PLAN

    every = (
        estimate.ESTIMATE, info.INFO, documents.PLOT, replay.REPLAY, diagnosis.DIAGNOSE, documents.CONVERT,
        documents.SIMULATE, documents.TRUTH, compare.REPRODUCE, compare.COMPARE, drift.BATCH, report.REPORT,
        export.EXPORT, DIFF, PLAN,
    )  # fmt: skip
    return next(document for document in every if document.kind == kind)


def load_schema(kind: str) -> dict[str, Any]:
    """Return the JSON Schema of a kind of document, one of KINDS."""
    return document_of(kind).schema()
