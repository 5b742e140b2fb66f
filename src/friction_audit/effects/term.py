"""What a term of a joint's model is: one named share of the torque that a measured motion takes.

A model says S = F_m + u = sum of its terms: the interaction torque and the compensator's torque together pay for
inertia, friction and whatever else there is. Every term is linear in some of its parameters once the others, which
give it its shape, are known, so that a fit needs to search the shape only.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import inf
from typing import Literal

import numpy as np

from friction_audit.dynamics.rigid_body import RigidBody
from friction_audit.joint_log import Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Others:
    """All joints of the arm, this one among them, j of them.

    Attributes:
        joint: Which of them this joint is, 0..j-1.
        dq: Velocities, shape (n, j). [rad/s]
        ddq: Accelerations, shape (n, j). [rad/s^2]
        sensed: What their torque sensors read, gravity included, counted as the interaction torque counts,
            shape (n, j). [N m]
    """

    joint: int
    dq: Float
    ddq: Float
    sensed: Float


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Motion:
    """Motion of one joint, shape (n,) each, and what a term may lean on besides.

    Attributes:
        t: Time. [s]
        q: Position. [rad]
        dq: Velocity. [rad/s]
        ddq: Acceleration. [rad/s^2]
        load: Load on the joint's gear besides ``rest``: gravity and the inertia of links as far as it is in the
            sensor and not in ``rest``, counted as the interaction torque counts; predicted, never measured; None
            where nobody has predicted it. [N m]
        temperature: Temperature; None where it was not logged. [degC]
        others: All joints of the arm; None for a single joint.
        rest: Torque that inertia, Coulomb and viscous friction of the same model take; None where a term does not
            need it. Terms that change how torque gets to the sensor, as a delay or a spring does, act on it. [N m]
        rigid: What the rigid-body model of the arm says about this joint; None where no model is known.
        way: Mean sign of the velocity over the cell of each sample; None where the sign at the sample is meant.
    """

    t: Float
    q: Float
    dq: Float
    ddq: Float
    load: Float | None = None
    temperature: Float | None = None
    others: Others | None = None
    rest: Float | None = None
    rigid: RigidBody | None = None
    way: Float | None = None

    @property
    def direction(self) -> Float:
        """Sign of the velocity, shape (n,)."""
        return np.sign(self.dq) if self.way is None else self.way


@dataclass(frozen=True, kw_only=True, slots=True)
class Parameter:
    """A number of a term.

    Attributes:
        name: Its name with the unit behind it, e.g. ``coulomb_nm``; unique over all terms, but for a number of a shape
            that means the same in several, as ``far_share``.
        unit: The unit, as people write it.
        meaning: One line.
        lower: Smallest value that makes sense.
        upper: Largest value that makes sense.
        whole: True for a choice by number, between which there is nothing.
        optional: True for a number that a file of a model may lack.
        default: What an optional number is where it is lacking.
    """

    name: str
    unit: str
    meaning: str
    lower: float = -inf
    upper: float = inf
    whole: bool = False
    optional: bool = False
    default: float = 0.0

    def allows(self, value: float) -> bool:
        """Return True for a finite value within the bounds."""
        return bool(np.isfinite(value)) and self.lower <= value <= self.upper


Forward = Literal["instant", "bristle", "delay", "spring", "play"]
"""How a term takes part in a forward simulation, see ``Term.forward``."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Term:
    """A term: its name, its parameters and its regressor.

    Attributes:
        name: As in the vocabulary of effects, or ``inertia``, ``coulomb``, ``viscous``, ``offset``.
        label: The name as people say it.
        linear: Parameters in which the torque is linear, one per column of the regressor.
        shape: The other parameters.
        basis: (motion, shape values) -> regressor, shape (n, len(linear)).
        bases: The same for many shapes, where they have work in common: pairs of the place in the list and the
            regressor, in any order. None where each is built on its own.
        friction: If True, what the term takes is dissipated.
        speed_only: If True, the torque follows from the velocity alone.
        forward: How it takes part in a forward simulation, which reads all numbers off the basis:

            - ``instant``: by its torque at the time, place and velocity of the instant, load, temperature and other
              joints as recorded. Should the past matter too, its torque along the motion is iterated.
            - ``bristle``: by a torque that builds up with the path since a reversal.
            - ``delay``: the torque that drives the joint was read late; the basis acts on ``Motion.rest``.
            - ``spring``: the measured side is ahead of the side of friction by the torque between them, times the
              parameter whose name ends on ``_rad_per_nm``; farther up to the one that ends on ``soft_nm``.
            - ``play``: the measured side moves within a play, of the full width of the parameter whose name ends on
              ``_rad``, before it takes the side of friction with it.

            Of a spring and of a play ``far_share`` is the part of the inertia on the side of friction; the rest moves
            with the measured side. The parameter that ends on ``damping_ratio`` damps the ringing of the former on the
            latter, on flanks at the frequency that ends on ``_hz``.
    """

    name: str
    label: str
    linear: tuple[Parameter, ...]
    shape: tuple[Parameter, ...] = ()
    basis: Callable[[Motion, Sequence[float]], Float]
    bases: Callable[[Motion, Sequence[Sequence[float]]], Iterator[tuple[int, Float]]] | None = None
    friction: bool = False
    speed_only: bool = False
    forward: Forward = "instant"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """All parameters: the linear ones, then the shape."""
        return self.linear + self.shape

    def regressor(self, motion: Motion, shape_values: Sequence[float] = ()) -> Float:
        """Return the torque per unit of each linear parameter, shape (n, len(linear))."""
        return self.basis(motion, shape_values)

    def regressors(self, motion: Motion, shapes: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield the place of each shape, in any order, and its regressor, shape (n, len(linear))."""
        if self.bases is not None:
            yield from self.bases(motion, shapes)
        else:
            yield from ((place, self.basis(motion, shape)) for place, shape in enumerate(shapes))

    def torque(self, values: Sequence[float], motion: Motion) -> Float:
        """Return the torque, given the values of ``parameters`` in order. [N m], shape (n,)."""
        split = len(self.linear)
        return np.asarray(self.basis(motion, values[split:]) @ np.asarray(values[:split], dtype=np.float64))
