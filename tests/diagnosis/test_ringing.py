"""A spring that rings above the corner of the rows gets its name, a hum does not."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.diagnosis.alternatives import Naming
from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.library import Library
from friction_audit.diagnosis.naming import Found, Names
from friction_audit.diagnosis.result import Vibration
from friction_audit.diagnosis.ringing import CORNER_HZ, find_ringing, on_every_sample, rings, shaking
from friction_audit.dynamics.transmission import FarSide, Transmission
from friction_audit.effects.backlash import EFFECT as BACKLASH
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.joint_elasticity import EFFECT as ELASTICITY
from friction_audit.joint_log import Float
from tests.diagnosis.found_effect import found_effect
from tests.diagnosis.moved_joint import COULOMB_NM, INERTIA_KG_M2, VISCOUS_NMS_PER_RAD, moved_joint
from tests.dynamics.joints import added_torque

RINGING_HZ = 33.0
PLAY = {"gap_rad": 3e-3, "contact_hz": 83.0, "flank_damping_ratio": 0.5}
STIFFNESS_NM_PER_RAD = INERTIA_KG_M2 * (2.0 * np.pi * RINGING_HZ) ** 2
FAR = FarSide(inertia_kg_m2=INERTIA_KG_M2, coulomb_nm=COULOMB_NM, viscous_nms_per_rad=VISCOUS_NMS_PER_RAD)


def spring(data: JointData) -> Float:
    return added_torque(data.motion(), FAR, Transmission(stiffness_nm_per_rad=STIFFNESS_NM_PER_RAD, damping_ratio=0.03))


def hum(data: JointData) -> Float:
    return np.asarray(0.03 * np.sin(2.0 * np.pi * RINGING_HZ * data.t))


def joint(kind: str) -> tuple[Ground, Names]:
    """A joint in which nothing was found on the rows."""
    data = moved_joint({"spring": spring, "hum": hum}[kind], noise_nm=0.005, duration_s=40.0)
    ground = make_ground(data, None, 0)
    return ground, Names(found=(), library=Library(entries=(), untestable={}), baseline=ground.baseline())


def test_a_spring_that_rings_above_the_corner_is_named() -> None:
    ground, names = joint("spring")
    vibration = shaking(ground, names)
    assert vibration is not None
    assert vibration.frequency_hz == pytest.approx(RINGING_HZ, rel=0.1)
    ringing = find_ringing(ground, names, 0.05, np.random.default_rng(0))
    assert ringing is not None
    assert ringing.effect.name == ELASTICITY.name
    assert BACKLASH.name not in ringing.effect.alternatives
    numbers = ringing.effect.parameters
    assert numbers["spring_nm_per_rad"].value == pytest.approx(STIFFNESS_NM_PER_RAD, rel=0.05)
    # The damping is another than that of the model, which the size pays for and the frequency does not.
    compliance = numbers["compliance_rad_per_nm"]
    assert compliance.value == pytest.approx(1.0 / STIFFNESS_NM_PER_RAD, rel=0.02)
    assert compliance.low <= compliance.value <= compliance.high
    assert ringing.effect.torque.shape == ground.y.shape


def found(candidate: Effect, ground: Ground, shape: dict[str, float]) -> Names:
    """What the rows would have found."""
    one = found_effect(ground, candidate, shape)
    return Names(found=(one,), library=Library(entries=(), untestable={}), baseline=ground.baseline())


def test_a_play_that_the_rows_tell_is_not_given_up_for_a_spring_that_rings_above() -> None:
    quiet, _ = joint("spring")
    column = BACKLASH.regressor(quiet.data, quiet.baseline(), PLAY)[:, 0]
    ground = make_ground(replace(quiet.data, torque=quiet.data.torque + 0.4 * column), None, 0)
    told = found(BACKLASH, ground, PLAY)
    assert shaking(ground, told) is not None
    assert find_ringing(ground, replace(told, found=()), 0.05, np.random.default_rng(0)) is not None
    assert find_ringing(ground, told, 0.05, np.random.default_rng(0)) is None


def test_a_spring_of_the_rows_that_does_not_ring_so_gives_way() -> None:
    ground, nothing = joint("spring")
    told = found(ELASTICITY, ground, {"spring_nm_per_rad": 4.0 * STIFFNESS_NM_PER_RAD})
    ringing = find_ringing(ground, told, 0.05, np.random.default_rng(0))
    assert ringing is not None
    assert ringing.names.found == nothing.found


def test_a_hum_that_is_as_strong_is_no_spring() -> None:
    ground, names = joint("hum")
    assert shaking(ground, names) is not None
    assert find_ringing(ground, names, 0.05, np.random.default_rng(0)) is None


def test_what_does_not_shake_is_not_looked_at() -> None:
    ground = make_ground(moved_joint(noise_nm=0.01), None, 0)
    names = Names(found=(), library=Library(entries=(), untestable={}), baseline=ground.baseline())
    assert shaking(ground, names) is None
    assert find_ringing(ground, names, 0.05, np.random.default_rng(0)) is None


def test_every_sample_is_a_row() -> None:
    ground, names = joint("hum")
    fine = on_every_sample(ground, names)
    assert len(fine.y) == int(ground.data.used.sum())
    assert fine.rows.corner_hz == CORNER_HZ
    np.testing.assert_allclose(fine.rows.of(ground.data.dq), ground.data.dq[fine.rows.used], atol=1e-3)
    locked = np.unique(ground.rows.cycle[ground.locked])
    assert set(fine.rows.cycle[fine.locked]) == set(locked)


def named(name: str, shape: dict[str, float]) -> Names:
    candidate = {one.name: one for one in (ELASTICITY, BACKLASH)}[name]
    found = Found(
        candidate=candidate,
        shape=shape,
        columns=np.zeros((1, 1)),
        naming=Naming(name=name, rivals=(), alternatives=()),
        p_value=0.01,
    )
    baseline = Nominal(inertia_kg_m2=0.2, coulomb_nm=0.3, viscous_nms_per_rad=0.1, torque=np.zeros(1))
    return Names(found=(found,), library=Library(entries=(), untestable={}), baseline=baseline)


@pytest.mark.parametrize(("low_hz", "expected"), [(5.0, False), (21.0, True), (39.0, True), (45.0, False)])
def test_a_spring_rings_from_its_resonance_to_twice_that(low_hz: float, expected: bool) -> None:
    spring_at_20 = named("joint_elasticity", {"spring_nm_per_rad": 0.2 * (2.0 * np.pi * 20.0) ** 2})
    at = Vibration(frequency_hz=low_hz + 1.0, low_hz=low_hz, high_hz=low_hz + 2.0, rms_nm=0.1)
    assert rings(spring_at_20, (), at) is expected


def test_flanks_ring_upwards() -> None:
    flanks = named("backlash", {"gap_rad": 1e-3, "contact_hz": 25.0})
    at = Vibration(frequency_hz=30.0, low_hz=28.0, high_hz=32.0, rms_nm=0.1)
    assert rings(flanks, (), at)
    assert not rings(flanks, (), replace(at, low_hz=10.0, high_hz=14.0))


@pytest.mark.parametrize(("low_hz", "expected"), [(18.5, True), (17.0, False)])
def test_a_name_along_a_smooth_motion_says_nothing_of_what_rings_above_that(low_hz: float, expected: bool) -> None:
    smooth = named("backlash", {"gap_rad": 1e-3, "contact_hz": 60.0, "motion_below_hz": 18.0})
    at = Vibration(frequency_hz=28.0, low_hz=low_hz, high_hz=36.0, rms_nm=0.1)
    assert rings(smooth, (), at) is expected
