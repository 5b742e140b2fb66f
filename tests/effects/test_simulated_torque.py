"""The simulator's formula of every effect against the detector's columns, at random states of a joint."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from friction_audit.dynamics.motion import Motion, Others
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.effects.registry import NAMES
from friction_audit.joint_log import Float
from friction_audit.simulation.effects import EFFECTS, velocity
from friction_audit.simulation.effects.effect import Setting
from friction_audit.simulation.effects.sensors import delayed
from friction_audit.simulation.mechanics.records import pack
from friction_audit.simulation.settings import JointParameters
from tests.effects.joint_data_by_hand import sines

JOINT = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.4, viscous_nms_per_rad=0.1)
DT, N = 4e-3, 500
HIDDEN = {effect.name: effect for effect in EFFECTS}


def states() -> Motion:
    """Random smooth states of a joint among three."""
    rng = np.random.default_rng(7)
    t = np.arange(N, dtype=np.float64) * DT
    q, dq, ddq = sines(t, *rng.uniform([0.1, 1.0, 0.0], [0.4, 9.0, 6.0], (4, 3)).tolist())
    others = Others(
        joint=1, dq=rng.normal(size=(N, 3)), ddq=rng.normal(size=(N, 3)), sensed=rng.normal(scale=5.0, size=(N, 3))
    )
    rest = 0.3 * ddq + 0.4 * np.sign(dq) + 0.1 * dq
    return Motion(t=t, q=q, dq=dq, ddq=ddq, load=rng.normal(scale=8.0, size=N), rest=rest, others=others)


MOTION = states()
assert MOTION.others is not None
SIGN, REST, SENSED = np.sign(MOTION.dq), np.asarray(MOTION.rest), MOTION.others.sensed
LOAD = np.asarray(MOTION.load) + REST


def law_of(function: str) -> Callable[..., Any]:
    """A formula of the simulator, in the family that has it."""
    families = ("velocity", "load_and_place", "sensors", "structure", "slow_and_events")
    modules = [import_module(f"friction_audit.simulation.effects.{name}") for name in families]
    law: Callable[..., Any] = next(getattr(module, function) for module in modules if hasattr(module, function))
    return law


def each(function: str, *signals: Float) -> Callable[[Any], Float]:
    """A law of the simulator, sample by sample; as Python, for to compile each by itself takes seconds."""
    law: Callable[..., Any] = law_of(function).py_func  # type: ignore[attr-defined]
    return lambda group: np.array(
        [law(pack([group]).view(np.recarray)[0], *args) for args in zip(*signals, strict=True)]
    )


def whole(function: str, *args: Any) -> Callable[[Any], Float]:
    law = law_of(function)
    return lambda group: np.asarray(law(group, *args))


def bristles(group: Any) -> Float:
    record, z, out = pack([group])[0], np.zeros(velocity.BRISTLES), []
    for speed in np.append(np.diff(MOTION.q) / DT, 0.0):
        out.append(velocity.presliding_force_nm(record, z, JOINT.coulomb_nm, JOINT.coulomb_nm, speed))
        velocity.presliding_advance(record, z, JOINT.coulomb_nm, JOINT.coulomb_nm, speed, DT)
    return np.array(out) - JOINT.coulomb_nm * SIGN


def stepped(group: Any) -> Float:
    ratios = (np.full(N, ratio) for ratio in (1.0, group.viscous_ratio))
    shares = [each("friction_step_factor", ratio, MOTION.t, np.full(N, N * DT))(group) - 1.0 for ratio in ratios]
    return JOINT.coulomb_nm * SIGN * shares[0] + JOINT.viscous_nms_per_rad * MOTION.dq * shares[1]


def rubbing(group: Any) -> Float:
    return SIGN * each("load_friction_nm", LOAD, LOAD * MOTION.dq)(group)


def wavy(group: Any) -> Float:
    return 0.4 * SIGN * (each("place_factor", MOTION.q)(group) - 1.0)


def crosstalk(group: Any) -> Float:
    none = type(group)()
    return np.asarray(whole("crosstalk_mixed", SENSED)([none, group, none])[:, 1] - SENSED[:, 1])


# Effect, parameters of the term, torque that the simulator's formula takes: F_m with the effect less F_m without it.
CASES: list[tuple[str, tuple[float, ...], Callable[[Any], Float]]] = [
    ("stribeck", (0.2, 0.3, 1.5), lambda g: SIGN * each("stribeck_nm", abs(MOTION.dq))(g)),
    ("nonlinear_viscous", (0.2, 1.7, 1e-6, 0.0), lambda g: SIGN * each("nonlinear_viscous_nm", abs(MOTION.dq))(g)),
    ("asymmetric_coulomb", (0.1,), lambda g: g.half_difference_nm * SIGN**2),
    ("asymmetric_viscous", (0.05,), lambda g: g.half_difference_nms_per_rad * abs(MOTION.dq)),
    ("presliding", (0.4, 0.02, 1.0, 0.0), bristles),
    ("presliding", (0.4, 0.02, 1.5, 0.0), bristles),
    ("load_dependent_friction", (0.06, 0.0, 1.0, 0.0, 0.0), rubbing),
    ("load_dependent_friction", (0.006, 0.0, 2.0, 0.0, 0.0), rubbing),
    ("position_dependent_friction", (0.1, -0.05, 3.0, 0.2, 1e6), wavy),
    ("torque_ripple", (0.0, 0.1, 20.0), lambda g: -each("cogging_nm", MOTION.q)(g)),
    ("torque_ripple", (0.1, 0.0, 20.0), whole("ripple_reading_nm", MOTION.q)),
    ("gravity_error", (0.2, -0.1, *([0.0] * 14), 0.0), whole("gravity_error_nm", MOTION.q)),
    ("cable_spring", (0.4, 0.0, 0.0, 0.1, 0.0), lambda g: -each("cable_spring_nm", MOTION.q)(g)),
    ("cable_spring", (0.4, 0.0, 0.0, 0.1, 0.2), lambda g: -each("cable_spring_nm", MOTION.q)(g)),
    ("torque_bias", (-0.1,), lambda g: np.full(N, g.torque_nm)),
    ("time_delay", (0.02, 0.02, 0.0), lambda g: delayed(g.delay_s, REST, DT) - REST),
    ("torque_crosstalk", (0.08, 0.0, -1.0), crosstalk),
    ("torque_crosstalk", (0.05, 0.05, 0.0), crosstalk),
    ("inertia_error", (0.05,), lambda g: g.extra_kg_m2 * MOTION.ddq),
    ("friction_step", (0.1, 0.02, 1.0, 0.0), stepped),
    ("friction_step", (0.1, 0.02, 1.0, 0.5), stepped),
    ("unlogged_compensation", (0.15, 0.05, 0.0, 0.0), lambda g: -each("unlogged_nm", MOTION.dq)(g)),
    ("unlogged_compensation", (0.15, 0.05, 0.0, 1.0), lambda g: -each("unlogged_nm", MOTION.dq)(g)),
]

# Without an equal formula, or a torque only in a moving joint: compared in simulated logs (tests/simulation).
IN_LOGS = {"stiction", "frictional_lag", "joint_limit_stop", "torque_drift", "joint_elasticity", "backlash"} | {
    "inertial_coupling", "warm_up", "contact_event",
}  # fmt: skip


@pytest.mark.parametrize(("name", "values", "simulated"), CASES, ids=[case[0] for case in CASES])
def test_the_simulator_s_formula_is_the_column(
    name: str, values: tuple[float, ...], simulated: Callable[[Any], Float]
) -> None:
    term = FittedTerm(name, values)
    setting = Setting(joint=JOINT, start_rad=0.0, driven=False, duration_s=N * DT)
    group = HIDDEN[name].make(HIDDEN[name].from_parameters(term.numbers, setting))
    expected = term.torque(MOTION)
    scale = float(np.abs(expected).max())
    assert scale > 0.0
    assert_allclose(simulated(group), expected, atol=1e-6 * scale)


def test_every_effect_is_compared() -> None:
    assert {name for name, _, _ in CASES} | IN_LOGS == set(NAMES)
