"""The rigid-body model of an arm, evaluated on whole arrays. MuJoCo does the dynamics."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass, replace
from functools import lru_cache, reduce
from importlib import import_module
from operator import add
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.presets import BUILT_IN

if TYPE_CHECKING:
    import mujoco

# How flange links end; where a URDF has none of them, the last link that the last joint moves is taken.
FLANGE_NAMES = ("link8", "flange", "tool0")
STANDARD_GRAVITY = (0.0, 0.0, -9.81)
CHUNK = 1 << 13
ZERO = 1e-15  # rounding of the cosine of a right angle

Payload = tuple[float, float, float, float]  # mass [kg] and place x, y, z [m] of a point mass in the flange frame


class Inertial(NamedTuple):
    """Mass [kg], centre of mass in the link's frame, shape (3,) [m], and inertia about it, shape (3, 3) [kg m^2]."""

    mass: float
    centre: Float
    inertia: Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Arm:
    """A rigid-body model; methods take q, dq, ddq in rad and s, (n, j), columns in the order of ``joint_names``."""

    name: str  # of the model in a result
    joint_names: tuple[str, ...]  # of the joints that count, base to tip
    flange: str  # name of the flange link, where a payload sits and whose speed is the hand's
    model: "mujoco.MjModel"  # one hinge per joint, no limits, no contacts
    columns: tuple[int, ...]  # column of the caller's arrays that each hinge of the model reads

    def matched(self, joint_names: tuple[str, ...], where: str) -> "Arm":
        """Return the arm with its columns in the order of a log: by name if the names agree, else as is."""
        if len(joint_names) != len(self.joint_names):
            raise UsageError(
                f"{where}: joints: {len(joint_names)} ({', '.join(joint_names)}); the model {self.name} needs "
                f"{len(self.joint_names)} ({', '.join(self.joint_names)}); give the arm's own --urdf, or --robot none"
            )
        if set(joint_names) != set(self.joint_names):
            return self
        columns = tuple(joint_names.index(name) for name in self.joint_names)
        return replace(self, joint_names=joint_names, columns=columns)

    def gravity(self, q: Float) -> Float:
        """Return the torque that holds the arm against gravity, shape (n, j). [N m]"""
        model, torque = self.model, np.empty(q.shape, order="F")
        axes, turns, reaches, anchor = self._joint_axes()
        mass = model.body_mass.copy()
        # Mass times centre of mass of each body with those that it carries, joints at 0, about its own joint.
        still = [axes[body] @ (mass[body] * (model.body_ipos[body] - anchor[body])) for body in range(model.nbody)]
        for body in range(model.nbody - 1, 0, -1):
            parent = model.body_parentid[body]
            still[parent], mass[parent] = still[parent] + mass[body] * reaches[body], mass[parent] + mass[body]
        for rows in chunks(len(q)):
            cosine, sine, down = self._down(q[rows], turns)
            moment = [list(one) for one in still]
            for body in range(model.nbody - 1, 0, -1):
                joint, parent, own = model.body_jntadr[body], model.body_parentid[body], moment[body]
                if joint >= 0:
                    torque[rows, joint] = own[1] * down[body][0] - own[0] * down[body][1]
                    own = _turned(own, cosine[joint], sine[joint])
                moment[parent] = [*map(add, moment[parent], _times(turns[body].T, own))]
        return self.to_model(torque, back=True)

    def inverse_dynamics(self, q: Float, dq: Float, ddq: Float) -> Float:
        """Return M(q) ddq + c(q, dq) + g(q), without friction, shape (n, j). [N m]"""
        import mujoco as mj

        model, data = self.model, mj.MjData(self.model)
        torque, place, speed, push = np.empty(q.shape), data.qpos, data.qvel, data.qacc
        motion = zip(self.to_model(q), self.to_model(dq), self.to_model(ddq), torque, strict=True)
        for position, velocity, acceleration, row in motion:
            place[:], speed[:], push[:] = position, velocity, acceleration
            mj.mj_kinematics(model, data)
            mj.mj_comPos(model, data)
            mj.mj_comVel(model, data)
            mj.mj_rne(model, data, 1, row)
        return self.to_model(torque, back=True)

    def mass_diagonal(self, q: Float) -> Float:
        """Return the diagonal of the mass matrix, shape (n, j). [kg m^2]"""
        still, weight, units = np.zeros_like(q), self.gravity(q), np.eye(q.shape[1])
        own = [self.inverse_dynamics(q, still, still + unit)[:, k] - weight[:, k] for k, unit in enumerate(units)]
        return np.column_stack(own)

    def hand_speed(self, q: Float, dq: Float) -> Float:
        """Return the speed of the flange frame's origin, shape (n,). [m/s]"""
        import mujoco as mj

        model, data = self.model, mj.MjData(self.model)
        flange, twist = model.body(self.flange).id, np.empty((len(q), 6))
        for position, velocity, row in zip(self.to_model(q), self.to_model(dq), twist, strict=True):
            data.qpos[:], data.qvel[:] = position, velocity
            mj.mj_kinematics(model, data)
            mj.mj_comPos(model, data)
            mj.mj_comVel(model, data)
            mj.mj_objectVelocity(model, data, mj.mjtObj.mjOBJ_XBODY, flange, row, 0)
        return np.asarray(np.linalg.norm(twist[:, 3:], axis=1))

    def gravity_direction(self, q: Float) -> Float:
        """Return the unit vector of gravity across each joint's axis, seen from the link it moves, shape (n, j, 2)."""
        direction, (_, turns, *_) = np.empty((*q.shape, 2)), self._joint_axes()
        for rows in chunks(len(q)):
            _, _, down = self._down(q[rows], turns)
            for joint, body in enumerate(self.model.jnt_bodyid):
                direction[rows, joint, 0], direction[rows, joint, 1] = down[body][:2]
        return self.to_model(direction / np.linalg.norm(self.model.opt.gravity), back=True)

    @lru_cache(maxsize=4)  # noqa: B019 - of few arms, and asked for with every block of a log
    def _joint_axes(self) -> tuple[Float, Float, Float, Float]:
        """Return axes for each body, the third along its joint, so that it turns two components of a vector only.

        They are in its frame; the matrix to them from its parent's, joints at 0, shape (b, 3, 3) each; its joint in the
        parent's axes from the parent's joint, and in its own frame, shape (b, 3) each.
        """
        import mujoco as mj

        model, fixed = self.model, np.empty(9)
        axes, turns = np.tile(np.eye(3), (2, model.nbody, 1, 1))
        reaches, anchor = np.zeros((2, model.nbody, 3))
        anchor[model.jnt_bodyid] = model.jnt_pos
        for body, axis in zip(model.jnt_bodyid, model.jnt_axis, strict=True):
            across = np.linalg.svd(axis[None])[2][1]
            axes[body] = across, np.cross(axis, across), axis
        for body, parent in enumerate(model.body_parentid):
            mj.mju_quat2Mat(fixed, model.body_quat[body])
            turns[body] = axes[body] @ fixed.reshape(3, 3).T @ axes[parent].T
            turns[body][np.abs(turns[body]) < ZERO] = 0.0
            reach = model.body_pos[body] - anchor[parent]
            reaches[body] = axes[parent] @ reach + turns[body].T @ axes[body] @ anchor[body]
        return axes, turns, reaches, anchor

    def _down(self, q: Float, turns: Float) -> tuple[Float, Float, list[list[Float]]]:
        """Return cosine and sine of the model's joints, shape (j, n), gravity in the axes of each body."""
        # MuJoCo takes one posture at a time: called for every sample it takes as long as reading the log
        # (benchmarks/bench_parquet.py, the row of a model). Here every body turns the vector of its parent.
        model, angle = self.model, self.to_model(q).T
        half = np.tan(0.5 * angle)  # two thirds of the time of a cosine and a sine
        double = 2.0 / (1.0 + half * half)
        cosine, sine = double - 1.0, double * half
        down = [list(model.opt.gravity)]
        for body, parent in enumerate(model.body_parentid[1:], start=1):
            vector, joint = _times(turns[body], down[parent]), model.body_jntadr[body]
            down.append(vector if joint < 0 else _turned(vector, cosine[joint], -sine[joint]))
        return cosine, sine, down

    def with_gravity(self, vector: Sequence[float] | Float) -> "Arm":
        """Return the arm where gravity is another vector in the base frame, shape (3,). [m/s^2]"""
        model = copy(self.model)
        model.opt.gravity[:] = vector
        return replace(self, model=model)

    def with_load(self, mass_kg: float, centre_m: Float, inertia_kg_m2: Float) -> "Arm":
        """Return the arm with a body fixed to the flange, and its inertia about its centre in the flange's axes."""
        import mujoco as mj

        model, turned = copy(self.model), np.empty(9)
        body = model.body(self.flange).id
        mj.mju_quat2Mat(turned, model.body_iquat[body])
        axes = turned.reshape(3, 3)
        own = axes * model.body_inertia[body] @ axes.T
        link = Inertial(float(model.body_mass[body]), model.body_ipos[body].copy(), own)
        _set_inertial(model, body, link, Inertial(mass_kg, centre_m, inertia_kg_m2))
        return replace(self, model=model)

    def poses(self, q: Float) -> tuple[Float, Float, Float]:
        """Return poses of the links that the joints move, in the order of the model and in the axes of the base.

        Origin of each link, on its joint's axis, (j, 3, n) [m], orientation, (j, 3, 3, n), joint axis, (j, 3, n).
        """
        model, angle = self.model, self.to_model(q).T
        axes, turns, reaches, _ = self._joint_axes()
        # Of each body, where its joint is, and its axes as columns of a matrix (3, 3, n).
        places, bodies = [np.zeros((3, 1))], [np.eye(3)[:, :, None]]
        for body, parent in enumerate(model.body_parentid[1:], start=1):
            joint, turned = model.body_jntadr[body], turns[body] @ bodies[parent]
            if joint >= 0:
                about = _turned([*turned.swapaxes(0, 1)], np.cos(angle[joint]), -np.sin(angle[joint]))
                turned = np.stack(np.broadcast_arrays(*about), axis=1)
            places.append(places[parent] + reaches[body] @ bodies[parent])
            bodies.append(turned)
        origin, orientation, axis = (np.empty((len(angle), *shape, len(q))) for shape in ((3,), (3, 3), (3,)))
        for joint, body in enumerate(model.jnt_bodyid):
            origin[joint], axis[joint] = places[body], bodies[body][:, 2]
            orientation[joint] = axes[body].T @ bodies[body]
        return origin, orientation, axis

    def to_model(self, array: Float, *, back: bool = False) -> Float:
        """Arrange an array of a log, shape (n, j, ...), in the order of the model, or one of the model ``back``."""
        in_order = self.columns == tuple(range(len(self.columns)))
        order = np.argsort(self.columns) if back else list(self.columns)
        return array if in_order else array[:, order]


