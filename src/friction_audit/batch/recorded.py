"""Recorded and Fault: what came of one arm of one log, from its content alone; names and places come later."""

from dataclasses import dataclass

from friction_audit.drift.session import Session


@dataclass(frozen=True, kw_only=True, slots=True)
class Recorded:
    """One arm of a log, estimated.

    Attributes:
        session: Its summary. ``robot`` is what the log itself calls the arm, empty if nothing; ``start_s`` is that of
            the log's clock; nothing of a manifest is in it.
        topic: What ``--topic`` would have to say to read this arm of several; empty where the log holds one.
        kind: ``"panda"``, ``"fr3"`` or ``"unknown"``.
        named_by_serial: True if the log's name for the arm is a serial number, which no other arm has.
    """

    session: Session
    topic: str
    kind: str
    named_by_serial: bool = False


@dataclass(frozen=True, kw_only=True, slots=True)
class Fault:
    """One arm of a log, or the whole of it, that no summary could be made of.

    Attributes:
        message: Why, as people are told beside the name of the log.
        topic: Which arm, as in ``Recorded``.
        lasting: True if the log itself is to blame: the same log with the same settings will fail again.
        detail: Where in the program it happened, if the program is to blame.
    """

    message: str
    topic: str = ""
    lasting: bool = True
    detail: str = ""


@dataclass(frozen=True, kw_only=True, slots=True)
class Worked:
    """What came of a log.

    Attributes:
        sha256: Hash of its content; empty where it could not be read at all.
        recorded: Its arms.
        faults: Arms without a summary.
    """

    sha256: str
    recorded: tuple[Recorded, ...] = ()
    faults: tuple[Fault, ...] = ()
