from dataclasses import replace

import numpy as np

from friction_audit.diagnosis.likely_work import longest_first
from friction_audit.effects.joint_data import JointData
from tests.diagnosis.moved_joint import moved_joint


def rippled(size_nm: float) -> JointData:
    return moved_joint(lambda data: size_nm * np.cos(20.0 * data.q), noise_nm=0.02)


def test_what_has_more_to_explain_over_its_noise_is_begun_first() -> None:
    plain, loud = moved_joint(noise_nm=0.02), moved_joint(noise_nm=0.2)
    little, much = rippled(0.03), rippled(0.1)
    assert longest_first([plain, little, much]) == [2, 1, 0]
    assert longest_first([loud, much, plain])[0] == 1


def test_a_joint_that_never_moves_or_has_no_noise_is_no_trouble() -> None:
    plain = moved_joint(noise_nm=0.02)
    still = replace(plain, moving=np.zeros(len(plain.t), bool))
    silent = replace(plain, torque=np.zeros(len(plain.t)))
    assert longest_first([still, silent, plain]) == [2, 0, 1]
    assert longest_first([]) == []
