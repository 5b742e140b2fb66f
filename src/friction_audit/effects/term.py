"""What a term of a joint's model is: one named share of the torque that a measured motion takes.

A model says S = F_m + u = sum of its terms: the interaction torque and the compensator's torque together pay for
inertia, friction and whatever else there is. Every term is linear in some of its parameters once the others, which
give it its shape, are known, so that a fit needs to search the shape only.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from friction_audit.dynamics.motion import Forward, Motion
from friction_audit.effects.parameter import Parameter
from friction_audit.joint_log import Float


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
    coefficients: tuple[Parameter, ...]
    nonlinear: tuple[Parameter, ...] = ()
    basis: Callable[[Motion, Sequence[float]], Float]
    bases: Callable[[Motion, Sequence[Sequence[float]]], Iterator[tuple[int, Float]]] | None = None
    friction: bool = False
    speed_only: bool = False
    forward: Forward = "instant"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """All parameters: the linear ones, then the shape."""
        return self.coefficients + self.nonlinear

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
        split = len(self.coefficients)
        return np.asarray(self.basis(motion, values[split:]) @ np.asarray(values[:split], dtype=np.float64))
