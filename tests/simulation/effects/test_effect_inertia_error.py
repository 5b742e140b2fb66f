from friction_audit.simulation.effects.inertia_error import InertiaError


def test_inertia_may_be_more_or_less_than_known() -> None:
    assert InertiaError().extra_kg_m2 == 0.0
    assert InertiaError.make({}) == InertiaError(extra_kg_m2=0.1)
    assert InertiaError.make({"extra_kg_m2": "-0.05"}) == InertiaError(extra_kg_m2=-0.05)
