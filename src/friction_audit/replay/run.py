"""A compensator over recorded signals, which do not react to it."""

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float
from friction_audit.replay.compensators import Compensator
from friction_audit.replay.records import TRACE, fresh_memory, pack


def run(
    compensator: Compensator | None,
    t: Float,
    dq: Float,
    interaction_nm: Float,
    *,
    cuts: NDArray[np.bool_] | None = None,
) -> dict[str, Float]:
    """Run the compensator of one joint in open loop.

    Args:
        compensator: What runs.
        t: Time, shape (n,), n at least 2. [s]
        dq: Velocity as measured. [rad/s]
        interaction_nm: Interaction torque F_m. [N m]
        cuts: True where a cycle ends, as told from outside; None to find the cycles from ``dq``.

    Returns:
        By the names in ``records.TRACE``, arrays of shape (n,); a torque at sample i acts from t[i] on.
    """
    from friction_audit.replay.kernels import FIND, run_records

    rate = (len(t) - 1) / (t[-1] - t[0])
    settings, memory = pack([compensator], float(rate)), fresh_memory(1)
    cut = np.full(len(t), FIND, np.int64) if cuts is None else cuts.astype(np.int64)
    out = np.empty((len(t), len(TRACE)))
    run_records(settings[0], memory[0], t, dq, interaction_nm, cut, out)
    return dict(zip(TRACE, out.T, strict=True))
