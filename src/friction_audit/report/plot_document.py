"""Figures that were written -> JSON document ``friction-audit/plot/1``."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from friction_audit.audit import Estimate
from friction_audit.report.document import Document, new_document, settings_document, source_document
from friction_audit.report.notices import estimate_notices


def plot_document(
    estimate: Estimate,
    figures: Iterable[tuple[str, int | None, str]],
    reading: Mapping[str, object] = MappingProxyType({}),
) -> Document:
    """Return the document on figures.

    Args:
        estimate: The result that was drawn.
        figures: Kind, joint number (None for a sheet of all) and path of every figure.
        reading: How the log was read: options of the reader by name.
    """
    return {
        **new_document("plot"),
        "source": source_document(estimate.log),
        "settings": settings_document(estimate, reading),
        "warnings": [notice._asdict() for notice in estimate_notices(estimate)],
        "figures": [{"kind": kind, "joint": joint, "path": path} for kind, joint, path in figures],
    }
