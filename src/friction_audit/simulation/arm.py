"""A whole arm, its hand guided by a person or its joints moved by its own motors; MuJoCo does the dynamics."""

from dataclasses import field, replace

import numpy as np

from friction_audit.compensation.controller import HAND_STATES
from friction_audit.compensation.law import Checked, within
from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.robot.arm import STANDARD_GRAVITY, load_arm
from friction_audit.simulation import settings as shared
from friction_audit.simulation.bench import JOINTS, PandaSettings, Progress, build_mechanism, moved_by, rotor_inertia
from friction_audit.simulation.effects import Hidden
from friction_audit.simulation.mechanics.control_loop import run, set_equilibrium, set_hand_impedance, set_masses
from friction_audit.simulation.mechanics.records import Mechanism
from friction_audit.simulation.periodic import Commanded, multisine
from friction_audit.simulation.strokes import HandPath, plan_hand

CHUNK_TICKS = 1000  # between two reports of the progress
BRAKE_NM = 1e6  # what a brake holds


class Hand(Checked):
    """A mass that holds the flange, drawn by springs and dampers along an intended path; the person bears its weight.

    The defaults are those of braced arms: stiff, and damped so that the hand rests in its pauses.
    """

    mass_kg: float = within(1.0)  # mass of the hand [kg]
    stiffness_n_per_m: float = within(1500.0)  # spring between intended and actual position [N/m]
    damping_ns_per_m: float = within(250.0)  # damper between them [N s/m]
    turning_stiffness_nm_per_rad: float = within(25.0)  # spring between intended and actual orientation [N m/rad]
    turning_damping_nms_per_rad: float = within(5.0)  # damper between them [N m s/rad]
    path: HandPath = field(default_factory=HandPath)  # the intended path


class Servo(Checked):
    """The position controller of every joint of an arm that moves by itself."""

    stiffness_nm_per_rad: float = within(600.0)  # of every joint [N m/rad]
    damping_nms_per_rad: float = within(50.0)  # of every joint [N m s/rad]
    motion: Commanded = field(default_factory=Commanded)  # what the joints are commanded to do


class ArmSettings(PandaSettings):
    """A Panda, who moves it, one recording."""

    duration_s: float = within(60.0, 0.0, shared.LONGEST_S)  # length of the recording [s]
    hand: Hand = field(default_factory=Hand)  # the person's hand at the flange
    servo: Servo = field(default_factory=Servo)  # the controller of an arm that moves by itself
    # False: the hand guides the arm and friction is on the motors' side of the sensors. True: the motors move it
    # without contact, and friction is on the links' side.
    driven: bool = False
    # a friction compensator active in every joint, the same or one for each, or None
    compensator: shared.AnyCompensator | None = None
    # True: the speed of the hand ends the cycles of all compensators at once (paper, section V.B)
    hand_cycles: bool = True
    braked: tuple[int, ...] = ()  # numbers of joints that do not move
    carried_kg: float = within(0.0, 0.0, 100.0)  # mass at the flange that gravity compensation does not know of [kg]
    compensates_gravity: bool = True  # whether the motors hold the arm against gravity
    logs_temperature: bool = False  # True: the log holds the temperature too

    def __post_init__(self) -> None:
        PandaSettings.__post_init__(self)
        if not set(self.braked) <= set(range(1, JOINTS + 1)):
            raise UsageError(f"arm: braked {self.braked}: expected joints from 1 to {JOINTS}")

    @property
    def moving(self) -> tuple[int, ...]:
        """Numbers of the joints that move."""
        return tuple(joint for joint in range(1, len(self.joints) + 1) if joint not in self.braked)

    def move(self, streams: shared.Streams, path: str, progress: Progress | None) -> shared.Moved:
        """Move the arm from rest; masses, gravity and the pull of the hand are those of the pose at each tick."""
        ticks, pose = shared.count_ticks(self.duration_s, self.rate_hz), np.array(self.pose_rad)
        joints, hidden = list(self.joints), list(self.hidden)
        for number in self.braked:  # a brake holds its joint, in which nothing hidden can then be felt
            joints[number - 1] = replace(joints[number - 1], coulomb_nm=BRAKE_NM)
            hidden[number - 1] = Hidden()
        held = replace(self, joints=tuple(joints), hidden=tuple(hidden))
        mechanism = build_mechanism(held, ticks, pose, streams)
        gravity = np.zeros((ticks + 1, len(pose)))
        arm = (ServoedArm if self.driven else GuidedArm)(self, mechanism, streams.person)
        # The inner sides, the motors' or the links', bear gravity compensation or their weight.
        load = -arm.compute(pose, 0.0 * pose)[1] if self.driven else arm.support(pose)
        set_equilibrium(mechanism.joints, mechanism.body, load)
        for k in range(ticks + 1):
            # Position and velocity at tick k, half a tick after the mechanism's state except at the start.
            ahead, (y, v, a) = 0.5 * mechanism.dt * (k > 0), (of[arm.link] for of in arm.states)
            q, dq = y + ahead * (v + 0.5 * ahead * a), v + ahead * a
            gravity[k] = arm.support(q)
            arm.pull(k, q, *arm.compute(q, dq), gravity[k])
            run(mechanism, np.zeros(0), np.zeros(0), arm.jacobian, arm.cycle, k, k + 1)
            if progress is not None and k % CHUNK_TICKS == 0:
                progress(k / ticks)
        return moved_by(mechanism, path, gravity)


