"""At the ends of their ranges effects are still physics; beyond them they are refused."""

from dataclasses import replace

import numpy as np
import pytest

from friction_audit.errors import UsageError
from friction_audit.simulation.bench import BenchSettings, simulate_bench
from friction_audit.simulation.effects import EFFECTS, Hidden, HiddenEffect
from friction_audit.simulation.effects.load_and_place import JointLimitStop
from friction_audit.simulation.effects.structure import InertiaError
from friction_audit.simulation.settings import IDEAL_SENSORS

IDEAL = BenchSettings(duration_s=6.0, sensors=(IDEAL_SENSORS,))


def ends(effect: type[HiddenEffect]) -> list[dict[str, str]]:
    """Return one setting for each finite end of a parameter's range, the strength above zero."""
    found = []
    for item in effect.parameters():
        found += [{item.name: f"{end:g}"} for end in (item.lower, item.upper) if np.isfinite(end)]
    return [given for given in found if given.get(effect.strength_name()) != "0"]


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_every_end_of_every_range_keeps_the_joint_under_the_hand(effect: type[HiddenEffect]) -> None:
    plain = np.abs(simulate_bench(IDEAL, 1).truth.motion.dq).max()
    for given in ends(effect):
        for form in effect.forms or ("",):
            group = effect.make(given | ({"form": form} if form else {}))
            motion = simulate_bench(replace(IDEAL, hidden=(Hidden().holding(group),)), 1).truth.motion
            assert np.abs(motion.dq).max() < 2.0 * plain, (given, form)


@pytest.mark.parametrize("form", ["spring_damper", "quadratic"])
def test_the_stiffest_wall_takes_energy(form: str) -> None:
    """Energy that the hand has put in is never less than what friction took and what moves."""
    group = JointLimitStop.make({"stiffness_nm_per_rad": "2000", "damping_s": "0.2", "at_rad": "0.2", "form": form})
    motion = simulate_bench(replace(IDEAL, hidden=(Hidden(joint_limit_stop=group),)), 1).truth.motion
    power = (motion.interaction_nm * motion.dq)[:, 0]
    work = np.cumsum(0.5 * (power[1:] + power[:-1]) * 1e-3)
    kept = motion.dissipated_j[1:, 0] + 0.5 * 0.3 * motion.dq[1:, 0] ** 2
    assert np.abs(motion.q).max() < 0.4
    assert (work - kept).min() > -1e-3 * work[-1]


def test_an_inertia_error_that_leaves_no_inertia_is_refused() -> None:
    hidden = Hidden(inertia_error=InertiaError(extra_kg_m2=-0.4))
    with pytest.raises(UsageError, match="extra_kg_m2 leaves joint 1 an inertia of"):
        simulate_bench(replace(IDEAL, hidden=(hidden,)), 1)
