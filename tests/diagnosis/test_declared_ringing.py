"""A spring or a play in a model file goes along the motion in which it explains more, and is no contact."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.contacts import _of_a_file
from friction_audit.diagnosis.declared import least_squares
from friction_audit.diagnosis.ground import make_ground
from friction_audit.effects.backlash import EFFECT as TERM
from friction_audit.effects.joint_data import JointData
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.joint_log import Float
from tests.diagnosis.moved_joint import COULOMB_NM, INERTIA_KG_M2, VISCOUS_NMS_PER_RAD, moved_joint

PLAY = FittedTerm("backlash", (1.0, 2e-3, 50.0, 0.5, 0.8))
SIMPLE = (FittedTerm("coulomb", (COULOMB_NM,)), FittedTerm("viscous", (VISCOUS_NMS_PER_RAD,)))
MODEL = JointModel(inertia_kg_m2=INERTIA_KG_M2, terms=(*SIMPLE, PLAY))


def play(data: JointData) -> Float:
    motion = data.motion()
    return TERM.torque(replace(motion, rest=MODEL.rest(motion)), PLAY.values)


def left(data: JointData, model: JointModel) -> float:
    ground = make_ground(data, model, 0)
    rest = ground.y - ground.base @ least_squares(ground.base, ground.y)
    return float(np.sqrt(np.mean(rest**2)))


@pytest.mark.parametrize("noise_rad", [0.0, 3e-5])
def test_a_declared_play_leaves_the_noise(noise_rad: float) -> None:
    still = moved_joint(play, noise_nm=0.01, duration_s=20.0)
    shaken = replace(still, q=still.q + np.random.default_rng(1).normal(0.0, noise_rad, len(still.q)))
    with_it, without = left(shaken, MODEL), left(shaken, replace(MODEL, terms=SIMPLE))
    assert with_it < 0.5 * without


def test_what_a_file_declares_is_known_to_be_there() -> None:
    ground = make_ground(moved_joint(play, noise_nm=0.01, duration_s=20.0), MODEL, 0)
    assert [ground.declared.names[k] for k in _of_a_file(ground)] == ["backlash_share"]
    simple = make_ground(moved_joint(play, noise_nm=0.01, duration_s=20.0), replace(MODEL, terms=SIMPLE), 0)
    assert _of_a_file(simple) == []
