"""Estimate -> a tidy CSV table: one row per joint and cycle that counts."""

import csv
import io
import math
from dataclasses import fields
from typing import Any

import numpy as np

from friction_audit.audit import Estimate
from friction_audit.friction.history import CoefficientHistory, JointFriction
from friction_audit.printable import csv_text
from friction_audit.report.units import column_in_unit

COLUMNS = tuple(f.name for f in fields(CoefficientHistory))
HEADER = ("joint", "name", *COLUMNS)


def history_csv(estimate: Estimate) -> str:
    """Return the histories of all joints; an empty cell where a window cannot give a value."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(column_in_unit(name, estimate.log.source.torque_unit) for name in HEADER)
    for joint in estimate.friction.joints:
        writer.writerows(_rows(joint))
    return text.getvalue()


def _rows(joint: JointFriction) -> list[list[str]]:
    columns = [np.asarray(getattr(joint.history, name)).tolist() for name in COLUMNS]
    return [list(map(csv_cell, (joint.joint, joint.name, *row))) for row in zip(*columns, strict=True)]


def csv_cell(value: Any) -> str:  # noqa: ANN401 - any cell
    """Return a value as a cell; an empty one for None and NaN, 0 or 1 for a flag."""
    match value:
        case None:
            return ""
        case str():
            return csv_text(value)
        case float():
            return "" if math.isnan(value) else f"{value:.10g}"
    return str(int(value))
