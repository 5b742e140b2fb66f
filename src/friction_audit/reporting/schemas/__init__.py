"""JSON Schemas of the documents, one file per kind; later versions of a kind only add keys."""

import json
from importlib.resources import files
from typing import Any

KINDS = (
    "estimate", "info", "plot", "replay", "diagnose", "convert", "simulate", "truth", "reproduce", "compare", "batch",
    "report",
)  # fmt: skip


def load_schema(kind: str) -> dict[str, Any]:
    """Return the JSON Schema of a kind of document, one of KINDS."""
    schema: dict[str, Any] = json.loads(files(__name__).joinpath(f"{kind}.json").read_text(encoding="utf-8"))
    return schema
