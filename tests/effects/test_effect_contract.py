"""What holds for every effect of the registry; the simulator's formula of each is the detector's column."""

import functools
import re
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from friction_audit.dynamics.motion import Motion, Others
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.effects.registry import NAMES, PART_OF, effect_of, effects, motion_between, same_as, terms
from friction_audit.joint_log import Float
from friction_audit.simulation.effects import EFFECTS, velocity
from friction_audit.simulation.effects.effect import Setting
from friction_audit.simulation.effects.sensors import delayed
from friction_audit.simulation.mechanics.records import pack
from friction_audit.simulation.settings import JointParameters
from tests.effects.joint_data_by_hand import at_rest, baseline, sines, started_and_stopped, two_sines

ODD = {"stribeck", "stiction", "nonlinear_viscous", "presliding", "frictional_lag", "load_dependent_friction"} | {
    "position_dependent_friction", "backlash", "warm_up", "friction_step", "unlogged_compensation",
    "asymmetric_coulomb", "asymmetric_viscous", "inertia_error", "joint_elasticity", "time_delay",
}  # fmt: skip
AXES = {"speed", "position", "displacement", "time", "acceleration", "load", "neighbour"}
MOST_FIELDS = 10
# What some effects have of their own.
OF_SOME = {"needs_nominal", "misses", "like_gravity", "screened", "follows", "transmits", "recorder"}
MOST_POINTS = 300  # a search tries all of them on every joint
MOVING = two_sines(32.0)
NOMINAL = baseline(MOVING)
STATED = replace(NOMINAL, declared=frozenset({"inertia_kg_m2", "coulomb_nm", "viscous_nms_per_rad"}))
each = pytest.mark.parametrize("effect", effects(), ids=lambda effect: effect.name)
with_formula = pytest.mark.parametrize("effect", [e for e in effects() if e.coefficients], ids=lambda e: e.name)


def test_effects_are_registered_under_their_names_and_small() -> None:
    assert tuple(effect.name for effect in effects()) == NAMES
    assert len(Effect.__annotations__.keys() - OF_SOME) <= MOST_FIELDS


def test_names_of_terms_and_parameters_are_unique() -> None:
    every = [parameter for term in terms() for parameter in term.parameters]
    assert len({parameter.name for parameter in every}) == len(set(every))  # far_share is one parameter of two effects
    assert len({term.name for term in terms()}) == len(terms())


@each
def test_words_and_relations(effect: Effect) -> None:
    assert effect.axis in AXES
    assert effect.label
    assert effect.record[0].islower()
    wholes = PART_OF.get(effect.name, ())
    for other in same_as(effect.name) - {effect.name}:
        assert PART_OF.get(other, ()) == wholes
    for other in (same_as(effect.name) - {effect.name}).union(wholes):
        assert other in effect.separate or effect.name in effect_of(other).separate
    assert set(effect.separate) <= set(NAMES) - {effect.name}
    assert not any(effect.name in effect_of(other).separate for other in effect.separate)  # each pair stands once


def test_any_two_effects_have_a_motion_that_separates_them_in_either_order() -> None:
    for one, other in combinations(NAMES, 2):
        motion = motion_between(one, other)
        assert motion[0].islower()
        assert set(motion.split("; ")) == set(motion_between(other, one).split("; "))


@each
def test_the_grid_is_small_distinct_and_holds_the_identifiable_part(effect: Effect) -> None:
    for data in (MOVING, started_and_stopped(starts=8)):
        grid = effect.grid(data)
        assert len(grid) <= MOST_POINTS
        assert grid or data is not MOVING  # a joint without neighbours has none of theirs
        assert len({tuple(sorted(at.items())) for at in grid}) == len(grid)
        assert all(at in grid for at in effect.identifiable_part(data))


@with_formula
def test_the_grid_is_within_bounds_and_complete(effect: Effect) -> None:
    needed = {parameter.name for parameter in effect.nonlinear if not parameter.optional}
    for at in effect.grid(MOVING):
        assert not at or needed <= set(at)  # an empty point has columns of its own
        assert all(one.allows(at.get(one.name, one.default)) for one in effect.nonlinear if at)


@with_formula
def test_columns_are_finite_and_never_read_the_measured_torque(effect: Effect) -> None:
    other = replace(MOVING, torque=MOVING.torque + 1.0)
    grid = effect.grid(MOVING)
    together: dict[int, Float] = {}
    for places, rows in effect.regressors_of(MOVING, [NOMINAL] * len(grid), grid, np.transpose):
        together |= dict(zip(places, rows.reshape(len(places), -1, len(MOVING.t)), strict=True))
    for place, at in enumerate(grid):
        columns = effect.regressor(MOVING, NOMINAL, at)
        assert columns.shape[0] == len(MOVING.t)
        assert columns.shape[1] <= len(effect.coefficients)
        assert np.all(np.isfinite(columns))
        assert_array_equal(columns, effect.regressor(other, NOMINAL, at))
        np.testing.assert_allclose(together[place].T, columns, atol=1e-9)


