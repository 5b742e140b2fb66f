"""The quantity over which the torque of an effect is a curve: an axis of the motion, or one of the effect's own."""

from dataclasses import replace

import numpy as np

from friction_audit.diagnosis.profiles import BINS, bin_means
from friction_audit.diagnosis.result import JointDiagnosis, NamedEffect, OwnAxis, Profile, Traces
from friction_audit.joint_log import Float

STRETCHES = 24
"""Of the axis, with equally many rows each."""
MOST_HIDDEN = 0.5
"""Share of the torque's mean square that may lie beside the curve."""


def shows_along(torque: Float, along: Float, dq: Float) -> bool:
    """Return whether most of a torque is a curve over a quantity, one for each direction of motion.

    A torque that rings, comes late or follows other joints has both signs at each place of any axis of this joint's
    motion: its mean there is next to nothing, and where that mean is largest is chance.

    Args:
        torque: Of an effect at the rows, free of noise, shape (m,). [N m]
        along: The quantity, shape (m,).
        dq: Velocity, shape (m,). [rad/s]
    """
    beside = sum(_beside(torque[which], along[which]) for which in (dq > 0, dq <= 0))
    return beside <= MOST_HIDDEN * float(torque @ torque)


def _beside(torque: Float, along: Float) -> float:
    """Return the sum of squares beside the means of the stretches. [N^2 m^2]"""
    parts = np.array_split(torque[np.argsort(along, kind="stable")], STRETCHES)
    return float(sum(len(part) * part.var() for part in parts if len(part)))


ORDER = "ripple_order"  # parameter of an effect that repeats with the position: its waves per revolution
SOURCE = "gravity_error_source"  # 0 where the error follows the joint's own angle
OF_SEVERAL_JOINTS = ("inertial_coupling", "torque_crosstalk")


def with_own_axes(joint: JointDiagnosis) -> JointDiagnosis:
    """Return the joint, its effects with the axis of their own where no axis of the motion shows them."""
    if joint.traces is None:
        return joint
    effects = joint.added
    found = {effect.name: own_axis(effect, joint.traces) for effect in effects}
    return replace(joint, effects=tuple(replace(effect, own=found.get(effect.name)) for effect in joint.effects))


def own_axis(effect: NamedEffect, traces: Traces) -> OwnAxis | None:
    """Return what an effect is drawn along; None where the axis of its curve shows it.

    A ripple is drawn over one wave, for bins in place would average it away. What follows several joints, or is no
    curve over its axis, as the ringing of a spring, is drawn over the torque that was fitted: on the diagonal the log
    holds all of the effect.
    """
    if ORDER in effect.parameters:
        waves = effect.parameters[ORDER].value * traces.q / (2 * np.pi)
        label, values = "Position within a wave [waves]", np.mod(waves, 1.0)
    else:
        source = effect.parameters.get(SOURCE)
        alone = effect.name not in OF_SEVERAL_JOINTS and (source is None or source.value == 0.0)
        if alone and shows_along(effect.torque, traces.along[effect.curve.axis], traces.dq):
            return None
        label, values = f"Fitted torque of {effect.name} [N m]", effect.torque
    before, after = traces.measured - traces.before, traces.measured - traces.after
    profiles = (_profile(label, values, traces, torque) for torque in (after + effect.torque, before, after))
    curve, without, left = profiles
    return OwnAxis(label=label, values=values, curve=curve, before=without, after=left)


def _profile(label: str, values: Float, traces: Traces, torque: Float) -> Profile:
    """Means of a torque of shape (m,) over an axis in bins of equal width."""
    edges = np.linspace(values.min(), values.max(), BINS + 1)
    bins = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, BINS - 1)
    forwards, forwards_se = bin_means(torque, bins, traces.cycle, traces.dq > 0, BINS)
    backwards, backwards_se = bin_means(torque, bins, traces.cycle, traces.dq <= 0, BINS)
    return Profile(
        axis=label,
        label=label,
        edges=edges,
        centre=0.5 * (edges[:-1] + edges[1:]),
        forwards=forwards,
        backwards=backwards,
        forwards_se=forwards_se,
        backwards_se=backwards_se,
        share=float("nan"),
        p_value=float("nan"),
        where="",
    )
