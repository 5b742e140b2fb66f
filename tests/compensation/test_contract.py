"""What every compensator and all settings with bounds keep to, and loops that ran away."""

from collections.abc import Iterator
from dataclasses import MISSING, fields, replace
from math import inf, nan, nextafter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from friction_audit.compensation import law
from friction_audit.compensation.competitors import (
    COMPENSATORS,
    Compensator,
    DisturbanceObserver,
    FixedCompensation,
    JointModelCompensation,
    LugreCompensation,
    SigmoidCompensation,
    TorqueRegulation,
    guard_of,
)
from friction_audit.compensation.controller import REVERSALS, TORQUE_BOUND_NM, run
from friction_audit.compensation.law import Checked, EnergyCompensator, Guard
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.simulation import PANDA_SENSORS
from tests.compensation.bench import COULOMB, INERTIA, VISCOUS, feed, guided

# What every compensator keeps to, over the tuple of them.

EXAMPLES: dict[str, Compensator | None] = {
    "none": None,
    "fixed": FixedCompensation(coulomb_nm=COULOMB, viscous_nms_per_rad=VISCOUS),
    "energy": EnergyCompensator(),
    "sigmoid": SigmoidCompensation(height_nm=0.6, steepness_s_per_rad=9.0, shift_rad_s=0.03),
    "lugre": LugreCompensation(coulomb_nm=COULOMB, breakaway_nm=0.4, viscous_nms_per_rad=VISCOUS),
    "disturbance_observer": DisturbanceObserver(inertia_kg_m2=INERTIA, observer_gain_per_s=50.0),
    "torque_regulation": TorqueRegulation(inertia_kg_m2=INERTIA, desired_inertia_kg_m2=0.15, cutoff_hz=100.0),
    "joint_model": JointModelCompensation(terms=(FittedTerm("coulomb", (COULOMB,)),)),
}
COMPETITORS = [name for name, made in EXAMPLES.items() if hasattr(made, "guard")]


def test_every_kind_has_an_example_and_its_own_code() -> None:
    assert [type(one) for one in EXAMPLES.values()] == [type(None), *COMPENSATORS]
    assert [getattr(law, name.upper()) for name in EXAMPLES] == list(range(len(EXAMPLES)))
    assert [kind.name for kind in COMPENSATORS] == [*EXAMPLES][1:]


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
    limited = replace(example, guard=Guard(max_torque_nm=0.05, max_torque_rate_nm_s=10.0))
    torque, _ = feed(limited, np.linspace(0.0, 1.0, 100), 2.0)
    assert np.abs(torque).max() == pytest.approx(0.05)
    assert np.abs(np.diff(torque)).max() <= 0.01 + 1e-12
    for passivity in (False, True):
        guarded = replace(example, guard=Guard(passivity=passivity))
        assert guard_of(guarded).passivity == passivity
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
    traces = run(FixedCompensation(coulomb_nm=0.3, viscous_nms_per_rad=0.0), T, dq, torque)
    assert np.all(traces["u_nm"][50:200] == 0.3)
    assert np.all(traces["u_nm"][200:] == 0.0)
    assert_array_equal(traces["unstable"], np.arange(500) >= 200)
    assert_array_equal(traces["energy_j"][200:], traces["energy_j"][199])


def test_its_own_torque_is_watched_too() -> None:
    regulation = TorqueRegulation(inertia_kg_m2=1.0, desired_inertia_kg_m2=1e-3)
    torque, memory = feed(regulation, 0.0, [1.0, 5.0, 20.0, 1.0])
    assert torque == pytest.approx([999.0, 4995.0, 0.0, 0.0])
    assert (memory["unstable"], memory["ticks"]) == (1, 4)


def test_turning_back_at_the_limit_tick_by_tick_is_no_control() -> None:
    held = TorqueRegulation(inertia_kg_m2=1.0, desired_inertia_kg_m2=0.1, guard=Guard(max_torque_nm=1.0))
    sides = np.where(np.arange(200) % 2, 1.0, -1.0)
    torque, memory = feed(held, 0.0, sides)
    assert memory["unstable"] == 1
    assert torque[: REVERSALS - 1].all()
    assert_array_equal(torque[REVERSALS + 2 :], 0.0)
