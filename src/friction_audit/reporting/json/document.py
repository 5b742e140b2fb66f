"""What all JSON documents share: numbers without NaN, where the log came from, warnings, text."""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from friction_audit import __version__
from friction_audit.joint_log import JointLog
from friction_audit.pipeline import Estimate
from friction_audit.reporting.terminal.plain import Notice, estimate_notices, log_notices

Document = dict[str, Any]


def new_document(kind: str) -> Document:
    """Return the head of a document of a kind, e.g. ``"estimate"``."""
    return {"schema": f"friction-audit/{kind}/1", "version": __version__}


def to_json(value: Any) -> Any:  # noqa: ANN401 - any value of a result or of settings
    """Return the value as JSON knows it: NaN and infinity as null, arrays and tuples as lists, paths as text."""
    match value:
        case Mapping():
            return {str(key): to_json(item) for key, item in value.items()}
        case np.ndarray() | np.generic():
            return to_json(value.tolist())
        case list() | tuple():
            return [to_json(item) for item in value]
        case float():
            return value if math.isfinite(value) else None
        case Path():
            return str(value)
    return value


def write_document(document: Document) -> str:
    """Return the document as text in ASCII, so that any file name can be written, with a newline at its end."""
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def source_document(log: JointLog) -> Document:
    """Return where a log came from and how long it is."""
    source = log.source
    return {
        "path": source.path,
        "sha256": source.sha256,
        "format": source.format,
        "robot": source.robot,
        "clock": source.clock,
        "topic": source.topic,
        "start_s": to_json(source.start_s),
        "channels": dict(source.channels),
        "joints": len(log.joint_names),
        "samples": len(log.t),
        "rate_hz": to_json(log.rate_hz),
        "duration_s": to_json(log.duration_s),
        "torque_unit": source.torque_unit,
    }


def settings_document(estimate: Estimate, reading: Mapping[str, object]) -> Document:
    """Return all settings, defaults included, and the choices that the log made where the user left them open.

    Args:
        estimate: The result.
        reading: How the log was read: options of the reader by name.
    """
    settings = to_json(asdict(estimate.settings))
    chosen = to_json(asdict(estimate.interaction.choice))
    return {
        "reading": to_json(dict(reading)),
        **settings,
        "torque_chosen": chosen,
        "cycles_per_point": estimate.settings.friction.cycles_per_point,
    }


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
