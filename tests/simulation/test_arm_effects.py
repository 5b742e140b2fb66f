"""Every hidden effect in joints 2 and 5 of an arm."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.simulation import EFFECTS, IDEAL_SENSORS, ArmSettings, Hidden, Simulation, TrueMotion, simulate
from friction_audit.simulation.effects.sensors import TorqueCrosstalk
from friction_audit.simulation.effects.structure import Backlash, JointElasticity
from friction_audit.simulation.panda_joint import PANDA_JOINTS

SHORT = ArmSettings(duration_s=2.0)
IDEAL = replace(SHORT, sensors=(IDEAL_SENSORS,) * 7)
ROTORS = np.array([joint.inertia_kg_m2 for joint in PANDA_JOINTS])
WITHIN_REACH = {"joint_limit_stop": {"at_rad": "0.05"}}
"""An arm guided for two seconds does not get far: the stops stand closer."""
NOTHING_YET = Hidden().holding(*(replace(effect.make({}), **{effect.strength_name(): 0.0}) for effect in EFFECTS))
SEED = 1


@cache
def log_of(hidden: Hidden, driven: bool) -> Simulation:
    among_others = tuple(hidden if joint in (2, 5) else Hidden() for joint in range(1, 8))
    return simulate(replace(SHORT, hidden=among_others, driven=driven), SEED)


@pytest.mark.parametrize("driven", [False, True], ids=["guided", "driven"])
def test_all_effects_at_zero_strength_change_nothing_to_the_bit(driven: bool) -> None:
    plain, hidden = (log_of(inside, driven).log for inside in (Hidden(), NOTHING_YET))
    for name, channel in plain.channels().items():
        assert_array_equal(hidden.channels()[name], channel)


@pytest.mark.parametrize("effect", EFFECTS, ids=[effect.name for effect in EFFECTS])
def test_effect_changes_the_log_and_keeps_it_finite(effect: Any) -> None:
    hidden = Hidden().holding(effect.make(WITHIN_REACH.get(effect.name, {})))
    plain, changed = (log_of(inside, False).log.channels() for inside in (Hidden(), hidden))
    for channel in changed.values():
        assert np.isfinite(channel).all()
        assert np.abs(channel).max() < 100.0
    joints = [1, 4]
    assert any(not np.array_equal(changed[name][:, joint], plain[name][:, joint]) for name in plain for joint in joints)


def test_crosstalk_mixes_the_neighbours_torques() -> None:
    clean = simulate(IDEAL, SEED).log.channels()
    hidden = [Hidden()] * 7
    hidden[1] = Hidden(torque_crosstalk=TorqueCrosstalk(share=0.05))
    mixed = simulate(replace(IDEAL, hidden=tuple(hidden)), SEED).log.channels()
    assert_array_equal(mixed["q"], clean["q"])
    assert_allclose(mixed["tau_J"][:, 1] - clean["tau_J"][:, 1], 0.05 * clean["tau_J"][:, 2], atol=1e-12)
    assert_array_equal(np.delete(mixed["tau_J"], 1, axis=1), np.delete(clean["tau_J"], 1, axis=1))


@cache
def moved(inside: Hidden, driven: bool) -> TrueMotion:
    """Return how an arm moves that hides the same in all joints."""
    return simulate(replace(IDEAL, hidden=(inside,) * 7, driven=driven), SEED).truth.motion


SOFT, STIFF = JointElasticity(compliance_rad_per_nm=1e-3), JointElasticity(compliance_rad_per_nm=1e-4)


@pytest.mark.parametrize("driven", [False, True], ids=["guided", "driven"])
@pytest.mark.parametrize(
    "inside",
    [
        pytest.param(Hidden(joint_elasticity=SOFT), id="soft"),
        pytest.param(Hidden(joint_elasticity=STIFF), id="stiff", marks=pytest.mark.thorough),
        pytest.param(
            Hidden(joint_elasticity=replace(STIFF, damping_ratio=0.0)), id="undamped", marks=pytest.mark.thorough
        ),
        pytest.param(Hidden(backlash=Backlash(gap_rad=2e-3)), id="backlash", marks=pytest.mark.thorough),
        pytest.param(Hidden(joint_elasticity=STIFF, backlash=Backlash(gap_rad=2e-3)), id="stiff with backlash"),
    ],
)
def test_transmissions_of_all_joints_stay_calm(inside: Hidden, driven: bool) -> None:
    rigid, soft = (moved(hidden, driven) for hidden in (Hidden(), inside))
    assert np.abs(soft.q - rigid.q).max() < 0.1
    assert np.abs(soft.inner_dq).max() < 1.5 * np.abs(rigid.inner_dq).max()
    assert np.abs(soft.interaction_nm).max() < 4.0 * np.abs(rigid.interaction_nm).max()
