"""Claims of the paper and figures -> JSON document ``friction-audit/reproduce/1``."""

from collections.abc import Iterable, Mapping

from friction_audit.report.document import Document, new_document, to_json


def reproduce_document(
    claims: Iterable[Mapping[str, object]], figures: Iterable[tuple[str, str, str]], seeds: int
) -> Document:
    """Return the document on the paper's figures.

    Args:
        claims: Per claim ``figure``, ``claim``, ``paper``, ``ours``, ``value``, ``holds`` and ``note``.
        figures: Number, title and path of every figure.
        seeds: Persons that were simulated where one moves the joint.
    """
    return {
        **new_document("reproduce"),
        "seeds": seeds,
        "claims": [to_json(claim) for claim in claims],
        "figures": [{"figure": figure, "title": title, "path": path} for figure, title, path in figures],
    }
