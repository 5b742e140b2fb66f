"""What an effect is: a torque that a joint model may lack, with its formula and what a diagnosis needs to know of it.

A joint model says F_m + u = sum of its terms: interaction torque and compensator torque pay for inertia, friction and
all other effects. Each is linear in its coefficients once its nonlinear parameters are known, so that a fit searches
over the nonlinear parameters only. Effects whose formulas are alike share a module.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, Literal, TypeAlias

import numpy as np

from friction_audit.dynamics.motion import Forward, Motion
from friction_audit.effects.joint_data import FEWEST_SAMPLES, JointData, Nominal
from friction_audit.effects.parameter import Parameter
from friction_audit.errors import kind_name
from friction_audit.joint_log import Float
from friction_audit.preprocessing.interaction import Caution

# Coefficient of an effect over what it follows from, at most: 1 but for the errors of a nominal model that was fitted
# without it.
LARGEST_SHARE = 1.6

# Values of nonlinear parameters by name: a point of the grid; of one point or of k of them, shape (k,) each.
Nonlinear = Mapping[str, float]
Points = Mapping[str, Any]
Each: TypeAlias = Any  # a number or an answer of one point, or of each of k, shape (k,)


class Effect:
    """One effect: a subclass has its words, its formula, ``columns`` or ``columns_of_many``, and what is its own."""

    # That of its class, from the vocabulary of the program, or ``inertia``, ``coulomb``, ``viscous``, ``offset``.
    name: ClassVar[str]
    label: ClassVar[str]  # a few words for people
    # Quantity on which it shows: position, displacement, time, acceleration, load, neighbour, or speed, where its
    # torque follows from the velocity alone.
    axis: ClassVar[str]
    # Parameters in which the torque is linear, one per column; empty for an effect that no joint model can hold.
    coefficients: ClassVar[tuple[Parameter, ...]] = ()
    nonlinear: ClassVar[tuple[Parameter, ...]] = ()  # the other parameters
    friction: ClassVar[bool] = False  # True if it is dissipated
    forward: ClassVar[Forward] = "instant"  # how it takes part in a forward simulation
    record: ClassVar[str] = ""  # the motion on which it shows itself best
    separate: ClassVar[Mapping[str, str]] = {}  # motions by easily confused effects; a pair stands once

    # What some effects have of their own.

    needs_nominal: ClassVar[bool] = False  # True if its columns hold torque of the nominal model and change with that
    # What its formula may miss: any torque, a curve over its axis, the same or another in each direction, or nothing.
    misses: ClassVar[Literal["any", "even", "directed", "nothing"]] = "any"
    # True if it is a constant or a curve of position, which the gravity of other joints in the torque resembles.
    like_gravity: ClassVar[bool] = False
    screened: ClassVar[int] = 1  # every so many points of its grid come first, the others where these show promise
    # True on the way of the torque to the sensor: its one coefficient follows from the others.
    follows: ClassVar[bool] = False
    transmits: ClassVar[bool] = False  # True for a link between the measured side and that of inertia and friction
    recorder: ClassVar[str] = ""  # what in the recording makes the same torque, and what to do

    def __init_subclass__(cls) -> None:
        cls.name = kind_name(cls)

    @staticmethod
    def requires(data: JointData, nominal: Nominal, /) -> Caution | None:
        """Return what the log of a joint that moves lacks to show it; None if nothing."""
        return None

    def tries(self, data: JointData) -> Iterable[Sequence[float] | Nonlinear]:
        """Return nonlinear parameters to try on a joint, in order or by name; those that are lacking have none."""
        return [()]

    def identifiable_part(self, data: JointData) -> tuple[Nonlinear, ...]:
        """Return what of the grid a log shows although ``not_identifiable`` says what it cannot."""
        return ()

    def possible(self, coefficients: Float, at: Points) -> Each:
        """Return whether coefficients, shape (q,), or (q, k) of k points, are physically possible."""
        pairs = zip(self.coefficients, coefficients, strict=False)
        return np.all([(one.lower < value) & (value <= one.upper) for one, value in pairs], axis=0)

    def coefficient_of(self, at: Points) -> Each:
        """Return the coefficient where it ``follows`` from the nonlinear parameters."""
        return 1.0

    def not_identifiable(self, data: JointData, nominal: Nominal) -> Caution | None:
        """Return why a log cannot show it, i.e. which motion is lacking; None if it can."""
        if np.count_nonzero(data.used) < FEWEST_SAMPLES:
            return Caution("hardly_any_motion")
        if self.like_gravity and data.unknown_gravity:
            return Caution("unknown_gravity")
        return self.requires(data, nominal)

    # The formula.

    def columns(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return the torque per unit of each coefficient, shape (n, p), at the nonlinear parameters in order."""
        return next(self.columns_of_many(motion, [values]))[1]

    def columns_of_many(self, motion: Motion, many: Sequence[Sequence[float]]) -> Iterator[tuple[int, Float]]:
        """Yield place and columns for many values, in any order; instead of ``columns`` where they share work."""
        yield from ((place, self.columns(motion, values)) for place, values in enumerate(many))

    def regressors(self, data: JointData, nominal: Nominal, grid: Sequence[Nonlinear]) -> Iterator[tuple[int, Float]]:
        """Yield place and columns on the samples of a joint, shape (n, p), for points of the grid, in any order."""
        yield from self.columns_of_many(data.motion(nominal.torque), [self.values(at) for at in grid])

    def regressors_of(
        self, data: JointData, nominals: Sequence[Nominal], grid: Sequence[Nonlinear], seen: Callable[[Float], Float]
    ) -> Iterator[tuple[Sequence[int], Float]]:
        """Yield places and how their columns are seen, (n, k) as (k, m); each point of a link has a nominal model."""
        yield from (([place], seen(columns)) for place, columns in self.regressors(data, nominals[0], grid))

    def regressor(self, data: JointData, nominal: Nominal, at: Nonlinear) -> Float:
        """Return the columns at one point."""
        return next(self.regressors_of(data, [nominal], (at,), np.transpose))[1].T

    # Derived.

    def grid(self, data: JointData) -> tuple[Nonlinear, ...]:
        """Return what ``tries`` says, by the names of the parameters; one empty mapping without any."""
        names, points = [one.name for one in self.nonlinear], self.tries(data)
        return tuple(at if isinstance(at, Mapping) else dict(zip(names, at, strict=False)) for at in points)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """All parameters: coefficients, then nonlinear ones."""
        return self.coefficients + self.nonlinear

    @property
    def memoryless(self) -> bool:
        """Whether it follows from the joint's own motion and load at the same instant."""
        return self.axis in ("speed", "position", "load")

    def torque(self, motion: Motion, values: Sequence[float]) -> Float:
        """Return the torque, given the values of ``parameters`` in order. [N m], shape (n,)."""
        split = len(self.coefficients)
        return np.asarray(self.columns(motion, values[split:]) @ np.asarray(values[:split], dtype=np.float64))

    def values(self, at: Nonlinear) -> tuple[float, ...]:
        """Return the nonlinear parameters in order; an optional one that is lacking has its default."""
        return tuple(at.get(p.name, p.default) if p.optional else at[p.name] for p in self.nonlinear)


class SpeedFriction(Effect):
    """Friction that follows from the velocity alone, which other programs can hold."""

    axis = "speed"
    friction = True
    # Its torque in C++, from the parameters by their places, the velocity ``dq``, its size ``speed`` and its sign
    # ``direction``, which is smooth at standstill.
    cpp: ClassVar[str] = ""

    def in_cpp(self, values: Sequence[float], table: str) -> tuple[str, Float | None]:
        """Return the torque at all parameters in C++, and the array that it reads by ``between(table, place)``."""
        return self.cpp.format(*values), None
