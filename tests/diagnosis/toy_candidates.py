"""Candidates by hand: a bump over position whose place and width are shapes, a slow wave in time, a needless one."""

import numpy as np

from friction_audit.diagnosis.candidate import Candidate, Shape
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.joint_log import Float


def _bump(data: JointData, _baseline: Nominal, shape: Shape) -> Float:
    return np.exp(-(((data.q - shape["place_rad"]) / shape["width_rad"]) ** 2))[:, None]


def _wave(data: JointData, _baseline: Nominal, shape: Shape) -> Float:
    return np.column_stack([np.sin(shape["rate"] * data.t), np.cos(shape["rate"] * data.t)])


def _step(data: JointData, _baseline: Nominal, shape: Shape) -> Float:
    return (np.sign(data.dq) * (data.t >= shape["moment_s"]))[:, None]


def _square(data: JointData, _baseline: Nominal, _shape: Shape) -> Float:
    return (data.dq * np.abs(data.dq))[:, None]


BUMP = Candidate(
    name="bump",
    label="a bump",
    shapes=tuple({"place_rad": place, "width_rad": 0.2} for place in (-0.6, -0.3, 0.0, 0.3, 0.6)),
    columns=_bump,
    column_units=("nm",),
    untestable=lambda _data, _baseline: None,
    admissible=lambda factors, _shape: bool(factors[0] > 0),
    axis="position",
)
WAVE = Candidate(
    name="wave",
    label="a wave",
    shapes=({"rate": 0.1}, {"rate": 0.5}),
    columns=_wave,
    column_units=("nm", "nm"),
    untestable=lambda _data, _baseline: None,
    admissible=lambda _factors, _shape: True,
    axis="time",
)
SQUARE = Candidate(
    name="square",
    label="friction that grows with the square of the speed",
    shapes=({},),
    columns=_square,
    column_units=("nms2_per_rad2",),
    untestable=lambda _data, _baseline: None,
    admissible=lambda _factors, _shape: True,
    axis="speed",
)
STEP = Candidate(
    name="step",
    label="friction changes at one moment",
    shapes=tuple({"moment_s": moment} for moment in (10.0, 20.0, 30.0, 40.0, 50.0)),
    columns=_step,
    column_units=("nm",),
    untestable=lambda _data, _baseline: None,
    admissible=lambda _factors, _shape: True,
    axis="time",
    moment="moment_s",
)
LOCKED_OUT = Candidate(
    name="locked_out",
    label="what no log shows",
    shapes=({},),
    columns=_square,
    column_units=("nm",),
    untestable=lambda _data, _baseline: "move the moon",
    admissible=lambda _factors, _shape: True,
    axis="speed",
)
TOYS = (BUMP, WAVE, SQUARE, LOCKED_OUT)
