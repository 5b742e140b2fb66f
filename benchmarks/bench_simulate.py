"""How long a simulated minute takes, beside the usual ways to write such a simulation; after compilation.

    python benchmarks/bench_simulate.py [--runs 3] [--duration 60]

One joint: SciPy's ``solve_ivp`` on the same equations, friction that sticks and slips through events. Seven joints: a
loop in Python with MuJoCo's forward dynamics every 0.1 ms, semi-implicit Euler, friction smoothed by a
tanh. What is compared takes turns in one run; the largest difference between the motions shows how alike they are.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import mujoco as mj
import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from friction_audit.joint_log import Float
from friction_audit.robot import load_arm
from friction_audit.simulation import IDEAL_SENSORS, ArmSettings, BenchSettings, simulate
from friction_audit.simulation.settings import make_streams
from friction_audit.simulation.strokes import plan_hand

DT = 1e-3
STEP_S = 1e-4
SMOOTHING_RAD_S = 0.005
"""Speed over which the friction of the loop in Python rises to its level; a tanh creeps where real friction holds."""

SEED = 1
TURNING_KG_M2 = 0.002
"""Inertia of the hand about the flange, as in the simulator."""


@dataclass
class OneJoint:
    """A joint of the bench as an ordinary differential equation with events."""

    settings: BenchSettings
    push: Float

    def __post_init__(self) -> None:
        """Gather the numbers."""
        joint, hand = self.settings.joints[0], self.settings.operator
        self.mass = joint.inertia_kg_m2 + hand.inertia_kg_m2
        self.stiffness, self.damping = hand.stiffness_nm_per_rad, hand.damping_nms_per_rad
        self.coulomb, self.viscous = joint.coulomb_nm, joint.viscous_nms_per_rad
        self.sign = 0.0

    def pull(self, t: float, y: Float) -> float:
        """Return all torques but friction; the drive's is linear from tick to tick."""
        place = t / DT
        k = min(int(place), len(self.push) - 2)
        push = self.push[k] + (place - k) * (self.push[k + 1] - self.push[k])
        return float(push - self.stiffness * y[0] - self.damping * y[1])

    def slope(self, t: float, y: Float) -> tuple[float, float]:
        """Return velocity and acceleration."""
        if self.sign == 0.0:
            return 0.0, 0.0
        return y[1], (self.pull(t, y) - self.sign * self.coulomb - self.viscous * y[1]) / self.mass

    def ends(self, t: float, y: Float) -> float:
        """Cross zero where the joint stops, or where friction no longer holds it."""
        return self.coulomb - abs(self.pull(t, y)) if self.sign == 0.0 else self.sign * y[1] + 1e-12

    ends.terminal = True  # type: ignore[attr-defined]
    ends.direction = -1.0  # type: ignore[attr-defined]

    def run(self) -> Float:
        """Return the positions at the ticks."""
        ticks = np.arange(len(self.push)) * DT
        positions, t, y = np.zeros(len(ticks)), 0.0, np.zeros(2)
        while t < ticks[-1]:
            rest = ticks[ticks > t]
            part = solve_ivp(
                self.slope, (t, ticks[-1]), y, t_eval=rest, events=self.ends, rtol=1e-7, atol=1e-9, max_step=0.01
            )
            first = len(ticks) - len(rest)
            positions[first : first + part.y.shape[1]] = part.y[0]
            if part.t_events is None or part.y_events is None or part.status != 1:
                break
            t, y = float(part.t_events[0][0]), np.array([part.y_events[0][0][0], 0.0])
            over = self.pull(t, y)
            self.sign = 0.0 if abs(over) < self.coulomb and self.sign != 0.0 else float(np.sign(over))
        return positions


def one_joint(duration_s: float) -> tuple[Callable[[], Float], Callable[[], Float]]:
    """Return the simulator and its rival, each giving the positions at the ticks."""
    settings = BenchSettings(sensors=(IDEAL_SENSORS,), duration_s=duration_s)
    hand, ticks = settings.operator, round(duration_s / DT)
    meant = hand.motion.intend(ticks, DT, make_streams(SEED, 1).person)
    push = hand.stiffness_nm_per_rad * meant.position + hand.damping_nms_per_rad * meant.velocity
    return lambda: simulate(settings, SEED).truth.motion.q[:, 0], OneJoint(settings, push).run


