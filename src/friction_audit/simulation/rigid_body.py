"""The arm's masses and forces at each tick, from MuJoCo, in the coordinates of the mechanics."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from friction_audit.compensation.hand_cycles import CYCLE_STATE
from friction_audit.joint_log import Float
from friction_audit.robot import STANDARD_GRAVITY, Arm
from friction_audit.simulation.mechanics.tick import guide, load_masses, tick_arm
from friction_audit.simulation.mechanism import Mechanism
from friction_audit.simulation.motion import HandMotion, Intention

if TYPE_CHECKING:
    from friction_audit.simulation.arm import ArmSettings

HAND_INERTIA_KG_M2 = 0.002  # of the hand about any axis through the flange; a guess that hardly matters


class RigidBody:
    """The true arm, the controller's model of it, and the mechanism that moves.

    Attributes:
        settings: What is simulated.
        mechanism: What moves.
        rotor: Mass matrix of the motors, shape (n, n). [kg m^2]
    """

    def __init__(self, settings: "ArmSettings", known: Arm, mechanism: Mechanism, rotor: Float, held_kg: float) -> None:
        import mujoco as mj

        self.settings, self.mechanism, self.rotor = settings, mechanism, rotor
        self._mj = mj
        turning = np.eye(3) * (HAND_INERTIA_KG_M2 if held_kg > 0 else 0.0)
        true = known.with_load(settings.carried_kg + held_kg, np.zeros(3), turning)
        self._known, self._model = known.model, true.model
        self._known_data, self._data = mj.MjData(self._known), mj.MjData(self._model)
        self._flange = self._model.body(known.flange).id
        self._parts, self._cycle = mechanism.parts, np.zeros(CYCLE_STATE)
        self._half = 0.5 * mechanism.clock.dt
        self._last = len(mechanism.out) - 1
        self._joints = n = len(settings.joints)
        self._mass, self._bias, self._held, self._jacobian = (np.zeros(s) for s in ((n, n), n, n, (6, n)))
        # Views, taken once: to ask a record for a field takes longer than the arithmetic of a tick.
        body = mechanism.body
        link = body.inner[:n] if settings.driven else slice(n)
        self._link, self._y, self._v, self._a = link, body.y, body.v, body.a

    def predict(self, k: int) -> tuple[Float, Float]:
        """Return position and velocity at tick k, half a tick after the mechanism's state except at the start."""
        ahead = self._half if k > 0 else 0.0
        y, v, a = self._y[self._link], self._v[self._link], self._a[self._link]
        return y + ahead * (v + 0.5 * ahead * a), v + ahead * a

    def support(self, q: Float) -> Float:
        """Return the torque with which the controller holds the arm against gravity, by its own model, shape (n,)."""
        if not self.settings.compensates_gravity:
            return np.zeros(self._joints)
        mj, model, data = self._mj, self._known, self._known_data
        data.qpos[:] = q
        mj.mj_kinematics(model, data)
        mj.mj_comPos(model, data)
        mj.mj_rne(model, data, 0, self._held)
        return self._held

    def load(self, q: Float) -> Float:
        """Return what the inner sides bear at rest, the motors gravity compensation or the links their weight."""
        return -self.compute(q, np.zeros(self._joints))[1] if self.settings.driven else self.support(q)

    def compute(self, q: Float, dq: Float) -> tuple[Float, Float]:
        """Return mass matrix and Coriolis plus gravity torque of the true arm."""
        mj, model, data = self._mj, self._model, self._data
        data.qpos[:], data.qvel[:] = q, dq
        mj.mj_kinematics(model, data)
        mj.mj_comPos(model, data)
        mj.mj_makeM(model, data)
        mj.mj_fullM(model, data, self._mass)
        mj.mj_comVel(model, data)
        mj.mj_rne(model, data, 0, self._bias)
        return self._mass, self._bias

    def tick(self, k: int, gravity: Float) -> None:
        """Move on from half a tick before tick k to half a tick after it; write the gravity compensation down."""
        raise NotImplementedError

    def _advance(self, k: int, *, by_hand: bool) -> None:
        out, traced = self.mechanism.out, self.mechanism.traced
        tick_arm(self._parts, self._jacobian, self._cycle, by_hand, k, self._last, out, traced)


