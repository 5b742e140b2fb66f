"""From a log to a name: effects hidden by the simulator, which shares no formula with the detector."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.signal import butter, lfilter, sosfiltfilt

from benchmarks import resampled
from friction_audit.api import diagnose_log
from friction_audit.joint_log import DERIVATIVE, Float, JointLog
from friction_audit.simulation import IDEAL_SENSORS, SCENARIOS, simulate
from friction_audit.simulation.hide import hide
from tests.each_case import thorough

SEED = 2


def recorded(*effects: str, scenario: str = "joint", duration_s: float = 60.0, seed: int = SEED) -> JointLog:
    settings = next(one.settings for one in SCENARIOS if one.name == scenario)
    return simulate(hide(replace(settings, duration_s=duration_s), effects), seed).log


def diagnosed(log: JointLog, **asked: Any) -> Any:
    (found,) = diagnose_log(log, **asked).joints
    return found


def names(found: Any) -> tuple[set[str], ...]:
    """Of each effect all names that it may have."""
    return tuple({effect.name, *effect.alternatives} for effect in found.effects)


SLOW = ("presliding", "torque_drift", "warm_up", "friction_step", "cable_spring")


@pytest.mark.parametrize(
    ("name", "scenario"),
    [
        ("stribeck", "joint"),
        ("time_delay", "joint"),
        ("load_dependent_friction", "joint-loaded"),
        *thorough((name, "joint") for name in ("backlash", *SLOW)),
    ],
)
def test_an_effect_is_named(name: str, scenario: str) -> None:
    found = diagnosed(recorded(name, scenario=scenario, duration_s=60.0 if name in SLOW else 40.0))
    assert found.verdict in ("named", "ambiguous")
    assert len(found.effects) == 1
    assert name in names(found)[0]
    assert found.gap.shrink > 0.8
    assert found.omnibus_p < 0.01


@pytest.mark.parametrize(("memory", "noise_nm"), [(0.99, 0.02), *thorough([(0.0, 0.02), (0.9, 0.02), (0.0, 0.005)])])
def test_nothing_hidden_has_no_name_in_noise_of_any_colour(memory: float, noise_nm: float) -> None:
    settings = next(one.settings for one in SCENARIOS if one.name == "joint")
    clean: Any = simulate(replace(settings, duration_s=40.0, sensors=(IDEAL_SENSORS,)), SEED).log
    noise = coloured(memory, noise_nm, len(clean.t))
    found = diagnosed(replace(clean, tau_interaction=clean.tau_interaction + noise[:, None]))
    assert (found.verdict, found.effects) == ("adequate", ())
    assert found.gap.before == pytest.approx(found.gap.floor, rel=0.03)
    truth = {"coulomb_nm": 0.30, "viscous_nms_per_rad": 0.07, "inertia_kg_m2": 0.30}
    for name, one in found.nominal.items():
        assert one.low - 0.02 * truth[name] <= truth[name] <= one.high + 0.02 * truth[name], name


SEEDS = {scenario: 130_000 + seed for truth, scenario, seed, _ in resampled.CASES if truth == "none"}
WAYS = [("joint", "held up"), ("smoothed sign", "held")]
MORE_WAYS = [("joint", "linear"), ("joint", "difference"), ("joint-sine", "cubic")]
signals = cache(lambda scenario: resampled.recorded("none", scenario, SEEDS[scenario], 1.0))


@pytest.mark.parametrize(("scenario", "way"), [*WAYS, *thorough(MORE_WAYS)])
def test_nothing_is_missing_in_a_clean_joint_whose_log_was_resampled(scenario: str, way: str) -> None:
    found = diagnosed(resampled.log_by(way, *signals(scenario), SEEDS[scenario]))
    assert (found.verdict, found.effects) == ("adequate", ())


def coloured(memory: float, noise_nm: float, n: int) -> Float:
    """Noise at 1 kHz, of which so much is left below 25 Hz, where models are fitted."""
    noise = lfilter([1.0], [1.0, -memory], np.random.default_rng(7).standard_normal(n + 1000))[1000:]
    seen = sosfiltfilt(butter(4, 25.0, fs=1000.0, output="sos"), noise)
    return np.asarray(noise_nm * noise / seen.std())


@pytest.mark.parametrize(
    ("hidden", "duration_s"),
    [
        pytest.param(("stribeck", "gravity_error"), 60.0, marks=pytest.mark.thorough),
        (("presliding", "torque_drift"), 40.0),
    ],
)
def test_two_effects_are_both_in_the_answer(hidden: tuple[str, ...], duration_s: float) -> None:
    found = diagnosed(recorded(*hidden, duration_s=duration_s))
    assert found.verdict in ("named", "ambiguous")
    assert len(found.effects) == 2
    for name in hidden:
        assert any(name in one for one in names(found)), names(found)


@pytest.mark.thorough
@pytest.mark.xfail(strict=True, reason="a contact is named with it, where one impact came at another moment")
def test_a_gap_in_sinusoids_is_not_named_a_delay() -> None:
    found = diagnosed(recorded("backlash:gap_rad=0.002", scenario="joint-sine", seed=1))
    assert names(found) == ({"backlash"},)
    width = found.effects[0].parameters["gap_rad"]
    assert width.low < 0.002 < width.high


@pytest.mark.thorough
@pytest.mark.xfail(strict=True, reason="40 % too large: the detector's spring stiffens evenly up to a torque")
def test_a_hardening_gear_is_one_spring() -> None:
    found = diagnosed(
        recorded("joint_elasticity:compliance_rad_per_nm=0.003,form=hardening", scenario="joint-sine", seed=3)
    )
    assert found.verdict == "named"
    assert names(found) == ({"joint_elasticity"},)
    compliance = found.effects[0].parameters["compliance_rad_per_nm"]
    assert compliance.value == pytest.approx(0.003, rel=0.1)


@pytest.mark.parametrize(("factor", "case"), [(-1.0, "turned"), (1.3, "scaled")])
def test_nothing_is_named_on_wrong_data(factor: float, case: str) -> None:
    log = recorded("stribeck", duration_s=30.0)
    found = diagnosed(replace(log, dq=factor * log.dq))
    assert (found.verdict, found.effects) == ("data_fault", ())
    assert case in [one.numbers.get("case") for one in found.reason]


@pytest.mark.parametrize("scenario", ["joint-sine", "joint-loaded"])
def test_an_encoder_without_velocity_that_is_too_coarse_is_said_and_a_finer_one_is_no_contact(scenario: str) -> None:
    log = recorded(scenario=scenario)
    source = replace(log.source, channels={**log.source.channels, "dq": DERIVATIVE})
    coarse, fine = (diagnosed(replace(log, q=step * np.round(log.q / step), source=source)) for step in (1e-3, 3e-5))
    assert (coarse.verdict, coarse.effects) == ("not_testable", ())
    assert coarse.reason[0].numbers["step"] == pytest.approx(1e-3)
    assert (fine.verdict, fine.effects) == ("adequate", ())


def test_a_coarse_velocity_is_no_effect() -> None:
    """Most samples of a slow joint read the same, which is no sign of a quiet velocity."""
    log = recorded(scenario="joint-slow", duration_s=180.0)
    found = diagnosed(replace(log, dq=0.05 * np.round(log.dq / 0.05)))
    assert (found.verdict, found.effects) == ("adequate", ())


def test_a_coarse_position_and_velocity_are_too_coarse_and_no_duplicates() -> None:
    log = recorded(scenario="joint-driven", duration_s=60.0)
    found = diagnosed(replace(log, q=1e-3 * np.round(log.q / 1e-3), dq=0.05 * np.round(log.dq / 0.05)))
    assert (found.verdict, found.reason[0].code) == ("not_testable", "coarse_steps")
