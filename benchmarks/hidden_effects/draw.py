"""Cases: a joint, who moves it, its sensors, and what is hidden in it, drawn by seed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from friction_audit.effects.joint_model import ArmModel, simple_model
from friction_audit.effects.registry import effects, same_as
from friction_audit.simulation.effects import EFFECTS
from friction_audit.simulation.effects.effect import HiddenEffect
from friction_audit.simulation.scenarios import SCENARIOS
from friction_audit.simulation.settings import PANDA_SENSORS, JointParameters, Sensors

SPREAD = 2.0
"""Every number of an effect is drawn from half to twice its usual value."""
NOISES = ("as measured", "slow", "very slow")
"""Colours of the torque noise: a Panda's, one that remembers 20 ms, one that remembers 100 ms."""
ONE_JOINT = ("joint", "joint-sine", "joint-slow", "joint-loaded", "joint-driven")
MOTIONS: dict[str, tuple[str, ...]] = {
    "stiction": ("joint", "joint-slow", "joint-loaded"),
    "load_dependent_friction": ("joint-loaded", "joint-driven"),
    "gravity_error": ("joint-loaded", "joint-driven"),
    "joint_elasticity": ("joint-driven", "joint-sine", "joint"),
    "unlogged_compensation": ("joint", "joint-sine", "joint-slow", "joint-loaded"),
    "torque_crosstalk": ("panda-driven", "panda"),
    "inertial_coupling": ("panda",),
    "inertia_error": ("joint-driven", "joint-sine", "joint"),
}
"""Scenarios in which an effect can be seen; all of one joint for those that are not here.

Rotors are on the motors' side of the sensors, so that only a hand that guides the arm makes their coupling felt.
"""
STATED = ("inertia_error", "unlogged_compensation")
"""Effects that can be seen next to a stated model only."""
NOT_PAIRED = ("unlogged_compensation", "contact_event")
"""Not to be seen without a declared model; hidden as an event, not as torque."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Case:
    """What one log is made from."""

    seed: int  # of the draw and of the simulation
    scenario: str  # its name
    noise: str  # colour of the torque noise
    effects: tuple[str, ...]  # names of the hidden effects
    groups: tuple[Any, ...]  # their numbers, strengths not yet scaled
    joint: JointParameters  # the joint, of a scenario of one
    duration_s: float  # length of the log [s]
    partial: float  # strength asked for: rms of what the effect adds, free of the declared model, over the noise's rms
    number: int = 1  # number of the joint in which it is hidden, one of an arm's, 1 of one

    @property
    def felt_in(self) -> tuple[int, ...]:
        """Numbers of the joints whose torque the effects change: a coupling that of the joint before, too."""
        return (self.number - 1, self.number) if "inertial_coupling" in self.effects else (self.number,)


def draw_case(seed: int, names: Sequence[str], partial: float, scenario: str | None = None) -> Case:
    """Draw everything but the effects' names and strength."""
    rng = np.random.default_rng([seed, 20261121, *"+".join(names).encode()])
    hidden = [next(effect for effect in EFFECTS if effect.name == name) for name in names]
    joint = JointParameters(
        inertia_kg_m2=float(rng.uniform(0.1, 0.6)),
        coulomb_nm=float(rng.uniform(0.15, 0.5)),
        viscous_nms_per_rad=float(rng.uniform(0.03, 0.1)),
    )
    can = [MOTIONS.get(name, ONE_JOINT) for name in names] or [ONE_JOINT]
    common = [place for place in can[0] if all(place in others for others in can)]
    place = scenario or str(rng.choice(common))
    longer = 3.0 if "warm_up" in names or place == "joint-slow" else 1.0
    return Case(
        seed=seed,
        scenario=place,
        noise=str(rng.choice(NOISES)),
        effects=tuple(names),
        groups=tuple(_draw_group(effect, rng) for effect in hidden),
        joint=joint,
        duration_s=longer * float(rng.uniform(60.0, 120.0)),
        partial=partial,
        # A joint of an arm with a neighbour on either side.
        number=int(np.random.default_rng([seed, 20261122]).integers(2, 7)) if place.startswith("panda") else 1,
    )


