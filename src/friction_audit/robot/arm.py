"""The rigid-body model of an arm, evaluated on whole arrays."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from importlib import resources
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from friction_audit.errors import UsageError
from friction_audit.joint_log import Float
from friction_audit.robot.urdf import joint_chain_xml

BUILT_IN = "panda"
"""The arm whose URDF comes with this package."""

FLANGE_NAMES = ("link8", "flange", "tool0")
"""How flange frames end; where a URDF has none of them, the last frame of the last joint is taken."""

STANDARD_GRAVITY = (0.0, 0.0, -9.81)

Payload = tuple[float, float, float, float]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Arm:
    """A rigid-body model; arrays have one column per joint, in the order of ``joint_names``.

    Attributes:
        name: What to call it in a result.
        joint_names: Names of the joints that count, base to tip.
        flange: Name of the flange frame, where a payload sits and whose speed is the hand's.
        model: The Pinocchio model.
        columns: Column of the caller's arrays that each joint of the model reads.
    """

    name: str
    joint_names: tuple[str, ...]
    flange: str
    model: Any
    columns: tuple[int, ...]

    def matched(self, joint_names: tuple[str, ...], where: str) -> "Arm":
        """Return the arm with its columns in the order of a log: by name if the names agree, else as is.

        Args:
            joint_names: The joints of the log.
            where: The log, for the message.

        Raises:
            UsageError: If the numbers of joints differ.
        """
        if len(joint_names) != len(self.joint_names):
            raise UsageError(
                f"{where}: joints: {len(joint_names)} ({', '.join(joint_names)}); the model {self.name} has "
                f"{len(self.joint_names)} ({', '.join(self.joint_names)}); the model needs every joint of the arm: "
                "give the arm's own --urdf, or --robot none to do without a model"
            )
        if set(joint_names) != set(self.joint_names):
            return self
        columns = tuple(joint_names.index(name) for name in self.joint_names)
        return replace(self, joint_names=joint_names, columns=columns)

    def gravity(self, q: Float) -> Float:
        """Return the torque that holds the arm against gravity.

        Args:
            q: Joint position, shape (n, j). [rad]

        Returns:
            Gravity torque, shape (n, j). [N m]
        """
        pin, data = _pinocchio(), self.model.createData()
        return self._rows(partial(pin.computeGeneralizedGravity, self.model, data), q)

    def inverse_dynamics(self, q: Float, dq: Float, ddq: Float) -> Float:
        """Return M(q) ddq + c(q, dq) + g(q), without friction.

        Args:
            q: Joint position, shape (n, j). [rad]
            dq: Joint velocity, shape (n, j). [rad/s]
            ddq: Joint acceleration, shape (n, j). [rad/s^2]

        Returns:
            Joint torque, shape (n, j). [N m]
        """
        pin, data = _pinocchio(), self.model.createData()
        return self._rows(partial(pin.rnea, self.model, data), q, dq, ddq)

    def hand_speed(self, q: Float, dq: Float) -> Float:
        """Return the speed of the flange frame's origin.

        Args:
            q: Joint position, shape (n, j). [rad]
            dq: Joint velocity, shape (n, j). [rad/s]

        Returns:
            Speed, shape (n,). [m/s]
        """
        pin, data = _pinocchio(), self.model.createData()
        frame = self.model.getFrameId(self.flange)
        speed = np.empty(len(q))
        for row, (position, velocity) in enumerate(zip(*self._arranged(q, dq), strict=True)):
            pin.forwardKinematics(self.model, data, position, velocity)
            # The frame does not matter for the length of the vector.
            speed[row] = np.linalg.norm(pin.getFrameVelocity(self.model, data, frame, pin.ReferenceFrame.LOCAL).linear)
        return speed

    def gravity_direction(self, q: Float) -> Float:
        """Return how gravity lies across each joint's axis, seen from the link that the joint moves.

        Args:
            q: Joint position, shape (n, j). [rad]

        Returns:
            Two components of the unit vector of gravity, across the axis and at right angles, shape (n, j, 2).
        """
        (arranged,) = self._arranged(q)
        along = self.model.gravity.linear / np.linalg.norm(self.model.gravity.linear)
        direction: dict[int, Float] = {0: np.broadcast_to(along, (len(q), 3))}
        result = np.empty((*q.shape, 2))
        for place, joint in enumerate(range(1, self.model.njoints)):
            axis, across = _axes(self.model, joint)
            here = direction[self.model.parents[joint]] @ self.model.jointPlacements[joint].rotation
            direction[joint] = _turned_back(here, axis, arranged[:, place])
            result[:, place] = direction[joint] @ across.T
        return result if self._in_order else result[:, np.argsort(self.columns)]

    @property
    def _in_order(self) -> bool:
        return self.columns == tuple(range(len(self.columns)))

    def _arranged(self, *arrays: Float) -> tuple[Float, ...]:
        if self._in_order:
            return tuple(np.ascontiguousarray(array) for array in arrays)
        return tuple(np.ascontiguousarray(array[:, list(self.columns)]) for array in arrays)

    def _rows(self, torque: Callable[..., Float], *motion: Float) -> Float:
        """Apply a function of one configuration to every row."""
        result = np.empty(motion[0].shape)
        for row, sample in enumerate(zip(*self._arranged(*motion), strict=True)):
            result[row] = torque(*sample)
        return result if self._in_order else result[:, np.argsort(self.columns)]


def load_arm(
    urdf: Path | None = None,
    payload: Payload | None = None,
    gravity_vector: tuple[float, float, float] = STANDARD_GRAVITY,
) -> Arm:
    """Load the built-in Panda, or the arm of a URDF.

    Args:
        urdf: File of another arm, or None for the Panda.
        payload: mass [kg] and centre of mass x, y, z [m] of a point mass in the flange frame, or None.
        gravity_vector: Gravity in the base frame. [m/s^2]

    Raises:
        UsageError: If the file cannot be read as an arm with inertias, or Pinocchio is not there.
    """
    pin = _pinocchio()
    where = "the built-in Panda" if urdf is None else str(urdf)
    xml, joints = joint_chain_xml(_read(urdf), where)
    try:
        model = pin.buildModelFromXML(xml)
    except ValueError as error:
        raise UsageError(f"{where}: Pinocchio cannot read it as a URDF ({error}); repair the file") from error
    model = _locked(pin, model, joints)
    flange = _flange(pin, model)
    if payload is not None:
        _add_point_mass(pin, model, flange, payload)
    model.gravity.linear = np.array(gravity_vector)
    names = tuple(model.names)[1:]
    name = BUILT_IN if urdf is None else urdf.stem
    return Arm(name=name, joint_names=names, flange=flange, model=model, columns=tuple(range(len(names))))


def check_urdf(urdf: Path) -> None:
    """Refuse a file that is no arm with inertias, without building its model.

    Raises:
        UsageError: If it cannot be read, is no URDF, no joint counts or there is no mass.
    """
    joint_chain_xml(_read(urdf), str(urdf))


def _axes(model: Any, joint: int) -> tuple[Float, Float]:  # noqa: ANN401
    """Return the axis of a revolute joint, shape (3,), and two directions across it, shape (2, 3)."""
    data = model.joints[joint].createData()
    model.joints[joint].calc(data, np.zeros(model.nq))
    axis = np.asarray(data.S).ravel()[3:]
    return axis, np.linalg.svd(axis[None])[2][1:]


def _turned_back(vector: Float, axis: Float, angle: Float) -> Float:
    """Express vectors of shape (n, 3) in a frame that has turned about the axis (Rodrigues' formula)."""
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = (vector @ axis)[:, None] * axis
    return along + cosine * (vector - along) - sine * np.cross(axis, vector)


def _pinocchio() -> ModuleType:
    try:
        import pinocchio
    except ImportError as error:
        raise UsageError(
            "the rigid-body model needs Pinocchio (package 'pin'), which is not installed and does not exist for "
            "Windows; use logged gravity or --torque tau_ext, or run on Linux or macOS"
        ) from error
    module: ModuleType = pinocchio
    return module


def _read(urdf: Path | None) -> bytes:
    if urdf is None:
        return resources.files("friction_audit.robot").joinpath("panda.urdf").read_bytes()
    try:
        return urdf.read_bytes()
    except OSError as error:
        raise UsageError(f"--urdf {urdf}: {error.strerror or error}; expected a URDF file") from error


def _locked(pin: ModuleType, model: Any, joints: tuple[str, ...]) -> Any:  # noqa: ANN401
    """Lock every joint that does not count (fingers, sliders) where it stands at zero."""
    ids = [number for number, name in enumerate(model.names) if number > 0 and name not in joints]
    return pin.buildReducedModel(model, ids, pin.neutral(model)) if ids else model


def _flange(pin: ModuleType, model: Any) -> str:  # noqa: ANN401
    """Name the flange frame: by its usual name, else the last body of the last joint."""
    bodies = [frame.name for frame in model.frames if frame.type == pin.FrameType.BODY]
    for ending in FLANGE_NAMES:
        found = [name for name in bodies if name.endswith(ending)]
        if found:
            return str(found[0])
    last = model.njoints - 1
    return str([f.name for f in model.frames if f.type == pin.FrameType.BODY and f.parentJoint == last][-1])


def _add_point_mass(pin: ModuleType, model: Any, flange: str, payload: Payload) -> None:  # noqa: ANN401
    mass, *centre = payload
    if not (np.isfinite(payload).all() and mass > 0):
        given = ",".join(f"{value:g}" for value in payload)
        raise UsageError(f"--payload {given}: expected mass,x,y,z in kg and m with a mass above zero")
    frame = model.frames[model.getFrameId(flange)]
    inertia = pin.Inertia(mass, np.array(centre), np.zeros((3, 3)))
    model.appendBodyToJoint(frame.parentJoint, inertia, frame.placement)
