"""Replay: its text on the terminal."""

from collections.abc import Iterator

from friction_audit.compensation.compensators import EnergyCompensator, JointModelCompensation, kind_of
from friction_audit.compensation.result import JointReplay
from friction_audit.friction.history import Coefficient
from friction_audit.pipeline import LogReplay
from friction_audit.reporting.notices import physics_of, reason_lines, replay_notices
from friction_audit.reporting.replay import FITTED, JOINT_REPLAY, OPERATOR
from friction_audit.reporting.table import Record
from friction_audit.reporting.terminal_table import log_line, table_lines
from friction_audit.reporting.words import in_unit, with_unit


def replay_lines(found: LogReplay) -> list[str]:
    """Return what was assumed, a row per joint, what moved in it, steps of friction, and why joints have no result."""
    marked, physics = physics_of(replay_notices(found), found.replay.joints)
    joints, counterfactual, unit = (
        found.replay.joints,
        found.replay.counterfactual,
        found.estimate.log.source.torque_unit,
    )
    who = "person" if found.estimate.interaction.choice.drive == "hand" else "drive"
    sentences = [*_models(found), *(line for joint in joints for line in _moved(joint, who))]
    sentences += [_recovery(joint) for joint in joints if joint.recovery is not None]
    sentences += [f"not replayed: {line}" for line in reason_lines(joints)]
    return [
        log_line(found.estimate.log),
        f"interaction torque: {found.estimate.interaction.choice.formula}",
        f"compensator: {describe_compensator(joints)}",
        f"{counterfactual.name}: {counterfactual.assumes}",
        *table_lines(JOINT_REPLAY.people(joints, "t", unit=unit), marked),
        *physics,
        *(in_unit(line, unit) for line in sentences),
    ]


def describe_compensator(joints: tuple[JointReplay, ...]) -> str:
    """Return the compensator in words, of a joint on which it ran: the others differ in limits and thresholds only."""
    compensator = next((joint for joint in joints if not joint.reason), joints[0]).compensator
    kind = kind_of(compensator)
    if not isinstance(compensator, EnergyCompensator):
        return f"{kind.name}, {kind.summary}"
    if compensator.forced is not None:
        given = compensator.forced
        law = f"fixed at {given.coulomb_nm:g} N m and {given.viscous_nms_per_rad:g} N m s/rad"
    else:
        cycles = compensator.cycles_per_estimate
        times = "" if compensator.factor == 1 else f", times {compensator.factor:g}"
        law = f"{compensator.model} model from the last {f'{cycles} cycles' if cycles > 1 else 'cycle'}{times}"
    return f"{kind.name}, {law}, {'with' if compensator.passivity else 'without'} passivity controller"


def _models(found: LogReplay) -> Iterator[str]:
    """Yield the model of each joint that was replayed with one, and what of it was applied."""
    given = found.settings.joint_model
    for joint in found.replay.joints if given is not None else ():
        if joint.model is None or joint.reason or given is None:
            continue
        names = ", ".join(term.name for term in joint.model.terms) or "no terms"
        compensator, origin = joint.compensator, joint.model.provenance
        applied = ""
        if isinstance(compensator, JointModelCompensation):
            applied = f"; applied: {', '.join(term.name for term in compensator.terms)}"
        cycles = f"{origin.cycles} cycles" if origin.cycles else ""
        known = ", ".join(part for part in (origin.method, origin.log, cycles) if part) or "origin unknown"
        model = f"inertia {joint.model.inertia_kg_m2:.4g} kg m², {names}"
        yield f"joint {joint.joint} by {given.path} ({known}): {model}{applied}"


def _moved(joint: JointReplay, who: str) -> Iterator[str]:
    """Yield the joint, and who moved it, that moved otherwise than recorded, with their 95 % intervals."""
    fitted, operator = joint.fitted, joint.operator
    if fitted is not None:
        yield f"joint {joint.joint} as fitted, 95 %: {_quantities(FITTED, fitted)}"
    if operator is not None:
        origin = f"as fitted to {operator.reversals} reversals, 95 %" if operator.reversals else "as given"
        yield f"{who} at joint {joint.joint} {origin}: {_quantities(OPERATOR, operator)}"


def _quantities(record: Record, found: object) -> str:
    columns = [column for column in record.columns if column.kind is Coefficient]
    names = {"coulomb": "Coulomb"}
    return ", ".join(f"{names.get(c.name, c.name)} {with_unit(c.value(found), c.unit)}" for c in columns)


def _recovery(joint: JointReplay) -> str:
    recovery = joint.recovery
    assert recovery is not None
    change = f"joint {joint.joint}: friction steps to {recovery.change:.2f} times at {recovery.step_s:.4g} s"
    if recovery.cycles is None:
        return f"{change}; the compensation is not right again in this log"
    return f"{change}; compensation right again after {recovery.cycles} cycles, {recovery.seconds:.3g} s"
