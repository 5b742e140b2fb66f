"""Rest, sliding and bristles in the loop: by hand and against SciPy, at every step size."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp

from friction_audit.joint_log import Float
from friction_audit.simulation.bench import BenchSettings, Operator, build_mechanism, moved_by, rotor_inertia
from friction_audit.simulation.effects import Hidden, velocity
from friction_audit.simulation.mechanics.control_loop import run, set_masses
from friction_audit.simulation.mechanics.integrator import accelerate
from friction_audit.simulation.mechanics.records import Body, make_body
from friction_audit.simulation.settings import IDEAL_SENSORS, JointParameters, TrueMotion, make_streams

# The mechanics of one joint, released from anywhere and stepped as finely as wanted.

NEXT_TO_NOTHING = 1e-300  # stiffness, or damping, of a hand that has none; the operator's must be above zero
FRICTIONLESS = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.0, viscous_nms_per_rad=0.0)
STEP_S = 1e-4  # the step of the simulator


def bench(joint: JointParameters = FRICTIONLESS, hidden: Hidden | None = None, **hand: float) -> BenchSettings:
    """Return a bench with ideal sensors; a hand has no spring and no damper unless told."""
    without = {"stiffness_nm_per_rad": NEXT_TO_NOTHING, "damping_nms_per_rad": NEXT_TO_NOTHING}
    operator = replace(Operator(), **(without | hand))  # type: ignore[arg-type]
    return BenchSettings(joints=(joint,), hidden=(hidden or Hidden(),), sensors=(IDEAL_SENSORS,), operator=operator)


def release(
    settings: BenchSettings,
    duration_s: float,
    *,
    step_s: float = STEP_S,
    tick_s: float | None = None,
    push: Float | None = None,
    q: tuple[float, float] = (0.0, 0.0),
    dq: tuple[float, float] = (0.0, 0.0),
) -> TrueMotion:
    """Let go of a joint whose outer and inner side are at q with dq, under a push of the hand known at every tick."""
    tick_s = 2.0 * step_s if tick_s is None else tick_s
    ticks = round(duration_s / tick_s)
    mechanism = build_mechanism(settings, ticks, np.zeros(1), make_streams(0, 1))
    body, hand, inner = mechanism.body, settings.operator, mechanism.body.inner[0]
    set_masses(body, np.array([[hand.inertia_kg_m2]]), rotor_inertia(settings.joints, settings.hidden))
    body.stiffness[0, 0], body.drive_damping[0, 0] = hand.stiffness_nm_per_rad, hand.damping_nms_per_rad
    body.y[inner], body.v[inner], body.y[0], body.v[0] = q[1], dq[1], q[0], dq[0]
    if dq[1] != 0.0 and body.mode[inner] == 0.0:
        body.mode[inner] = np.sign(dq[1])
    mechanism = mechanism._replace(dt=tick_s, substeps=round(0.5 * tick_s / step_s))
    push = np.zeros(ticks + 1) if push is None else push
    run(mechanism, push, np.zeros(2), np.zeros((6, 1)), np.zeros(0), 0, ticks + 1)
    return replace(moved_by(mechanism, "any step").motion, t=np.arange(ticks + 1, dtype=np.float64) * tick_s)


# Rest is rest: where it begins, what it bears, when it ends.

TICK_S = 1e-3
JOINT = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.07)


def pushed(push: Float, hidden: Hidden | None = None, speed: float = 0.0) -> TrueMotion:
    """Push a joint, hand and all 0.6 kg m^2, by a torque and nothing else."""
    duration = (len(push) - 1) * TICK_S
    return release(bench(JOINT, hidden), duration, tick_s=TICK_S, push=push, dq=(speed, speed))


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize(
    ("hidden", "level"),
    [
        (Hidden(), {1.0: 0.3, -1.0: 0.3}),
        (Hidden(stiction=velocity.Stiction(excess_nm=0.2, form=velocity.IMMEDIATE)), {1.0: 0.5, -1.0: 0.5}),
        (Hidden(asymmetric_coulomb=velocity.AsymmetricCoulomb(half_difference_nm=0.1)), {1.0: 0.4, -1.0: 0.2}),
    ],
)
def test_break_away_at_the_level_and_not_before(hidden: Hidden, level: dict[float, float], direction: float) -> None:
    t = np.arange(2001, dtype=np.float64) * TICK_S
    motion = pushed(0.5 * direction * t, hidden)
    moving = motion.dq[:, 0] != 0.0
    assert_allclose(motion.t[moving][0], level[direction] / 0.5, atol=1.01 * TICK_S)
    assert moving[np.flatnonzero(moving)[0] :].all()
    assert_array_equal(motion.q[~moving], 0.0)
    assert_allclose(motion.friction_nm[~moving, 0], 0.5 * direction * motion.t[~moving], atol=1e-15)


def test_coasting_stops_for_good_where_it_must() -> None:
    """M dv = -(Fc + Fv v) dt: at rest after M/Fv ln(1 + Fv v/Fc), exactly, and without having turned."""
    motion = pushed(np.zeros(2001), speed=0.5)
    stop = 0.6 / 0.07 * np.log1p(0.07 * 0.5 / 0.3)
    q = 0.6 / 0.07 * (0.5 - 0.3 / 0.07 * np.log1p(0.07 * 0.5 / 0.3))
    rest = motion.t > stop + TICK_S
    assert_array_equal(motion.dq[rest], 0.0)
    assert_array_equal(np.diff(motion.q[rest], axis=0), 0.0)
    assert (motion.dq >= 0.0).all()
    assert_allclose(motion.q[-1, 0], q, rtol=1e-7)
    assert_allclose(motion.dissipated_j[-1, 0], 0.5 * 0.6 * 0.25, rtol=1e-12)


# Several coupled joints that break away at once: those that slide go the way that friction opposes.

JOINTS = 7
LEVEL_NM = np.array([0.3, 0.2, 0.4, 0.3, 0.35, 0.5, 0.3])


def stuck(rng: np.random.Generator) -> Body:
    """Return strongly coupled joints at rest, pulled about as hard as friction holds."""
    body = make_body(np.zeros(JOINTS, dtype=bool), np.zeros(JOINTS, dtype=bool), np.zeros(JOINTS))
    arms = rng.normal(size=(JOINTS, 3))
    body.mass[:JOINTS, :JOINTS] = arms @ arms.T + 0.05 * np.eye(JOINTS)
    body.force[:JOINTS] = LEVEL_NM * rng.normal(0.0, 1.5, JOINTS)
    body.hold[:JOINTS] = body.slip[:JOINTS] = LEVEL_NM[:, None]
    return body


@pytest.mark.parametrize("seed", range(20))
def test_friction_opposes_what_slides_and_bears_what_sticks(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(50):
        body = stuck(rng)
        accelerate(body, 0.0)
        mode, ddq = body.mode[:JOINTS], body.a[:JOINTS]
        left = body.force[:JOINTS] - body.mass[:JOINTS, :JOINTS] @ ddq
        assert (mode * ddq >= 0.0).all()
        assert_allclose(left[mode != 0.0], (mode * LEVEL_NM)[mode != 0.0], atol=1e-9)
        assert (np.abs(left) <= LEVEL_NM + 1e-9).all()
        assert (ddq[mode == 0.0] == 0.0).all()


# Energy and order of convergence: against solutions known by hand and against SciPy's, at every step size.

SPRING, MASS, REACH = 60.0, 0.6, 0.5
PULSATION = np.sqrt(SPRING / MASS)
DRY = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.0)
STEPS = (1e-3, 5e-4, 2.5e-4, STEP_S)


def orders(errors: list[float]) -> Float:
    return np.asarray(np.diff(np.log(errors)) / np.diff(np.log(STEPS)))


def coulomb_swing(t: Float) -> Float:
    """Return the position of a swing with Coulomb friction: half-turns about centres that change sides."""
    shift = DRY.coulomb_nm / SPRING
    half = np.floor(t * PULSATION / np.pi).astype(int)
    turns, direction = [REACH], 1.0
    while abs(turns[-1]) > shift:
        turns.append(2.0 * direction * shift - turns[-1])
        direction = -direction
    last = len(turns) - 1
    start = np.array(turns)[np.minimum(half, last)]
    centre = np.where(half < last, np.where(half % 2 == 0, shift, -shift), start)
    return np.asarray(centre + (start - centre) * np.cos(PULSATION * t - np.pi * np.minimum(half, last)))


def test_swing_with_coulomb_friction_turns_and_stops_as_by_hand() -> None:
    errors, balances = [], []
    for step in STEPS:
        settings = bench(DRY, stiffness_nm_per_rad=SPRING)  # a mass is let go on a hand's spring, drawn out by REACH
        motion = release(settings, 20.0, step_s=step, tick_s=2e-3, q=(REACH, REACH))
        errors.append(float(np.abs(motion.q[:, 0] - coulomb_swing(motion.t)).max()))
        total = (0.5 * MASS * motion.dq**2 + 0.5 * SPRING * motion.q**2 + motion.dissipated_j)[:, 0]
        balances.append(float(np.abs(total / total[0] - 1.0).max()))
        assert (np.diff(motion.dissipated_j[:, 0]) >= 0.0).all()
    assert_allclose(orders(errors), 2.0, atol=0.05)
    assert_allclose(orders(balances), 2.0, atol=0.05)
    assert errors[-1] < 1e-6
    assert balances[-1] < 3e-7
    assert (motion.dq[-1000:] == 0.0).all()


# velocity.Presliding while the joint moves: LuGre against SciPy, loops, steady motion.

FORMS = (velocity.LUGRE, velocity.DAHL, velocity.MAXWELL_SLIP)
BRISTLE_SPRING, DAMPER, CREEP = 10.0, 0.05, 0.05
SOFT = velocity.Presliding(displacement_rad=0.002, damping_s=0.02)


def published(t: Float) -> Float:
    """Return position and velocity after Canudas de Wit et al. (1995), shape (2, n), with sigma1 |v| below 4 g."""
    sigma0 = 0.3 / SOFT.displacement_rad
    sigma1 = SOFT.damping_s * sigma0

    def slope(now: float, state: Float) -> list[float]:
        q, v, z = state
        level = 0.3 + 0.3 * np.exp(-((v / 0.1) ** 2))
        rate = v - sigma0 * abs(v) / level * z
        damping = sigma1 / (1.0 + sigma1 * abs(v) / (4.0 * level))  # passive (Barabanov and Ortega 2000)
        pull = BRISTLE_SPRING * (CREEP * now - q) + DAMPER * (CREEP - v)
        return [v, (pull - sigma0 * z - damping * rate - 0.07 * v) / 0.6, rate]

    known = solve_ivp(slope, (0.0, t[-1]), [0.0] * 3, "LSODA", rtol=1e-9, atol=1e-12, t_eval=t, max_step=5e-3)
    return known.y[:2]


def test_stick_slip_of_lugre_follows_the_published_equations() -> None:
    """A soft spring pulls the joint slowly: it sticks and slips."""
    hidden = Hidden(presliding=SOFT, stribeck=velocity.Stribeck(excess_nm=0.3, speed_rad_s=0.1))
    push = BRISTLE_SPRING * CREEP * TICK_S * np.arange(6001, dtype=np.float64) + DAMPER * CREEP
    settings = bench(JOINT, hidden, stiffness_nm_per_rad=BRISTLE_SPRING, damping_nms_per_rad=DAMPER)
    motion = release(settings, 6.0, tick_s=TICK_S, push=push)
    q, v = published(motion.t)
    assert v.max() > 2.5 * CREEP
    assert np.sort(v)[len(v) // 4] < 0.2 * CREEP
    assert_allclose(motion.q[:, 0], q, atol=2e-8)
    assert_allclose(motion.dq[:, 0], v, atol=1e-7)


def guided(form: int, course: Float, speed: Float) -> TrueMotion:
    stiff = {"stiffness_nm_per_rad": 600.0, "damping_nms_per_rad": 60.0}
    hidden = Hidden(presliding=velocity.Presliding(displacement_rad=0.005, form=form))
    push = 600.0 * course + 60.0 * speed
    return release(bench(JOINT, hidden, **stiff), (len(push) - 1) * TICK_S, tick_s=TICK_S, push=push)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("reach", [0.001, 0.004, 0.05])
def test_closed_loops_take_energy_and_run_clockwise_about_the_spring(form: int, reach: float) -> None:
    """Once settled, friction takes the area of the loop: not below zero, at most the Coulomb level times the path.

    Of Maxwell-slip the area is known: every element that yields takes four times its torque times the way it slips.
    """
    omega = np.pi
    t = np.arange(12001) * TICK_S
    motion = guided(form, reach * (1.0 - np.cos(omega * t)), reach * omega * np.sin(omega * t))
    loop = slice(10000, 12001)
    moved = np.diff(motion.q[loop, 0])
    dry = (motion.friction_nm - 0.07 * motion.dq)[loop, 0]
    area = float(np.sum(0.5 * (dry[1:] + dry[:-1]) * moved))
    viscous = float(np.sum(0.07 * np.diff(motion.t[loop]) * motion.dq[loop][1:, 0] ** 2))
    assert -1e-12 < area <= 0.3 * np.abs(moved).sum()
    assert_allclose(motion.dissipated_j[12000, 0] - motion.dissipated_j[10000, 0], area + viscous, rtol=0.01, atol=1e-9)
    if form == velocity.MAXWELL_SLIP:
        slipped = np.maximum(
            np.ptp(motion.q[loop]) / 2.0 - 0.005 * velocity.FIRST_YIELD * np.arange(1, velocity.BRISTLES + 1), 0.0
        )
        assert_allclose(area, 4.0 * 0.3 / velocity.BRISTLES * slipped.sum(), rtol=1e-3, atol=1e-9)
    elif reach == 0.05:
        assert area > 0.85 * 0.3 * np.abs(moved).sum()