class GuidedArm(RigidBody):
    """An arm whose hand is guided."""

    def __init__(
        self, settings: "ArmSettings", known: Arm, mechanism: Mechanism, rotor: Float, intended: HandMotion
    ) -> None:
        super().__init__(settings, known, mechanism, rotor, settings.hand.mass_kg)
        hand = settings.hand
        self._springs = np.repeat([hand.stiffness_n_per_m, hand.turning_stiffness_nm_per_rad], 3)
        self._dampers = np.repeat([hand.damping_ns_per_m, hand.turning_damping_nms_per_rad], 3)
        self._lift = -hand.mass_kg * np.array([*STANDARD_GRAVITY, 0.0, 0.0, 0.0])
        self._target = np.hstack([intended.velocity, intended.angular])
        self._place, self._orientation = self._intend(intended)
        self._quaternion, self._turn = np.zeros(4), np.zeros(3)

    def _intend(self, intended: HandMotion) -> tuple[Float, Float]:
        """Return intended places, shape (ticks + 1, 3), and orientations, shape (ticks + 1, 3, 3)."""
        from scipy.spatial.transform import Rotation

        self.compute(np.array(self.settings.pose_rad), np.zeros(self._joints))
        start, upright = self._data.xpos[self._flange], self._data.xmat[self._flange].reshape(3, 3)
        return start + intended.position, Rotation.from_rotvec(intended.rotation).as_matrix() @ upright

    def tick(self, k: int, gravity: Float) -> None:
        """Move on from half a tick before tick k to half a tick after it."""
        q, dq = self.predict(k)
        mass, bias = self.compute(q, dq)
        mj, data, jacobian = self._mj, self._data, self._jacobian
        mj.mj_jacBody(self._model, data, jacobian[:3], jacobian[3:], self._flange)
        mj.mju_mat2Quat(self._quaternion, (self._orientation[k] @ data.xmat[self._flange].reshape(3, 3).T).ravel())
        mj.mju_quat2Vel(self._turn, self._quaternion, 1.0)
        off = np.concatenate([self._place[k] - data.xpos[self._flange], self._turn])
        target = self._target[k]
        pull = self._springs * off + self._dampers * target + self._lift
        gravity[:] = self.support(q)
        guide(
            self.mechanism.body,
            mass,
            bias,
            jacobian,
            self._springs,
            self._dampers,
            pull,
            self._springs * target,
            q,
            self.rotor,
            gravity,
        )
        self._advance(k, by_hand=self.settings.compensator is not None and self.settings.hand_cycles)


class ServoedArm(RigidBody):
    """An arm that moves by itself."""

    def __init__(
        self, settings: "ArmSettings", known: Arm, mechanism: Mechanism, rotor: Float, command: Intention
    ) -> None:
        super().__init__(settings, known, mechanism, rotor, 0.0)
        servo = settings.servo
        self._command = replace(command, position=command.position + np.array(settings.pose_rad))
        body = mechanism.body
        body.stiffness[:] = np.eye(len(body.y)) * servo.stiffness_nm_per_rad
        body.drive_damping[:] = np.eye(len(body.y)) * servo.damping_nms_per_rad

    def tick(self, k: int, gravity: Float) -> None:
        """Move on from half a tick before tick k to half a tick after it."""
        q, dq = self.predict(k)
        mass, bias = self.compute(q, dq)
        gravity[:] = self.support(q)
        body, servo, n = self.mechanism.body, self.settings.servo, self._joints
        place, speed = self._command.position[k], self._command.velocity[k]
        body.push[:n] = gravity + servo.stiffness_nm_per_rad * place + servo.damping_nms_per_rad * speed
        body.push_rate[:n] = servo.stiffness_nm_per_rad * speed
        body.support[:n] = -bias
        load_masses(body, self.rotor, mass)
        self._advance(k, by_hand=False)
