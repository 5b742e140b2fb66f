"""Forward simulation of a recording in MuJoCo, with the exported friction and without."""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.export.friction_law import FittedFriction
from friction_audit.joint_log import Float

if TYPE_CHECKING:
    from mujoco import MjModel

WINDOW_S = (
    0.2  # after which the simulation starts again from the recorded state: an arm without friction is far by then
)
MOST_WINDOWS = 300  # a minute of simulation in all, spread over the log; their rms is known to 4 %
GAP_STEPS = 20  # median time steps above which a window has no torque to be driven by
STEP_S = 1e-3  # of the simulation, or the log's own step where that is shorter
# A hinge whose inertia is all the joint's; the body has what MuJoCo asks of every moving one.
HINGE = """<mujoco><compiler boundmass="0" boundinertia="0"/><option gravity="0 0 0"/><worldbody><body>
<joint axis="0 0 1" armature="{!r}"/><inertial pos="0 0 0" mass="1e-9" diaginertia="1e-9 1e-9 1e-9"/>
</body></worldbody></mujoco>"""


@dataclass(frozen=True, kw_only=True, slots=True)
class SimulatedGap:
    """Simulated less recorded position at the ends of windows of 0.2 s, root mean square, of one joint."""

    joint: int  # number of the joint, 1..n
    without_rad: float  # without friction
    with_rad: float  # with the friction that is exported
    windows: int  # number of windows


def hinge(inertia_kg_m2: float) -> "MjModel":
    """Return a model of one joint with nothing but an inertia."""
    import mujoco

    return mujoco.MjModel.from_xml_string(HINGE.format(inertia_kg_m2))


def simulated_gaps(
    model: "MjModel", t: Float, q: Float, dq: Float, torque: Float, friction: Sequence[FittedFriction | None]
) -> tuple[Float, Float, int]:
    """Move an arm by recorded torques over windows that each start from the recording, without friction and with it.

    Args:
        model: The arm, j joints that turn, without friction.
        t: Times, strictly increasing, shape (n,). [s]
        q: Positions, shape (n, j). [rad]
        dq: Velocities, shape (n, j). [rad/s]
        torque: Torques on the joints, shape (n, j). [N m]
        friction: Friction of each joint, None for one without.

    Returns:
        Root mean square of simulated less recorded position at the ends of the windows, without friction and with it,
        shape (j,) each [rad], and the number of windows.
    """
    usual = float(np.median(np.diff(t)))
    step = min(STEP_S, usual)
    steps = round(WINDOW_S / step)
    times = np.arange(t[0], t[-1], step)
    drive, position, velocity = (
        np.column_stack([np.interp(times, t, column) for column in signal.T]) for signal in (torque, q, dq)
    )
    starts = np.arange(0, len(times) - steps, steps)
    gaps = t[:-1][np.diff(t) > GAP_STEPS * usual]
    begins = times[starts]
    inside = np.searchsorted(gaps, begins) != np.searchsorted(gaps, begins + WINDOW_S)
    starts = starts[~inside]
    starts = starts[np.linspace(0, len(starts) - 1, min(len(starts), MOST_WINDOWS)).astype(np.int64)]
    bare = copy(model)
    bare.opt.timestep = step
    rubbing = copy(bare)
    for dof, fitted in enumerate(friction):
        if fitted is not None:
            rubbing.dof_frictionloss[dof] = fitted.coulomb_nm
            rubbing.dof_damping[dof] = fitted.viscous_nms_per_rad
            rubbing.dof_dampingpoly[dof] = fitted.quadratic_nms2_per_rad2, fitted.cubic_nms3_per_rad3
    if not len(starts):
        return np.full(model.nv, np.nan), np.full(model.nv, np.nan), 0
    ends = position[starts + steps]
    errors = [_ends(one, drive, position, velocity, starts, steps) - ends for one in (bare, rubbing)]
    without, with_friction = (np.sqrt(np.mean(error**2, axis=0)) for error in errors)
    return without, with_friction, len(starts)


def _ends(model: "MjModel", drive: Float, q: Float, dq: Float, starts: Sequence[int], steps: int) -> Float:
    """Return the positions that the simulation reaches from each start, shape (w, j)."""
    import mujoco

    data, ends = mujoco.MjData(model), np.empty((len(starts), model.nv))
    for window, start in enumerate(starts):
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = q[start], dq[start]
        for k in range(start, start + steps):
            data.qfrc_applied[:] = 0.5 * (drive[k] + drive[k + 1])
            mujoco.mj_step(model, data)
        ends[window] = data.qpos
    return ends
