"""Motion of a joint without what is hardly more than noise: what rings on it would ring with the noise too."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from friction_audit.discrepancy.candidate import Baseline, Shape, values_of
from friction_audit.discrepancy.joint_data import JointData
from friction_audit.discrepancy.mean_sign import mean_sign
from friction_audit.joint_log import Float
from friction_audit.model.term import Motion, Term

MOTION_BELOW_HZ = 18.0
"""What rings faster amplifies the noise of the position, ten times and more, and what people and motors mean to do is
below 4 Hz; unless the measured side rings with the far one, it is better taken as smooth."""
FILTER_S = 0.2
"""Reach of the low-pass to either side."""


def smooth_motion(data: JointData, baseline: Baseline, below_hz: float | None) -> Motion:
    """Return the motion below a frequency, with the declared model's torque along it; as measured where it is None."""
    if below_hz is None:
        return data.motion(baseline.torque)
    motion = motion_below(data, below_hz)
    rest = baseline.inertia_kg_m2 * motion.ddq + baseline.coulomb_nm * motion.direction
    return replace(motion, rest=rest + baseline.viscous_nms_per_rad * motion.dq)


def motion_below(data: JointData, below_hz: float) -> Motion:
    """Return the motion below a frequency, without a torque."""
    if below_hz not in data.smooth:
        q, dq, ddq = (_low_passed(signal, below_hz, data.step_s) for signal in (data.q, data.dq, data.ddq))
        data.smooth[below_hz] = replace(data.motion(), q=q, dq=dq, ddq=ddq, way=mean_sign(data.t, dq, ddq))
    return data.smooth[below_hz]


def _low_passed(signal: Float, below_hz: float, step_s: float) -> Float:
    """A signal filtered symmetrically, its ends held; half of the amplitude passes at the frequency."""
    from scipy.signal import firwin, oaconvolve

    half = round(FILTER_S / step_s)
    kernel = firwin(2 * half + 1, below_hz, fs=1.0 / step_s)
    return np.asarray(oaconvolve(np.pad(signal, half, mode="edge"), kernel, "valid"))


def along_motions(
    data: JointData,
    baseline: Baseline,
    shapes: Sequence[Shape],
    term: Term,
) -> Iterator[tuple[int, Float]]:
    """Columns of many shapes, all of them along one motion at a time: as measured, or below the frequency they name.

    Args:
        data: The joint.
        baseline: The declared model as fitted.
        shapes: Those with ``motion_below_hz`` go along a smooth motion.
        term: What builds them.
    """
    for below_hz, alike in by_motion(shapes).items():
        values = [values_of(term, shapes[place]) for place in alike]
        for k, column in term.regressors(smooth_motion(data, baseline, below_hz), values):
            yield alike[k], column


def by_motion(shapes: Sequence[Shape]) -> dict[float | None, list[int]]:
    """Places of shapes by the frequency below which their motion lies; None for the motion as measured. [Hz]"""
    places: dict[float | None, list[int]] = {}
    for place, shape in enumerate(shapes):
        places.setdefault(shape.get("motion_below_hz"), []).append(place)
    return places
