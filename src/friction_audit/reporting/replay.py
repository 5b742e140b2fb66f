"""Replay: its document, its tables for files and its text."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from friction_audit.compensation.competitors import Compensator, JointModelCompensation
from friction_audit.compensation.law import EnergyCompensator
from friction_audit.compensation.records import STATUSES
from friction_audit.compensation.result import JointReplay
from friction_audit.friction.history import Coefficient
from friction_audit.pipeline import LogReplay
from friction_audit.reporting.documents import ResultDocument
from friction_audit.reporting.notices import log_line, physics_of, reason_lines, replay_notices, sentence_of, text_of
from friction_audit.reporting.table import ALL, JOINTS, PEOPLE, Column, Record, to_json
from friction_audit.reporting.words import in_unit, with_unit

DIVERGED = "div."
WORST = -9.99  # share of the dissipation below which the removed share is not shown as a number
FILED = ("violations", "lowest", "injected", "active_fraction")  # of the passivity, in the table for files


def _diverged(joint: JointReplay) -> bool:
    return joint.numbers is not None and not math.isnan(joint.numbers.diverged_s)


def _removed(name: str, title: str, short: str = "") -> Column:
    """Return the column of a share removed, of loops that did not diverge."""
    stable = lambda joint: None if _diverged(joint) else getattr(joint.numbers, name, None)  # noqa: E731
    form = lambda share: f"<{100 * WORST:.0f}" if share < WORST else f"{100 * share:.1f}"  # noqa: E731
    return Column(name, float, get=stable, unit="%", form=form, title=title, short=short, on=PEOPLE)


def _compensator(compensator: Compensator) -> dict[str, Any]:
    settings: dict[str, Any] = {"kind": compensator.name, **to_json(compensator)}
    if isinstance(compensator, JointModelCompensation):  # as a model file has them
        settings["terms"] = {one.name: one.numbers for one in compensator.terms}
    return settings


FITTED = Record(
    Column("inertia", Coefficient, "inertia", "inertia", unit="kg m²"),
    Column("coulomb", Coefficient, "Coulomb friction", "coulomb", unit="N m"),
    Column("viscous", Coefficient, "viscous friction", "viscous", unit="N m s/rad"),
)
OPERATOR = Record(
    Column("inertia", Coefficient, "inertia", "inertia", unit="kg m²"),
    Column("damping", Coefficient, "damping", "damping", unit="N m s/rad"),
    Column("stiffness", Coefficient, "stiffness", "stiffness", unit="N m/rad"),
    Column("reversals", int, "reversals that they were fitted to, 0 if given"),
)
MODEL = Record(
    Column("inertia", float, "inertia", unit="kg m²"),
    Column("provenance", dict, "method, log, sha256 and cycles that it was made from"),
    Column("terms", dict, "terms by name, each its numbers by name", lambda m: {t.name: t.numbers for t in m.terms}),
)
PASSIVITY = Record(
    Column("violations", int, "samples with the ledger below zero by more than two samples and the payback exchange"),
    Column("violations_since_activation", int, "the same of the ledger from the activation on"),
    Column("active_cycles", int, "cycles that gave out more than 5 % of what friction dissipated"),
    Column("lowest", float, "lowest value of the ledger", unit="J"),
    Column("lowest_since_activation", float, "lowest value from the activation on", unit="J"),
    Column("reserve", float, "in the ledger at the activation", unit="J"),
    Column("activation", float, "when the compensator first acted", unit="s"),
    Column("injected", float, "energy that the passivity controller dissipated", unit="J"),
    Column("active_fraction", float, "share of the time for which the passivity controller acted"),
    Column("hidden", bool, "whether the reserve hides over-compensation"),
)  # fmt: skip
STEP = Record(
    Column("step", float, "when friction changed", unit="s"),
    Column("change", float, "friction after over friction before"),
    Column("cycles", int, "cycles until the compensation is right again", null=True),
    Column("seconds", float, "time until then"),
)
HISTORY = Record(
    Column("cycle", int, "number of the compensator's cycle, from 1", lambda h: np.arange(1, len(h.status) + 1)),
    Column("start", float, "its start", unit="s"),
    Column("stop", float, "its end, by the causal filter of a controller", unit="s"),
    Column("friction", float, "energy that friction dissipated", unit="J"),
    Column("net_energy", float, "that less the work of the compensator", unit="J"),
    Column("coulomb_applied", float, "Coulomb friction compensated", unit="N m"),
    Column("viscous_applied", float, "viscous friction compensated", unit="N m s/rad"),
    Column("coulomb_estimated", float, "estimate after the cycle", unit="N m"),
    Column("viscous_estimated", float, "estimate after the cycle", unit="N m s/rad"),
    Column("acted", bool, "whether the passivity controller acted"),
    Column("status", STATUSES, "what came of the cycle", lambda h: [STATUSES[status] for status in h.status]),
    name="replay_cycles",
    summary="a cycle of the compensator on a joint: energy, coefficients applied and estimated",
    over="stop_s",
)


def _number(name: str, meaning: str, unit: str = "", **more: Any) -> Column:  # noqa: ANN401
    """Return a column of the numbers of a replay, null where there is a reason."""
    return Column(name, float, meaning, unit=unit, form=".3f", **more).at("numbers")


JOINT_REPLAY = Record(
    *JOINTS,
    Column("compensator", dict, "kind and settings in force", lambda one: _compensator(one.compensator), on="j"),
    Column("compensator", str, get=lambda one: one.compensator.name, on="f"),
    Column("limits", dict, "`torque_nm` and `rate_nm_s`, null for none", on="j"),
    Column("cycles", int, "cycles", lambda one: 0 if one.history is None else len(one.history), on="j"),
    _number("energy_recorded", "net energy put in, as recorded", "J"),
    _number("energy_without", "without the compensator", "J", title="energy without", short="energy\nwithout", on=ALL),
    _number("energy_with", "with it", "J", title="energy with", short="energy\nwith", on=ALL),
    _number("dissipation_removed", "one less the size of `energy_with_j` over `energy_without_j`"),
    _number("dissipation_removed_updated", "the same cycle by cycle, from the second update of the coefficients on"),
    _removed("dissipation_removed", "removed"),
    _removed("dissipation_removed_updated", "removed, coefficients updated", "later"),
    _number("peak_torque_without", "largest torque", "N m", title="peak torque without", short="peak\nwithout", on=ALL),
    _number("peak_torque_with", "with the compensator", "N m", title="peak torque with", short="peak\nwith", on=ALL),
    _number("rms_torque_without", "root mean square of the interaction torque", "N m"),
    _number("rms_torque_with", "with the compensator", "N m"),
    _number("peak_compensation", "largest torque of the compensator", "N m"),
    _number("peak_rate", "its largest rate", "N m/s"),
    _number("limited_fraction", "share of the samples at a limit"),
    Column("cycles_to_converge", int, "cycles before compensation is right", "numbers.cycles_to_converge", null=True),
    Column(
        "cycles_to_converge", int, sort="numbers.cycles_to_converge",
        get=lambda one: DIVERGED if _diverged(one) else one.numbers and one.numbers.cycles_to_converge, form=str,
        title="cycles to converge", short="conv.\ncycles", on=PEOPLE,
    ),
    _number("diverged", "when the loop diverged, or null", "s"),
    Column("joint_model", MODEL, "with a model file: the model of the joint", "model", on="j", null=True),
    Column("fitted_joint", FITTED, "joint fitted to the log, where it is simulated", "fitted", on="j", null=True),
    Column("operator", OPERATOR, "with `same-operator`: impedance of the person", on="j", null=True),
    Column("model_error", float, "velocity error of the simulated joint over the velocity", on="j"),
    Column("passivity", PASSIVITY, "passivity of the compensated joint", on="j", null=True),
    *(one.at("passivity", on="f") for one in PASSIVITY.columns if one.name in FILED),
    Column("damped", float, get="passivity.injected_j", unit="J", form=".3f", on=PEOPLE),
    Column(
        "passive", str, get="passivity", title="passive\n(acted)", on="t",
        form=lambda found: f"{'no' if found.violations else 'yes'} ({found.active_cycles})",
    ),
    Column(
        "passive", str, get="passivity", on="p",
        form=lambda found: "no" if found.violations else f"yes, acted in {found.active_cycles} cycles",
    ),
    Column("friction_step", STEP, "a step of friction in the log, or null", "recovery", on="j", null=True),
    Column("reason", str, "why the joint cannot be replayed", lambda j: text_of(j.reason), null=True),
    Column(
        "remark", str, on="p",
        get=lambda j: f"diverges at {j.numbers.diverged_s:.3g} s" if _diverged(j) else text_of(j.reason),
    ),
    Column("history", HISTORY, "per cycle of the compensator", on="j"),
    name="replay_joints",
    summary="numbers of a compensator on a joint, over the whole log",
)  # fmt: skip

# A replay that diverged has fewer samples than the recording.
SIGNALS = Record(
    Column("time", get="replayed.t", unit="s"),
    Column("dq_without", get=lambda joint: joint.without.dq[: len(joint.replayed.t)], unit="rad/s"),
    Column("dq_with", get="replayed.dq", unit="rad/s"),
    Column("interaction_without", get=lambda joint: joint.without.interaction_nm[: len(joint.replayed.t)], unit="N m"),
    Column("interaction_with", get="replayed.interaction_nm", unit="N m"),
    *(Column(name, get=f"replayed.{name}_nm", unit="N m") for name in ("compensation", "passivity", "limited")),
    name="replay_signals",
    summary="motion and torque of a joint without the compensator and with it at a sample of the log; "
    "a compensator's torque is the one in force at the sample, computed at the sample before",
    over="time_s",
)


def _settings(found: LogReplay) -> dict[str, Any]:
    """Return the settings; of a model file its path, for each joint has its model among its numbers."""
    given = found.settings.joint_model
    return {"replay": to_json(found.settings) | {"joint_model": None if given is None else given.path}}


REPLAY: ResultDocument = ResultDocument(
    "replay/3",
    "What a friction compensator would have done on one log",
    Column("assume", str, "the counterfactual", "replay.counterfactual.code"),
    Column("assumes", str, "its assumption, one sentence", lambda found: sentence_of(found.replay.counterfactual)),
    Column("joints", [JOINT_REPLAY], "per joint; where there is a reason the numbers are null", "replay.joints"),
    notices=replay_notices,
    settings=_settings,
    files=(
        (JOINT_REPLAY, lambda _, joint: [joint]),
        (HISTORY, lambda _, joint: joint.history),
        (SIGNALS, lambda _, joint: None if joint.replayed is None else joint),
    ),
)


def replay_lines(found: LogReplay) -> list[str]:
    """Return what was assumed, a row per joint, what moved in it, steps of friction, and why joints have no result."""
    marked, physics = physics_of(replay_notices(found), found.replay.joints)
    joints, counterfactual = found.replay.joints, found.replay.counterfactual
    unit = found.estimate.log.source.torque_unit
    who = "person" if found.estimate.interaction.choice.drive == "hand" else "drive"
    sentences = [*_models(found), *(line for joint in joints for line in _moved(joint, who))]
    for number, step in ((joint.joint, joint.recovery) for joint in joints if joint.recovery is not None):
        change = f"joint {number}: friction steps to {step.change:.2f} times at {step.step_s:.4g} s"
        right = f"after {step.cycles} cycles, {step.seconds:.3g} s" if step.cycles else "not in this log"
        sentences.append(f"{change}; compensation right again: {right}")
    sentences += [f"not replayed: {line}" for line in reason_lines(joints)]
    return [
        log_line(found.estimate.log),
        f"interaction torque: {found.estimate.interaction.choice.formula}",
        f"compensator: {describe_compensator(joints)}",
        f"{counterfactual.code}: {sentence_of(counterfactual)}",
        *JOINT_REPLAY.people(joints, "t", unit=unit).lines(marked),
        *physics,
        *(in_unit(line, unit) for line in sentences),
    ]


def describe_compensator(joints: tuple[JointReplay, ...]) -> str:
    """Return the compensator in words, of a joint on which it ran: the others differ in limits and thresholds only."""
    compensator = next((joint for joint in joints if not joint.reason), joints[0]).compensator
    if not isinstance(compensator, EnergyCompensator):
        return f"{compensator.name}, {compensator.summary}"
    if compensator.forced is not None:
        given = compensator.forced
        law = f"fixed at {given.coulomb_nm:g} N m and {given.viscous_nms_per_rad:g} N m s/rad"
    else:
        cycles = compensator.cycles_per_estimate
        times = "" if compensator.factor == 1 else f", times {compensator.factor:g}"
        law = f"{compensator.model} model from the last {f'{cycles} cycles' if cycles > 1 else 'cycle'}{times}"
    return f"{compensator.name}, {law}, {'with' if compensator.passivity else 'without'} passivity controller"


def _models(found: LogReplay) -> Iterator[str]:
    """Yield the model of each joint that was replayed with one, and what of it was applied."""
    given = found.settings.joint_model
    for joint in found.replay.joints:
        if given is None or joint.model is None or joint.reason:
            continue
        names = ", ".join(term.name for term in joint.model.terms) or "no terms"
        applied, origin = joint.compensator, joint.model.provenance
        if isinstance(applied, JointModelCompensation):
            names += f"; applied: {', '.join(term.name for term in applied.terms)}"
        cycles = f"{origin.cycles} cycles" if origin.cycles else ""
        known = ", ".join(filter(None, (origin.method, origin.log, cycles))) or "origin unknown"
        yield f"joint {joint.joint} by {given.path} ({known}): inertia {joint.model.inertia_kg_m2:.4g} kg m², {names}"


def _moved(joint: JointReplay, who: str) -> Iterator[str]:
    """Yield the joint, and who moved it, that moved otherwise than recorded, with their 95 % intervals."""
    origin = "as given"
    if joint.operator is not None and joint.operator.reversals:
        origin = f"as fitted to {joint.operator.reversals} reversals, 95 %"
    for record, moved, words in (
        (FITTED, joint.fitted, f"joint {joint.joint} as fitted, 95 %"),
        (OPERATOR, joint.operator, f"{who} at joint {joint.joint} {origin}"),
    ):
        columns = [one for one in record.columns if one.kind is Coefficient and moved is not None]
        numbers = [f"{one.meaning.split()[0]} {with_unit(one.value(moved), one.unit)}" for one in columns]
        yield from [f"{words}: {', '.join(numbers)}"] if numbers else ()
