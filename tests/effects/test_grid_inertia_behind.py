"""Without an inertia behind it, a transmission has nothing to ring or to strike."""

from dataclasses import replace

from friction_audit.effects import backlash, joint_elasticity
from tests.effects.joint_data_by_hand import baseline, two_sines


def test_without_one_springs_and_gaps_are_not_testable() -> None:
    data = two_sines(30.0)
    weightless = replace(baseline(data), inertia_kg_m2=-0.01)
    assert backlash.EFFECT.not_identifiable(data, baseline(data)) is None
    assert "no inertia" in str(joint_elasticity.EFFECT.not_identifiable(data, weightless))
    assert "no inertia" in str(backlash.EFFECT.not_identifiable(data, weightless))
