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


def stribeck(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """LuGre's g(v)."""
    return _with(setup, stribeck=s, stribeck_speed=rng.uniform(0.04, 0.2), stribeck_exponent=rng.uniform(1, 2))


def presliding(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """Maxwell-slip springs beside the stiff bristles, or LuGre's bristles soft."""
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


def asymmetric_coulomb(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """The level of the bristles by direction."""
    return _with(setup, uneven_coulomb=s * rng.choice([-1, 1]))


def asymmetric_viscous(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """Viscous friction by direction."""
    return _with(setup, uneven_viscous=s * rng.choice([-1, 1]))


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


def joint_limit_stop(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """A rubber stop that some of the strokes reach."""
    return _with(setup, stop=s, stop_rad=rng.uniform(0.25, 0.35))


def torque_bias(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """An offset of the sensor."""
    return _sensed(setup, bias_nm=s * rng.choice([-1, 1]))


def torque_drift(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """A sensor that warms, wanders, or goes straight."""
    kind = rng.choice(["creep_nm", "ramp_nm", "wander_nm"])
    return _sensed(setup, **{str(kind): s, "creep_s": rng.uniform(15, 60)})


def time_delay(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """The torque is read late, or the motion is."""
    return _sensed(setup, torque_late_s=s * rng.choice([-1, 1]))


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


def inertia_error(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """A declared inertia that is wrong."""
    return replace(setup, declared_inertia=setup.joint.inertia * max(1 + s * rng.choice([-1, 1]), 0.05))


def warm_up(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """Grease that warms."""
    viscous = s * rng.uniform(0.05, 0.4)
    return _with(setup, cold=s, cold_viscous=viscous, warming_s=setup.duration_s * rng.uniform(0.15, 0.6))


def friction_step(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """A level that changes at once."""
    return _with(setup, stepped=s, step_s=setup.duration_s * rng.uniform(0.25, 0.75))


def contact_event(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """Somebody bumps into the link once."""
    return _with(setup, pushed=s, push_s=setup.duration_s * rng.uniform(0.2, 0.8), push_long_s=rng.uniform(0.15, 0.5))


def rate_and_state(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """Contacts that age at rest and are renewed by sliding (Dieterich 1979; Ruina 1983)."""
    return _with(setup, ageing=s, ageing_s=rng.uniform(0.05, 0.5), renewal_rad=rng.uniform(0.005, 0.03))


def relaxing_hose(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """A hose whose pull relaxes (a Maxwell element)."""
    return _with(setup, maxwell=s, maxwell_s=rng.uniform(0.3, 1.5))


def loose_load(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """A mass on a soft spring, as a liquid that sloshes."""
    return _with(setup, slosh=s, slosh_hz=rng.uniform(1.5, 4), slosh_damping=rng.uniform(0.03, 0.15))


def hum(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """A vibration of the floor."""
    return _sensed(setup, hum_nm=s, hum_hz=rng.uniform(3, 15))


def bent_sensor(setup: Setup, s: float, rng: np.random.Generator) -> Setup:
    """A sensor that is not linear."""
    return _sensed(setup, bent_per_nm2=s * rng.choice([-1, 1]))


def late_speed(setup: Setup, rng: np.random.Generator) -> Setup:
    """The speed is what drivers make of the position: filtered differences, 4 to 10 ms late."""
    return _sensed(setup, tachometer=False, difference_hz=rng.uniform(30, 80))


def coarse_encoder(setup: Setup, rng: np.random.Generator) -> Setup:
    """0.8 to 1.5 mrad a count."""
    return _sensed(setup, encoder_bits=int(rng.integers(12, 14)))


def slow_log(setup: Setup, rng: np.random.Generator) -> Setup:
    """As a topic that is published seldom."""
    return _sensed(setup, rate_hz=float(rng.choice([100.0, 200.0])))


def batched_stamps(setup: Setup, _rng: np.random.Generator) -> Setup:
    """Stamps of arrival: packets of several samples come late together."""
    return _sensed(setup, clock="batches")


def turned_torque(setup: Setup, _rng: np.random.Generator) -> Setup:
    """The other sign convention."""
    return _sensed(setup, sign=-1.0)


RECORDED: dict[str, Callable[[Setup, np.random.Generator], Setup]] = {
    "late_speed": late_speed,
    "coarse_encoder": coarse_encoder,
    "slow_log": slow_log,
    "batched_stamps": batched_stamps,
    "turned_torque": turned_torque,
}
"""Nothing is hidden in the joint, and it is recorded in a way that a tool has to expect."""
OUTSIDE: dict[str, tuple[Put, float]] = {
    "rate_and_state": (rate_and_state, 0.05),
    "relaxing_hose": (relaxing_hose, 0.5),
    "loose_load": (loose_load, 0.03),
    "hum": (hum, 0.05),
    "bent_sensor": (bent_sensor, 0.05),
}
HIDDEN: dict[str, tuple[Put, float]] = {
    "stribeck": (stribeck, 0.1),
    "presliding": (presliding, 0.3),
    "nonlinear_viscous": (nonlinear_viscous, 0.1),
    "asymmetric_coulomb": (asymmetric_coulomb, 0.05),
    "asymmetric_viscous": (asymmetric_viscous, 0.03),
    "load_dependent_friction": (load_dependent_friction, 0.02),
    "position_dependent_friction": (position_dependent_friction, 0.1),
    "torque_ripple": (torque_ripple, 0.05),
    "gravity_error": (gravity_error, 0.1),
    "cable_spring": (cable_spring, 0.2),
    "joint_limit_stop": (joint_limit_stop, 0.1),
    "torque_bias": (torque_bias, 0.05),
    "torque_drift": (torque_drift, 0.05),
    "time_delay": (time_delay, 0.004),
    "joint_elasticity": (joint_elasticity, 1 / 15**2),
    "backlash": (backlash, 0.01),
    "inertia_error": (inertia_error, 0.3),
    "warm_up": (warm_up, 0.1),
    "friction_step": (friction_step, 0.1),
    "contact_event": (contact_event, 1.0),
}
"""Names of the catalogue, each with the strength that the search for a size starts from."""
