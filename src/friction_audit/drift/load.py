"""What an analysis of drift imports when it is needed, imported ahead: it takes a second, while others read logs."""

from importlib import import_module

HEAVY = (
    "scipy.optimize",
    "scipy.signal",
    "scipy.stats",
    "statsmodels.robust.robust_linear_model",
    "statsmodels.stats.multitest",
    "friction_audit.drift.analyse",
)


def load() -> None:
    """Import it."""
    for name in HEAVY:
        import_module(name)
