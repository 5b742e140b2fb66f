"""LogReplay -> a tidy CSV table: one row per joint and cycle of its compensator."""

import csv
import io

from friction_audit.audit import LogReplay
from friction_audit.replay.result import STATUSES, JointReplay
from friction_audit.report.history_table import csv_cell
from friction_audit.report.replay_document import HISTORY
from friction_audit.report.units import column_in_unit

HEADER = ("joint", "name", "cycle", *HISTORY, "acted", "status")


def replay_csv(found: LogReplay) -> str:
    """Return the histories of all joints; an empty cell where there is no estimate yet."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(column_in_unit(name, found.estimate.log.source.torque_unit) for name in HEADER)
    for joint in found.replay.joints:
        writer.writerows(_rows(joint))
    return text.getvalue()


def _rows(joint: JointReplay) -> list[list[str]]:
    history = joint.history
    if history is None:
        return []
    columns = zip(*(getattr(history, name).tolist() for name in HISTORY), strict=True)
    found = zip(columns, history.acted.tolist(), history.status.tolist(), strict=True)
    return [
        list(map(csv_cell, (joint.joint, joint.name, cycle, *values, acted, STATUSES[status])))
        for cycle, (values, acted, status) in enumerate(found, start=1)
    ]
