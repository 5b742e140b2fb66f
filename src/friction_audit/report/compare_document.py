"""Comparison of methods -> JSON document ``friction-audit/compare/1``."""

from collections.abc import Iterable, Mapping

from friction_audit.report.document import Document, new_document, to_json


def compare_document(
    told: Mapping[str, object],
    methods: Iterable[Mapping[str, object]],
    sweeps: Iterable[Mapping[str, object]],
    figures: Iterable[tuple[str, str]],
) -> Document:
    """Return the document on a comparison.

    Args:
        told: ``arm``, ``duration_s``, ``seeds``, ``tuning_seeds``, ``margin_seeds``, ``settings`` and ``effects``.
        methods: Per method and tuning what came of it.
        sweeps: Per sweep its points.
        figures: Name and path of every figure.
    """
    return {
        **new_document("compare"),
        **to_json(told),
        "methods": [to_json(one) for one in methods],
        "sweeps": [to_json(one) for one in sweeps],
        "figures": [{"figure": name, "path": path} for name, path in figures],
    }
