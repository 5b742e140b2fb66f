"""Friction of the joints of a source -> a file of a simulator or a controller."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from friction_audit.export.friction_law import FrictionLaw, even_speeds
from friction_audit.export.mujoco_check import SimulatedGap, hinge, simulated_gaps
from friction_audit.export.source import Joints, laws_of, speeds_of
from friction_audit.export.target import ExportedJoint, Target, match_names
from friction_audit.export.xml_text import XmlText
from friction_audit.io.files import whole_file
from friction_audit.joint_log import Float
from friction_audit.pipeline import Estimate
from friction_audit.preprocessing.torque_source import known_arm

CUBIC = 3  # highest power of the damping that MuJoCo simulates


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Export:
    """What was written."""

    target: Target  # format
    path: str  # where it was written
    into: str  # the user's file that it is a changed copy of, or empty
    joints: tuple[ExportedJoint, ...]  # the joints as written
    lacking: tuple[tuple[int, str], ...]  # number of a joint without friction to export, and why
    by_order: bool  # whether the order of the joints matched them to those of the user's file
    armature_unknown: bool  # whether the inertia was left out because nothing shows whose it is
    simulated: tuple[SimulatedGap, ...]  # forward simulations of the log's joints
    estimate: Estimate | None  # the estimate of the log that the numbers come from, or None


@dataclass(frozen=True, kw_only=True, slots=True)
class ExportSettings:
    """How friction is written."""

    joints: tuple[int, ...] | None = None  # numbers (1..n) of the joints, None for all
    speeds: tuple[float, float] | None = None  # lowest and highest speed of a fit, None for those of the log [rad/s]
    # whether the inertia is written as armature; None where it is without that of the links
    armature: bool | None = None
    overwrite: bool = False  # whether a file that exists is replaced


def export_friction(
    joints: Joints,
    target: Target,
    out: Path,
    settings: ExportSettings,
    *,
    into: XmlText | None = None,
    estimate: Estimate | None = None,
) -> Export:
    """Write the friction of joints in a file, whole or not at all.

    Args:
        joints: Models of the joints.
        target: Format.
        out: File to write.
        settings: How.
        into: The user's file of the robot: the output is a copy of it with the friction in its joints.
        estimate: The estimate of the log that the models come from, or None: it gives the speeds over which a curve is
            fitted, and the motion that is simulated.

    Raises:
        UsageError: If a joint is not in the source or in the user's file, or the output cannot be written.
        AnalysisError: If no joint has friction to export.
    """
    numbers = [number for number, *_ in joints.models]
    speeds = speeds_of(estimate) if estimate else {}
    if settings.speeds is not None:
        speeds = dict.fromkeys(numbers, even_speeds(*settings.speeds))
    armature = target.armature and bool(joints.reflected if settings.armature is None else settings.armature)
    count = len(joints.models) + len(joints.lacking)
    laws, lacking = laws_of(joints, speeds, wanted=settings.joints, armature=armature)
    written, by_order = _joints_of(laws, count, target, into)
    text = target.write(written, into)
    with whole_file(out, overwrite=settings.overwrite) as draft:
        draft.write_bytes(text)
    return Export(
        target=target,
        path=str(out),
        into="" if into is None else into.where,
        joints=written,
        lacking=lacking,
        by_order=by_order,
        armature_unknown=settings.armature is None and joints.reflected is None and target.armature,
        simulated=_simulated(laws, joints, estimate),
        estimate=estimate,
    )


def _joints_of(
    laws: Sequence[FrictionLaw], count: int, target: Target, into: XmlText | None
) -> tuple[tuple[ExportedJoint, ...], bool]:
    """Fit each law to what the target holds, and find its joint in the user's file, by name or else by order."""
    names, by_order = [law.name for law in laws], False
    if into is not None and target.joints_of is not None:
        found = [tag.attributes.get("name", "") for tag in target.joints_of(into)]
        names, by_order = match_names(laws, count, found, into.where)
    power = 1 if target.highest_power is None else target.highest_power
    pairs = zip(names, laws, strict=True)
    return tuple(ExportedJoint(name=name, law=law, fitted=law.fit(power)) for name, law in pairs), by_order


def _simulated(laws: Sequence[FrictionLaw], joints: Joints, estimate: Estimate | None) -> tuple[SimulatedGap, ...]:
    """Simulate a log in MuJoCo: the whole arm where a model of it made the torque, else each joint alone."""
    if estimate is None:
        return ()
    choice, log, seen = estimate.interaction.choice, estimate.log, estimate.interaction
    friction = {law.joint: law.fit(CUBIC) for law in laws}
    gaps = []
    if choice.inertia == "model":  # what is left of the inertia moves no joint: it takes the whole arm
        arm = known_arm(log, estimate.settings.torque, choice)
        if arm is not None and choice.drive == "robot" and choice.source == "tau_J" and log.tau_J is not None:
            q, dq, torque = (arm.to_model(signal) for signal in (log.q, log.dq, log.tau_J))
            order = [column + 1 for column in arm.columns]
            found = simulated_gaps(arm.model, log.t, q, dq, torque, [friction.get(number) for number in order])
            gaps = [_gap(order.index(number), number, found) for number in sorted(friction)]
    else:
        inertias = {number: model.inertia_kg_m2 for number, _, model in joints.models}
        for number, fitted in ((law, one) for law, one in friction.items() if inertias[law] > 0.0):
            k = [seen.joint_numbers.index(number)]
            q, dq, torque = (signal[:, k] for signal in (seen.q, seen.dq, seen.torque))
            gaps.append(_gap(0, number, simulated_gaps(hinge(inertias[number]), seen.t, q, dq, torque, [fitted])))
    return tuple(gap for gap in gaps if gap.windows)


def _gap(column: int, number: int, found: tuple[Float, Float, int]) -> SimulatedGap:
    without, with_friction, windows = found
    return SimulatedGap(
        joint=number, without_rad=float(without[column]), with_rad=float(with_friction[column]), windows=windows
    )
