"""The sessions of a batch: their part of its document and of its page, and all their values for files."""

import math
from collections.abc import Iterator, Sequence
from itertools import islice, product
from types import SimpleNamespace
from typing import Any, NamedTuple

from friction_audit.drift.report import ArmDrift, JointDrift
from friction_audit.drift.session import Session
from friction_audit.friction.history import UNDETERMINED, Coefficient
from friction_audit.reporting.drift_words import UNITS
from friction_audit.reporting.notices import session_sentences, text_of
from friction_audit.reporting.table import JOINT, NAME, Column, Record, to_json
from friction_audit.reporting.words import SHORTEST_NAME, format_start, iso_start, joint_label

ROWS_AT_ONCE = 2000
PAGE = "jfp"  # what document, files and page have

CURVE = Record(
    Column("speed_rad_s", [float], "mean speed in each bin"),
    Column("torque_nm", [float], "mean interaction torque in it"),
    Column("spread_nm", [float], "its standard deviation"),
)
SESSION_JOINT = Record(
    JOINT,
    NAME,
    Column("coulomb", Coefficient, "estimate", "coefficients.coulomb_nm", unit="N m"),
    Column("viscous", Coefficient, "estimate", "coefficients.viscous_nms_per_rad", unit="N m s/rad"),
    Column("cycles", int, "cycles that count"),
    Column("moving", float, "time in motion", unit="s"),
    Column("speed_quartiles_rad_s", [float], "quartiles of the speed in motion", "speed_rad_s"),
    Column("temperature", float, "mean of the logged temperature", unit="°C"),
    Column("relative_change_within_session", {"*": Coefficient}, "from the first to the last third", "within"),
    Column("reason", str, "why there is no estimate", lambda one: text_of(one.reason), null=True),
    Column("verdict", str, "of `diagnose`, null if it was not asked", lambda one: one.verdict or None, null=True),
    Column("effects", [str], "effects that it named"),
    Column("curve", CURVE, "torque against speed"),
)  # fmt: skip


class SessionRow(NamedTuple):
    """A session, its place among those of its arm, from 0, and its part in the comparison or why it has none."""

    place: int
    session: Session
    note: str = ""


def _temperature(row: SessionRow) -> float | None:
    """Return the temperature from the manifest, or the mean of the joints. [degC]"""
    logged = [one.temperature_c for one in row.session.joints if one.temperature_c is not None]
    given = row.session.temperature_c
    return math.fsum(logged) / len(logged) if given is None and logged else given


NUMBER = Column("session", str, get=lambda row: str(row.place + 1), sort="place", on="p")
FILE = Column("file", str, get="session.path", code=True, on="p")
HEAD = (
    Column("robot", str, "which arm", "session.robot"),
    Column("session", int, "number within the arm, from 1", lambda row: row.place + 1),
    NUMBER,
    Column("start", get="session.start_s", form=format_start, title="started (UTC)", on="p"),
    Column("start", str, "ISO 8601, UTC", lambda row: iso_start(row.session.start_s) or "", null=True),
    Column("start", float, "Unix time", "session.start_s", unit="s"),
    Column("start_from", str, "`manifest`, `log`, `name` or `nothing`", "session.start_from", on=PAGE),
    Column("path", str, "as found", "session.path"),
    Column("sha256", str, "of the file", "session.sha256"),
    Column("duration", float, "length", "session.duration_s", unit="s", form=".0f", title="length", on=PAGE),
)
NOTES = (
    Column("note", str, "from the manifest", "session.note"),
    Column("damaged", bool, "whether part of the file was left out", "session.damaged"),
)
SESSION = Record(
    *HEAD,
    Column("conditions", dict, "how it was recorded and read", "session.conditions"),
    Column("temperature", float, "from the manifest", "session.temperature_c", unit="°C"),
    *NOTES,
    Column("warnings", [str], "what was noticed", lambda row: session_sentences(row.session.warnings)),
    Column("joints", [SESSION_JOINT], "per joint", "session.joints"),
    Column("part", str, get="note", on="p"),
    Column("temperature", get=_temperature, form=".1f", unit="°C", on="p"),
    Column(
        "read_as", str, get="session.conditions", title="recorded and read as", on="p",
        form=lambda how: f"{how.drive}, {how.torque}, gravity {how.gravity}, inertia {how.inertia}",
    ),
    Column("payload", str, get="session.conditions.payload", on="p"),
    FILE,
    Column(
        "notes", str, on="p", get=lambda row: "; ".join(filter(None, (
            row.session.note, "damaged, part of it left out" * row.session.damaged,
            *session_sentences(row.session.warnings),
        ))),
    ),
)  # fmt: skip
LEFT_OUT = Record(NUMBER, FILE, Column("reason", str, get="note", on="p"))

