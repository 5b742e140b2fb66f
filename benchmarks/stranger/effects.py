"""Hidden effects: how each is put into a joint or its sensors, with a strength that ``strength`` turns to a given size.

``OUTSIDE`` holds what no one name of the catalogue stands for, ``RECORDED`` what is no effect but a way of recording.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.stranger.joint import Joint
from benchmarks.stranger.sensors import Sensors


@dataclass(frozen=True, kw_only=True)
class Setup:
    """A joint, its sensors, where the torque is measured ("drive" or "spring"), and the inertia that is declared."""

    joint: Joint
    sensors: Sensors
    torque_at: str = "drive"
    declared_inertia: float | None = None
    duration_s: float = 90.0


Put = Callable[[Setup, float, np.random.Generator], Setup]


def _with(setup: Setup, **changes: float) -> Setup:
    return replace(setup, joint=setup.joint._replace(**changes))


def _sensed(setup: Setup, **changes: float | bool | str) -> Setup:
    return replace(setup, sensors=replace(setup.sensors, **changes))  # type: ignore[arg-type]


def presliding(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """Maxwell-slip springs next to the stiff bristles, or LuGre's bristles soft."""
    if rng.random() < 0.5:
        return _with(setup, soft=s, soft_reach_rad=float(np.exp(rng.uniform(np.log(4e-3), np.log(6e-2)))))
    return _with(setup, bristle_rad=0.03 * s)


