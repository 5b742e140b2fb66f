"""Replay with a model file: its joint moves otherwise than recorded, or its friction is applied."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from friction_audit.compensation.competitors import JointModelCompensation
from friction_audit.compensation.counterfactual import tables_of_file
from friction_audit.compensation.feed_forward import UNABLE, feed_friction, feed_of
from friction_audit.compensation.records import fresh_memory
from friction_audit.compensation.result import dissipation_removed
from friction_audit.compensation.settings import Competitor, ModelFile, ReplaySettings
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel, simple_model
from friction_audit.effects.registry import terms
from friction_audit.errors import UsageError
from friction_audit.joint_log import JointLog
from friction_audit.simulation.hide import with_model
from friction_audit.simulation.scenarios import simulate
from friction_audit.simulation.settings import IDEAL_SENSORS, PANDA_SENSORS
from tests.compensation.bench import BENCH, TRUE_HAND, replay
from tests.effects.joint_data_by_hand import typical_term

SIMPLE = simple_model(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07)


def and_term(name: str, *values: float) -> JointModel:
    return replace(SIMPLE, terms=(*SIMPLE.terms, FittedTerm(name, values)))


def file_of(*joints: JointModel | None) -> ModelFile:
    names = tuple(f"joint{number}" for number in range(1, len(joints) + 1))
    return ModelFile(path="model.toml", model=ArmModel(names=names, joints=joints))


@cache
def log_of(model: JointModel, *, noisy: bool = False) -> JointLog:
    bench = replace(BENCH, duration_s=40.0, sensors=(PANDA_SENSORS[0] if noisy else IDEAL_SENSORS,))
    return simulate(with_model(bench, file_of(model).model), 1).log


def run(log: JointLog, assume: str, model: JointModel | None, *, applied: bool = False) -> Any:
    settings = ReplaySettings(
        assume=assume,
        operator=TRUE_HAND if assume == "same-operator" else None,
        joint_model=file_of(model),
        competitor=Competitor(name="model") if applied else None,
    )
    return replay(log, settings).joints[0]


def motion_of(log: JointLog) -> Motion:
    q, dq = log.q[:, 0], log.dq[:, 0]
    return Motion(t=log.t, q=np.ascontiguousarray(q), dq=dq, ddq=np.gradient(dq, log.t))


def assert_same(one: Any, other: Any, tolerance: float) -> None:
    for name in ("dq", "interaction_nm", "compensation_nm"):
        np.testing.assert_allclose(getattr(one.replayed, name), getattr(other.replayed, name), atol=tolerance)
    np.testing.assert_allclose(one.history.friction_j, other.history.friction_j, atol=tolerance)


@pytest.mark.parametrize("assume", ["same-torque", "same-operator"])
def test_a_file_with_the_fitted_numbers_gives_the_very_same_replay(assume: str) -> None:
    log = log_of(SIMPLE, noisy=True)
    settings = ReplaySettings(assume=assume, operator=TRUE_HAND if assume == "same-operator" else None)
    fitted = replay(log, settings).joints[0]
    found = fitted.fitted
    model = simple_model(
        inertia_kg_m2=found.inertia.value, coulomb_nm=found.coulomb.value, viscous_nms_per_rad=found.viscous.value
    )
    given = run(log, assume, model)
    assert given.fitted is None
    assert given.simulated
    assert given.model == model
    assert given.model_error == pytest.approx(fitted.model_error, rel=1e-9)
    assert_same(given, fitted, 1e-9)


@pytest.mark.parametrize(
    "model",
    [
        and_term("stribeck", 0.15, 0.1, 1.5),
        and_term("presliding", 0.3, 0.004, 1.0, 0.005),
        and_term("cable_spring", 0.4, 0.0, 0.0, 0.3, 0.0),
    ],
)
def test_the_joint_of_the_file_moves_as_the_recorded_one_did(model: JointModel) -> None:
    """Without a compensator the true model gives the recording again; the simple one fitted to it does not."""
    joint = run(log_of(model), "same-operator", model, applied=True)
    assert joint.model_error < 1e-3
    # By cycles, from rest to rest: the spring of some models holds energy where the log ends.
    assert dissipation_removed(joint.history) > 0.999


@pytest.mark.parametrize("speed", [-0.5, -0.03, -0.005, 0.0, 0.02, 0.4])
def test_what_is_applied_is_the_friction_by_hand(speed: float) -> None:
    """Coulomb 0.3 N m, 0.1 N m more forwards, viscous 0.07 N m s/rad, beyond 0.01 rad/s rising over 0.03 rad/s."""
    terms = (*SIMPLE.terms, FittedTerm("asymmetric_coulomb", (0.1,)))
    n = 1000
    motion = Motion(
        t=np.asarray(np.arange(n) * 1e-3, np.float64),
        q=np.linspace(0, 0.1, n),
        dq=np.linspace(-1, 1, n),
        ddq=np.zeros(n),
    )
    memory, feed = fresh_memory(1), feed_of(terms, motion)
    feed_friction(memory[0], feed, 0.05, speed, 10)
    expected = 0.3 * np.sign(speed) + 0.1 + 0.07 * speed
    assert float(memory["modelled_nm"][0]) == pytest.approx(np.sign(speed) * expected if speed else 0.4, abs=1e-6)
    assert float(memory["bristle_nm"][0]) == 0.0


def test_every_term_runs_or_is_refused_by_name() -> None:
    motion, firm = motion_of(log_of(SIMPLE)), simple_model(inertia_kg_m2=1.0, coulomb_nm=3.0, viscous_nms_per_rad=1.0)
    plain = {"gravity_error": (0.3, 0.1, *[0.0] * 15), "warm_up": (0.1, 0.02, 30.0, 0.0)}  # not of the arm or the air
    for term in terms():
        if term.name not in {*UNABLE, "inertia"}:
            one = FittedTerm(term.name, plain[term.name]) if term.name in plain else typical_term(term)
            kept = tuple(own for own in firm.terms if own.name != term.name)
            assert tables_of_file(replace(firm, terms=(*kept, one)), motion).inertia_kg_m2 >= 1.0


@pytest.mark.parametrize("name", sorted(UNABLE))
def test_a_term_that_cannot_run_is_refused_by_name(name: str) -> None:
    term = next(term for term in terms() if term.name == name)
    model = and_term(name, *(min(max(0.01, parameter.lower), parameter.upper) for parameter in term.parameters))
    joint = run(log_of(SIMPLE), "same-torque", model)
    assert joint.numbers is None
    assert f"{name}: {UNABLE[name]}" in joint.reason
    of_friction = {"stiction", "frictional_lag", "load_dependent_friction"}
    applied = run(log_of(SIMPLE), "same-motion", model, applied=True)
    assert (f"{name}: {UNABLE[name]}" in applied.reason) == (name in of_friction)


@pytest.mark.parametrize(
    ("applied", "model", "message"),
    [
        (False, None, "no model of it"),
        (False, replace(SIMPLE, inertia_kg_m2=-0.001), "an inertia of -0.001"),
        (False, replace(and_term("torque_ripple", 0.0, 0.08, 40.0), inertia_kg_m2=0.0), "an inertia of 0 "),
        (False, and_term("asymmetric_coulomb", 0.5), "friction pushes"),
        (False, and_term("gravity_error", *(0.0,) * 5, 1.0, *(0.0,) * 10, 2.0), "gravity_error: it needs the model of"),
        (False, and_term("warm_up", 0.1, 0.0, 30.0, 0.01), "warm_up: it needs the temperature"),
        (True, None, "no model of it"),
        (True, JointModel(inertia_kg_m2=0.3), "no term of friction"),
        # Longer than the strokes of the recording: it had ended the replay of all joints.
        (True, and_term("presliding", 0.3, 0.5, 1.0, 0.0), "presliding: along this recording"),
    ],
)
def test_a_joint_that_cannot_be_simulated_or_has_no_friction_to_apply_says_why(
    applied: bool, model: JointModel | None, message: str
) -> None:
    joint = run(log_of(SIMPLE), "same-motion" if applied else "same-torque", model, applied=applied)
    assert joint.numbers is None
    assert message in joint.reason


def test_models_that_do_not_fit_are_refused() -> None:
    with pytest.raises(UsageError, match="1 joints, and the log has a joint 2"):
        file_of(SIMPLE).joint(2)
    with pytest.raises(UsageError, match="no term of friction"):
        JointModelCompensation(terms=())