INTERVAL_ENDS = {"value": "value", "ci95_low": "low", "ci95_high": "high"}  # column in a file: field
SESSIONS = Record(
    *HEAD,
    Column("rate", float, get="session.conditions.rate_hz", unit="Hz"),
    *(
        Column(name, str, get=f"session.conditions.{name}")
        for name in ("drive", "torque", "gravity", "inertia", "payload")
    ),
    Column("session_temperature", float, get="session.temperature_c", unit="°C"),
    *NOTES,
    Column("compared", bool, get="is_compared"),
    Column("reference", bool),
    Column("left_out", str),
    *(one.at("joint", on="f") for one in SESSION_JOINT.columns if one.name in ("joint", "name", "cycles", "moving")),
    *(
        Column(f"speed_{name}", float, get=f"joint.speed_rad_s.{k}", unit="rad/s")
        for k, name in enumerate(("lower_quartile", "median", "upper_quartile"))
    ),
    *(one.at("joint", on="f") for one in SESSION_JOINT.columns if one.name in ("temperature", "reason")),
    Column("verdict", str, get=lambda row: row.joint.verdict or ""),
    Column("effects", str, get=lambda row: " ".join(row.joint.effects)),
    Column("coefficient", str),
    Column("unit", str, get=lambda row: UNITS[row.coefficient]),
    *(Column(name, float, get=f"own.{end}") for name, end in INTERVAL_ENDS.items()),
    Column("relative_change_within_session", Coefficient, get="within"),
    *(Column(f"compared_{name}", float, get=f"compared.{end}") for name, end in INTERVAL_ENDS.items()),
    Column("relative_deviation", float, get="control.relative.value"),
    Column("outside", bool, get="control.outside"),
    Column("isolated", bool),
    name="sessions",
    summary="a coefficient of a joint in a session, as the session has it and as it was compared, at like temperature",
)


def coefficient_column(joint: JointDrift, name: str) -> Column:
    """Return the column of a coefficient of a joint in the table of sessions."""
    title = joint_label(joint.joint, joint.name, SHORTEST_NAME)
    get = lambda row: next((one.coefficients.get(name) for one in row.session.joints if one.joint == joint.joint), None)  # noqa: E731
    return Column(f"joint_{joint.joint}", Coefficient, get=get, title=title, on="p")


def session_columns(arms: Sequence[ArmDrift]) -> tuple[dict[str, type], Iterator[dict[str, list[Any]]]]:
    """Return the table of all sessions: what is in its columns, and the columns of some rows after the other."""
    columns = {column.key(): column for column in SESSIONS.file_columns()}
    rows = (row for arm in arms for row in _value_rows(arm))
    lots = iter(lambda: list(islice(rows, ROWS_AT_ONCE)), [])
    cells = ({key: [to_json(column.value(row)) for row in lot] for key, column in columns.items()} for lot in lots)
    return {key: column.kind for key, column in columns.items()}, cells


def _value_rows(arm: ArmDrift) -> Iterator[SimpleNamespace]:
    drifts = {(drift.joint, one.coefficient): one for drift in arm.joints for one in drift.coefficients}
    compared = {(key, k): own for key, one in drifts.items() for k, own in zip(one.sessions, one.values, strict=True)}
    control = {(key, point.session): point for key, one in drifts.items() for point in one.control}
    used, reference, left_out = set(arm.compared), set(arm.reference), dict(arm.left_out)
    for k, session in enumerate(arm.sessions):
        for joint, name in product(session.joints, UNITS):
            key = joint.joint, name
            yield SimpleNamespace(
                place=k, session=session, joint=joint, coefficient=name,
                own=joint.coefficients.get(name, UNDETERMINED), within=joint.within.get(name, UNDETERMINED),
                left_out=text_of(left_out.get(k, ())), is_compared=k in used, reference=k in reference,
                compared=compared.get((key, k), UNDETERMINED), control=control.get((key, k)),
                isolated=k in drifts[key].isolated if (key, k) in compared else None,
            )  # fmt: skip
