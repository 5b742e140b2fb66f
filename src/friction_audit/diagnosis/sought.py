"""Numbers that are looked for at once: those of a transmission, and inertia and friction of what is behind it."""

from dataclasses import dataclass

import numpy as np

from friction_audit.diagnosis.declared import FRICTION, INERTIA
from friction_audit.diagnosis.ground import Ground
from friction_audit.dynamics.transmission import FarSide
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import Nominal
from friction_audit.joint_log import Float

OFF, FAR_OFF = 1.4, 2.5
"""Inertia and Coulomb friction, fitted beside a transmission that is a little off, are at most so many times too small
or too large; and beside one that is nothing like it."""
VISCOUS_SHARE = 0.5
"""Viscous friction is more than it seems by at most so much of Coulomb friction, at the usual speed; or it is none."""
BEHIND = (INERTIA, *FRICTION.values())


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Sought:
    """k numbers: logarithms of some of a shape, then those of the declared model that nobody stated.

    Attributes:
        shape: The shape to begin with, whole.
        of_shape: Names of its numbers that are looked for.
        of_model: Names of those of the declared model, in its order.
        baseline: The declared model to begin with.
        start: The numbers to begin with, shape (k,).
        low: The smallest that are allowed.
        high: The largest.
    """

    shape: Nonlinear
    of_shape: tuple[str, ...]
    of_model: tuple[str, ...]
    baseline: Nominal
    start: Float
    low: Float
    high: Float

    def shape_at(self, numbers: Float) -> Nonlinear:
        """The shape with some of k numbers, shape (k,)."""
        return {**self.shape, **dict(zip(self.of_shape, np.exp(self._split(numbers)[0]).tolist(), strict=True))}

    def model_at(self, numbers: Float) -> Float:
        """Those of k numbers, shape (k, ...), that are factors of the declared model."""
        return self._split(numbers)[1]

    def far_side_at(self, numbers: Float) -> FarSide:
        """What is behind the transmission, for k numbers, shape (k,)."""
        known = {name: getattr(self.baseline, name) for name in BEHIND}
        return FarSide(**known | dict(zip(self.of_model, self.model_at(numbers).tolist(), strict=True)))

    def _split(self, numbers: Float) -> tuple[Float, Float]:
        return numbers[: len(self.of_shape)], numbers[len(self.of_shape) :]


def seek(candidate: Effect, shape: Nonlinear, ground: Ground, baseline: Nominal, *, everywhere: bool = False) -> Sought:
    """Return what is looked for, from a shape and the declared model as fitted beside it.

    Args:
        candidate: An effect that transmits torque.
        shape: One of its shapes.
        ground: The joint.
        baseline: The declared model.
        everywhere: Whether it is looked for among the hidden shapes of the candidate, and not near the one given.
    """
    ranges = candidate.hidden_ranges(ground.data) if everywhere else candidate.joint_ranges(ground.data, shape)
    whole = {p.name: p.default for p in candidate.nonlinear if p.name in ranges} | ({} if everywhere else dict(shape))
    behind = _ranges(baseline, _usual_speed(ground), FAR_OFF if everywhere else OFF)
    of_model = tuple(name for name in ground.declared.names if name in BEHIND)
    start = [
        *(np.log(np.clip(whole[name], *ends)) for name, ends in ranges.items()),
        *(getattr(baseline, name) for name in of_model),
    ]
    low, high = np.array([*(np.log(ends) for ends in ranges.values()), *(behind[name] for name in of_model)]).T
    return Sought(
        shape=whole,
        of_shape=tuple(ranges),
        of_model=of_model,
        baseline=baseline,
        start=np.clip(np.array(start), low, high),
        low=low,
        high=high,
    )


def _ranges(baseline: Nominal, usual_speed_rad_s: float, off: float) -> dict[str, tuple[float, float]]:
    """From where to where each number of what is behind is looked for."""
    # A fit beside what is wrong may give numbers below zero.
    inertia, coulomb = max(baseline.inertia_kg_m2, 0.0), max(baseline.coulomb_nm, 0.0)
    more = VISCOUS_SHARE * coulomb / usual_speed_rad_s
    return {
        INERTIA: (inertia / off, inertia * off),
        FRICTION["coulomb"]: (coulomb / off, coulomb * off),
        FRICTION["viscous"]: (0.0, max(baseline.viscous_nms_per_rad, 0.0) + more),
    }


def _usual_speed(ground: Ground) -> float:
    return float(np.sqrt(np.mean(ground.data.dq[ground.data.used] ** 2)))
