"""Replay where the joint moves otherwise than recorded, fitted or of a file; steps and cycles of the hand by hand."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from friction_audit.compensation.competitors import NOT_RUNNABLE, make_feedforward, update_feedforward
from friction_audit.compensation.plant import tabulate_model
from friction_audit.compensation.records import initial_states
from friction_audit.compensation.result import dissipation_removed, find_step
from friction_audit.compensation.settings import Competitor, ModelFile, ReplaySettings, energy_compensator
from friction_audit.dynamics.motion import Motion
from friction_audit.effects.joint_model import ArmModel, FittedTerm, JointModel, simple_model
from friction_audit.effects.registry import terms
from friction_audit.joint_log import Float, JointLog
from friction_audit.reporting.notices import sentences, text_of
from friction_audit.simulation.bench import Operator
from friction_audit.simulation.hide import with_model
from friction_audit.simulation.scenarios import simulate
from friction_audit.simulation.settings import IDEAL_SENSORS, PANDA_SENSORS
from friction_audit.simulation.strokes import StopAndGo
from tests.compensation.bench import BENCH, BY_HAND, TRUE_HAND, log_of, replay
from tests.effects.joint_data_by_hand import typical_term

MINUTE = replace(BENCH, duration_s=60.0)
COMPENSATOR = energy_compensator()


@pytest.mark.parametrize("operator", [BY_HAND, Operator(motion=StopAndGo())], ids=["sinusoid", "stop and go"])
def test_the_same_operator_is_predicted(operator: Operator) -> None:
    """What the simulator makes of operator, joint and compensator, replay foretells from the log without one."""
    bench = replace(MINUTE, operator=operator)
    joint = replay(
        log_of(bench), ReplaySettings(assume="same-operator", operator=TRUE_HAND, compensator=COMPENSATOR)
    ).joints[0]
    happened: Any = log_of(replace(bench, compensator=COMPENSATOR))
    assert joint.model_error < 1e-3
    np.testing.assert_allclose(joint.replayed.dq, happened.dq[:, 0], atol=5e-3)
    np.testing.assert_allclose(joint.replayed.compensation_nm, happened.tau_compensation[:, 0], atol=0.03)
    assert joint.numbers.dissipation_removed_updated > 0.99


def test_the_operator_is_fitted_from_quick_reversals() -> None:
    noisy = replace(MINUTE, sensors=(PANDA_SENSORS[0],), duration_s=120.0)
    for log, bound in ((log_of(replace(MINUTE, duration_s=120.0)), 0.08), (log_of(noisy), 0.2)):
        joint = replay(log, ReplaySettings(assume="same-operator", compensator=COMPENSATOR)).joints[0]
        hand = joint.operator
        assert hand.reversals >= 20
        assert hand.inertia.value == pytest.approx(0.3, rel=bound)
        assert hand.damping.value == pytest.approx(9.0, rel=bound)
        assert hand.stiffness.value == pytest.approx(60.0, rel=bound)
        for number, truth in ((hand.inertia, 0.3), (hand.damping, 9.0), (hand.stiffness, 60.0)):
            assert number.low < truth < number.high


def test_a_person_who_pauses_cannot_be_fitted() -> None:
    log = log_of(replace(MINUTE, operator=Operator(motion=StopAndGo())))
    found = replay(log, ReplaySettings(assume="same-operator"))
    assert "quick reversals" in text_of(found.joints[0].reason)
    assert "--operator" in text_of(found.joints[0].reason)
    assert [caution.code for caution in found.warnings] == ["not_replayed"]


def test_the_same_torque_moves_a_compensated_joint_farther() -> None:
    joint = replay(log_of(MINUTE), ReplaySettings(assume="same-torque", compensator=COMPENSATOR)).joints[0]
    history, replayed = joint.history, joint.replayed
    assert joint.fitted.inertia.value == pytest.approx(0.3, rel=0.01)
    assert joint.model_error < 1e-3
    np.testing.assert_allclose(replayed.interaction_nm, joint.without.interaction_nm, atol=1e-9)
    assert np.abs(replayed.dq[20000:]).mean() > 1.2 * np.abs(joint.without.dq[20000:]).mean()
    # The ridge starts from no friction; two updates later it has the split.
    np.testing.assert_allclose(history.coulomb_estimated_nm[5:], 0.3, rtol=0.03)
    np.testing.assert_allclose(history.viscous_estimated_nms_per_rad[5:], 0.07, rtol=0.1)


@pytest.mark.parametrize("assume", ["same-motion", "same-torque"])
def test_a_jump_of_the_clock_adds_no_energy_and_no_steps(assume: str) -> None:
    log, settings = log_of(MINUTE), ReplaySettings(assume=assume, compensator=COMPENSATOR)
    jumped = replace(log, t=log.t + 1e6 * (log.t > 0.5 * log.t[-1]))
    (one,), (other,) = replay(log, settings).joints, replay(jumped, settings).joints
    assert other.numbers.energy_without_j == pytest.approx(one.numbers.energy_without_j, rel=0.05)
    assert other.numbers.energy_with_j == pytest.approx(one.numbers.energy_with_j, rel=0.1)
    assert other.passivity.violations == 0


def test_a_competitor_that_diverges_is_cut_there_and_said_so() -> None:
    competitor = Competitor(name="torque_regulation", desired_inertia_kg_m2=0.02)
    found = replay(log_of(MINUTE), ReplaySettings(assume="same-operator", operator=TRUE_HAND, competitor=competitor))
    joint = found.joints[0]
    assert 0.0 < joint.numbers.diverged_s < 60.0
    assert joint.replayed.t[-1] < joint.numbers.diverged_s
    assert np.isfinite(joint.replayed.dq).all()
    assert "diverged" in {caution.code for caution in found.warnings}


@pytest.mark.parametrize("name", ["fixed", "sigmoid", "lugre", "disturbance_observer", "torque_regulation"])
def test_competitors_are_tuned_from_the_log(name: str) -> None:
    settings = ReplaySettings(assume="same-operator", operator=TRUE_HAND, competitor=Competitor(name=name))
    joint = replay(log_of(MINUTE), settings).joints[0]
    assert np.isnan(joint.numbers.diverged_s)
    assert joint.numbers.dissipation_removed > (0.4 if name == "torque_regulation" else 0.8)


def test_an_inertia_that_the_log_does_not_tell_is_refused() -> None:
    log: Any = log_of(MINUTE)
    ddq = np.gradient(log.dq[:, 0], log.t)
    massless = replace(log, tau_interaction=log.tau_interaction - 0.3 * ddq[:, None])
    joint = replay(massless, ReplaySettings(assume="same-torque")).joints[0]
    assert "inertia is not determined" in text_of(joint.reason)


# Parts of a replay by hand.


def test_what_is_given_out_counts_as_left_over() -> None:
    assert dissipation_removed(np.array([1.0, 1.0, 2.0]), np.array([1.0, -0.5, 0.5])) == pytest.approx(0.5)
    assert dissipation_removed(1.0, -0.5) == pytest.approx(0.5)
    assert np.isnan(dissipation_removed(np.zeros(0), np.zeros(0)))
    assert np.isnan(dissipation_removed(-1.0, 0.0))


def cycles(after: float, at: int, count: int = 24) -> tuple[Float, Float, Float]:
    """Return path, squared speed and friction of strokes at changing speed, of which friction changes at one."""
    path = 0.5 + 0.2 * np.sin(np.arange(count))
    speed = 0.8 + 0.3 * np.cos(2.0 * np.arange(count))
    factor = np.where(np.arange(count) < at, 1.0, after)
    return path, path * speed, factor * path * (0.3 + 0.1 * speed)


def test_neither_speed_nor_noise_nor_warming_up_is_a_step() -> None:
    rng = np.random.default_rng(2)
    path, square, friction = cycles(1.0, 10)
    assert find_step(path, square, friction) is None
    for _ in range(20):
        assert find_step(path, square, friction * (1.0 + 0.2 * rng.standard_normal(len(path)))) is None
    assert find_step(path, square, friction * np.linspace(2.0, 1.0, len(path))) is None
    assert find_step(path[:5], square[:5], friction[:5]) is None
    assert find_step(0.0 * path, square, friction) is None
    assert find_step(np.ones(8), np.full(8, 2.0), np.ones(8)) is None


# With a model file: its joint moves otherwise than recorded, or its friction is applied.

SIMPLE = simple_model(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07)


def and_term(name: str, *values: float) -> JointModel:
    return replace(SIMPLE, terms=(*SIMPLE.terms, FittedTerm(name, values)))


def file_of(*joints: JointModel | None) -> ModelFile:
    names = tuple(f"joint{number}" for number in range(1, len(joints) + 1))
    return ModelFile(path="model.toml", model=ArmModel(names=names, joints=joints))


@cache
def log_by(model: JointModel, *, noisy: bool = False) -> JointLog:
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


def assert_same(one: Any, other: Any, tolerance: float) -> None:
    for name in ("dq", "interaction_nm", "compensation_nm"):
        np.testing.assert_allclose(getattr(one.replayed, name), getattr(other.replayed, name), atol=tolerance)
    np.testing.assert_allclose(one.history.friction_j, other.history.friction_j, atol=tolerance)


@pytest.mark.parametrize("assume", ["same-torque", "same-operator"])
def test_a_file_with_the_fitted_numbers_gives_the_very_same_replay(assume: str) -> None:
    log = log_by(SIMPLE, noisy=True)
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
    joint = run(log_by(model), "same-operator", model, applied=True)
    assert joint.model_error < 1e-3
    # By cycles, from rest to rest: the spring of some models holds energy where the log ends.
    assert dissipation_removed(joint.history.friction_j, joint.history.net_energy_j) > 0.999


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
    state, feed = initial_states(1), make_feedforward(terms, motion)
    update_feedforward(state[0], feed, 0.05, speed, 10)
    expected = 0.3 * np.sign(speed) + 0.1 + 0.07 * speed
    assert float(state["modelled_nm"][0]) == pytest.approx(np.sign(speed) * expected if speed else 0.4, abs=1e-6)
    assert float(state["bristle_nm"][0]) == 0.0


def test_every_term_runs_or_is_refused_by_name() -> None:
    log, firm = log_by(SIMPLE), simple_model(inertia_kg_m2=1.0, coulomb_nm=3.0, viscous_nms_per_rad=1.0)
    q, dq = np.ascontiguousarray(log.q[:, 0]), log.dq[:, 0]
    motion = Motion(t=log.t, q=q, dq=dq, ddq=np.gradient(dq, log.t))
    plain = {"gravity_error": (0.3, 0.1, *[0.0] * 15), "warm_up": (0.1, 0.02, 30.0, 0.0)}  # not of the arm or the air
    for term in terms():
        if term.name not in {*NOT_RUNNABLE, "inertia"}:
            one = FittedTerm(term.name, plain[term.name]) if term.name in plain else typical_term(term)
            kept = tuple(own for own in firm.terms if own.name != term.name)
            assert tabulate_model(replace(firm, terms=(*kept, one)), motion).inertia_kg_m2 >= 1.0


@pytest.mark.parametrize("name", sorted(NOT_RUNNABLE))
def test_a_term_that_cannot_run_is_refused_by_name(name: str) -> None:
    term = next(term for term in terms() if term.name == name)
    model = and_term(name, *(min(max(0.01, parameter.lower), parameter.upper) for parameter in term.parameters))
    joint = run(log_by(SIMPLE), "same-torque", model)
    assert joint.numbers is None
    why = f"{name}: {sentences()['not_in_loop'][NOT_RUNNABLE[name]]}"
    assert why in text_of(joint.reason)
    of_friction = {"stiction", "frictional_lag", "load_dependent_friction"}
    applied = run(log_by(SIMPLE), "same-motion", model, applied=True)
    assert (why in text_of(applied.reason)) == (name in of_friction)


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
    joint = run(log_by(SIMPLE), "same-motion" if applied else "same-torque", model, applied=applied)
    assert joint.numbers is None
    assert message in text_of(joint.reason)
