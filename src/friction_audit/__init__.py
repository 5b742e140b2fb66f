"""friction-audit: how much friction is in the joints, is it changing, and what does the model miss?

    log = friction_audit.read_log("run.mcap")
    estimate = friction_audit.estimate_log(log, joints=[1])
    friction_audit.to_frames(estimate)["coefficients"]

The names are loaded when they are first used; ``__init__.pyi`` tells type checkers what they are.
"""

from importlib import import_module

__version__ = "0.1.0"

_NAMES = ("read_log", "log_from_frame", "write_log", "simulate_log", "estimate_log", "replay_log", "diagnose_log")
_NAMES += ("report_log", "to_frames", "plot", "FrictionAuditError")

__all__ = list(_NAMES)


def __getattr__(name: str) -> object:
    """Load a public name when it is first used."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = import_module(f"{__name__}.{'errors' if name == 'FrictionAuditError' else 'api'}")
    globals()[name] = value = getattr(module, name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
