"""What a spring and a gap between motor and link have in common: the far side, and the motion that they see."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.dynamics.transmission import FarSide
from friction_audit.effects.effect import BatchedEffect, Nonlinear
from friction_audit.effects.excitation import reversals
from friction_audit.effects.joint_data import JointData, Nominal, mean_sign
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float
from friction_audit.preprocessing.even_grid import filtered, windowed_sinc

# What rings faster amplifies the noise of the position ten times and more, and what people and motors mean to do is
# below 4 Hz; unless the measured side rings with the far one, its motion is better taken as smooth.
MOTION_BELOW_HZ = 18.0
FILTER_S = 0.2  # reach of the low-pass to either side

FAR_SHARE = Parameter(
    name="far_share",
    unit="1",
    meaning="part of the inertia on the link side, the rest on the measured side",
    lower=0.0,
    upper=1.0,
    optional=True,
    default=1.0,
)


class Link(BatchedEffect):
    """A spring or a gap: those of many parameters are followed side by side."""

    transmits = True
    follows = True

    def regressor(self, data: JointData, nominal: Nominal, at: Nonlinear) -> Float:
        """Return what the link adds to the torque, along the motion as measured or below a frequency."""
        ((_, column),) = self.regressors(data, nominal, (at,))
        return column

    def regressors(self, data: JointData, nominal: Nominal, grid: Sequence[Nonlinear]) -> Iterator[tuple[int, Float]]:
        """Yield the same for many points."""
        yield from self.regressors_of(data, [nominal] * len(grid), grid)

    def not_identifiable(self, data: JointData, nominal: Nominal) -> str | None:
        """Return the motion that is lacking: jumps of friction show a link, and an inertia that rings."""
        inertia = "the torque shows no inertia: reverse faster, so that the motor's inertia is felt"
        return reversals(data, nominal) or (None if nominal.inertia_kg_m2 > 0.0 else inertia)


def far_side_of(nominal: Nominal) -> FarSide:
    """Return inertia and friction of the nominal model; negative friction counts as none."""
    return FarSide(
        inertia_kg_m2=max(nominal.inertia_kg_m2, 0.0),
        coulomb_nm=max(nominal.coulomb_nm, 0.0),
        viscous_nms_per_rad=max(nominal.viscous_nms_per_rad, 0.0),
    )


def motion_below(data: JointData, below_hz: float) -> Motion:
    """Return the motion below a frequency, without a torque."""
    if below_hz not in data.smooth:
        q, dq, ddq = (_low_passed(signal, below_hz, data.step_s) for signal in (data.q, data.dq, data.ddq))
        data.smooth[below_hz] = replace(data.motion(), q=q, dq=dq, ddq=ddq, way=mean_sign(data.t, dq, ddq))
    return data.smooth[below_hz]


def _low_passed(signal: Float, below_hz: float, step_s: float) -> Float:
    """A signal filtered symmetrically, its ends held; half of the amplitude passes at the frequency."""
    if below_hz >= 0.5 / step_s:  # the log holds nothing above its Nyquist frequency
        return signal
    kernel = windowed_sinc(np.hamming(2 * round(FILTER_S / step_s) + 1), below_hz, 1.0 / step_s)
    # From its first value, so that rest is rest to the last digit.
    return np.asarray(signal[0] + filtered((signal - signal[0])[None], kernel, np.arange(len(signal)))[0])


def motions(data: JointData, grid: Sequence[Mapping[str, float]]) -> Iterator[tuple[Motion, list[int]]]:
    """Yield each motion, without a torque, and the places in the grid that go along it.

    Args:
        data: The joint.
        grid: Points with ``motion_below_hz`` go along the motion below that frequency, all others as measured.
    """
    places: dict[float | None, list[int]] = {}
    for place, at in enumerate(grid):
        places.setdefault(at.get("motion_below_hz"), []).append(place)
    for below_hz, alike in places.items():
        yield data.motion() if below_hz is None else motion_below(data, below_hz), alike
