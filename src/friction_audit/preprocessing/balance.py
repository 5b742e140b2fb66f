"""A row of the balance: which torques are removed from the source, with which sign, and what the energy says of it."""

from typing import NamedTuple, cast

import numpy as np

from friction_audit.joint_log import Float, JointLog
from friction_audit.parallel import WORKERS, per_joint
from friction_audit.preprocessing.interaction import SignEvidence
from friction_audit.preprocessing.resampling import GridTorque
from friction_audit.preprocessing.sign import CoarseLog
from friction_audit.preprocessing.torque_source import CHANNELS, Plan

SIGNS = {"hand": -1, "robot": 1}  # factor on tau_J and on tau_ext in each row


class Balance(NamedTuple):
    """One row of the balance: F_m = sign * (source - each of the torques removed)."""

    plan: Plan
    source: Float
    drive: str
    sign: int
    logged: Float | None
    inertial: GridTorque | None  # M ddq + c of the model, or None
    modelled_means: Float | None  # what the model removes at the times of the coarse log, shape (m, j), or None
    evidence: tuple[SignEvidence, ...] = ()

    @property
    def inertia_left(self) -> bool:
        """True if joints that move together leave inertial and Coriolis torque in F_m."""
        by_motors = self.drive == "robot" and self.plan.source == "tau_J"
        return by_motors and self.inertial is None and self.source.shape[1] > 1

    @property
    def formula(self) -> str:
        """The balance in words, for people."""
        source, gravity = self.plan.source, self.plan.gravity
        if source != "tau_J":
            return f"F_m = {'-' if self.sign < 0 else ''}{CHANNELS[source]}"
        removed = ["M ddq", "c"] if self.inertial is not None else []
        removed += ["g"] if gravity in ("logged", "model") else []
        inside = ", gravity included" if gravity == "in-torque" else ""
        if self.drive == "hand":
            return f"F_m = {''.join(f'{name} ' for name in removed)}-{' ' if removed else ''}tau_J{inside}"
        listed = " + ".join(removed)
        return "F_m = tau_J" + (f" - ({listed})" if len(removed) > 1 else f" - {listed}" if removed else "") + inside

    def coarse(self, coarse: CoarseLog) -> Float:
        """Return F_m of all joints at the coarse log's times, shape (m, j). [N m]"""
        torque = coarse.mean(self.source)
        if self.logged is not None:
            torque -= coarse.mean(self.logged)
        if self.modelled_means is not None:
            torque -= self.modelled_means
        return self.sign * torque

    def driving(self, log: JointLog, coarse: CoarseLog) -> Float:
        """Return F_m + u of all joints at the coarse log's times, shape (m, j). [N m]"""
        torque = self.coarse(coarse)
        for active in (log.tau_compensation, log.tau_passivity):
            if active is not None:
                torque += coarse.mean(active)
        return torque

    def full(self, log: JointLog, columns: list[int]) -> Float:
        """Return F_m of some joints at every sample of the log or of a part of it, shape (n, len(columns)). [N m]"""
        source, logged = getattr(log, CHANNELS[self.plan.source]), None if self.logged is None else log.gravity
        if self.sign > 0 and logged is None and self.modelled_means is None and len(columns) == source.shape[1]:
            return cast("Float", source)
        torque, arm, weight = np.empty((len(log.t), len(columns)), order="F"), self.plan.arm, logged
        if arm is not None and self.plan.gravity == "model":
            pieces = np.array_split(log.q, WORKERS)
            weight = np.concatenate(per_joint(lambda piece: arm.gravity(pieces[piece]), WORKERS))

        def fill(place: int) -> None:
            own, column = torque[:, place], columns[place]
            np.subtract(source[:, column], 0.0 if weight is None else weight[:, column], out=own)
            if self.inertial is not None:
                self.inertial.subtract_from(own[:, None], log.t, [column])
            if self.sign < 0:
                np.negative(own, out=own)

        per_joint(fill, len(columns))
        return torque
