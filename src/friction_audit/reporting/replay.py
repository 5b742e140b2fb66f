"""Replay: its document, its tables for files and its text."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from friction_audit.compensation.compensators import Compensator, JointModelCompensation, kind_of
from friction_audit.compensation.result import STATUSES, JointReplay, Signals
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.friction.history import Coefficient
from friction_audit.io.tidy_table import TidyTable
from friction_audit.pipeline import LogReplay
from friction_audit.reporting.documents import NO_OPTIONS, SETTINGS, SOURCE, WARNINGS, settings_document
from friction_audit.reporting.notices import replay_notices
from friction_audit.reporting.table import ALL, JOINT, NAME, PEOPLE, Column, Document, Record, joint_column, to_json

DIVERGED = "div."
# Share of the dissipation below which the removed share is not shown as a number.
WORST = -9.99
# Numbers of the passivity that stand in the table for files.
FILED = ("violations", "lowest", "injected", "active_fraction")


def _short(value: float) -> str:
    """Return a number in five characters or so."""
    size = abs(value)
    return f"{value:.3f}" if size < 10.0 else f"{value:.2f}" if size < 100.0 else f"{value:.0f}"  # noqa: PLR2004


def _percent(share: float) -> str:
    return f"<{100 * WORST:.0f}" if share < WORST else f"{100 * share:.1f}"


def _stable(name: str) -> Callable[[JointReplay], float | None]:
    """Return what gets a number of a loop that did not diverge."""
    return lambda joint: None if _diverged(joint) else getattr(joint.numbers, name, None)


def _diverged(joint: JointReplay) -> bool:
    return joint.numbers is not None and not math.isnan(joint.numbers.diverged_s)


def _converged(joint: JointReplay) -> str:
    cycles = None if joint.numbers is None else joint.numbers.cycles_to_converge
    return DIVERGED if _diverged(joint) else "" if cycles is None else str(cycles)


def _passive(joint: JointReplay) -> str | None:
    found = joint.passivity
    return None if found is None else f"{'yes' if found.violations == 0 else 'no'} ({found.active_cycles})"


def _passive_words(joint: JointReplay) -> str | None:
    found = joint.passivity
    if found is None:
        return None
    return f"yes, acted in {found.active_cycles} cycles" if found.violations == 0 else "no"


def _remark(joint: JointReplay) -> str:
    diverged = f"diverges at {joint.numbers.diverged_s:.3g} s" if joint.numbers and _diverged(joint) else ""
    return joint.reason or diverged


def _compensator(compensator: Compensator) -> dict[str, Any]:
    settings = {"kind": kind_of(compensator).name, **to_json(compensator)}
    return settings | ({"terms": _terms(compensator.terms)} if isinstance(compensator, JointModelCompensation) else {})


def _terms(terms: Iterable[FittedTerm]) -> dict[str, dict[str, float]]:
    """Return the terms by name, each its numbers by name, as a model file has them."""
    return {
        one.name: {parameter.name: value for parameter, value in zip(one.effect.parameters, one.values, strict=True)}
        for one in terms
    }


FITTED = Record(
    (
        Column("inertia", Coefficient, "inertia", "inertia", unit="kg m²"),
        Column("coulomb", Coefficient, "Coulomb friction", "coulomb", unit="N m"),
        Column("viscous", Coefficient, "viscous friction", "viscous", unit="N m s/rad"),
    )
)
OPERATOR = Record(
    (
        Column("inertia", Coefficient, "inertia", "inertia", unit="kg m²"),
        Column("damping", Coefficient, "damping", "damping", unit="N m s/rad"),
        Column("stiffness", Coefficient, "stiffness", "stiffness", unit="N m/rad"),
        Column("reversals", int, "reversals that they were fitted to, 0 if given"),
    )
)
MODEL = Record(
    (
        Column("inertia", float, "inertia", unit="kg m²"),
        Column("provenance", dict, "method, log, sha256 and cycles that it was made from"),
        Column("terms", dict, "terms by name, each its numbers by name", lambda model: _terms(model.terms)),
    )
)
PASSIVITY = Record(
    (
        Column(
            "violations", int,
            "samples with the energy ledger below zero by more than two samples and the payback exchange",
        ),
        Column("violations_since_activation", int, "the same of the ledger from the activation on"),
        Column("active_cycles", int, "cycles that gave out more than 5 % of what friction dissipated"),
        Column("lowest", float, "lowest value of the ledger", unit="J"),
        Column("lowest_since_activation", float, "lowest value from the activation on", unit="J"),
        Column("reserve", float, "in the ledger at the activation", unit="J"),
        Column("activation", float, "when the compensator first acted", unit="s"),
        Column("injected", float, "energy that the passivity controller dissipated", unit="J"),
        Column("active_fraction", float, "share of the time for which the passivity controller acted"),
        Column("hidden", bool, "whether the reserve hides over-compensation"),
    )
)  # fmt: skip
STEP = Record(
    (
        Column("step", float, "when friction changed", unit="s"),
        Column("change", float, "friction after over friction before"),
        Column("cycles", int, "cycles until the compensation is right again", null=True),
        Column("seconds", float, "time until then"),
    )
)
HISTORY = Record(
    (
        Column("cycle", int, "number of the compensator's cycle, from 1", lambda h: np.arange(1, len(h.status) + 1)),
        Column("start", float, "its start", unit="s"),
        Column("stop", float, "its end", unit="s"),
        Column("friction", float, "energy that friction dissipated", unit="J"),
        Column("net_energy", float, "that less the work of the compensator", unit="J"),
        Column("coulomb_applied", float, "Coulomb friction compensated", unit="N m"),
        Column("viscous_applied", float, "viscous friction compensated", unit="N m s/rad"),
        Column("coulomb_estimated", float, "estimate after the cycle", unit="N m"),
        Column("viscous_estimated", float, "estimate after the cycle", unit="N m s/rad"),
        Column("acted", bool, "whether the passivity controller acted"),
        Column("status", STATUSES, "what came of the cycle", lambda h: [STATUSES[status] for status in h.status]),
    ),
    name="replay_cycles",
    summary="a cycle of the compensator on a joint: energy, coefficients applied and estimated",
    time="stop_s",
    arrays=True,
)


def _number(name: str, meaning: str, unit: str = "", **more: Any) -> Column:  # noqa: ANN401
    """Return a column of the numbers of a replay, null where there is a reason."""
    return Column(name, float, meaning, f"numbers.{Column(name, unit=unit).key}", unit=unit, form=_short, **more)


JOINT_REPLAY = Record(
    (
        JOINT,
        NAME,
        joint_column(),
        Column("compensator", dict, "kind and settings in force", lambda one: _compensator(one.compensator), on="j"),
        Column("compensator", str, get=lambda one: kind_of(one.compensator).name, on="f"),
        Column("limits", dict, "`torque_nm` and `rate_nm_s`, null for none", on="j"),
        Column("cycles", int, "cycles", lambda one: len(one.history.status) if one.history else 0, on="j"),
        _number("energy_recorded", "net energy put in, as recorded", "J"),
        _number(
            "energy_without", "without the compensator", "J", title="energy without", short="energy\nwithout", on=ALL
        ),
        _number("energy_with", "with it", "J", title="energy with", short="energy\nwith", on=ALL),
        _number("dissipation_removed", "one less the size of `energy_with_j` over `energy_without_j`"),
        _number(
            "dissipation_removed_updated", "the same cycle by cycle, from the second update of the coefficients on"
        ),
        Column(
            "removed", float, get=_stable("dissipation_removed"), unit="%", form=_percent, title="removed", on=PEOPLE
        ),
        Column(
            "later", float, get=_stable("dissipation_removed_updated"), unit="%", form=_percent,
            title="removed, coefficients updated", short="later", on=PEOPLE,
        ),
        _number(
            "peak_torque_without", "largest interaction torque", "N m", title="peak torque without",
            short="peak\nwithout", on=ALL,
        ),
        _number(
            "peak_torque_with", "with the compensator", "N m", title="peak torque with", short="peak\nwith", on=ALL
        ),
        _number("rms_torque_without", "root mean square of the interaction torque", "N m"),
        _number("rms_torque_with", "with the compensator", "N m"),
        _number("peak_compensation", "largest torque of the compensator", "N m"),
        _number("peak_rate", "its largest rate", "N m/s"),
        _number("limited_fraction", "share of the samples at a limit"),
        Column(
            "cycles_to_converge", int, "cycles before the compensation is right", "numbers.cycles_to_converge",
            null=True,
        ),
        Column(
            "cycles_to_converge", int, get=lambda one: one, form=_converged, sort="numbers.cycles_to_converge",
            title="cycles to converge", short="conv.\ncycles", on=PEOPLE,
        ),
        _number("diverged", "when the loop diverged, or null", "s"),
        Column("joint_model", MODEL, "with a model file: the model of the joint", "model", on="j", null=True),
        Column("fitted_joint", FITTED, "joint fitted to the log, where it is simulated", "fitted", on="j", null=True),
        Column("operator", OPERATOR, "with `same-operator`: impedance of the person", on="j", null=True),
        Column("model_error", float, "velocity error of the simulated joint over the velocity", on="j"),
        Column("passivity", PASSIVITY, "passivity of the compensated joint", on="j", null=True),
        *(replace(one, get=f"passivity.{one.key}", on="f") for one in PASSIVITY.columns if one.name in FILED),
        Column("damped", float, get="passivity.injected_j", unit="J", form=_short, title="damped", on=PEOPLE),
        Column("passive", str, get=_passive, title="passive\n(acted)", on="t"),
        Column("passive", str, get=_passive_words, title="passive", on="p"),
        Column("friction_step", STEP, "a step of friction in the log, or null", "recovery", on="j", null=True),
        Column("reason", str, "why the joint cannot be replayed", null=True),
        Column("remark", str, get=_remark, title="remark", on="p"),
        Column("history", HISTORY, "per cycle of the compensator", on="j"),
    ),
    name="replay_joints",
    summary="numbers of a compensator on a joint, over the whole log",
)  # fmt: skip


def _signal(of: int, name: str) -> Callable[[tuple[Signals, Signals]], Any]:
    """Return what gets a signal without the compensator or with it, up to where the latter ended."""
    return lambda both: getattr(both[of], name)[: min(len(one.t) for one in both)]


SIGNALS = Record(
    (
        Column("time", get=_signal(0, "t"), unit="s"),
        Column("dq_without", get=_signal(0, "dq"), unit="rad/s"),
        Column("dq_with", get=_signal(1, "dq"), unit="rad/s"),
        Column("interaction_without", get=_signal(0, "interaction_nm"), unit="N m"),
        Column("interaction_with", get=_signal(1, "interaction_nm"), unit="N m"),
        *(Column(name, get=_signal(1, f"{name}_nm"), unit="N m") for name in ("compensation", "passivity", "limited")),
    ),
    name="replay_signals",
    summary="motion and torque of a joint without the compensator and with it at a sample of the log; "
    "a compensator's torque is the one in force at the sample, computed at the sample before",
    time="time_s",
    arrays=True,
)
REPLAY: Document = Document(
    "replay",
    3,
    "What a friction compensator would have done on one log",
    Record(
        (
            SOURCE,
            SETTINGS,
            WARNINGS,
            Column("assume", str, "the counterfactual"),
            Column("assumes", str, "its assumption, one sentence"),
            Column("joints", [JOINT_REPLAY], "per joint; where there is a reason the numbers are null"),
        )
    ),
)


def replay_document(found: LogReplay, reading: Mapping[str, object] = NO_OPTIONS) -> dict[str, Any]:
    """Return the document of a replay.

    Args:
        found: The result.
        reading: How the log was read: options of the reader by name.
    """
    given = found.settings.joint_model
    # Of a model file its path: each joint has its model among its numbers.
    settings = to_json(found.settings) | {"joint_model": None if given is None else given.path}
    head = {
        "source": found.estimate.log,
        "settings": settings_document(found.estimate, reading) | {"replay": settings},
        "warnings": replay_notices(found),
    }
    return REPLAY.json(head | replay_values(found), found.estimate.log.source.torque_unit)


def replay_values(found: LogReplay) -> dict[str, Any]:
    """Return what the document of a replay holds apart from log, settings and warnings."""
    counterfactual = found.replay.counterfactual
    return {"assume": counterfactual.name, "assumes": counterfactual.assumes, "joints": found.replay.joints}


TABLES = (JOINT_REPLAY, HISTORY, SIGNALS)


def replay_tables(found: LogReplay) -> tuple[TidyTable, ...]:
    """Return the tables of a replay for files: joints, cycles, signals."""
    joints, unit = found.replay.joints, found.estimate.log.source.torque_unit
    return (
        JOINT_REPLAY.file(((one.joint, one.name, [one]) for one in joints), unit),
        history_table(found),
        SIGNALS.file(
            ((one.joint, one.name, (one.without, one.replayed)) for one in joints if one.replayed is not None), unit
        ),
    )


def history_table(found: LogReplay) -> TidyTable:
    """Return the cycles of the compensator."""
    joints = found.replay.joints
    return HISTORY.file(((one.joint, one.name, one.history) for one in joints), found.estimate.log.source.torque_unit)
