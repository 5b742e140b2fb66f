"""Contacts: events that no motion tells. Their samples are left out of everything else.

The detector is a bank of matched filters on the residual (G. L. Turin, IRE Trans. Inf. Theory 6 (1960) 311).
"""

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.find_contacts import find_contacts
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.effects.contact_event import Contact, overlap
from friction_audit.joint_log import Float

SHIFTED = 2.0  # times a torque what is left where it is modelled at one moment and comes at another, at most
SHAKEN = ("backlash", "joint_elasticity")  # noise of the motion shifts when their torque comes


def detect(problem: RegressionProblem, explained: Float | None = None) -> tuple[Contact, ...]:
    """Contacts beside a torque that is explained, shape (n,). [N m]"""
    return find_contacts(problem.data, explained)


def touched(problem: RegressionProblem, contacts: tuple[Contact, ...]) -> NDArray[np.bool_]:
    """Samples that the filter mixes with a contact, shape (m,)."""
    reach = len(problem.samples.kernel) // 2 * problem.data.step_s
    t, inside = problem.samples.t, np.zeros(len(problem.samples.t), bool)
    for contact in contacts:
        inside |= (t >= contact.start_s - reach) & (t <= contact.stop_s + reach)
    return inside


def confirmed(
    problem: RegressionProblem, contacts: tuple[Contact, ...], torques: dict[str, Float], left: Float
) -> tuple[Contact, ...]:
    """The contacts that still stand out of what the named effects leave of all samples.

    Args:
        problem: The joint with all samples.
        contacts: Found before anything was named.
        torques: Of each named effect, shape (n,). [N m]
        left: What the augmented model leaves, shape (n,). [N m]
    """
    again = detect(problem, np.sum(list(torques.values()), axis=0) if torques else None)
    shaken = [torque for name, torque in torques.items() if name in SHAKEN]
    t = problem.data.t
    kept = []
    for contact in contacts:
        inside = (t >= contact.start_s) & (t <= contact.stop_s)
        power = float(np.sum(left[inside] ** 2))
        if any(overlap(contact, other) for other in again) and not any(
            power < SHIFTED**2 * float(np.sum(torque[inside] ** 2)) for torque in shaken
        ):
            kept.append(contact)
    return tuple(kept)
