"""Torque bias: the torque sensor does not read zero without a load."""

from dataclasses import dataclass

import numpy as np

from friction_audit.joint_log import Float
from friction_audit.simulation.effects.effect import Given, HiddenEffect, Setting, Values, strength


@dataclass(frozen=True, kw_only=True, slots=True)
class TorqueBias(HiddenEffect):
    """A constant error of the torque sensor."""

    summary = "the torque sensor does not read zero without a load"
    felt_at_rest = True
    same_law = ""
    stands_for = ("offset",)

    torque_nm: float = strength(0.15, "reading without a load", like="torque_bias_nm")

    @classmethod
    def from_parameters(cls, values: Values, setting: Setting) -> Given:
        return {"torque_nm": next(iter(values.values()))}


def reading_nm(group: TorqueBias, t: Float) -> Float:
    """Return what is added to the interaction torque as read, shape (n,). [N m]"""
    return np.full(len(t), group.torque_nm)
