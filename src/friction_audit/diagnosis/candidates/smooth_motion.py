"""Motion of a joint without what is hardly more than noise: what rings on it would ring with the noise too."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from friction_audit.diagnosis.candidate import Shape
from friction_audit.diagnosis.joint_data import JointData
from friction_audit.diagnosis.mean_sign import mean_sign
from friction_audit.effects.term import Motion
from friction_audit.joint_log import Float

MOTION_BELOW_HZ = 18.0
"""What rings faster amplifies the noise of the position, ten times and more, and what people and motors mean to do is
below 4 Hz; unless the measured side rings with the far one, it is better taken as smooth."""
FILTER_S = 0.2
"""Reach of the low-pass to either side."""


def motion_below(data: JointData, below_hz: float) -> Motion:
    """Return the motion below a frequency, without a torque."""
    if below_hz not in data.smooth:
        q, dq, ddq = (_low_passed(signal, below_hz, data.step_s) for signal in (data.q, data.dq, data.ddq))
        data.smooth[below_hz] = replace(data.motion(), q=q, dq=dq, ddq=ddq, way=mean_sign(data.t, dq, ddq))
    return data.smooth[below_hz]


def _low_passed(signal: Float, below_hz: float, step_s: float) -> Float:
    """A signal filtered symmetrically, its ends held; half of the amplitude passes at the frequency."""
    from scipy.signal import firwin, oaconvolve

    if below_hz >= 0.5 / step_s:  # the log holds nothing above its Nyquist frequency
        return signal
    half = round(FILTER_S / step_s)
    kernel = firwin(2 * half + 1, below_hz, fs=1.0 / step_s)
    # From its first value, so that rest is rest to the last digit.
    return np.asarray(signal[0] + oaconvolve(np.pad(signal - signal[0], half, mode="edge"), kernel, "valid"))


def motions(data: JointData, shapes: Sequence[Shape]) -> Iterator[tuple[Motion, list[int]]]:
    """Yield each motion, without a torque, and the places of the shapes along it.

    Args:
        data: The joint.
        shapes: Those with ``motion_below_hz`` go along the motion below that frequency, all others as measured.
    """
    places: dict[float | None, list[int]] = {}
    for place, shape in enumerate(shapes):
        places.setdefault(shape.get("motion_below_hz"), []).append(place)
    for below_hz, alike in places.items():
        yield data.motion() if below_hz is None else motion_below(data, below_hz), alike
