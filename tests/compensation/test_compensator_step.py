"""The compensator over signals given sample by sample, worked out by hand."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from friction_audit.compensation.compensators import Coefficients, EnergyCompensator, FixedCompensation
from friction_audit.compensation.controller import trace
from friction_audit.compensation.records import GAP, MEMORY, NOT_MOVED, SCALED, TOO_ALIKE, TRACE, fresh_memory, pack
from friction_audit.compensation.replay import run
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float

DT = 1e-3
OPEN = EnergyCompensator(
    model="viscous",
    forced=Coefficients(),
    forced_from_cycle=1,
    controller_in_interaction=False,
    max_damping_nms_per_rad=1e9,
)
"""A controller over a recording that does not react to it; it compensates nothing."""


def clock(n: int) -> Float:
    return np.arange(n, dtype=np.float64) * DT


def strokes(peaks: list[float], *, seconds: float = 0.5) -> Float:
    """Return the velocity of half sines to and fro, with a rest between them."""
    phase = np.linspace(0.0, np.pi, round(seconds / DT))
    return np.concatenate([(-1.0) ** i * peak * np.sin(phase) for i, peak in enumerate(peaks)])


def test_fixed_compensation() -> None:
    dq = np.array([0.0, 0.02, -0.02, 0.021, -1.0])
    signals = run(FixedCompensation(coulomb_nm=0.3, viscous_nms_per_rad=0.1), clock(5), dq, np.zeros(5))
    assert signals["u_nm"].tolist() == pytest.approx([0.0, 0.0, 0.0, 0.3021, -0.4])


def test_the_coulomb_term_is_silent_then_rises_to_all_of_it() -> None:
    compensator = EnergyCompensator(forced=Coefficients(coulomb_nm=0.2), forced_from_cycle=1, passivity=False)
    dq = np.array([0.0, 0.01, -0.01, 0.025, -0.025, 0.04, -5.0])
    signals = run(compensator, clock(7), dq, np.zeros(7))
    assert signals["u_nm"] == pytest.approx(np.array([0.0, 0.0, 0.0, 0.1, -0.1, 0.2, -0.2]))


def test_the_noise_of_a_velocity_at_rest_does_not_make_it_chatter() -> None:
    noise = np.random.default_rng(2).normal(0.0, 0.0027, 10_000)
    compensator = EnergyCompensator(forced=Coefficients(coulomb_nm=0.3), forced_from_cycle=1, passivity=False)
    with_sign = FixedCompensation(coulomb_nm=0.3, viscous_nms_per_rad=0.0, dead_band_rad_s=0.0)
    assert np.abs(run(compensator, clock(10_000), noise, np.zeros(10_000))["u_nm"]).max() < 0.05
    assert np.abs(np.diff(run(with_sign, clock(10_000), noise, np.zeros(10_000))["u_nm"])).mean() > 0.2


@pytest.mark.parametrize("window", [2, 5])
def test_friction_of_a_recording_with_a_compensator_of_its_own(window: int) -> None:
    dq = strokes([0.5, 0.8, 0.6, 1.1, 0.7, 0.9])
    friction = 0.3 * np.sign(dq) + 0.07 * dq + 0.2 * np.gradient(dq, DT)
    signals = run(EnergyCompensator(window=window, factor=0.0, passivity=False), clock(len(dq)), dq, friction)
    assert np.all(np.isnan(signals["estimated_coulomb_nm"][signals["cycle"] < window]))
    assert signals["estimated_coulomb_nm"][-1] == pytest.approx(0.3, rel=5e-3)
    assert signals["estimated_viscous_nms_per_rad"][-1] == pytest.approx(0.07, rel=2e-2)


def test_a_negative_estimate_is_kept_and_not_applied() -> None:
    dq = strokes([0.5, 0.8, 0.6])
    signals = run(EnergyCompensator(model="viscous", passivity=False), clock(len(dq)), dq, -0.1 * dq)
    assert signals["estimated_viscous_nms_per_rad"][-1] == pytest.approx(-0.1, rel=5e-3)
    assert np.all(signals["viscous_nms_per_rad"] == 0.0)
    assert np.all(signals["u_nm"] == 0.0)


def stepped(peaks: list[float], levels: list[float]) -> tuple[Float, Float]:
    """Return the velocity of strokes, and friction of 0.3 N m and 0.07 N m s/rad times a level for each."""
    dq = strokes(peaks)
    level = np.repeat(levels, len(dq) // len(peaks))
    return dq, level * (0.3 * np.sign(dq) + 0.07 * dq)


def test_of_a_pair_with_a_negative_coefficient_the_other_is_not_used_alone() -> None:
    """Friction doubles between two cycles of about one speed: their equations meet where no friction is."""
    dq, friction = stepped([0.5, 0.6, 0.5], [1.0, 2.0, 2.0])
    share = 1e-6
    signals = run(EnergyCompensator(window=2, factor=share, passivity=False), clock(len(dq)), dq, friction)
    at = int(np.argmax(signals["cycle"] == 2))
    assert signals["estimated_coulomb_nm"][at] < -0.1
    assert signals["estimated_viscous_nms_per_rad"][at] > 2.0
    ends = [0, *(int(np.argmax(signals["cycle"] == i)) for i in (1, 2))]
    net = np.diff(signals["energy_j"][ends])
    square = np.array([np.trapezoid(dq[a : b + 1] ** 2, dx=DT) for a, b in pairwise(ends)])
    assert signals["coulomb_nm"][at] == 0.0
    assert signals["viscous_nms_per_rad"][at] == pytest.approx(share * (net @ square) / (square @ square), rel=1e-6)


def test_cycles_too_alike_still_tell_how_much_friction_there_is() -> None:
    dq, friction = stepped([0.5, 1.1, 0.5, 0.5, 0.5, 0.5], [1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
    signals = run(EnergyCompensator(window=2, factor=0.0, passivity=False), clock(len(dq)), dq, friction)
    for cycle, level in ((2, 1.0), (5, 2.0)):
        at = int(np.argmax(signals["cycle"] == cycle))
        assert signals["estimated_coulomb_nm"][at] == pytest.approx(0.3 * level, rel=5e-3)
        assert signals["estimated_viscous_nms_per_rad"][at] == pytest.approx(0.07 * level, rel=2e-2)
    assert signals["status"][at] == SCALED
    assert signals["refused"][at] == 2


def test_cycles_too_alike_tell_nothing_before_there_is_an_estimate() -> None:
    dq, friction = stepped([0.5, 0.5, 0.5], [1.0, 1.0, 1.0])
    signals = run(EnergyCompensator(window=2, factor=0.0), clock(len(dq)), dq, friction)
    assert signals["status"][-1] == TOO_ALIKE
    assert np.all(np.isnan(signals["estimated_coulomb_nm"]))


def test_cycles_told_from_outside() -> None:
    dq = strokes([0.5, 0.8, 0.6])
    cuts = np.zeros(len(dq), bool)
    cuts[[300, 1000]] = True
    signals = run(EnergyCompensator(model="viscous", factor=0.0), clock(len(dq)), dq, 0.1 * dq, cuts=cuts)
    assert (np.flatnonzero(np.diff(signals["cycle"])) + 1).tolist() == [300, 1000]
    assert signals["estimated_viscous_nms_per_rad"][300] == pytest.approx(0.1, rel=1e-4)


def test_a_joint_that_did_not_move_gives_no_equation() -> None:
    cuts = np.zeros(500, bool)
    cuts[400] = True
    noise = np.random.default_rng(1).normal(0.0, 0.0027, 500)
    signals = run(EnergyCompensator(model="coulomb"), clock(500), noise, np.ones(500), cuts=cuts)
    assert signals["status"][400] == NOT_MOVED
    assert signals["refused"][-1] == 1
    assert np.all(np.isnan(signals["estimated_coulomb_nm"]))


def test_a_cycle_with_a_hole_gives_no_equation() -> None:
    dq = strokes([0.5, 0.8])
    t = clock(len(dq))
    t[250:] += 0.2
    signals = run(EnergyCompensator(model="viscous"), t, dq, 0.1 * dq)
    assert GAP in signals["status"]
    assert np.all(np.isnan(signals["estimated_viscous_nms_per_rad"][:600]))


def test_the_deficit_of_a_tick_is_paid_in_the_next() -> None:
    signals = run(OPEN, clock(4), np.full(4, 0.5), np.array([0.0, -0.4, 0.0, 0.0]))
    assert signals["energy_j"] == pytest.approx(np.array([0.0, -1.0e-4, -2.0e-4, -2.0e-4]))
    assert signals["damping_nms_per_rad"] == pytest.approx(np.array([0.0, 0.4, 0.4, 0.0]))
    assert signals["passivity_nm"] == pytest.approx(np.array([0.0, -0.2, -0.2, 0.0]))
    assert signals["dissipated_j"] == pytest.approx(np.array([0.0, 0.0, 1.0e-4, 2.0e-4]))
    assert signals["observed_energy_j"] == pytest.approx(np.array([0.0, -1.0e-4, -1.0e-4, 0.0]), abs=1e-18)
    assert signals["unserved_j"] == pytest.approx(np.zeros(4), abs=1e-18)
    assert signals["acted"].tolist() == [0.0, 1.0, 1.0, 1.0]


def test_energy_stored_at_the_start_is_a_reserve() -> None:
    reserve = EnergyCompensator(forced=Coefficients(), initial_energy_j=1.5e-4, controller_in_interaction=False)
    signals = run(reserve, clock(4), np.full(4, 0.5), np.array([0.0, -0.4, 0.0, 0.0]))
    assert signals["observed_energy_j"][:3] == pytest.approx(np.array([1.5e-4, 0.5e-4, -0.5e-4]))
    assert signals["damping_nms_per_rad"][:2].tolist() == [0.0, 0.0]
    assert signals["damping_nms_per_rad"][2] > 0.0


@settings(max_examples=100, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.05, 1.0), st.floats(-5.0, 5.0)), min_size=3, max_size=60),
    st.sampled_from([-1.0, 1.0]),
)
def test_the_ledger_is_never_further_below_zero_than_one_tick_takes_it(
    samples: list[tuple[float, float]], direction: float
) -> None:
    speed, force = np.array(samples).T
    dq = direction * speed
    signals = run(OPEN, clock(len(dq)), dq, force)
    observed = signals["observed_energy_j"]
    work = np.diff(signals["energy_j"])
    # The damping is planned with the speed at the tick, and takes what the mean speed until the next one makes of it.
    missed = np.maximum(0.0, -observed[:-1]) * np.maximum(0.0, 1.0 - 0.5 * (speed[:-1] + speed[1:]) / speed[:-1])
    assert np.all(observed[1:] >= np.minimum(0.0, work) - missed - 1e-12)
    assert np.all(signals["passivity_nm"] * dq <= 0.0)


@settings(max_examples=50, deadline=None)
@given(
    force=st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=60), cap=st.floats(0.01, 5.0), torque=st.floats(0.05, 2.0)
)
def test_what_the_caps_leave_is_carried_and_reported(force: list[float], cap: float, torque: float) -> None:
    compensator = EnergyCompensator(
        forced=Coefficients(),
        forced_from_cycle=1,
        controller_in_interaction=False,
        max_damping_nms_per_rad=cap,
        max_torque_nm=torque,
    )
    signals = run(compensator, clock(len(force)), np.full(len(force), 0.5), np.array(force))
    assert signals["damping_nms_per_rad"].max() <= cap * (1 + 1e-12)
    assert np.abs(signals["u_nm"]).max() <= torque * (1 + 1e-12)
    left = np.maximum(signals["observed_energy_j"][:-1], 0.0) - signals["unserved_j"][:-1]
    assert signals["observed_energy_j"][1:] == pytest.approx(left + np.diff(signals["energy_j"]), abs=1e-12)


def test_nothing_is_injected_at_rest_and_the_deficit_waits() -> None:
    dq = np.array([0.5, 0.5, 0.0, 0.005, -0.005, 0.5])
    signals = run(OPEN, clock(6), dq, np.array([-0.4, -0.4, 0.0, 0.0, 0.0, 0.0]))
    assert signals["damping_nms_per_rad"][[2, 3, 4]].tolist() == [0.0, 0.0, 0.0]
    assert np.all(signals["unserved_j"][2:5] > 0.0)
    assert signals["unserved_j"][5] == pytest.approx(0.0, abs=1e-18)
    assert np.all(np.isfinite(signals["u_nm"]))


def test_the_trace_is_what_its_names_say() -> None:
    memory = fresh_memory(1)
    assert set(TRACE) <= set(MEMORY.names or ())
    for i, name in enumerate(TRACE):
        memory[name] = i + 1
    row = np.zeros(len(TRACE))
    trace(memory[0], row)
    assert row.tolist() == list(range(1, len(TRACE) + 1))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"model": "stribeck"}, "model stribeck: expected one of viscous, coulomb, combined"),
        ({"window": 1}, "window 1: expected 2 to 64 cycles"),
        ({"window": 65, "model": "viscous"}, "expected 1 to 64 cycles"),
        ({"initiation_rad_s": 0.01}, "initiation above termination"),
        ({"forced_from_cycle": 0}, "cycles count from 1"),
        ({"factor": -1.0}, "factor -1: expected zero or more"),
        ({"max_torque_nm": 0.0}, "max_torque_nm 0: expected a number above zero"),
        ({"minimum_speed_rad_s": float("nan")}, "minimum_speed_rad_s nan"),
    ],
)
def test_settings_out_of_range_are_refused(wrong: dict[str, float], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        EnergyCompensator(**wrong)  # type: ignore[arg-type]


def test_a_fixed_dead_band_and_a_rate_out_of_range_are_refused() -> None:
    with pytest.raises(UsageError, match="dead_band_rad_s -1"):
        FixedCompensation(coulomb_nm=0.1, viscous_nms_per_rad=0.1, dead_band_rad_s=-1.0)
    with pytest.raises(UsageError, match="rate 0 Hz"):
        pack([None], 0.0)
