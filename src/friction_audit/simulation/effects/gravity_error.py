"""Gravity error: the gravity torque that is subtracted is not the one that the motor holds."""

import math
from dataclasses import dataclass
from math import inf

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import (
    Given,
    HiddenEffect,
    Setting,
    Values,
    must,
    number,
    strength,
    within_half_turn,
)


@dataclass(frozen=True, kw_only=True, slots=True)
class GravityError(HiddenEffect):
    """A wrong mass, a wrong centre of mass, an unknown payload or a tilted base.

    All of them are the same for one joint: an amplitude and a phase.
    """

    summary = "the gravity torque that is subtracted is wrong"
    felt_at_rest = True

    torque_nm: float = strength(0.3, "amplitude", "N m", lower=-inf)
    phase_rad: float = number(0.0, "phase at q = 0", "rad", lower=-inf)

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        cosine, sine = values["gravity_cos_nm"], values["gravity_sin_nm"]
        must(round(values["gravity_error_source"]) == 0, "it errs in the joint's own angle")
        size = math.hypot(cosine, sine)
        return {"torque_nm": -size if setting.driven else size, "phase_rad": within_half_turn(math.atan2(cosine, sine))}


def reading_nm(group: GravityError, q: Float) -> Float:
    """Return by how much the gravity torque that is subtracted is too large, shape (n,). [N m]

    The interaction torque comes out too large by it where a hand moves the joint, too small where the robot does.
    """
    return np.asarray(group.torque_nm * np.sin(q + group.phase_rad))
