"""What a scenario is: settings with a name."""

from dataclasses import dataclass

from friction_audit.simulate.dispatch import AnySettings


@dataclass(frozen=True, kw_only=True, slots=True)
class Scenario:
    """A situation that can be simulated by its name.

    Attributes:
        name: As on the command line.
        summary: One line.
        settings: What is simulated; every number of it can be set.
        figure: The figure of the paper that it belongs to, or None.
    """

    name: str
    summary: str
    settings: AnySettings
    figure: str | None = None
