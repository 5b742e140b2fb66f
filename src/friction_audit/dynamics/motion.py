"""Motion of one joint, and what else is known of it: the input of every torque of a joint model."""

from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from friction_audit.joint_log import Float
from friction_audit.preprocessing.even_grid import on_finer_grid

# Of a link: mass, first moments x, y, z, and the moments of inertia xx, xy, yy, xz, yz, zz about its joint's frame.
INERTIAL_PARAMETERS = 10


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class RigidBody:
    """Torques of one joint per unit of what may be wrong with the rigid-body model of the arm, at m times."""

    t: Float  # times, coarse enough to be stored, fine enough to be interpolated, shape (m,) [s]
    links: tuple[int, ...]  # numbers (1..j) of the links whose weight is given
    # torque per unit of first moment x, y, z [kg m] and mass [kg] of those links, by gravity, and by the links' inertia
    # where it is in the balance; linearly dependent columns are zero, shape (m, len(links), 4)
    weight: NDArray[np.floating[Any]]  # in single precision, which is enough: most of the memory of a diagnosis
    tilt: Float  # gravity torque per unit of gravity along two directions across the vertical [m/s^2], shape (m, 2)
    # torque M ddq + c of the model; None where the link's inertia is not in the balance, shape (m,) [N m]
    inertial: Float | None
    # the same per unit of each inertial parameter of the last link, in single precision too, shape (m, 10), or None
    tip: NDArray[np.floating[Any]] | None
    _kept: "list[RigidBody]" = field(default_factory=list, init=False, repr=False)

    def on(self, t: Float) -> "RigidBody":
        """The torques at even times, of which theirs are some, by cubic splines; those of the last times are kept."""
        if len(self.t) == len(t) and np.array_equal(self.t, t):
            return self
        if self._kept and self._kept[-1].t is t:
            return self._kept[-1]
        every, n = round((self.t[1] - self.t[0]) / (t[1] - t[0])), len(t)
        weight = np.empty((n, *self.weight.shape[1:]), np.float32)
        for k in range(weight.shape[1]):  # one after the other: a spline takes several times the memory of its values
            weight[:, k] = on_finer_grid(self.weight[:, k], every, n)
        inertial = None if self.inertial is None else on_finer_grid(self.inertial, every, n)
        tip = None if self.tip is None else on_finer_grid(self.tip, every, n).astype(np.float32)
        tilt = on_finer_grid(self.tilt, every, n)
        self._kept[:] = [RigidBody(t=t, links=self.links, weight=weight, tilt=tilt, inertial=inertial, tip=tip)]
        return self._kept[-1]


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Others:
    """All joints of the arm, this one among them, j of them."""

    joint: int  # which of them this joint is, 0..j-1
    q: Float  # positions, shape (n, j) [rad]
    dq: Float  # velocities, shape (n, j) [rad/s]
    ddq: Float  # accelerations, shape (n, j) [rad/s^2]
    # what their torque sensors read, gravity included, with the sign of the interaction torque, shape (n, j) [N m]
    sensed: Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Motion:
    """Motion of one joint, shape (n,) each, and other inputs of a torque."""

    t: Float  # time [s]
    q: Float  # position [rad]
    dq: Float  # velocity [rad/s]
    ddq: Float  # acceleration [rad/s^2]
    # load on the joint's gear in addition to ``rest``: gravity and the inertia of links as far as it is in the sensor
    # and not in ``rest``; predicted, never measured; None where it is not known [N m]
    load: Float | None = None
    temperature: Float | None = None  # temperature; None where it was not logged [degC]
    others: Others | None = None  # all joints of the arm; None for a single joint
    # torque of inertia, Coulomb and viscous friction of the same model; None where it is not needed. Effects that
    # change how torque gets to the sensor, as a delay or a spring does, act on it [N m]
    rest: Float | None = None
    rigid: RigidBody | None = None  # torques of the rigid-body model of the arm; None where no model is known
    # mean sign of the velocity over the cell of each sample; None where the sign at the sample is meant
    smooth_direction: Float | None = None

    @property
    def direction(self) -> Float:
        """Sign of the velocity, shape (n,)."""
        return np.sign(self.dq) if self.smooth_direction is None else self.smooth_direction


# How a term takes part in a forward simulation:
# - ``instant``: by its torque at the instant, load, temperature and other joints as recorded; where the past matters
#   too, its torque along the motion is iterated.
# - ``bristle``: by a torque that builds up with the path since a reversal.
# - ``delay``: the torque that drives the joint was read late; the columns act on ``Motion.rest``.
# - ``spring``: the measured side is ahead of the side of friction by the torque between them, times the parameter whose
#   name ends on ``_rad_per_nm``; farther up to the one that ends on ``soft_nm``.
# - ``gap``: the measured side moves within a gap, of the full width of the parameter whose name ends on ``_rad``.
# Of both ``far_share`` is the part of the inertia on the side of friction; the parameter that ends on ``damping_ratio``
# damps the ringing, on flanks at the frequency that ends on ``_hz``.
Forward = Literal["instant", "bristle", "delay", "spring", "gap"]


# An ``effects.joint_model.FittedTerm``: ``name``, ``values``, its ``effect``, and ``torque(motion)``.
Term: TypeAlias = Any
# An ``effects.joint_model.JointModel``: ``inertia_kg_m2``, ``terms``, and ``rest(motion)``, its simple torque.
Model: TypeAlias = Any
