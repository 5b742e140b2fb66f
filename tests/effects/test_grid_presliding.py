"""Presliding against bristles of other makers: Euler steps of LuGre, and springs with sliders."""

import numpy as np
import pytest

from friction_audit.effects import backlash, presliding, time_delay
from friction_audit.joint_log import Float
from tests.effects.explained import share_explained
from tests.effects.joint_data_by_hand import STEP_S, baseline, joint_data, two_sines

DATA = two_sines(30.0)
SUBSTEPS = 20


def lugre(reach_rad: float, damping_s: float) -> Float:
    """Euler steps of Canudas de Wit's equations at a constant level of 1."""
    z, torque = 0.0, np.zeros(len(DATA.q))
    for k, v in enumerate(DATA.dq):
        for _ in range(SUBSTEPS):
            rate = v - abs(v) * z / reach_rad
            z += rate * STEP_S / SUBSTEPS
        torque[k] = (z + damping_s * rate) / reach_rad
    return torque


def sliders(reaches_rad: Float) -> Float:
    """Springs of equal strength that slip at their reaches."""
    bent, torque = np.zeros(len(reaches_rad)), np.zeros(len(DATA.q))
    for k in range(1, len(DATA.q)):
        bent = np.clip(bent + DATA.q[k] - DATA.q[k - 1], -reaches_rad, reaches_rad)
        torque[k] = np.mean(bent / reaches_rad)
    return torque


@pytest.mark.parametrize("reach_rad", [0.003, 0.02])
@pytest.mark.parametrize("form", ["lugre", "damped lugre", "sliders"])
def test_bristles_are_presliding_and_nothing_else(form: str, reach_rad: float) -> None:
    spread = reach_rad * np.array([0.3, 0.6, 1.0, 1.5])
    torque = sliders(spread) if form == "sliders" else lugre(reach_rad, 0.01 if form == "damped lugre" else 0.0)
    own = share_explained(presliding.EFFECT, DATA, torque)
    assert own > 0.9
    for other in (backlash.EFFECT, time_delay.EFFECT):
        assert share_explained(other, DATA, torque) < own - 0.1


def test_reaches_go_with_the_span() -> None:
    small = joint_data(0.1 * DATA.q, 0.1 * DATA.dq, 0.1 * DATA.ddq)
    ours, theirs = (presliding.EFFECT.grid(data) for data in (small, DATA))
    assert [s["reach_rad"] for s in ours] == pytest.approx([0.1 * s["reach_rad"] for s in theirs])


def test_friction_only_and_after_enough_reversals() -> None:
    shape = presliding.EFFECT.grid(DATA)[0]
    assert presliding.EFFECT.admissible(np.array([0.1]), shape)
    assert not presliding.EFFECT.admissible(np.array([-0.1]), shape)
    once = joint_data(DATA.q[:400], DATA.dq[:400], DATA.ddq[:400])
    assert "reversals" in str(presliding.EFFECT.not_identifiable(once, baseline(once)))
