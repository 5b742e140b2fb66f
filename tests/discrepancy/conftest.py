"""Which of the cases of a test are for a thorough run alone: the others prove the same, or nearly."""

from pathlib import Path

import pytest

THOROUGH = {
    "test_diagnose.py::test_an_effect_is_named": ("presliding", "torque_drift", "warm_up", "cable_spring"),
    "test_diagnose.py::test_nothing_hidden_has_no_name_in_noise_of_any_colour": ("0.0-0.02", "0.9-0.02", "0.0-0.005"),
    "test_diagnose.py::test_two_effects_are_both_in_the_answer": ("stribeck+gravity_error",),
    "test_noise.py::test_integral_time_of_a_known_process": ("0.0",),
    "test_omnibus.py::test_nothing_is_found_in_noise_more_often_than_allowed": ("24-0.9", "60-0.98"),
    "test_search.py::test_an_effect_of_a_part_of_the_noise_is_named": ("0.3-35",),
    "test_search.py::test_noise_gets_no_name": ("12-0.0", "60-0.98"),
    "test_stated_friction.py::test_where_friction_is_fitted_it_cannot_be_said": ("model1",),
}
"""Of each test, the names of cases that take seconds."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        test, _, case = item.name.partition("[")
        if item.path.parent == Path(__file__).parent and case[:-1] in THOROUGH.get(f"{item.path.name}::{test}", ()):
            item.add_marker(pytest.mark.thorough)
