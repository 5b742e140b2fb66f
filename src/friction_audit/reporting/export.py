"""Export -> document and lines of the terminal."""

from collections.abc import Iterable, Iterator
from math import isfinite, isnan

from friction_audit.drift.session import COEFFICIENTS
from friction_audit.export.export import Export, Target
from friction_audit.export.friction_law import ExportedJoint
from friction_audit.presets import FRANKA
from friction_audit.reporting.documents import WARNINGS
from friction_audit.reporting.drift_words import NAMES, UNITS
from friction_audit.reporting.notices import Notice, estimate_notices, notice, text_of
from friction_audit.reporting.table import Column, Document, Record, joint_column
from friction_audit.reporting.words import with_unit

ROUNDED = 1e-3  # share of the friction below which an error of the fit is nothing to a simulator


JOINT = Record(
    Column("joint", int, "number, from 1", "law.joint", on="j"),
    Column("name", str, "name in the source", "law.name", on="j"),
    joint_column("law", on="t"),
    Column("file_name", str, "name in the file", "name", title="name in the file", on="jt"),
    Column("static", float, "friction at the onset of motion", unit="N m", on="j"),
    Column("coulomb", float, "Coulomb friction", "written.coulomb_nm", unit="N m", title="Coulomb", on="jt"),
    Column("viscous", float, "viscous friction", "written.viscous_nms_per_rad", unit="N m s/rad", on="jt"),
    Column("quadratic_nms2_per_rad2", float, "damping of dq |dq|", "fitted.coefficients.2", on="j"),
    Column("cubic_nms3_per_rad3", float, "damping of dq^3", "fitted.coefficients.3", on="j"),
    Column("inertia", float, "armature", "written.inertia_kg_m2", unit="kg m²", title="armature", on="jt", null=True),
    Column("error", float, "rms of law less file over the speeds", "fitted.error_nm", unit="N m", on="j"),
    Column("error_share", float, "the same over the rms of the law", "fitted.error_share", on="j"),
    Column("lowest_speed", float, "of the fit", lambda one: float(one.law.speeds.min()), unit="rad/s", on="j"),
    Column("highest_speed", float, "of the fit", lambda one: float(one.law.speeds.max()), unit="rad/s", on="j"),
    Column("left_out", [str], "terms that the file cannot hold", "law.left_out", on="j"),
)  # fmt: skip
GAP = Record(
    Column("joint", int, "number", on="jt"),
    Column("without", float, "rms position error without any", unit="rad", title="error without friction", on="jt"),
    Column("with", float, "rms position error with the exported friction", unit="rad", title="with friction", on="jt"),
    Column("windows", int, "windows of 0.2 s"),
)


def _joint_notices(joint: ExportedJoint, target: Target) -> Iterator[Notice]:
    number, fitted, speeds = joint.law.joint, joint.fitted, joint.law.speeds
    for name in COEFFICIENTS:
        one = joint.found.get(name, joint.written[name])
        if not one.value >= 0.0:
            why = "the source does not determine it"
            if not isnan(one.value):
                why = f"it is {with_unit(one, UNITS[name])}; the friction in the file is the closest without it"
            yield notice("written_as_zero", number, name=NAMES[name], why=why)
    if joint.law.left_out:
        yield notice("terms_left_out", number, target=target.name, terms=", ".join(joint.law.left_out))
    if target.highest_power is not None and fitted.error_share > ROUNDED:
        error = {"error": fitted.error_nm, "percent": 100 * fitted.error_share}
        yield notice("friction_fitted", number, target=target.name, low=speeds.min(), high=speeds.max(), **error)


def export_notices(export: Export) -> Iterable[Notice]:
    """Yield what the user must know of the numbers in the file."""
    yield from estimate_notices(export.estimate) if export.estimate else ()
    yield from (notice("no_friction", number, why=text_of(why)) for number, why in export.lacking)
    for joint in export.joints:
        yield from _joint_notices(joint, export.target)
    if export.by_order:
        yield notice("joints_by_order", pairs=", ".join(f"{one.law.name} = {one.name}" for one in export.joints))
    if export.armature_unknown:
        yield notice("armature_left_out")
    if export.estimate and export.estimate.log.source.robot in FRANKA:
        yield notice("inner_torque_loop", robot=export.estimate.log.source.robot)


EXPORT = Document(
    "export/1",
    "Friction in the file of a simulator or a controller",
    Column("target", str, "format", "target.name"),
    Column("path", str, "where it was written"),
    Column("into", str, "file of the user that it is a copy of", null=True),
    Column("joints", [JOINT], "as written"),
    Column("simulated", [GAP], "forward simulation of the log in MuJoCo, by joint"),
    WARNINGS._replace(get=export_notices),
)


def export_lines(export: Export) -> list[str]:
    """Return the table, and how much of the simulated error the friction explains."""
    lines = JOINT.people(export.joints, "t").filled().lines()
    if any(isfinite(one.high) for joint in export.joints for one in joint.written.values()):
        lines.append("intervals are 95 %")
    if export.simulated:
        lines += ["", "Simulated in MuJoCo with the recorded torque, 0.2 s at a time:"]
        lines += GAP.people(export.simulated, "t").lines()
    return [*lines, "", export.path]
