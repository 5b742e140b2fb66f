"""What is left that follows no quantity of the motion and is no noise of a sensor: it shakes, comes round, scatters."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from friction_audit.diagnosis.floor import beside_wanted_curves
from friction_audit.diagnosis.ground import Ground
from friction_audit.diagnosis.line import Line, find_line
from friction_audit.diagnosis.result import Vibration
from friction_audit.diagnosis.ringing import LEAST_VIBRATION
from friction_audit.diagnosis.rows import filter_rows
from friction_audit.diagnosis.spectrum import HIGHEST_HZ, LOWEST_HZ, find_vibration
from friction_audit.diagnosis.stroke_scatter import StrokeScatter, find_stroke_scatter
from friction_audit.diagnosis.tell import vibration_of
from friction_audit.effects.joint_data import JointData
from friction_audit.joint_log import Float

ROUNDS_PER_RAD = (0.05, 10.0)
"""Of what may come round with the path travelled."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Restless:
    """What follows nothing that was recorded.

    Attributes:
        vibration: The stronger one of a hump and a line of the spectrum in time.
        scatter: Friction that is another from stroke to stroke.
        decides: Whether one of them is large enough to decide that something is missing.
        phrases: What people are told of it.
    """

    vibration: Vibration | None
    scatter: StrokeScatter | None
    decides: bool
    phrases: tuple[str, ...]


def find_restless(
    ground: Ground, effects: list[Float], fine: list[Float], over: float, rings: Callable[[Vibration], bool]
) -> Restless:
    """Look at what the model, and the curves that it lacks, leave.

    A line is looked for beside these curves, for whatever repeats with the motion has lines too.

    Args:
        ground: The joint.
        effects: Columns of the effects that were found, on the rows.
        fine: The same on the fine grid.
        over: How many times the noise may be left before something is missing.
        rings: Whether a vibration is that of an effect that was found.
    """
    left = ground.residual(*effects)
    size = float(np.sqrt(np.mean(left**2)))
    least = size * float(np.sqrt(1.0 - 1.0 / over**2))
    bare = beside_wanted_curves(ground, *effects)
    hum = find_line(bare, ground.rows.t, LOWEST_HZ, min(HIGHEST_HZ, ground.rows.corner_hz), least)
    speed, path = (of[:: ground.rows.every][ground.rows.used] for of in (ground.data.dq, _path(ground.data)))
    turning, rubbing = (
        find_line(torque, path, *ROUNDS_PER_RAD, least, np.abs(speed)) for torque in (bare, np.sign(speed) * bare)
    )
    scatter = find_stroke_scatter(left, speed > 0.0, ground.rows.t)
    scatter = scatter if scatter is not None and scatter.rms_nm >= least else None
    shaking, motion = _shaking(ground, effects, fine)
    hump = find_vibration(shaking, ground.data, motion)
    line = None if hum is None else _vibration(hum)
    shaken = hump is not None and hump.rms_nm > LEAST_VIBRATION * size and not rings(hump)
    vibration = hump if line is None or (hump is not None and hump.rms_nm > line.rms_nm) else line
    told = [] if vibration is None else [vibration_of(vibration)]
    told += [_round_phrase(what, one) for what, one in (("torque", turning), ("friction", rubbing)) if one is not None]
    told += [] if scatter is None else [scatter.message]
    others = any(one is not None for one in (turning, rubbing, scatter))
    decides = shaken or (line is not None and not rings(line)) or others
    return Restless(vibration=vibration, scatter=scatter, decides=decides, phrases=tuple(told))


def _shaking(ground: Ground, effects: list[Float], fine: list[Float]) -> tuple[Float, Float]:
    """What is left with the model's torque below the corner of the rows, and that torque above it, shape (n,). [N m]

    Above the corner inertia times acceleration is the tremor of a hand, or the encoder's noise, which grows with the
    square of the frequency: a structure that shakes would drown in it.
    """
    left, torque = ground.fine_residual(effects, fine), ground.data.torque
    load = np.zeros_like(torque) if ground.data.load is None else ground.data.load
    predicted = torque - left + load
    above = np.asarray(predicted - filter_rows(predicted, ground.rows.kernel, 1))
    return np.asarray(left + above), above


def _path(data: JointData) -> Float:
    """Path travelled, shape (n,). [rad]"""
    return np.asarray(np.cumsum(np.abs(data.dq) * data.moving) * data.step_s)


def _vibration(line: Line) -> Vibration:
    return Vibration(
        frequency_hz=line.frequency,
        low_hz=line.frequency - line.resolution,
        high_hz=line.frequency + line.resolution,
        rms_nm=line.rms_nm,
    )


def _round_phrase(what: str, line: Line) -> str:
    return (
        f"a {what} of {line.rms_nm:.2g} N m rms with a period of {1.0 / line.frequency:.3g} rad of the path "
        "travelled, in both directions"
    )
