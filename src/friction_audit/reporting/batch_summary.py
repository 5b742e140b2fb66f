"""BatchSummary: what a batch has to say, gathered for every form in which it is said."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from friction_audit.drift.report import ArmDrift, DriftReport
from friction_audit.drift.session import Session


@dataclass(frozen=True, kw_only=True, slots=True)
class FailedLog:
    """A file that gave no session.

    Attributes:
        path: As found.
        message: What was wrong with it, and what to do.
    """

    path: str
    message: str


@dataclass(frozen=True, kw_only=True, slots=True)
class BatchSummary:
    """A batch of recordings and what became of the friction in them.

    Attributes:
        report: Drift, arm by arm.
        failed: Files that gave no session.
        exceeded: Limits that were exceeded, a sentence each.
        cannot_tell: Limits that the sessions cannot test, a sentence each.
        warnings: What was noticed about the logs as a whole, one sentence each.
        settings: All settings by name, defaults included; values are numbers, words, lists or mappings of them.
        command: The command that makes all of it again.
        computed: Sessions computed in this run.
        known: Sessions that the ledger already held.
    """

    report: DriftReport
    failed: tuple[FailedLog, ...] = ()
    exceeded: tuple[str, ...] = ()
    cannot_tell: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    settings: Mapping[str, object] = field(default_factory=dict)
    command: str = ""
    computed: int = 0
    known: int = 0

    @property
    def arms(self) -> tuple[ArmDrift, ...]:
        """The arms, in order."""
        return self.report.arms

    @property
    def sessions(self) -> tuple[Session, ...]:
        """The sessions of all arms, in order."""
        return tuple(session for arm in self.arms for session in arm.sessions)
