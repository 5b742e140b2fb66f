"""Export -> document and lines of the terminal."""

from collections.abc import Iterable
from typing import Any

from friction_audit.export.export import Export
from friction_audit.export.target import ExportedJoint
from friction_audit.reporting.documents import WARNINGS
from friction_audit.reporting.notices import Notice, estimate_notices
from friction_audit.reporting.table import Column, Document, Record, joint_column
from friction_audit.reporting.terminal_table import table_lines

ROUNDED = 1e-3  # share of the friction below which an error of the fit is nothing to a simulator
INNER_LOOP = ("panda", "fr3")  # arms whose joints have an inner torque loop

JOINT = Record(
    Column("joint", int, "number, from 1", "law.joint", on="j"),
    Column("name", str, "name in the source", "law.name", on="j"),
    joint_column("law", on="t"),
    Column("file_name", str, "name in the file", "name", title="name in the file", on="jt"),
    Column("static", float, "friction at the onset of motion", unit="N m", on="j"),
    Column("coulomb", float, "Coulomb friction", "fitted.coulomb_nm", unit="N m", title="Coulomb", on="jt"),
    Column(
        "viscous", float, "viscous friction", "fitted.viscous_nms_per_rad", unit="N m s/rad", title="viscous",
        on="jt",
    ),
    Column("quadratic_nms2_per_rad2", float, "damping of dq |dq|", "fitted.quadratic_nms2_per_rad2", on="j"),
    Column("cubic_nms3_per_rad3", float, "damping of dq^3", "fitted.cubic_nms3_per_rad3", on="j"),
    Column("inertia", float, "armature", "law.inertia_kg_m2", unit="kg m²", title="armature", on="jt", null=True),
    Column("error", float, "rms of law less file over the speeds", "fitted.error_nm", unit="N m", on="j"),
    Column("error_share", float, "the same over the rms of the law", "fitted.error_share", on="j"),
    Column("lowest_speed", float, "of the fit", lambda one: float(one.law.speeds.min()), unit="rad/s", on="j"),
    Column("highest_speed", float, "of the fit", lambda one: float(one.law.speeds.max()), unit="rad/s", on="j"),
    Column("left_out", [str], "terms that the file cannot hold", "law.left_out", on="j"),
)  # fmt: skip
GAP = Record(
    Column("joint", int, "number", title="joint", on="jt"),
    Column(
        "without", float, "rms position error without friction", unit="rad", title="error without friction", on="jt"
    ),
    Column("with", float, "rms position error with the exported friction", unit="rad", title="with friction", on="jt"),
    Column("windows", int, "windows of 0.2 s"),
)
EXPORT = Document(
    "export",
    1,
    "Friction in the file of a simulator or a controller",
    Column("target", str, "format", "target.name"),
    Column("path", str, "where it was written"),
    Column("into", str, "file of the user that it is a copy of", null=True),
    Column("joints", [JOINT], "as written"),
    Column("simulated", [GAP], "forward simulation of the log in MuJoCo, by joint"),
    WARNINGS,
)


def export_document(export: Export) -> dict[str, Any]:
    """Return the document."""
    own = {name: getattr(export, name) for name in ("target", "path", "into", "joints", "simulated")}
    return EXPORT.json(own | {"warnings": list(export_notices(export))})


def export_notices(export: Export) -> Iterable[Notice]:
    """Yield what the user must know of the numbers in the file."""
    yield from estimate_notices(export.estimate) if export.estimate else ()
    name = export.target.name
    for number, why in export.lacking:
        yield Notice("no_friction", number, f"not exported: {why}")
    for joint in export.joints:
        number = joint.law.joint
        if joint.law.left_out:
            terms = ", ".join(joint.law.left_out)
            yield Notice(
                "terms_left_out", number, f"joint {number}: {name} has no place for {terms}; the file is without"
            )
        if export.target.highest_power is not None and joint.fitted.error_share > ROUNDED:
            yield Notice("friction_fitted", number, _fit_sentence(joint, name))
    if export.by_order:
        pairs = ", ".join(f"{joint.law.name} = {joint.name}" for joint in export.joints)
        yield Notice("joints_by_order", None, f"joints were matched by their order: {pairs}")
    if export.armature_unknown:
        yield Notice(
            "armature_left_out",
            None,
            "the inertia is not written as armature: the source does not show that it is without the inertia of the "
            "links; use --armature if it is",
        )
    robot = export.estimate.log.source.robot if export.estimate else ""
    if robot in INNER_LOOP:
        yield Notice(
            "inner_torque_loop",
            None,
            f"this is the friction at the joint torque sensor; the inner torque loop of a {robot} has already "
            "reduced that of motor and gear",
        )


def _fit_sentence(joint: ExportedJoint, target: str) -> str:
    low, high = joint.law.speeds.min(), joint.law.speeds.max()
    return (
        f"joint {joint.law.joint}: its friction curve was fitted by what {target} holds, "
        f"{joint.fitted.error_nm:.2g} N m rms off ({100 * joint.fitted.error_share:.2g} %) "
        f"from {low:.2g} to {high:.2g} rad/s"
    )


def export_lines(export: Export) -> list[str]:
    """Return the table, and how much of the simulated error the friction explains."""
    lines = table_lines(JOINT.people(export.joints, "t").filled())
    if export.simulated:
        lines += ["", "Simulated in MuJoCo with the recorded torque, 0.2 s at a time:"]
        lines += table_lines(GAP.people(export.simulated, "t"))
    return [*lines, "", export.path]
