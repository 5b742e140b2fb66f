"""A log that was written -> JSON document ``friction-audit/convert/1``."""

from collections.abc import Sequence

from friction_audit.joint_log import JointLog
from friction_audit.report.document import Document, new_document, source_document
from friction_audit.report.notices import Notice, log_notices


def convert_document(log: JointLog, path: str, dialect: str, left_out: Sequence[str] = ()) -> Document:
    """Return the document on a conversion.

    Args:
        log: The log as it was written.
        path: Where it was written.
        dialect: Name of the writer.
        left_out: Channels that the format has no place for.
    """
    notices = log_notices(log) + left_out_notices(path, dialect, left_out)
    return {
        **new_document("convert"),
        "source": source_document(log),
        "output": {"path": path, "dialect": dialect, "joints": len(log.joint_names), "samples": len(log.t)},
        "warnings": [notice._asdict() for notice in notices],
    }


def left_out_notices(path: str, dialect: str, left_out: Sequence[str]) -> tuple[Notice, ...]:
    """Return the warning about channels that the format of a written log has no place for."""
    if not left_out:
        return ()
    message = f"{path}: the dialect {dialect} has no place for {', '.join(left_out)}; left out"
    return (Notice("channels_left_out", None, message),)
