"""What a candidate is: an effect that may be missing in a model, by the columns that it adds to a regression."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf

from friction_audit.dynamics.transmission import FarSide
from friction_audit.effects.joint_data import JointData, Nominal
from friction_audit.effects.term import Term
from friction_audit.joint_log import Float

Shape = Mapping[str, float]
"""Values of the numbers that enter a candidate nonlinearly."""


def _plain(_shape: Shape) -> bool:
    return False


def _itself(_data: JointData, _shape: Shape) -> str:
    return ""


def _sharp(_baseline: Nominal, _shape: Shape) -> float:
    return 0.0


def _none(_shape: Shape) -> tuple[Shape, ...]:
    return ()


def _unseen(_data: JointData) -> tuple[Shape, ...]:
    return ()


def _nowhere(_data: JointData) -> Mapping[str, tuple[float, float]]:
    return {}


def _nothing(_data: JointData, _shape: Shape) -> Mapping[str, tuple[float, float]]:
    return {}


def _firm(_shape: Shape) -> Mapping[str, tuple[float, float]]:
    return {}


@dataclass(frozen=True, kw_only=True, slots=True)
class Candidate:
    """One effect, as a detector sees it.

    Attributes:
        name: From the vocabulary of the program.
        label: A few words for people.
        shapes: Values to try for the numbers that enter nonlinearly, or how to choose them for a joint; one empty
            mapping if there are none. A search tries them all; afterwards the numbers of an accepted effect are
            refined within the bounds of the term's parameters.
        columns: ``columns(data, baseline, shape)``: what the effect adds to the torque, shape (n, p), up to p factors.
        trials: ``trials(data)(shape)``: of how many independent trials a shape was the best, where they were more than
            those of the grid; 0 where they were not, None where they never are.
        together: The same for many shapes that have work in common: pairs of the place in the list and the columns, in
            any order. None where each is built on its own.
        column_units: Unit of each factor, e.g. ``("nm",)``.
        untestable: ``untestable(data, baseline)``: why this log cannot show the effect, what motion is lacking; None if
            it can.
        shown: ``shown(data)``: shapes that a log shows although ``untestable`` says what else of the effect it cannot.
        admissible: ``admissible(factors, shape)``: whether sign and size are physically possible.
        axis: The quantity on which it shows itself: speed, position, displacement, time, acceleration, load, neighbour.
        same_as: Names that no motion of this kind tells apart from it.
        part_of: Names that it may be a part of where they are found too, which no motion of this kind tells.
        term: The term of a joint model that it adds; None for an effect that no model can hold.
        leans_on_model: Whether its columns hold torque of the declared model, so that they change with its factors.
        rugged: Name of the number of its shape on which the misfit has many valleys; empty without one.
        beside_rugged: Values of other numbers of the shape to try for each value of that one.
        richer: ``richer(shape)``: whether a shape is told only where it adds a good deal to the best of the others.
        stands_in: ``stands_in(data, shape)``: why a shape cannot be this effect in this motion, but stands in for
            something else that runs alike; empty where it can.
        moment: Name of the number of its shape that is a moment, which a locked cycle may hide; empty without one.
        exact: Whether its formula cannot be wrong, as that of a constant cannot.
        blur: ``blur(baseline, shape)``: how far off that number is whatever the log says, for what its formula assumes.
        loose: ``loose(shape)``: names of numbers that may be so many times what is told, at least and at most, whatever
            the log says, for what a shape assumes.
        fading: Name of the number of its shape that is a time constant; empty without one.
        noisy: Name of the number of its shape that noise of the motion moves; empty without one.
        along_noise: Names of the numbers, above zero, that noise moves with it.
        behind: ``behind(data, far, shapes)``: what many shapes add by themselves, whatever a factor may make of it,
            each with what is behind it, of an effect that hands on the torque of inertia and friction, and is fitted
            together with these; None for all others.
        sought: ``sought(data, shape)``: from where to where numbers of a shape, all above zero, are looked for with
            them, by name.
        hidden: ``hidden(data)``: the same for shapes that no grid comes near, however many others are found in their
            place; empty where there are none.
        plainer: ``plainer(shape)``: shapes with fewer numbers that are near one that is fitted so, to be fitted so too.
        assumed: Names of numbers that a shape may lack, where they are as usual; intervals take them for unknown too.
    """

    name: str
    label: str
    shapes: tuple[Shape, ...] | Callable[[JointData], tuple[Shape, ...]]
    columns: Callable[[JointData, Nominal, Shape], Float]
    column_units: tuple[str, ...]
    untestable: Callable[[JointData, Nominal], str | None]
    admissible: Callable[[Float, Shape], bool]
    axis: str
    shown: Callable[[JointData], tuple[Shape, ...]] = _unseen
    same_as: tuple[str, ...] = ()
    part_of: tuple[str, ...] = ()
    term: Term | None = None
    leans_on_model: bool = False
    rugged: str = ""
    beside_rugged: tuple[Shape, ...] = ()
    richer: Callable[[Shape], bool] = _plain
    stands_in: Callable[[JointData, Shape], str] = _itself
    moment: str = ""
    exact: bool = False
    blur: Callable[[Nominal, Shape], float] = _sharp
    loose: Callable[[Shape], Mapping[str, tuple[float, float]]] = _firm
    fading: str = ""
    noisy: str = ""
    along_noise: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    together: Callable[[JointData, Nominal, Sequence[Shape]], Iterator[tuple[int, Float]]] | None = None
    trials: Callable[[JointData], Callable[[Shape], float]] | None = None
    behind: Callable[[JointData, Sequence[FarSide], Sequence[Shape]], Iterator[tuple[int, Float]]] | None = None
    sought: Callable[[JointData, Shape], Mapping[str, tuple[float, float]]] = _nothing
    hidden: Callable[[JointData], Mapping[str, tuple[float, float]]] = _nowhere
    plainer: Callable[[Shape], tuple[Shape, ...]] = _none

    def bounds(self, name: str) -> tuple[float, float]:
        """Between which values a number of a shape makes sense; anywhere, if the term does not know it."""
        known = () if self.term is None else self.term.nonlinear
        return next(((one.lower, one.upper) for one in known if one.name == name), (-inf, inf))

    def each(self, data: JointData, baseline: Nominal, shapes: Sequence[Shape]) -> Iterator[tuple[int, Float]]:
        """Yield the place of each shape, in any order, and its columns, shape (n, p)."""
        if self.together is not None:
            yield from self.together(data, baseline, shapes)
        else:
            yield from ((place, self.columns(data, baseline, shape)) for place, shape in enumerate(shapes))

    def whole(self, shape: Shape) -> dict[str, float]:
        """A shape with what it lacks, as assumed."""
        lacking = () if self.term is None else self.term.nonlinear
        return {**shape, **{p.name: p.default for p in lacking if p.name in self.assumed and p.name not in shape}}

    def tried(self, data: JointData) -> tuple[Shape, ...]:
        """All shapes to try on a joint."""
        return self.shapes(data) if callable(self.shapes) else self.shapes


def columns_of(term: Term) -> Callable[[JointData, Nominal, Shape], Float]:
    """The columns of a candidate that is a term of a model, shapes by the names of the term's parameters."""

    def columns(data: JointData, baseline: Nominal, shape: Shape) -> Float:
        return term.regressor(data.motion(baseline.torque), values_of(term, shape))

    return columns


def columns_together(term: Term) -> Callable[[JointData, Nominal, Sequence[Shape]], Iterator[tuple[int, Float]]]:
    """The same for many shapes, of a term that builds them together."""

    def columns(data: JointData, baseline: Nominal, shapes: Sequence[Shape]) -> Iterator[tuple[int, Float]]:
        values = [values_of(term, shape) for shape in shapes]
        yield from term.regressors(data.motion(baseline.torque), values)

    return columns


def values_of(term: Term, shape: Shape) -> tuple[float, ...]:
    """The numbers of a shape in the order of the term; one that it may lack has its default."""
    return tuple(shape.get(p.name, p.default) if p.optional else shape[p.name] for p in term.nonlinear)
