"""JSON Schemas of the documents; later versions of a kind rename keys, the same version only adds some."""

from typing import Any

KINDS = (
    "estimate", "info", "plot", "replay", "diagnose", "convert", "simulate", "truth", "reproduce", "compare", "batch",
    "report",
)  # fmt: skip


def load_schema(kind: str) -> dict[str, Any]:
    """Return the JSON Schema of a kind of document, one of KINDS."""
    from friction_audit.reporting import compare, diagnosis, documents, drift, estimate, info, replay, report

    every = (
        estimate.ESTIMATE, info.INFO, documents.PLOT, replay.REPLAY, diagnosis.DIAGNOSE, documents.CONVERT,
        documents.SIMULATE, documents.TRUTH, compare.REPRODUCE, compare.COMPARE, drift.BATCH, report.REPORT,
    )  # fmt: skip
    return next(document.schema() for document in every if document.kind == kind)
