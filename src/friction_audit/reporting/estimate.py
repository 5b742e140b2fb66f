"""Estimate: its document, its tables for files and its text."""

from typing import Any

import numpy as np

from friction_audit.friction.history import Coefficient
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.energy_cycles import REASONS
from friction_audit.reporting.documents import ResultDocument
from friction_audit.reporting.notices import estimate_notices, log_line, physics_of, reason_lines, text_of
from friction_audit.reporting.table import ALL, INTERVAL, JOINT, NAME, Column, Record, joint_column
from friction_audit.reporting.words import format_coefficient, in_unit, joint_label

MARK = "*"  # of a joint whose coefficients are not from energy cycles
SIGN = ("sign undecided", "sign consistent with dissipation")

REGRESSION = Record(
    Column("coulomb", Coefficient, "Coulomb friction", "coulomb", unit="N m"),
    Column("viscous", Coefficient, "viscous friction", "viscous", unit="N m s/rad"),
    Column("offset", float, "constant part of the torque", unit="N m"),
    Column("inertia", float, "coefficient of the acceleration", "inertia.value", unit="kg m²"),
    Column("inertia_kg_m2_ci95", INTERVAL, "its 95 % interval", "inertia"),
    Column("residual_rms", float, "root mean square of the residual", unit="N m"),
    Column("samples", int, "samples used"),
)


def _over_time(name: str, unit: str) -> tuple[Column, ...]:
    """Return the columns of a coefficient of the last cycles."""
    value = Column(name, float, f"{name} friction of the last cycles", f"{name}.value", unit=unit)
    low, high = (Column(f"{name}_{end}", get=f"{name}.{end}", unit=unit, on="f") for end in ("low", "high"))
    both = lambda h: zip(low.value(h), high.value(h), strict=True)  # noqa: E731
    return value, Column(f"{value.key()}_ci95", INTERVAL, "its 95 % interval", both, on="j"), low, high


HISTORY = Record(
    Column("cycle", int, "number of the cycle among those of the joint, from 1"),
    Column("start", float, "its start", unit="s"),
    Column("stop", float, "its end, when the estimate is known", unit="s"),
    *_over_time("coulomb", "N m"),
    *_over_time("viscous", "N m s/rad"),
    Column("net_energy", float, "net energy since the start of the first cycle", unit="J"),
    Column("dissipated", float, "energy that friction dissipated in the cycle, as the estimator counts it", unit="J"),
    Column("path", float, "path of the cycle, which times the Coulomb coefficient is energy", unit="rad"),
    Column("square_speed_rad2_s", float, "integral of the squared velocity, likewise for the viscous one"),
    name="coefficient_history",
    summary="friction coefficients of a joint after a cycle that counts, from the last cycles, with 95 % intervals",
    over="stop_s",
)  # fmt: skip

