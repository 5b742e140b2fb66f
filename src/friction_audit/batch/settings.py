"""BatchSettings: what is done with each log, and its fingerprint, by which a ledger knows its results again."""

import hashlib
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from friction_audit.audit import AuditSettings
from friction_audit.ingest import ReadOptions
from friction_audit.ingest.fingerprint import sha256_of

if TYPE_CHECKING:
    from friction_audit.discrepancy.settings import DiagnosisSettings

RESULTS_VERSION = 11
"""Raised with every change of the program after which the same log gives other numbers: ledgers then compute anew."""


@dataclass(frozen=True, kw_only=True, slots=True)
class BatchSettings:
    """What is done with each log of a batch.

    Attributes:
        audit: The chain.
        reading: How logs are read.
        diagnosis: What is asked of a diagnosis, or None for none.
    """

    audit: AuditSettings = field(default_factory=AuditSettings)
    reading: ReadOptions = field(default_factory=ReadOptions)
    diagnosis: "DiagnosisSettings | None" = None

    def text(self) -> str:
        """Return all that the numbers depend on beside the log, as JSON in a fixed order."""
        every = {"results": RESULTS_VERSION, **asdict(self)}
        return json.dumps(every, sort_keys=True, default=_as_text)

    def key(self) -> str:
        """Return the fingerprint of the settings."""
        return hashlib.sha256(self.text().encode()).hexdigest()[:16]


def _as_text(value: Any) -> str:  # noqa: ANN401 - what JSON does not know
    """Return a file by what it holds: an arm's URDF may be written anew under its name."""
    return f"sha256 {sha256_of(value)}" if isinstance(value, Path) else str(value)
