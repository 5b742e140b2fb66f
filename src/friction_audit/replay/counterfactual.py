"""What may be assumed of the person who would have met another joint than the recorded one."""

from dataclasses import dataclass, replace

FITTED, MODELLED = "the joint fitted to this log", "the joint of the model file"


@dataclass(frozen=True, kw_only=True, slots=True)
class Counterfactual:
    """One assumption.

    Attributes:
        name: As on the command line.
        title: In a few words, for figures and tables.
        assumes: One sentence for every output.
    """

    name: str
    title: str
    assumes: str


SAME_MOTION = Counterfactual(
    name="same-motion",
    title="same motion",
    assumes="assumes that the joint would have moved exactly as recorded and the person had pushed as much less (or "
    "more) as the compensator gives; nothing feeds back on the motion, so it cannot show instability",
)
SAME_TORQUE = Counterfactual(
    name="same-torque",
    title="same torque",
    assumes="assumes that the person would have pushed exactly as recorded, whatever the joint does; "
    f"{FITTED} moves under that torque, cycle by cycle from the recorded start",
)
SAME_OPERATOR = Counterfactual(
    name="same-operator",
    title="same operator",
    assumes="assumes that the person is a linear impedance with the same intention as in the recording; "
    f"{FITTED} and that impedance move together in closed loop",
)
COUNTERFACTUALS = (SAME_MOTION, SAME_TORQUE, SAME_OPERATOR)
"""In the order of the command line; the first is the default."""

ASSUMPTIONS = tuple(one.name for one in COUNTERFACTUALS)


def of_a_model(one: Counterfactual) -> Counterfactual:
    """Return the assumption in which the joint of a model file moves."""
    return replace(one, assumes=one.assumes.replace(FITTED, MODELLED))
