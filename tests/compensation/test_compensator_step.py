"""The compensator over signals by hand, sample by sample; what every compensator and all settings keep to."""

from collections.abc import Callable, Iterator
from dataclasses import MISSING, fields, replace
from math import inf, nan, nextafter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.testing import assert_array_equal

from friction_audit.compensation import competitors, law
from friction_audit.compensation.controller import DETECT, MOST_REVERSALS, TORQUE_BOUND_NM, run, step
from friction_audit.compensation.law import NO_RIDGE, Checked, Coefficients, EnergyCompensator
from friction_audit.compensation.records import GAP, STATE, initial_states, settings_records
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation import PANDA_SENSORS
from tests.compensation.bench import COULOMB, INERTIA, VISCOUS, feed, guided

DT = 1e-3
OPEN = EnergyCompensator(
    model="viscous", forced=Coefficients(), forced_from_cycle=1, payback_s=0.0, max_damping_nms_per_rad=1e9
)
"""A controller that compensates nothing and pays a deficit within a tick."""


def clock(n: int) -> Float:
    return np.arange(n, dtype=np.float64) * DT


def strokes(peaks: list[float], *, seconds: float = 0.5) -> Float:
    """Return the velocity of half sines to and fro, with a rest between them."""
    phase = np.linspace(0.0, np.pi, round(seconds / DT))
    return np.concatenate([(-1.0) ** i * peak * np.sin(phase) for i, peak in enumerate(peaks)])


def closed(compensator: EnergyCompensator, dq: Float, force: Float) -> Any:
    """Run a compensator along a motion that is kept up by force; its sensor feels that without its own torque."""
    settings, state, seen = settings_records([compensator], 1.0 / DT)[0], initial_states(1)[0], np.empty(len(dq), STATE)
    for i, (v, torque) in enumerate(zip(dq, force, strict=True)):
        step(settings, state, v, torque - state["u_nm"], DT if i else 0.0, DETECT)
        seen[i] = state
    return seen


FORCED = EnergyCompensator(forced=Coefficients(coulomb_nm=0.2), forced_from_cycle=1, passivity=False)
FIXED = competitors.FixedCompensation(coulomb_nm=0.3, viscous_nms_per_rad=0.1)


@pytest.mark.parametrize(
    ("compensator", "dq", "expected"),
    [
        (FIXED, [0.0, 0.02, -0.02, 0.021, -1.0], [0.0, 0.0, 0.0, 0.3021, -0.4]),
        (FORCED, [0.0, 0.01, -0.01, 0.025, -0.025, 0.04, -5.0], [0.0, 0.0, 0.0, 0.1, -0.1, 0.2, -0.2]),
    ],
)
def test_friction_is_silent_in_the_dead_band_then_all_of_it(compensator: Any, dq: Any, expected: Any) -> None:
    signals = run(compensator, clock(len(dq)), np.array(dq), np.zeros(len(dq)))
    assert signals["u_nm"].tolist() == pytest.approx(expected)


@pytest.mark.parametrize("window", [2, 5])
def test_friction_of_a_recording_with_a_compensator_of_its_own(window: int) -> None:
    dq = strokes([0.5, 0.8, 0.6, 1.1, 0.7, 0.9])
    friction = 0.3 * np.sign(dq) + 0.07 * dq + 0.2 * np.gradient(dq, DT)
    compensator = EnergyCompensator(window=window, ridge=NO_RIDGE, factor=0.0, passivity=False)
    signals = run(compensator, clock(len(dq)), dq, friction)
    assert np.all(np.isnan(signals["estimated_coulomb_nm"][signals["cycle"] < window]))
    assert signals["estimated_coulomb_nm"][-1] == pytest.approx(0.3, rel=5e-3)
    assert signals["estimated_viscous_nms_per_rad"][-1] == pytest.approx(0.07, rel=2e-2)