# Of the torque regression the terminal has the value alone, for a comparison by eye.
REGRESSED: dict[str, Any] = {"form": lambda one: format_coefficient(one).split()[0], "title": "regr.", "on": "t"}
FRICTION = Record(
    JOINT,
    NAME,
    Column(
        "joint", str, get="", on="t",
        form=lambda one: joint_label(one.joint, one.name) + f" {MARK}" * (one.method != "energy" and not one.reason),
    ),
    joint_column(on="p"),
    Column("model", ("combined", "coulomb", "viscous"), "friction model"),
    Column("method", ("energy", "regression"), "energy cycles, or torque regression where too few cycles count"),
    Column("cycles", int, "cycles that count", on="jfp"),
    Column("rejected_cycles", int, "cycles rejected", title="rejected", on="jfp"),
    Column("moving", float, "time above the initiation threshold", unit="s"),
    Column("coulomb", Coefficient, "over the whole log", "coulomb", unit="N m", title="Coulomb", on=ALL),
    Column("coulomb", Coefficient, get="regression.coulomb", unit="N m", **REGRESSED),
    Column("viscous", Coefficient, "over the whole log", "viscous", unit="N m s/rad", on=ALL),
    Column("viscous", Coefficient, get="regression.viscous", unit="N m s/rad", **REGRESSED),
    Column("offset", float, "torque offset", unit="N m"),
    Column("gravity_error", float, "amplitude of the gravity error", unit="N m"),
    Column(
        "cycles", int, get="", form=lambda one: f"{one.cycles} ({one.rejected_cycles})",
        title="cycles\n(rejected)", on="t",
    ),
    Column("condition_number", float, "of scaled regression", short="cond.\nnumber", on=ALL),
    Column("correlation", float, "between the two coefficients"),
    Column("coulomb", Coefficient, get="regression.coulomb", unit="N m", title="regression: Coulomb", on="p"),
    Column("viscous", Coefficient, get="regression.viscous", unit="N m s/rad", title="regression: viscous", on="p"),
    Column("residual_rms", float, get="regression.residual_rms_nm", unit="N m", on="f"),
    Column(
        "reason", str, "why there is no estimate", lambda one: text_of(one.reason), null=True,
        form=lambda reason: f"no estimate: {reason}", title="remark", on="jfp",
    ),
    Column("regression", REGRESSION, "the torque regression, for comparison", on="j", null=True),
    Column("history", HISTORY, "per cycle that counts", on="j"),
    name="coefficients",
    summary="friction coefficients of a joint over the whole log, with 95 % intervals",
)  # fmt: skip
CYCLES = Record(
    Column("cycle", int, get=lambda own: np.arange(1, len(own.start) + 1)),
    Column("start", unit="s"),
    Column("stop", unit="s"),
    Column("peak_speed", unit="rad/s"),
    Column("net_energy", float, get="sums.work_j", unit="J"),
    Column("compensation", float, get="sums.compensation_j", unit="J"),
    Column("dissipated", float, get="sums.dissipated_j", unit="J"),
    Column("path", float, get="sums.path_rad", unit="rad"),
    Column("displacement", float, get="sums.displacement_rad", unit="rad"),
    Column("open", bool),
    Column("rejected", str, get=lambda own: [REASONS[reason] for reason in own.reason]),
    name="cycles",
    summary="an energy cycle of a joint, from rest to rest, also one that is rejected",
    over="stop_s",
)
INTERACTION = Record(
    Column("time", get="0.t", unit="s"),
    Column("q", get=lambda at: at[0].q[:, at[1]], unit="rad"),
    Column("dq", get=lambda at: at[0].dq[:, at[1]], unit="rad/s"),
    Column("interaction", get=lambda at: at[0].torque[:, at[1]], unit="N m"),
    Column(
        "compensation", get=lambda at: None if at[0].compensation is None else at[0].compensation[:, at[1]],
        unit="N m", optional=True,
    ),
    name="interaction",
    summary="motion of a joint and torque at its friction port at a sample of the log",
    over="time_s",
)  # fmt: skip
ESTIMATE: ResultDocument = ResultDocument(
    "estimate/1",
    "Friction coefficients of the joints of one log",
    Column("estimator", str, "method", "friction.estimator"),
    Column("joints", [FRICTION], "per joint", "friction.joints"),
    notices=estimate_notices,
    files=(
        (FRICTION, lambda _, joint: [joint]),
        (HISTORY, lambda _, joint: joint.history),
        (CYCLES, lambda found, joint: found.cycles[found.interaction.joint_numbers.index(joint.joint)]),
        (INTERACTION, lambda found, joint: (found.interaction, found.interaction.joint_numbers.index(joint.joint))),
    ),
)


def estimate_lines(estimate: Estimate) -> list[str]:
    """Return what was chosen, a row per joint, and the reasons of the joints that have no estimate."""
    choice, settings = estimate.interaction.choice, estimate.settings.friction
    joints, unit = estimate.friction.joints, estimate.log.source.torque_unit
    marked, physics = physics_of(estimate_notices(estimate), joints)
    intervals = "no intervals" if estimate.friction.estimator == "paper" else "intervals are 95 %"
    window = f"history over up to {settings.cycles_per_point} cycles; {intervals}"
    lines = [
        log_line(estimate.log),
        "; ".join(text for text in (f"interaction torque: {choice.formula}", text_of(choice.reason)) if text),
        f"drive {choice.drive}, gravity {choice.gravity}, inertia {choice.inertia}; {SIGN[choice.sign_proved]}",
        f"estimator: {estimate.friction.estimator}, {settings.model} model, {window}",
        *FRICTION.people(joints, "t", unit=unit).lines(marked),
    ]
    if any(joint.method != "energy" and not joint.reason for joint in joints):
        lines.append(f"{MARK} from torque regression: too few energy cycles")
    return lines + physics + [in_unit(f"not determined: {line}", unit) for line in reason_lines(joints)]
