"""Energy and order of convergence: against solutions known by hand and against SciPy's, at every step size."""

import numpy as np
from numpy.testing import assert_allclose

from friction_audit.joint_log import Float
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.effects.velocity import IMMEDIATE, Stiction, Stribeck
from friction_audit.simulation.settings import JointParameters
from friction_audit.simulation.simulation import TrueMotion
from tests.simulation.mechanics.any_step import STEP_S, bench, release
from tests.simulation.mechanics.stick_slip import Course, DryMass, solve

SPRING, MASS, REACH = 60.0, 0.6, 0.5
PULSATION = np.sqrt(SPRING / MASS)
DRY = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=0.0)
STEPS = (1e-3, 5e-4, 2.5e-4, STEP_S)


def orders(errors: list[float]) -> Float:
    """Return the orders of convergence between the successive steps."""
    return np.asarray(np.diff(np.log(errors)) / np.diff(np.log(STEPS)))


def swing(step_s: float, duration_s: float, joint: JointParameters | None = None) -> TrueMotion:
    """Let a mass go on a hand's spring, drawn out by REACH."""
    settings = bench(joint, stiffness_nm_per_rad=SPRING) if joint else bench(stiffness_nm_per_rad=SPRING)
    return release(settings, duration_s, step_s=step_s, tick_s=2e-3, q=(REACH, REACH))


def stored(motion: TrueMotion) -> Float:
    """Return kinetic and elastic energy."""
    return np.asarray((0.5 * MASS * motion.dq**2 + 0.5 * SPRING * motion.q**2)[:, 0])


def test_energy_of_a_frictionless_swing_is_of_order_two() -> None:
    """The leapfrog's energy swings by (w h)^2 / 4 of itself."""
    errors = []
    for step in STEPS:
        energy = stored(swing(step, 5.0))
        errors.append(float(np.abs(energy / energy[0] - 1.0).max()))
        assert_allclose(errors[-1], (PULSATION * step) ** 2 / 4.0, rtol=0.01)
    assert_allclose(orders(errors), 2.0, atol=0.01)


def coulomb_swing(t: Float) -> Float:
    """Return the position of a swing with Coulomb friction: half-turns about centres that change sides."""
    shift = DRY.coulomb_nm / SPRING
    half = np.floor(t * PULSATION / np.pi).astype(int)
    turns, way = [REACH], 1.0
    while abs(turns[-1]) > shift:
        turns.append(2.0 * way * shift - turns[-1])
        way = -way
    last = len(turns) - 1
    start = np.array(turns)[np.minimum(half, last)]
    centre = np.where(half < last, np.where(half % 2 == 0, shift, -shift), start)
    return np.asarray(centre + (start - centre) * np.cos(PULSATION * t - np.pi * np.minimum(half, last)))


def test_swing_with_coulomb_friction_turns_and_stops_as_by_hand() -> None:
    errors, balances = [], []
    for step in STEPS:
        motion = swing(step, 20.0, DRY)
        errors.append(float(np.abs(motion.q[:, 0] - coulomb_swing(motion.t)).max()))
        total = stored(motion) + motion.dissipated_j[:, 0]
        balances.append(float(np.abs(total / total[0] - 1.0).max()))
        assert (np.diff(motion.dissipated_j[:, 0]) >= 0.0).all()
    assert_allclose(orders(errors), 2.0, atol=0.05)
    assert_allclose(orders(balances), 2.0, atol=0.05)
    assert errors[-1] < 1e-6
    assert balances[-1] < 3e-7
    assert (motion.dq[-1000:] == 0.0).all()


def creep(t: float) -> tuple[float, float]:
    return 0.05 * t, 0.05


STRIBECK = Hidden(stribeck=Stribeck(excess_nm=0.3, speed_rad_s=0.1))
STICTION = Hidden(stiction=Stiction(excess_nm=0.3, form=IMMEDIATE))


def gaps_to_scipy(hidden: Hidden, known: DryMass, steps: tuple[float, ...]) -> tuple[list[float], list[float]]:
    """Return the largest difference of position and of velocity, at every step size."""
    joint = JointParameters(inertia_kg_m2=0.3, coulomb_nm=0.3, viscous_nms_per_rad=known.viscous)
    settings = bench(joint, hidden, stiffness_nm_per_rad=known.stiffness, damping_nms_per_rad=known.damping)
    t = np.arange(3001, dtype=np.float64) * 2e-3
    course = np.array([known.course(now) for now in t])
    push = known.stiffness * course[:, 0] + known.damping * course[:, 1]
    q, v = solve(known, t)
    motions = [release(settings, 6.0, step_s=step, tick_s=2e-3, push=push) for step in steps]
    assert np.ptp(q) > 0.2
    return [float(np.abs(m.q[:, 0] - q).max()) for m in motions], [float(np.abs(m.dq[:, 0] - v).max()) for m in motions]


def dry(course: Course, stiffness: float, damping: float, excess: float = 0.0, hold: float = 0.3) -> DryMass:
    return DryMass(
        mass=MASS,
        stiffness=stiffness,
        damping=damping,
        viscous=0.07,
        slide=lambda speed: 0.3 + excess * float(np.exp(-((speed / 0.1) ** 2))),
        hold=hold,
        course=course,
    )


def test_creeping_stick_slip_with_stribeck_friction_follows_scipy() -> None:
    places, speeds = gaps_to_scipy(STRIBECK, dry(creep, 10.0, 0.05, excess=0.3, hold=0.6), STEPS)
    assert orders(places)[-1] > 1.8
    assert places[-1] < 1e-8
    assert speeds[-1] < 1e-7


def test_creeping_stick_slip_with_a_break_away_level_follows_scipy() -> None:
    """Friction jumps where the joint breaks away; that moment is known to within a step."""
    places, speeds = gaps_to_scipy(STICTION, dry(creep, 10.0, 0.05, hold=0.6), (STEP_S,))
    assert places[0] < 5e-5
    assert speeds[0] < 2e-4