def _turned(vector: Sequence[Float], cosine: Float, sine: Float) -> list[Float]:
    """Return the components of vectors, shape (..., n) or (..., 1), turned about the third axis by n angles."""
    x, y, z = vector
    return [cosine * x - sine * y, sine * x + cosine * y, z]


def _times(matrix: Float, vector: Sequence[Float]) -> list[Float]:
    """Return a matrix times vectors, by component: most joints are parallel or at right angles, with few products."""
    rows = (
        [one if factor == 1.0 else factor * one for factor, one in zip(row, vector, strict=True) if factor]
        for row in matrix.tolist()
    )
    return [reduce(add, products) for products in rows]


def chunks(samples: int) -> Iterator[slice]:
    """Yield slices of so many samples that what is computed of all of them at once stays below some 20 MB."""
    return (slice(start, start + CHUNK) for start in range(0, samples, CHUNK))


def load_arm(
    urdf: Path | None = None,
    payload: Payload | None = None,
    gravity_vector: tuple[float, float, float] = STANDARD_GRAVITY,  # in the base frame [m/s^2]
) -> Arm:
    """Load the built-in Panda, or the arm of a URDF."""
    from friction_audit.robot.urdf import parse_urdf

    # In a thread: MuJoCo keeps an error from its import, with all frames that it was called from, and so a whole log.
    with ThreadPoolExecutor(max_workers=1) as pool:
        mj: Any = pool.submit(import_module, "mujoco").result()
    where = "the built-in Panda" if urdf is None else str(urdf)
    xml, inertials = parse_urdf(read_urdf(urdf), where)
    try:
        model = mj.MjModel.from_xml_string(xml)
    except ValueError as error:
        raise UsageError(f"{where}: MuJoCo cannot read it ({' '.join(str(error).split())}); repair it") from error
    for body in range(1, model.nbody):
        _set_inertial(model, body, *inertials.get(model.body(body).name, ()))
    model.opt.gravity[:] = gravity_vector
    name, names = BUILT_IN if urdf is None else urdf.stem, tuple(model.joint(k).name for k in range(model.njnt))
    links = [str(model.body(k).name) for k in range(1, model.nbody)]
    moved = [link for k, link in enumerate(links, start=1) if model.body_weldid[k] == model.jnt_bodyid[-1]]
    flange = next((link for ending in FLANGE_NAMES for link in links if link.endswith(ending)), moved[-1])
    arm = Arm(name=name, joint_names=names, flange=flange, model=model, columns=tuple(range(len(names))))
    return arm if payload is None else arm.with_load(payload[0], np.array(payload[1:]), np.zeros((3, 3)))


def read_urdf(urdf: Path | None) -> bytes:
    """Return the content of a URDF; of the built-in Panda's without a file."""
    from importlib import resources

    if urdf is None:
        return resources.files("friction_audit.robot").joinpath("panda.urdf").read_bytes()
    try:
        return urdf.read_bytes()
    except OSError as error:
        raise UsageError(f"--urdf {urdf}: {error.strerror or error}; expected a URDF file") from error


def _set_inertial(model: "mujoco.MjModel", body: int, *parts: Inertial) -> None:
    """Give a body of the model the inertial parameters of its parts."""
    import mujoco as mj

    mass = sum(part.mass for part in parts)
    centre = sum((part.mass * part.centre for part in parts), np.zeros(3)) / (mass or 1.0)
    inertia = np.zeros((3, 3))
    for part in parts:
        lever = part.centre - centre
        inertia += part.inertia + part.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
    moments, axes = np.linalg.eigh(inertia)
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    model.body_subtreemass[model.body_rootid[body]] += mass - model.body_mass[body]
    model.body_mass[body], model.body_ipos[body], model.body_inertia[body] = mass, centre, moments
    mj.mju_mat2Quat(model.body_iquat[body], axes.ravel())