HAND_INERTIA_KG_M2 = 0.002  # of the hand about any axis through the flange; a guess that hardly matters


class ArmDynamics:
    """The true arm, the controller's model of it, and the mechanism that moves."""

    def __init__(self, settings: ArmSettings, mechanism: Mechanism, held_kg: float) -> None:
        import mujoco as mj

        self.settings, self.mechanism, self._mj = settings, mechanism, mj
        self.rotor = rotor_inertia(settings.joints, settings.hidden)
        turning = np.eye(3) * (HAND_INERTIA_KG_M2 if held_kg > 0 else 0.0)
        known = load_arm()
        self._known = known.model
        self._model = known.with_load(settings.carried_kg + held_kg, np.zeros(3), turning).model
        self._known_data, self._data = mj.MjData(self._known), mj.MjData(self._model)
        self._flange = self._model.body(known.flange).id
        by_hand = settings.compensator is not None and settings.hand_cycles
        self.cycle = np.zeros(HAND_STATES if by_hand else 0)
        self._ticks, self._dt = len(mechanism.out) - 1, mechanism.dt
        self._joints = n = len(settings.joints)
        self._mass, self._bias, self._held, self.jacobian = (np.zeros(s) for s in ((n, n), n, n, (6, n)))
        # Views, taken once: to ask a record for a field takes longer than the arithmetic of a tick.
        body = mechanism.body
        self.link, self.states = body.inner[:n] if settings.driven else slice(n), (body.y, body.v, body.a)

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


class GuidedArm(ArmDynamics):
    """An arm whose hand is guided."""

    def __init__(self, settings: ArmSettings, mechanism: Mechanism, person: np.random.Generator) -> None:
        from scipy.spatial.transform import Rotation

        hand = settings.hand
        super().__init__(settings, mechanism, hand.mass_kg)
        intended = plan_hand(hand.path, self._ticks, self._dt, person)
        self._springs = np.repeat([hand.stiffness_n_per_m, hand.turning_stiffness_nm_per_rad], 3)
        self._dampers = np.repeat([hand.damping_ns_per_m, hand.turning_damping_nms_per_rad], 3)
        self._lift = -hand.mass_kg * np.array([*STANDARD_GRAVITY, 0.0, 0.0, 0.0])
        self._target = np.hstack([intended.velocity, intended.angular])
        self.compute(np.array(settings.pose_rad), np.zeros(self._joints))
        self._place = self._data.xpos[self._flange] + intended.position
        upright = self._data.xmat[self._flange].reshape(3, 3)
        self._orientation = Rotation.from_rotvec(intended.rotation).as_matrix() @ upright
        self._quaternion, self._turn = np.zeros(4), np.zeros(3)

    def pull(self, k: int, q: Float, mass: Float, bias: Float, gravity: Float) -> None:
        """Let the hand pull from half a tick before tick k to half a tick after it."""
        mj, data, jacobian, springs, dampers = self._mj, self._data, self.jacobian, self._springs, self._dampers
        body, rotor = self.mechanism.body, self.rotor
        mj.mj_jacBody(self._model, data, jacobian[:3], jacobian[3:], self._flange)
        mj.mju_mat2Quat(self._quaternion, (self._orientation[k] @ data.xmat[self._flange].reshape(3, 3).T).ravel())
        mj.mju_quat2Vel(self._turn, self._quaternion, 1.0)
        off, target = np.concatenate([self._place[k] - data.xpos[self._flange], self._turn]), self._target[k]
        pull = springs * off + dampers * target + self._lift
        set_hand_impedance(body, mass, bias, jacobian, springs, dampers, pull, springs * target, q, rotor, gravity)


class ServoedArm(ArmDynamics):
    """An arm that moves by itself."""

    def __init__(self, settings: ArmSettings, mechanism: Mechanism, person: np.random.Generator) -> None:
        super().__init__(settings, mechanism, 0.0)
        self._servo, body = settings.servo, mechanism.body
        self._command = multisine(self._servo.motion, self._joints, self._ticks, self._dt, person)
        body.stiffness[:] = np.eye(len(body.y)) * self._servo.stiffness_nm_per_rad
        body.drive_damping[:] = np.eye(len(body.y)) * self._servo.damping_nms_per_rad

    def pull(self, k: int, _: Float, mass: Float, bias: Float, gravity: Float) -> None:
        """Let the motors pull, likewise."""
        body, servo, n = self.mechanism.body, self._servo, self._joints
        position, speed = self._command.position[k] + self.settings.pose_rad, self._command.velocity[k]
        body.push[:n] = gravity + servo.stiffness_nm_per_rad * position + servo.damping_nms_per_rad * speed
        body.push_rate[:n] = servo.stiffness_nm_per_rad * speed
        body.support[:n] = -bias
        set_masses(body, self.rotor, mass)
