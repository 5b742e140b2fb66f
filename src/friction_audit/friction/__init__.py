"""EnergyCycles -> FrictionHistory: the estimators of the paper and the better ones."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from friction_audit.friction.history import FrictionHistory
    from friction_audit.friction.settings import FrictionSettings
    from friction_audit.preprocessing.energy_cycles import EnergyCycles
    from friction_audit.preprocessing.interaction import Interaction


def estimate_friction(
    interaction: "Interaction",
    cycles: "EnergyCycles",
    settings: "FrictionSettings",
    dead_torque: frozenset[int] = frozenset(),
) -> "FrictionHistory":
    """Estimate the friction of every joint; see :mod:`friction_audit.friction.estimate`."""
    from friction_audit.friction.estimate import estimate_friction as estimate

    return estimate(interaction, cycles, settings, dead_torque)