def nonlinear_viscous(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """A power law, thinning or thickening, or friction that saturates."""
    kind = rng.integers(3)
    if kind == 0:
        return _with(setup, curved=s, curved_exponent=rng.uniform(1.7, 2.6))
    if kind == 1:
        return _with(setup, curved=s, curved_exponent=rng.uniform(0.3, 0.6))
    return _with(setup, saturating=s, saturation_speed=rng.uniform(0.3, 0.8))


def load_dependent_friction(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """Friction in proportion to what the gear transmits, which a payload changes in the middle of the recording."""
    heavy = {"payload_factor": rng.uniform(1.6, 2.5), "payload_s": setup.duration_s * rng.uniform(0.35, 0.65)}
    return _with(setup, load_share=s, pendulum=rng.uniform(3, 8), **heavy)


def position_dependent_friction(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """A worn place, or an eccentric gear."""
    if rng.random() < 0.5:
        return _with(setup, worn=s, worn_centre_rad=rng.uniform(-0.3, 0.3), worn_width_rad=rng.uniform(0.1, 0.3))
    return _with(setup, eccentric=s, eccentric_order=rng.uniform(1, 6))


def torque_ripple(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """Waves over the angle, with a second harmonic."""
    order = float(np.round(np.exp(rng.uniform(np.log(10), np.log(120)))))
    second = s * rng.uniform(0, 0.5)
    return _with(setup, ripple=s, ripple_second=second, ripple_order=order, ripple_phase=rng.uniform(0, 6))


def gravity_error(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """A mass that was forgotten."""
    angle = rng.uniform(0, 2 * np.pi)
    return _with(setup, heavier_sin=s * np.sin(angle), heavier_cos=s * np.cos(angle))


def cable_spring(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """A hose that stiffens, with or without slack."""
    slack = rng.choice([0.0, rng.uniform(0.1, 0.25)])
    stiffening = s * rng.uniform(0, 4)
    return _with(setup, hose=s, hose_hardening=stiffening, hose_centre_rad=rng.uniform(-0.2, 0.2), hose_slack_rad=slack)


def torque_drift(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """A sensor that warms, wanders, or goes straight."""
    kind = rng.choice(["creep_nm", "ramp_nm", "wander_nm"])
    return _sensed(setup, **{str(kind): s, "creep_s": rng.uniform(15, 60)})


def joint_elasticity(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """Two masses and a spring, the torque measured before the first or between the two."""
    at = str(rng.choice(["drive", "spring"]))
    hertz = 1 / np.sqrt(s)
    changed = _with(setup, spring_hz=hertz, motor_share=rng.uniform(0.1, 0.4), spring_damping=rng.uniform(0.03, 0.15))
    return replace(changed, torque_at=at)


def backlash(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """Two masses and a dead zone."""
    at = str(rng.choice(["drive", "spring"]))
    share = rng.uniform(0.1, 0.4)
    stiff = _with(setup, spring_hz=rng.uniform(25, 40), spring_damping=0.3, motor_share=share, gap_rad=s)
    return replace(stiff, torque_at=at)


def warm_up(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """Grease that warms."""
    viscous = s * rng.uniform(0.05, 0.4)
    return _with(setup, cold=s, cold_viscous=viscous, warming_s=setup.duration_s * rng.uniform(0.15, 0.6))


RECORDED: dict[str, Callable[[Setup, np.random.Generator], Setup]] = {
    # the speed is what drivers make of the position: filtered differences, 4 to 10 ms late
    "late_speed": lambda setup, rng: _sensed(setup, tachometer=False, difference_hz=rng.uniform(30, 80)),
    # 0.8 to 1.5 mrad a count
    "coarse_encoder": lambda setup, rng: _sensed(setup, encoder_bits=int(rng.integers(12, 14))),
    # as a topic that is published seldom
    "slow_log": lambda setup, rng: _sensed(setup, rate_hz=float(rng.choice([100.0, 200.0]))),
    # stamps of arrival: packets of several samples come late together
    "batched_stamps": lambda setup, _rng: _sensed(setup, clock="batches"),
    # the other sign convention
    "turned_torque": lambda setup, _rng: _sensed(setup, sign=-1.0),
}
"""Nothing is hidden in the joint, and it is recorded in a way that a tool has to expect."""
OUTSIDE: dict[str, tuple[Put, float]] = {
    # contacts that age at rest and are renewed by sliding (Dieterich 1979; Ruina 1983)
    "rate_and_state": (
        lambda setup, s, rng: _with(
            setup, ageing=s, ageing_s=rng.uniform(0.05, 0.5), renewal_rad=rng.uniform(0.005, 0.03)
        ),
        0.05,
    ),
    # a hose whose pull relaxes (a Maxwell element)
    "relaxing_hose": (lambda setup, s, rng: _with(setup, maxwell=s, maxwell_s=rng.uniform(0.3, 1.5)), 0.5),
    # a mass on a soft spring, as a liquid that sloshes
    "loose_load": (
        lambda setup, s, rng: _with(
            setup, slosh=s, slosh_hz=rng.uniform(1.5, 4), slosh_damping=rng.uniform(0.03, 0.15)
        ),
        0.03,
    ),
    # a vibration of the floor
    "hum": (lambda setup, s, rng: _sensed(setup, hum_nm=s, hum_hz=rng.uniform(3, 15)), 0.05),
    # a sensor that is not linear
    "bent_sensor": (lambda setup, s, rng: _sensed(setup, bent_per_nm2=s * rng.choice([-1, 1])), 0.05),
}
HIDDEN: dict[str, tuple[Put, float]] = {
    # LuGre's g(v)
    "stribeck": (
        lambda setup, s, rng: _with(
            setup, stribeck=s, stribeck_speed=rng.uniform(0.04, 0.2), stribeck_exponent=rng.uniform(1, 2)
        ),
        0.1,
    ),
    "presliding": (presliding, 0.3),
    "nonlinear_viscous": (nonlinear_viscous, 0.1),
    # the level of the bristles by direction
    "asymmetric_coulomb": (lambda setup, s, rng: _with(setup, uneven_coulomb=s * rng.choice([-1, 1])), 0.05),
    # viscous friction by direction
    "asymmetric_viscous": (lambda setup, s, rng: _with(setup, uneven_viscous=s * rng.choice([-1, 1])), 0.03),
    "load_dependent_friction": (load_dependent_friction, 0.02),
    "position_dependent_friction": (position_dependent_friction, 0.1),
    "torque_ripple": (torque_ripple, 0.05),
    "gravity_error": (gravity_error, 0.1),
    "cable_spring": (cable_spring, 0.2),
    # a rubber stop that some of the strokes reach
    "joint_limit_stop": (lambda setup, s, rng: _with(setup, stop=s, stop_rad=rng.uniform(0.25, 0.35)), 0.1),
    # an offset of the sensor
    "torque_bias": (lambda setup, s, rng: _sensed(setup, bias_nm=s * rng.choice([-1, 1])), 0.05),
    "torque_drift": (torque_drift, 0.05),
    # the torque is read late, or the motion is
    "time_delay": (lambda setup, s, rng: _sensed(setup, torque_late_s=s * rng.choice([-1, 1])), 0.004),
    "joint_elasticity": (joint_elasticity, 1 / 15**2),
    "backlash": (backlash, 0.01),
    # a declared inertia that is wrong
    "inertia_error": (
        lambda setup, s, rng: replace(
            setup, declared_inertia=setup.joint.inertia * max(1 + s * rng.choice([-1, 1]), 0.05)
        ),
        0.3,
    ),
    "warm_up": (warm_up, 0.1),
    # a level that changes at once
    "friction_step": (
        lambda setup, s, rng: _with(setup, stepped=s, step_s=setup.duration_s * rng.uniform(0.25, 0.75)),
        0.1,
    ),
    # somebody bumps into the link once
    "contact_event": (
        lambda setup, s, rng: _with(
            setup, pushed=s, push_s=setup.duration_s * rng.uniform(0.2, 0.8), push_long_s=rng.uniform(0.15, 0.5)
        ),
        1.0,
    ),
}
"""Names of the catalogue, each with the strength that the search for a size starts from."""