def stepped(peaks: list[float], levels: list[float]) -> tuple[Float, Float]:
    """Return the velocity of strokes, and friction of 0.3 N m and 0.07 N m s/rad times a level for each."""
    dq = strokes(peaks)
    level = np.repeat(levels, len(dq) // len(peaks))
    return dq, level * (0.3 * np.sign(dq) + 0.07 * dq)


def at_end_of(cycle: int, signals: Any) -> tuple[float, float]:
    at = int(np.argmax(signals["cycle"] == cycle))
    return float(signals["estimated_coulomb_nm"][at]), float(signals["estimated_viscous_nms_per_rad"][at])


def test_as_published_a_step_between_two_cycles_is_split_wrongly_and_the_negative_part_not_applied() -> None:
    """Friction doubles between two cycles of about one speed: their equations meet where no friction is."""
    dq, friction = stepped([0.5, 0.6, 0.5], [1.0, 2.0, 2.0])
    compensator = EnergyCompensator(window=2, ridge=NO_RIDGE, factor=1e-6, passivity=False)
    signals = run(compensator, clock(len(dq)), dq, friction)
    coulomb, viscous = at_end_of(2, signals)
    assert coulomb < -0.1
    assert viscous > 2.0
    at = int(np.argmax(signals["cycle"] == 2))
    assert signals["coulomb_nm"][at] == 0.0
    assert signals["viscous_nms_per_rad"][at] == pytest.approx(1e-6 * viscous)


def test_the_ridge_follows_the_level_of_cycles_of_one_speed() -> None:
    dq, friction = stepped([0.5, 1.1, 0.5, 0.5, 0.5, 0.5], [1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
    signals = run(EnergyCompensator(window=2, factor=0.0, passivity=False), clock(len(dq)), dq, friction)
    for cycle, level in ((2, 1.0), (5, 2.0)):
        coulomb, viscous = at_end_of(cycle, signals)
        mean_speed = 0.5 * np.pi / 4.0
        assert coulomb + viscous * mean_speed == pytest.approx(level * (0.3 + 0.07 * mean_speed), rel=0.03)


def test_a_cycle_with_a_hole_gives_no_equation() -> None:
    dq = strokes([0.5, 0.8])
    t = clock(len(dq))
    t[250:] += 0.2
    signals = run(EnergyCompensator(model="viscous"), t, dq, 0.1 * dq)
    assert GAP in signals["status"]
    assert np.all(np.isnan(signals["estimated_viscous_nms_per_rad"][:600]))


def test_the_deficit_of_a_tick_is_paid_in_the_next() -> None:
    signals = closed(OPEN, np.full(4, 0.5), np.array([0.0, -0.4, 0.0, 0.0]))
    # Trapezoids: the torque that sets in at a tick counts half in the interval before it.
    assert signals["energy_j"] == pytest.approx(1e-4 * np.array([0.0, -1.0, -1.5, -0.25]))
    assert signals["damping_nms_per_rad"] == pytest.approx(np.array([0.0, 0.4, 0.6, 0.1]))
    assert signals["passivity_nm"] == pytest.approx(np.array([0.0, -0.2, -0.3, -0.05]))
    assert signals["dissipated_j"] == pytest.approx(1e-4 * np.array([0.0, 0.0, 1.0, 2.5]))
    assert signals["acted"].tolist() == [0.0, 1.0, 1.0, 1.0]


def test_a_deficit_is_paid_over_the_horizon() -> None:
    force = np.concatenate([[0.0, -4.0], np.zeros(98)])
    signals = closed(replace(OPEN, payback_s=0.02), np.full(100, 0.5), force)
    deficit = -signals["energy_j"]
    assert signals["damping_nms_per_rad"] == pytest.approx(np.maximum(deficit, 0.0) / (0.25 * 0.02), abs=1e-9)
    assert deficit[22] / deficit[2] == pytest.approx(np.exp(-1.0), rel=0.05)


@settings(max_examples=100, deadline=None)
@given(
    force=st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=60),
    cap=st.floats(0.01, 5.0),
    torque=st.floats(0.05, 2.0),
    rate=st.floats(1.0, 1e4),
)
def test_the_three_torques_add_up_to_one_within_the_limits(
    force: list[float], cap: float, torque: float, rate: float
) -> None:
    compensator = EnergyCompensator(
        forced=Coefficients(coulomb_nm=0.5),
        forced_from_cycle=1,
        max_damping_nms_per_rad=cap,
        max_torque_nm=torque,
        max_torque_rate_nm_s=rate,
    )
    dq = np.full(len(force), 0.5)
    signals = closed(compensator, dq, np.array(force))
    u = signals["u_nm"]
    assert u == pytest.approx(signals["compensation_nm"] + signals["passivity_nm"] + signals["limited_nm"], abs=1e-12)
    assert signals["compensation_nm"] == pytest.approx(0.5)
    assert signals["damping_nms_per_rad"].max() <= cap * (1 + 1e-12)
    assert np.all(signals["passivity_nm"] * dq <= 0.0)
    assert np.abs(u).max() <= torque * (1 + 1e-12)
    assert np.abs(np.diff(u, prepend=0.0)).max() <= rate * DT * (1 + 1e-9)


def test_a_limit_of_the_rate_does_not_wind_up() -> None:
    """While the braking is faster than the limit, the torque must not run on past what both ask for together."""
    law = EnergyCompensator(forced=Coefficients(viscous_nms_per_rad=0.5), forced_from_cycle=1, max_torque_rate_nm_s=1e3)
    signals = closed(law, np.full(60, 1.4), np.concatenate([np.full(20, -9.0), np.full(40, 0.0)]))
    asked = signals["compensation_nm"] + signals["passivity_nm"]
    assert signals["compensation_nm"] == pytest.approx(0.7)
    assert np.all(signals["u_nm"] >= np.minimum.accumulate(asked) - 1e-12)


LUGRE = competitors.LugreCompensation(coulomb_nm=COULOMB, breakaway_nm=0.4, viscous_nms_per_rad=VISCOUS)


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: replace(LUGRE, breakaway_nm=0.2), "breakaway_nm 0.2: expected coulomb_nm 0.3 or more"),
        (lambda: competitors.fit_sigmoid(0.0, 0.0), "friction above zero"),
    ],
)
def test_what_makes_no_sense_is_refused(made: Callable[[], object], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        made()


# What every compensator and all settings with bounds keep to, and loops that ran away.

EXAMPLES: dict[str, competitors.Compensator | None] = {
    "none": None,
    "fixed": competitors.FixedCompensation(coulomb_nm=COULOMB, viscous_nms_per_rad=VISCOUS),
    "energy": EnergyCompensator(),
    "sigmoid": competitors.SigmoidCompensation(height_nm=0.6, steepness_s_per_rad=9.0, shift_rad_s=0.03),
    "lugre": LUGRE,
    "disturbance_observer": competitors.DisturbanceObserver(inertia_kg_m2=INERTIA, observer_gain_per_s=50.0),
    "torque_regulation": competitors.TorqueRegulation(
        inertia_kg_m2=INERTIA, desired_inertia_kg_m2=0.15, cutoff_hz=100.0
    ),
    "joint_model": competitors.JointModelCompensation(terms=(FittedTerm("coulomb", (COULOMB,)),)),
}
COMPETITORS = [name for name in EXAMPLES if name not in ("none", "energy")]


def test_every_kind_has_an_example_and_its_own_code() -> None:
    assert [type(one) for one in EXAMPLES.values()] == [type(None), *competitors.COMPENSATORS]
    assert [getattr(law, name.upper()) for name in EXAMPLES] == list(range(len(EXAMPLES)))
    assert [kind.name for kind in competitors.COMPENSATORS] == [*EXAMPLES][1:]


@pytest.mark.parametrize("name", EXAMPLES)
def test_standstill_is_still_under_noise(name: str) -> None:
    motion = guided(EXAMPLES[name], sensors=PANDA_SENSORS[0])
    last = slice(-1000, None)
    assert np.ptp(motion.q[last]) < 1e-3
    assert np.abs(motion.compensation_nm[last]).max() < COULOMB + 0.2


@pytest.mark.parametrize("name", [*EXAMPLES][1:])
def test_twice_the_gain_is_twice_the_gains_or_the_torque_gain(name: str) -> None:
    example: Any = EXAMPLES[name]
    twice = example.scaled(2.0)
    assert example.scaled(1.0) == example
    assert [getattr(twice, gain) for gain in example.gains] == [2.0 * getattr(example, gain) for gain in example.gains]
    assert name != "torque_regulation" or twice.desired_inertia_kg_m2 == pytest.approx(
        0.1
    )  # B / (1 + 2 (B / 0.15 - 1))


@pytest.mark.parametrize("name", COMPETITORS)
def test_competitors_keep_their_limits_and_are_guarded(name: str) -> None:
    example: Any = EXAMPLES[name]
    limited = replace(example, max_torque_nm=0.05, max_torque_rate_nm_s=10.0)
    torque, _ = feed(limited, np.linspace(0.0, 1.0, 100), 2.0)
    assert np.abs(torque).max() == pytest.approx(0.05)
    assert np.abs(np.diff(torque)).max() <= 0.01 + 1e-12
    for passivity in (False, True):
        guarded = replace(example, passivity=passivity)
        assert (feed(guarded, np.full(200, 0.5), -0.4)[1]["dissipated_j"] > 0.0) == passivity


def kinds_below(kind: type[Checked]) -> Iterator[type[Any]]:
    """Yield all settings that have bounds: compensators, motions, joints, sensors, scenarios."""
    for below in kind.__subclasses__():
        yield below
        yield from kinds_below(below)


@pytest.mark.parametrize("kind", [*kinds_below(Checked)], ids=lambda kind: kind.__name__)
def test_settings_refuse_every_number_out_of_its_bounds_by_name(kind: type[Any]) -> None:
    needed: dict[str, Any] = {one.name: 1.0 for one in fields(kind) if one.default is one.default_factory is MISSING}
    for item in (item for item in fields(kind) if "within" in item.metadata):
        low, high = item.metadata["within"]
        for wrong in (nan, -inf, nextafter(low, -inf), *([] if high == inf else [2.0 * high])):
            value = (wrong, wrong) if isinstance(item.default, tuple) else wrong
            with pytest.raises(UsageError, match=f": {item.name} .*: expected"):
                kind(**needed | {item.name: value})


def test_every_kind_has_its_section_in_the_documentation() -> None:
    page = Path(__file__).parents[2] / "docs" / "compensators.md"
    headings = [line.removeprefix("## ") for line in page.read_text().splitlines() if line.startswith("## ")]
    assert headings[: len(EXAMPLES)] == list(EXAMPLES)


# Loops that ran away.

T: Float = np.arange(500.0) * 1e-3
DQ: Float = np.sin(T)


@pytest.mark.parametrize("bad", [np.nan, -np.inf, 1.1 * TORQUE_BOUND_NM])
@pytest.mark.parametrize("signal", ["speed", "torque"])
def test_a_reading_that_is_none_silences_for_good_and_does_not_reach_the_ledgers(signal: str, bad: float) -> None:
    dq, torque = DQ.copy(), np.ones_like(T)
    (dq if signal == "speed" else torque)[200] = bad
    traces = run(competitors.FixedCompensation(coulomb_nm=0.3, viscous_nms_per_rad=0.0), T, dq, torque)
    assert np.all(traces["u_nm"][50:200] == 0.3)
    assert np.all(traces["u_nm"][200:] == 0.0)
    assert_array_equal(traces["unstable"], np.arange(500) >= 200)
    assert_array_equal(traces["energy_j"][200:], traces["energy_j"][199])


def test_its_own_torque_is_watched_too() -> None:
    regulation = competitors.TorqueRegulation(inertia_kg_m2=1.0, desired_inertia_kg_m2=1e-3)
    torque, state = feed(regulation, 0.0, [1.0, 5.0, 20.0, 1.0])
    assert torque == pytest.approx([999.0, 4995.0, 0.0, 0.0])
    assert (state["unstable"], state["ticks"]) == (1, 4)


def test_turning_back_at_the_limit_tick_by_tick_is_no_control() -> None:
    held = competitors.TorqueRegulation(inertia_kg_m2=1.0, desired_inertia_kg_m2=0.1, max_torque_nm=1.0)
    sides = np.where(np.arange(200) % 2, 1.0, -1.0)
    torque, state = feed(held, 0.0, sides)
    assert state["unstable"] == 1
    assert torque[: MOST_REVERSALS - 1].all()
    assert_array_equal(torque[MOST_REVERSALS + 2 :], 0.0)
