"""JSON Schemas of the documents."""

from importlib import import_module
from typing import Any

from friction_audit.reporting.table import Document

# Kind of document -> module of this package that specifies it, under its name in capitals.
MODULES = {
    "estimate": "estimate", "info": "info", "plot": "documents", "replay": "replay", "diagnose": "diagnosis",
    "convert": "documents", "simulate": "documents", "truth": "documents", "reproduce": "compare", "compare": "compare",
    "batch": "drift", "report": "report", "export": "export", "diff": "diff", "plan": "plan",
}  # fmt: skip
KINDS = tuple(MODULES)


def load_schema(kind: str) -> dict[str, Any]:
    """Return the JSON Schema of a kind of document, one of KINDS."""
    document: Document = getattr(import_module(f"friction_audit.reporting.{MODULES[kind]}"), kind.upper())
    return document.schema()