# A spring that stiffens does so by the size of the torque on it.
@pytest.mark.parametrize("effect", [e for e in effects() if e.name != "joint_elasticity"], ids=lambda e: e.name)
def test_no_grid_reads_the_measured_torque(effect: Effect) -> None:
    other = replace(MOVING, torque=np.cumsum(MOVING.torque))
    assert effect.grid(other) == effect.grid(MOVING)
    assert effect.not_identifiable(other, NOMINAL) == effect.not_identifiable(MOVING, NOMINAL)


@each
def test_a_joint_at_rest_lacks_a_motion_and_has_no_friction(effect: Effect) -> None:
    rest = at_rest()
    for at in effect.grid(rest) if effect.coefficients else ():
        columns = effect.regressor(rest, baseline(rest), at)
        assert np.all(np.isfinite(columns))
        assert not (effect.name in ODD and columns.any())
    rest = replace(rest, others=replace(rest.others, dq=np.zeros_like(rest.others.dq)))
    assert effect.not_identifiable(rest, baseline(rest)) is not None


@with_formula
def test_what_is_admissible_a_model_can_hold(effect: Effect) -> None:
    rng = np.random.default_rng(0)
    for at in effect.grid(MOVING)[:5]:
        for coefficients in rng.normal(scale=0.02, size=(50, len(effect.coefficients))):
            if effect.possible(coefficients, at):
                assert all(c.allows(float(v)) for c, v in zip(effect.coefficients, coefficients, strict=True))


def test_stated_numbers_make_what_needs_them_identifiable() -> None:
    for name in ("inertia_error", "unlogged_compensation"):
        assert "fitted" in repr(effect_of(name).not_identifiable(MOVING, NOMINAL))
        assert effect_of(name).not_identifiable(MOVING, STATED) is None
    for link in ("joint_elasticity", "backlash"):
        assert "no_inertia" in repr(effect_of(link).not_identifiable(MOVING, replace(NOMINAL, inertia_kg_m2=-0.01)))


# The name of an effect stands in the lines of the two registries; its classes have it.

SOURCE = Path(__file__).parents[2] / "src" / "friction_audit"
# Where the simulator applies what an effect does: compiled code calls each by its name.
APPLIED = ("simulation/mechanics/", "simulation/bench.py", "simulation/sensors.py")
# Other files: examples of the help, scenarios, a caution of the same name and its sentence, and parts of the program
# that treat one effect in a way of its own.
ELSEWHERE = {
    "stribeck": 2, "stiction": 1, "nonlinear_viscous": 2, "asymmetric_coulomb": 2, "asymmetric_viscous": 1,
    "presliding": 2,
    "frictional_lag": 2, "load_dependent_friction": 1, "torque_ripple": 2, "gravity_error": 5, "torque_bias": 2,
    "torque_drift": 1, "time_delay": 2, "torque_crosstalk": 2, "joint_elasticity": 4, "backlash": 3,
    "inertial_coupling": 2, "warm_up": 1, "friction_step": 4, "contact_event": 7, "unlogged_compensation": 2,
}  # fmt: skip


@functools.cache
def written() -> dict[str, set[str]]:
    """Return the files in which each name is a string, an import or a field; the word may be the field's too."""
    any_of = f"({'|'.join(NAMES)})"
    name = re.compile(rf'"{any_of}[":]|\.{any_of}\b|import {any_of}\b|^    {any_of}: (?:\w+\.)?[A-Z]', re.MULTILINE)
    found: dict[str, set[str]] = {}
    for path in SOURCE.rglob("*.py"):
        for match in name.finditer(path.read_text()):
            found.setdefault(match[match.lastindex or 0], set()).add(path.relative_to(SOURCE).as_posix())
    return found


@pytest.mark.parametrize("name", NAMES)
def test_an_effect_stands_in_one_line_of_either_registry(name: str) -> None:
    own = {"effects/registry.py", "simulation/effects/__init__.py"}
    # In modules of other effects it is the other side of a pair that is easily confused.
    assert own <= written()[name]
    elsewhere = (path for path in written()[name] - own if not path.startswith(("effects/", "simulation/effects/")))
    others = sorted(path for path in elsewhere if not path.startswith(APPLIED))
    assert len(others) <= ELSEWHERE.get(name, 0), others


# The simulator's formula of every effect against the detector's columns, at random states of a joint.

JOINT = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.4, viscous_nms_per_rad=0.1)
DT, N = 4e-3, 500
HIDDEN = {effect.name: effect for effect in EFFECTS}


