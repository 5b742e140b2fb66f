"""Effects by hand: a bump over position of unknown place and width, a slow wave in time, one that is not needed."""

from collections.abc import Callable, Sequence
from copy import copy
from typing import Any

import numpy as np

from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import quoted

COLUMNS: dict[str, Callable[[JointData, Nonlinear], Float]] = {
    "bump": lambda data, at: np.exp(-(((data.q - at["place_rad"]) / at["width_rad"]) ** 2))[:, None],
    "wave": lambda data, at: np.column_stack([np.sin(at["rate"] * data.t), np.cos(at["rate"] * data.t)]),
    "line": lambda data, _: data.q[:, None],
    "cube": lambda data, _: (data.q**3)[:, None],
    "square": lambda data, _: (data.dq * np.abs(data.dq))[:, None],
}


def altered(effect: Effect, *, units: Sequence[str] = (), **changes: object) -> Effect:
    """Return an effect with other attributes or methods; ``grid`` is given as its points, ``regressor`` of one."""
    other = copy(effect)
    if "grid" in changes:
        points = changes["grid"]
        changes["grid"] = lambda _data: points
    if "regressor" in changes:  # of one point
        one: Any = changes["regressor"]
        changes["regressors"] = lambda data, nominal, grid: ((k, one(data, nominal, at)) for k, at in enumerate(grid))
    if units:
        changes["coefficients"] = tuple(Parameter(f"factor_{k}_{unit}", unit, "") for k, unit in enumerate(units, 1))
    for name, value in changes.items():
        object.__setattr__(other, name, value)
    return other


def toy(name: str, label: str, axis: str, units: Sequence[str], *grid: Nonlinear) -> Effect:
    about = {"name": name, "label": label, "axis": axis, "units": units}
    return altered(Effect(), **about, grid=grid or ({},), regressor=lambda data, _nominal, at: COLUMNS[name](data, at))


PLACES = ({"place_rad": place, "width_rad": 0.2} for place in (-0.6, -0.3, 0.0, 0.3, 0.6))
BUMP = altered(toy("bump", "a bump", "position", ["nm"], *PLACES), possible=lambda factors, _at: factors[0] > 0)
WAVE = toy("wave", "a wave", "time", ["nm", "nm"], {"rate": 0.1}, {"rate": 0.5})
SQUARE = toy("square", "friction that grows with the square of the speed", "speed", ["nms2_per_rad2"])
LINE, CUBE = (toy(name, "a torque of the position", "position", ["nm"]) for name in ("line", "cube"))
LOCKED_OUT = altered(SQUARE, name="locked_out", not_identifiable=lambda _data, _nominal: quoted("move the moon")[0])
TOYS = (BUMP, WAVE, SQUARE, LOCKED_OUT)


# Torques that the nominal model lacks, shape (n,).


def rising(data: JointData) -> Float:
    return np.asarray(0.1 * data.direction * np.exp(-((data.dq / 0.1) ** 2)))


def bump(data: JointData) -> Float:
    return np.asarray(0.1 * np.exp(-(((data.q - 0.2) / 0.2) ** 2)))