def draw_pairs(first: int, seeds: int) -> list[tuple[str, int]]:
    """One pair of effects for each seed, as ``first+second``, and the seed; both can be seen in one scenario."""
    every = effects_that_pair()
    return [(str(np.random.default_rng([seed, 3]).choice(every)), seed) for seed in range(first, first + seeds)]


def effects_that_pair() -> list[str]:
    """All pairs of effects that share a scenario of one joint and some motion separates."""
    some = [one for one in effects() if one.name not in NOT_PAIRED]
    places = {one.name: set(MOTIONS.get(one.name, ONE_JOINT)) & set(ONE_JOINT) for one in some}
    return [
        f"{one.name}+{two.name}"
        for one, two in combinations(some, 2)
        if places[one.name] & places[two.name] and two.name not in same_as(one.name)
    ]


def _draw_group(effect: type[HiddenEffect], rng: np.random.Generator) -> Any:  # noqa: ANN401 - every effect has its own
    numbers = {}
    for parameter in effect.parameters():
        value = parameter.default * float(np.exp(rng.uniform(-np.log(SPREAD), np.log(SPREAD))))
        numbers[parameter.name] = repr(min(max(value, parameter.lower), parameter.upper))
    if effect.forms:
        numbers["form"] = str(rng.choice(effect.forms))
    return effect.make(numbers)


def settings_of(case: Case, scales: Sequence[float], *, ideal: bool = False) -> Any:  # noqa: ANN401 - of any scenario
    """Settings of the simulation, every effect's strength times its scale."""
    settings = next(item for item in SCENARIOS if item.name == case.scenario).settings
    several = len(settings.hidden) > 1
    hidden = list(settings.hidden)
    for name, group, scale in zip(case.effects, case.groups, scales, strict=True):
        strength = next(effect for effect in EFFECTS if effect.name == name).strength_name
        scaled = replace(group, **{strength: getattr(group, strength) * scale})
        hidden[case.number - 1] = hidden[case.number - 1].holding(scaled)
    changes: dict[str, Any] = {"duration_s": case.duration_s, "hidden": tuple(hidden)}
    sensors = PANDA_SENSORS if several else PANDA_SENSORS[:1]
    changes["sensors"] = tuple(Sensors() if ideal else coloured(one, case.noise) for one in sensors)
    if not several:
        changes["joints"] = (case.joint,)
    return replace(settings, **changes)


def model_of(case: Case) -> ArmModel | None:
    """What somebody would state to have the effects seen: the joints without them, Coulomb friction held if needed."""
    if not set(case.effects) & set(STATED):
        return None
    held = ("coulomb",) if "unlogged_compensation" in case.effects else ()
    simple = (
        simple_model(
            inertia_kg_m2=one.inertia_kg_m2, coulomb_nm=one.coulomb_nm, viscous_nms_per_rad=one.viscous_nms_per_rad
        )
        for one in settings_of(case, (0.0,) * len(case.effects)).joints
    )
    joints = tuple(replace(one, held=held) for one in simple)
    return ArmModel(names=tuple(f"joint{k}" for k in range(1, len(joints) + 1)), joints=joints)


def coloured(sensors: Sensors, noise: str) -> Sensors:
    """The sensors with a noise of another memory, about as strong below 25 Hz."""
    if noise == "slow":
        return replace(sensors, torque_noise_nm=0.6 * sensors.torque_noise_nm, torque_correlation_s=0.02)
    if noise == "very slow":
        return replace(sensors, torque_noise_nm=0.45 * sensors.torque_noise_nm, torque_correlation_s=0.1)
    return sensors
