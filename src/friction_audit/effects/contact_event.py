"""Contact: something touches the arm now and then, for stretches of time that no motion predicts.

Its grid is empty: a diagnosis finds the moments and adds them.
"""

from dataclasses import dataclass

import numpy as np

from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.joint_log import Float

KNOTS = 5  # points of the curve through one contact, nothing at its ends


@dataclass(frozen=True, kw_only=True, slots=True)
class Contact:
    """One stretch of time.

    Attributes:
        start_s: Its beginning. [s]
        stop_s: Its end. [s]
    """

    start_s: float
    stop_s: float


class ContactEvent(Effect):
    def regressor(self, data: JointData, nominal: Nominal, at: Nonlinear) -> Float:
        """Hats over each contact, shape (n, contacts * KNOTS); a column of zeros where there is none."""
        hats = [np.zeros((len(data.t), 1))] if not at else []
        for contact in contacts_of(at):
            knots = np.linspace(contact.start_s, contact.stop_s, KNOTS + 2)
            hats += [
                np.interp(data.t, knots, np.eye(KNOTS + 2)[i], left=0.0, right=0.0)[:, None]
                for i in range(1, KNOTS + 1)
            ]
        return np.hstack(hats)

    def admissible(self, coefficients: Float, at: Nonlinear) -> bool:
        """Any torque, where there was a contact."""
        return bool(at)


def contacts_of(at: Nonlinear) -> tuple[Contact, ...]:
    """Return the contacts of a point of the grid."""
    return tuple(Contact(start_s=at[f"start_{k}_s"], stop_s=at[f"stop_{k}_s"]) for k in range(1, len(at) // 2 + 1))


EFFECT = ContactEvent(
    name="contact_event",
    label="short contact with the arm",
    family="slow and events",
    axis="time",
    record="record again with no person and no object near the arm",
)
