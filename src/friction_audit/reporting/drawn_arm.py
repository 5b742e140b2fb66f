"""As much of an arm as a figure shows: what is drawn elsewhere is small enough to be sent there."""

import math
from collections.abc import Collection, Mapping
from dataclasses import replace

from friction_audit.drift.report import ArmDrift, CoefficientDrift, JointDrift
from friction_audit.drift.session import Session

Kept = Mapping[int, Collection[int]]
"""Sessions whose summary of a joint a figure shows, by the joint."""


def as_drawn(arm: ArmDrift, kind: str) -> ArmDrift:
    """Return an arm without what a kind of figure does not show.

    Of every joint the first estimate and the first curve stay: they tell that there is something to draw.

    Args:
        arm: The arm, with the joints to be drawn.
        kind: Name of the kind of figure.
    """
    kept = {joint.joint: _first_curve(arm, joint.joint) | _shown(arm, joint, kind) for joint in arm.joints}
    return replace(
        arm,
        sessions=tuple(_bare(session, index, kept) for index, session in enumerate(arm.sessions)),
        joints=tuple(
            replace(joint, coefficients=tuple(_shortened(found, kind) for found in joint.coefficients))
            for joint in arm.joints
        ),
    )


def curve_sessions(arm: ArmDrift) -> tuple[int, tuple[int, ...], int] | None:
    """Return the sessions whose curves are drawn: the first, those of the reference, the last; None without any."""
    compared = arm.compared or tuple(range(len(arm.sessions)))
    return (compared[0], arm.reference, compared[-1]) if compared else None


def _shown(arm: ArmDrift, joint: JointDrift, kind: str) -> set[int]:
    """Return the sessions whose own summary of a joint is drawn."""
    if kind == "curves":
        drawn = curve_sessions(arm)
        return set() if drawn is None else {drawn[0], *drawn[1], drawn[2]}
    if kind == "drift":  # those that were not compared are drawn as they are
        return {k for found in joint.coefficients for k in set(range(len(arm.sessions))).difference(found.sessions)}
    return set()


def _first_curve(arm: ArmDrift, joint: int) -> set[int]:
    moved = (
        index
        for index, session in enumerate(arm.sessions)
        for one in session.joints
        if one.joint == joint and one.curve.speed_rad_s
    )
    return {index for index in (next(moved, None),) if index is not None}


def _bare(session: Session, index: int, kept: Kept) -> Session:
    joints = tuple(joint for joint in session.joints if index in kept.get(joint.joint, ()))
    return replace(session, joints=joints, warnings=())


def _shortened(found: CoefficientDrift, kind: str) -> CoefficientDrift:
    """Return what became of a coefficient without the series that are not drawn."""
    control = found.control if kind == "control" else ()
    if kind == "drift":
        return replace(found, control=control)
    first = next((k for k, value in enumerate(found.values) if math.isfinite(value.value)), 0)
    part = slice(first, first + 1)
    return replace(found, values=found.values[part], control=control)
