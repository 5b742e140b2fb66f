"""friction-audit: how much friction is in the joints, is it changing, and what does the model miss?

    log = friction_audit.read_log("run.mcap")
    estimate = friction_audit.estimate_log(log, joints=[1])
    friction_audit.to_frames(estimate)["coefficients"]

The names are loaded when they are first used; ``__init__.pyi`` tells type checkers what they are.
"""

from importlib import import_module

__version__ = "0.1.0"

_PLACES = {
    "read_log": "api",
    "log_from_frame": "api",
    "write_log": "api",
    "simulate_log": "api",
    "estimate_log": "api",
    "replay_log": "api",
    "diagnose_log": "api",
    "report_log": "api",
    "to_frames": "api",
    "plot": "api",
    "FrictionAuditError": "errors",
}

__all__ = list(_PLACES)


def __getattr__(name: str) -> object:
    """Load a public name when it is first used."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
