"""The name of an effect stands in its module, in its simulator module and in the lines of the two registries."""

import re
from pathlib import Path

import pytest

from friction_audit.effects.registry import MODULES, NAMES

SOURCE = Path(__file__).parents[2] / "src" / "friction_audit"
TEXTS = {path.relative_to(SOURCE).as_posix(): path.read_text() for path in SOURCE.rglob("*.py")}
# Where the simulator applies what an effect does: compiled code calls each by its name.
APPLIED = ("simulation/mechanics/", "simulation/bench.py", "simulation/sensors.py")
# Other files: examples of the help, scenarios, a caution of the same name and its sentence, and parts of the program
# that treat one effect in a way of its own.
ELSEWHERE = {
    "stribeck": 2, "stiction": 1, "nonlinear_viscous": 2, "asymmetric_coulomb": 2, "asymmetric_viscous": 1,
    "presliding": 2,
    "frictional_lag": 2, "load_dependent_friction": 1, "torque_ripple": 2, "gravity_error": 5, "torque_bias": 2,
    "torque_drift": 1, "time_delay": 2, "torque_crosstalk": 2, "joint_elasticity": 4, "backlash": 3,
    "inertial_coupling": 2, "warm_up": 1, "friction_step": 4, "contact_event": 7, "unlogged_compensation": 2,
}  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_an_effect_is_defined_in_one_module_of_either_side(name: str) -> None:
    # As a string, an import or a field; the word itself may be the field's, as in "backlash".
    written = re.compile(rf'"{name}[":]|\.{name}\b|import {name}\b|^    {name}: (\w+\.)?[A-Z]', re.MULTILINE)
    found = {path for path, text in TEXTS.items() if written.search(text)}
    own = {f"effects/{MODULES[name]}.py", "effects/registry.py", "simulation/effects/__init__.py"}
    # Its own class carries the name too; in other effects it is the other side of a pair that is easily confused.
    assert own <= found
    others = {path for path in found - own if not path.startswith(("effects/", "simulation/effects/", *APPLIED))}
    assert len(others) <= ELSEWHERE.get(name, 0), sorted(others)