def states() -> Motion:
    """Random smooth states of a joint among three."""
    rng = np.random.default_rng(7)
    t = np.arange(N, dtype=np.float64) * DT
    q, dq, ddq = sines(t, *rng.uniform([0.1, 1.0, 0.0], [0.4, 9.0, 6.0], (4, 3)).tolist())
    moved = {"q": np.zeros((N, 3)), "dq": rng.normal(size=(N, 3)), "ddq": rng.normal(size=(N, 3))}
    others = Others(joint=1, **moved, sensed=rng.normal(scale=5.0, size=(N, 3)))
    rest = 0.3 * ddq + 0.4 * np.sign(dq) + 0.1 * dq
    return Motion(t=t, q=q, dq=dq, ddq=ddq, load=rng.normal(scale=8.0, size=N), rest=rest, others=others)


MOTION = states()
assert MOTION.others is not None
SIGN, REST, SENSED = np.sign(MOTION.dq), np.asarray(MOTION.rest), MOTION.others.sensed
LOAD = np.asarray(MOTION.load) + REST


def law_of(function: str) -> Any:
    modules = (import_module(effect.__module__) for effect in EFFECTS)
    return next(getattr(module, function) for module in modules if hasattr(module, function))


def by_sample(function: str, *signals: Float) -> Callable[[Any], Float]:
    """A law of the simulator, sample by sample; as Python, for to compile by_sample by itself takes seconds."""
    law: Callable[..., Any] = law_of(function).py_func
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
    shares = [by_sample("friction_step_factor", ratio, MOTION.t, np.full(N, N * DT))(group) - 1.0 for ratio in ratios]
    return JOINT.coulomb_nm * SIGN * shares[0] + JOINT.viscous_nms_per_rad * MOTION.dq * shares[1]


def rubbing(group: Any) -> Float:
    return SIGN * by_sample("load_friction_nm", LOAD, LOAD * MOTION.dq)(group)


def wavy(group: Any) -> Float:
    return 0.4 * SIGN * (by_sample("position_factor", MOTION.q)(group) - 1.0)


def crosstalk(group: Any) -> Float:
    none = type(group)()
    return np.asarray(whole("crosstalk_mixed", SENSED)([none, group, none])[:, 1] - SENSED[:, 1])


# Effect, parameters of the term, torque that the simulator's formula takes: F_m with the effect less F_m without it.
CASES: list[tuple[str, tuple[float, ...], Callable[[Any], Float]]] = [
    ("stribeck", (0.2, 0.3, 1.5), lambda g: SIGN * by_sample("stribeck_nm", abs(MOTION.dq))(g)),
    ("nonlinear_viscous", (0.2, 1.7, 1e-6, 0.0), lambda g: SIGN * by_sample("nonlinear_viscous_nm", abs(MOTION.dq))(g)),
    ("asymmetric_coulomb", (0.1,), lambda g: g.half_difference_nm * SIGN**2),
    ("asymmetric_viscous", (0.05,), lambda g: g.half_difference_nms_per_rad * abs(MOTION.dq)),
    ("presliding", (0.4, 0.02, 1.0, 0.0), bristles),
    ("presliding", (0.4, 0.02, 1.5, 0.0), bristles),
    ("load_dependent_friction", (0.06, 0.0, 1.0, 0.0, 0.0), rubbing),
    ("load_dependent_friction", (0.006, 0.0, 2.0, 0.0, 0.0), rubbing),
    ("position_dependent_friction", (0.1, -0.05, 3.0, 0.2, 1e6), wavy),
    ("torque_ripple", (0.0, 0.1, 20.0), lambda g: -by_sample("cogging_nm", MOTION.q)(g)),
    ("torque_ripple", (0.1, 0.0, 20.0), whole("ripple_reading_nm", MOTION.q)),
    ("gravity_error", (0.2, -0.1, *([0.0] * 14), 0.0), whole("gravity_error_nm", MOTION.q)),
    ("cable_spring", (0.4, 0.0, 0.0, 0.1, 0.0), lambda g: -by_sample("cable_spring_nm", MOTION.q)(g)),
    ("cable_spring", (0.4, 0.0, 0.0, 0.1, 0.2), lambda g: -by_sample("cable_spring_nm", MOTION.q)(g)),
    ("torque_bias", (-0.1,), lambda g: np.full(N, g.torque_nm)),
    ("time_delay", (0.02, 0.02, 0.0), lambda g: delayed(g.delay_s, REST, DT) - REST),
    ("torque_crosstalk", (0.08, 0.0, -1.0), crosstalk),
    ("torque_crosstalk", (0.05, 0.05, 0.0), crosstalk),
    ("inertia_error", (0.05,), lambda g: g.extra_kg_m2 * MOTION.ddq),
    ("friction_step", (0.1, 0.02, 1.0, 0.0), stepped),
    ("friction_step", (0.1, 0.02, 1.0, 0.5), stepped),
    ("unlogged_compensation", (0.15, 0.05, 0.0, 0.0), lambda g: -by_sample("unlogged_nm", MOTION.dq)(g)),
    ("unlogged_compensation", (0.15, 0.05, 0.0, 1.0), lambda g: -by_sample("unlogged_nm", MOTION.dq)(g)),
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
