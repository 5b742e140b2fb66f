"""Is a torque so large that it may be in another unit? Nothing in a log of motion proves a unit of torque."""

import numpy as np

from friction_audit.ingest.reader import Recording
from friction_audit.ingest.vet.rows import with_findings
from friction_audit.joint_log import Finding, Float

LARGEST_NM = {"tau_J": 1000.0, "tau_interaction": 300.0, "tau_ext_hat_filtered": 300.0}
"""What a joint of an arm for tens of kilograms never holds, and what is left of it without gravity. [N m]"""
SHARE = 0.95
"""Of the samples that may be below what is looked at: a few wild ones prove nothing."""
MOST_SAMPLES = 1 << 16


def check_torque(recording: Recording) -> Recording:
    """Notice torques that may be in mN m; nothing is changed."""
    present = [name for name in LARGEST_NM if name in recording.channels]
    return with_findings(recording, *(found for name in present if (found := _suspected(recording, name)) is not None))


def _suspected(recording: Recording, name: str) -> Finding | None:
    """Name the joint with the largest usual torque of a channel, where that is suspicious."""
    usual = _usual(recording.channels[name])
    joint = int(np.argmax(usual))
    if usual[joint] <= LARGEST_NM[name]:
        return None
    message = (
        f"{name} is above {usual[joint]:.4g} in a twentieth of the samples: a very large arm, or mN m; read as N m; if "
        "it is mN m, divide the column by 1000, or coefficients are too large by that"
    )
    return Finding(code="torque_unit_suspected", message=message, joint=joint + 1, amount=float(usual[joint]))


def _usual(torque: Float) -> Float:
    """Size that a twentieth of the samples exceeds, of each joint, shape (j,)."""
    every = max(1, len(torque) // MOST_SAMPLES)
    return np.asarray(np.quantile(np.abs(torque[::every]), SHARE, axis=0), np.float64)