def loop_in_python(settings: ArmSettings) -> Float:
    """Return the positions of the seven joints at the ticks."""
    known, hand = load_arm(), settings.hand
    model = known.with_load(hand.mass_kg, np.zeros(3), np.eye(3) * TURNING_KG_M2).model
    model.dof_armature[:] = [joint.inertia_kg_m2 for joint in settings.joints]
    data, known_data, flange = mj.MjData(model), mj.MjData(known.model), model.body(known.flange).id
    coulomb = np.array([joint.coulomb_nm for joint in settings.joints])
    viscous = np.array([joint.viscous_nms_per_rad for joint in settings.joints])
    springs = np.repeat([hand.stiffness_n_per_m, hand.turning_stiffness_nm_per_rad], 3)
    dampers = np.repeat([hand.damping_ns_per_m, hand.turning_damping_nms_per_rad], 3)
    lift = np.array([0.0, 0.0, 9.81 * hand.mass_kg, 0.0, 0.0, 0.0])
    data.qpos[:] = settings.pose_rad
    ticks, steps = round(settings.duration_s / DT), round(DT / STEP_S)
    path = plan_hand(hand.path, ticks, DT, make_streams(SEED, 7).person)
    mj.mj_kinematics(model, data)
    place, orientation = data.xpos[flange], data.xmat[flange].reshape(3, 3)
    places = place + path.position
    turns = Rotation.from_rotvec(path.rotation).as_matrix() @ orientation
    speeds = np.hstack([path.velocity, path.angular])
    positions = np.empty((ticks + 1, 7))
    jacobian, quaternion, turn = np.empty((6, 7)), np.empty(4), np.empty(3)
    for k in range(ticks + 1):
        positions[k] = known_data.qpos[:] = data.qpos
        mj.mj_fwdPosition(known.model, known_data)
        mj.mj_fwdVelocity(known.model, known_data)
        for _ in range(steps):
            mj.mj_fwdPosition(model, data)
            mj.mj_fwdVelocity(model, data)
            mj.mj_jacBody(model, data, jacobian[:3], jacobian[3:], flange)
            mj.mju_mat2Quat(quaternion, (turns[k] @ orientation.T).ravel())
            mj.mju_quat2Vel(turn, quaternion, 1.0)
            off = np.concatenate([places[k] - place, turn])
            wrench = springs * off + dampers * (speeds[k] - jacobian @ data.qvel) + lift
            friction = coulomb * np.tanh(data.qvel / SMOOTHING_RAD_S) + viscous * data.qvel
            data.qfrc_applied[:] = known_data.qfrc_bias + jacobian.T @ wrench - friction
            mj.mj_fwdAcceleration(model, data)
            data.qvel += STEP_S * data.qacc_smooth
            data.qpos += STEP_S * data.qvel
    return positions


def seven_joints(duration_s: float) -> tuple[Callable[[], Float], Callable[[], Float]]:
    """Return the simulator and its rival, each giving the positions at the ticks."""
    settings = ArmSettings(sensors=(IDEAL_SENSORS,) * 7, duration_s=duration_s)
    return lambda: simulate(settings, SEED).truth.motion.q, lambda: loop_in_python(settings)


def compared(name: str, rival: str, goal: str, runs: int, pair: tuple[Callable[[], Float], Callable[[], Float]]) -> str:
    """Return the rows of a simulation and its rival."""
    taken: tuple[list[float], list[float]] = ([], [])
    found = [np.empty(0), np.empty(0)]
    for _ in range(runs):
        for place, run in enumerate(pair):
            before = time.perf_counter()
            found[place] = run()
            taken[place].append(time.perf_counter() - before)
    ours, theirs = map(statistics.median, taken)
    apart = np.abs(found[0] - found[1]).max()
    return (
        f"| {name} | friction-audit | {ours:.2f} ({goal}) |  |  |\n"
        f"| {name} | {rival} | {theirs:.1f} | {theirs / ours:.0f} | {apart:.1g} |"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--duration", type=float, default=60.0, help="length of the recordings [s]")
    arguments = parser.parse_args()
    for settings in (BenchSettings(), ArmSettings()):
        simulate(replace(settings, duration_s=0.1), SEED)
    seconds = f"{arguments.duration:g} s"
    print("| recording | method | wall [s] | times faster | largest difference [rad] |\n|---|---|---:|---:|---:|")
    print(
        compared(
            f"one joint, {seconds}",
            "scipy solve_ivp with events",
            "goal 1",
            arguments.runs,
            one_joint(arguments.duration),
        )
    )
    print(
        compared(
            f"seven joints, {seconds}",
            "mujoco in a Python loop",
            "goal 15",
            arguments.runs,
            seven_joints(arguments.duration),
        )
    )


if __name__ == "__main__":
    main()
