"""A row of the balance: which torques are taken from the source, and with which sign."""

from dataclasses import dataclass

import numpy as np

from friction_audit.interaction.interaction import SignEvidence
from friction_audit.interaction.plan import CHANNELS, Plan
from friction_audit.interaction.resample import GridTorque
from friction_audit.interaction.sign import CoarseLog, most
from friction_audit.joint_log import Float, JointLog
from friction_audit.per_joint import per_joint

SIGNS = {"hand": -1, "robot": 1}
"""Factor on tau_J and on tau_ext in the balance of each row."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Balance:
    """One row of the balance: F_m = sign * (source - each of the torques removed)."""

    drive: str
    sign: int
    inertia: bool
    logged: Float | None
    modelled: GridTorque | None
    evidence: tuple[SignEvidence, ...] = ()

    @property
    def proved(self) -> bool:
        """True if the energy rises on most of the moving joints."""
        return most(self.evidence, "rises")

    def coarse(self, log: JointLog, coarse: CoarseLog, source: Float) -> Float:
        """Make the torque of all joints at the coarse log's times, for the proof of the sign."""
        torque = coarse.mean(source)
        if self.logged is not None:
            torque -= coarse.mean(self.logged)
        if self.modelled is not None:
            self.modelled.subtract_from(torque, coarse.t, list(range(len(log.joint_names))))
        return self.sign * torque

    def full(self, log: JointLog, source: Float, columns: list[int]) -> Float:
        """Make the torque of some joints, column by column; the recorded array itself where nothing is to be done."""
        if self.sign > 0 and self.logged is None and self.modelled is None and len(columns) == source.shape[1]:
            return source
        torque = np.empty((len(log.t), len(columns)), order="F")
        per_joint(lambda place: self._fill(torque[:, place], log.t, source, columns[place]), len(columns))
        return torque

    def _fill(self, torque: Float, t: Float, source: Float, column: int) -> None:
        if self.logged is None:
            torque[:] = source[:, column]
        else:
            np.subtract(source[:, column], self.logged[:, column], out=torque)
        if self.modelled is not None:
            self.modelled.subtract_from(torque[:, None], t, [column])
        if self.sign < 0:
            np.negative(torque, out=torque)


def formula(plan: Plan, balance: Balance) -> str:
    """Return the balance in words, for people."""
    if plan.source != "tau_J":
        return f"F_m = {'-' if balance.sign < 0 else ''}{CHANNELS[plan.source]}"
    removed = [name for name, there in (("M ddq", balance.inertia), ("c", balance.inertia)) if there]
    removed += ["g"] if plan.gravity != "none" else []
    inside = "" if plan.gravity != "none" else ", gravity still inside"
    if balance.drive == "hand":
        return f"F_m = {''.join(f'{name} ' for name in removed)}-{' ' if removed else ''}tau_J{inside}"
    listed = " + ".join(removed)
    return "F_m = tau_J" + (f" - ({listed})" if len(removed) > 1 else f" - {listed}" if removed else "") + inside
