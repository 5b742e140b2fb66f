"""Settings and a seed -> JointLog with known truth."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from friction_audit.simulate.bench import BenchSettings, simulate_bench
    from friction_audit.simulate.effects import EFFECTS, Hidden
    from friction_audit.simulate.operator import Operator
    from friction_audit.simulate.panda_joint import HandGuidedPanda, simulate_hand_guided_panda
    from friction_audit.simulate.settings import IDEAL_SENSORS, PANDA_SENSORS, JointParameters, Sensors
    from friction_audit.simulate.simulation import Motion, Simulation, Truth

__all__ = [
    "EFFECTS",
    "IDEAL_SENSORS",
    "PANDA_SENSORS",
    "BenchSettings",
    "HandGuidedPanda",
    "Hidden",
    "JointParameters",
    "Motion",
    "Operator",
    "Sensors",
    "Simulation",
    "Truth",
    "simulate_bench",
    "simulate_hand_guided_panda",
]

# Settings and effects bring the compiler along, which takes longer to import than all else: only on demand.
_MODULES = {
    "BenchSettings": "bench",
    "simulate_bench": "bench",
    "EFFECTS": "effects",
    "Hidden": "effects",
    "Operator": "operator",
    "HandGuidedPanda": "panda_joint",
    "simulate_hand_guided_panda": "panda_joint",
    "IDEAL_SENSORS": "settings",
    "PANDA_SENSORS": "settings",
    "JointParameters": "settings",
    "Sensors": "settings",
    "Motion": "simulation",
    "Simulation": "simulation",
    "Truth": "simulation",
}


def __getattr__(name: str) -> Any:  # noqa: ANN401 - any name of the package
    """Import a public name when it is first asked for (PEP 562)."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
