"""LogReplay -> the table that people read."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from friction_audit.compensation.compensators import EnergyCompensator, JointModelCompensation, kind_of
from friction_audit.compensation.result import JointReplay
from friction_audit.effects.joint_model import Provenance
from friction_audit.friction.history import Coefficient
from friction_audit.pipeline import LogReplay
from friction_audit.reporting.terminal.estimate import NOTHING, format_coefficient, joint_label
from friction_audit.reporting.terminal.plain import plain_lines, reason_lines
from friction_audit.reporting.units import in_unit

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

TITLES = (
    "joint",
    "energy\nwithout",
    "[J]\nwith",
    "removed\n[%]",
    "later\n[%]",
    "peak\nwithout",
    "[N m]\nwith",
    "conv.\ncycles",
    "damped\n[J]",
    "passive\n(out)",
)

DIVERGED = "div."
WORST = -9.99
"""Share of the dissipation below which a removal is no number any more."""


def replay_table(found: LogReplay) -> "list[RenderableType]":
    """Return what was assumed, a row per joint, what moved in it, steps of friction, and why joints have no result."""
    from rich.text import Text

    joints = found.replay.joints
    parts: list[RenderableType] = [Text(line) for line in _head(found)]
    unit = found.estimate.log.source.torque_unit
    parts.extend(map(Text, plain_lines(_table(joints, unit))))
    lines = [*_models(found), *(line for joint in joints for line in _moved(joint))]
    lines += [line for joint in joints for line in _recovery(joint)]
    lines += [f"not replayed: {line}" for line in reason_lines(joints)]
    parts.extend(Text(line) for line in in_unit(lines, unit))
    return parts


def _head(found: LogReplay) -> tuple[str, ...]:
    log, counterfactual = found.estimate.log, found.replay.counterfactual
    samples = f"{len(log.t)} samples, {log.rate_hz:.6g} Hz, {log.duration_s:.6g} s"
    return (
        f"{log.source.path}: {log.source.format}, {samples}",
        f"interaction torque: {found.estimate.interaction.choice.formula}",
        f"compensator: {describe_compensator(shown_joint(found.replay.joints))}",
        f"{counterfactual.name}: {counterfactual.assumes}",
    )


def shown_joint(joints: tuple[JointReplay, ...]) -> JointReplay:
    """Return a joint on which what was asked for ran; any, if it ran on none."""
    return next((joint for joint in joints if not joint.reason), joints[0])


def describe_compensator(joint: JointReplay) -> str:
    """Return the compensator in words; the settings of the joints differ in limits and thresholds only."""
    compensator = joint.compensator
    kind = kind_of(compensator)
    if not isinstance(compensator, EnergyCompensator):
        return f"{kind.name}, {kind.summary}"
    controller = "with" if compensator.passivity else "without"
    if compensator.forced is not None:
        given = compensator.forced
        law = f"fixed at {given.coulomb_nm:g} N m and {given.viscous_nms_per_rad:g} N m s/rad"
    else:
        cycles = compensator.cycles_per_estimate
        times = "" if compensator.factor == 1 else f", times {compensator.factor:g}"
        law = f"{compensator.model} model from the last {f'{cycles} cycles' if cycles > 1 else 'cycle'}{times}"
    return f"{kind.name}, {law}, {controller} passivity controller"


def _table(joints: tuple[JointReplay, ...], unit: str) -> "Table":
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False, collapse_padding=True)
    for title in in_unit(TITLES, unit):
        table.add_column(Text(title), justify="left" if title == TITLES[0] else "right", no_wrap=True)
    for joint in joints:
        table.add_row(*_row(joint))
    return table


def _row(joint: JointReplay) -> tuple[str, ...]:
    label = joint_label(joint.joint, joint.name)
    numbers, passivity = joint.numbers, joint.passivity
    if numbers is None or passivity is None:
        return label, *(NOTHING for _ in TITLES[1:])
    diverged = not math.isnan(numbers.diverged_s)
    converged = numbers.cycles_to_converge
    return (
        label,
        _number(numbers.energy_without_j),
        _number(numbers.energy_with_j),
        NOTHING if diverged else _percent(numbers.dissipation_removed),
        NOTHING if diverged else _percent(numbers.dissipation_removed_updated),
        _number(numbers.peak_torque_without_nm),
        _number(numbers.peak_torque_with_nm),
        DIVERGED if diverged else NOTHING if converged is None else str(converged),
        _number(passivity.injected_j),
        f"{'yes' if passivity.violations == 0 else 'no'} ({passivity.active_cycles})",
    )


def _number(value: float) -> str:
    """Return a number in five characters or so."""
    size = abs(value)
    return f"{value:.3f}" if size < 10.0 else f"{value:.2f}" if size < 100.0 else f"{value:.0f}"  # noqa: PLR2004


def _percent(share: float) -> str:
    if share < WORST:
        return f"<{100 * WORST:.0f}"
    return NOTHING if math.isnan(share) else f"{100 * share:.1f}"


def _models(found: LogReplay) -> Iterator[str]:
    """Yield the model of each joint that was replayed with one, and what of it was applied."""
    given = found.settings.joint_model
    if given is None:
        return
    for joint in found.replay.joints:
        if joint.model is not None and not joint.reason:
            names = ", ".join(term.name for term in joint.model.terms) or "no terms"
            told = f"inertia {joint.model.inertia_kg_m2:.4g} kg m², {names}"
            yield f"joint {joint.joint} by {given.path} ({_origin(joint.model.provenance)}): {told}{_applied(joint)}"


def _applied(joint: JointReplay) -> str:
    if not isinstance(joint.compensator, JointModelCompensation):
        return ""
    return f"; applied: {', '.join(term.name for term in joint.compensator.terms)}"


def _origin(origin: Provenance) -> str:
    """Return where a model comes from, as far as its file tells."""
    cycles = f"{origin.cycles} cycles" if origin.cycles else ""
    return ", ".join(part for part in (origin.method, origin.log, cycles) if part) or "its origin is not said"


def _moved(joint: JointReplay) -> Iterator[str]:
    """Yield the joint and the person that moved otherwise than recorded, with their 95 % intervals."""
    fitted, operator = joint.fitted, joint.operator
    if fitted is not None:
        found = (fitted.inertia, fitted.coulomb, fitted.viscous)
        yield f"joint {joint.joint} as fitted, 95 %: {_quantities(FITTED, found)}"
    if operator is not None:
        found = (operator.inertia, operator.damping, operator.stiffness)
        origin = f"as fitted to {operator.reversals} reversals, 95 %" if operator.reversals else "as given"
        yield f"person at joint {joint.joint} {origin}: {_quantities(OPERATOR, found)}"


FITTED = (("inertia", "kg m²"), ("Coulomb", "N m"), ("viscous", "N m s/rad"))
OPERATOR = (("inertia", "kg m²"), ("damping", "N m s/rad"), ("stiffness", "N m/rad"))
"""What the numbers are called, and their units."""


def _quantities(names: tuple[tuple[str, str], ...], found: tuple[Coefficient, ...]) -> str:
    pairs = zip(names, found, strict=True)
    return ", ".join(f"{name} {format_coefficient(value)} {unit}" for (name, unit), value in pairs)


def _recovery(joint: JointReplay) -> list[str]:
    recovery = joint.recovery
    if recovery is None:
        return []
    change = f"joint {joint.joint}: friction steps to {recovery.change:.2f} times at {recovery.step_s:.4g} s"
    if recovery.cycles is None:
        return [f"{change}; the compensation is not right again in this log"]
    return [f"{change}; compensation right again after {recovery.cycles} cycles, {recovery.seconds:.3g} s"]
