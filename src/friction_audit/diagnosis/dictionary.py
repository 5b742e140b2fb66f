"""Columns of every effect on the samples: the one place that knows how the catalogue of effects is written."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.problem import PLAUSIBLE_SD, SAMPLE_SD, SIGN_WIDTHS_RAD_S, RegressionProblem
from friction_audit.effects.effect import Effect, Nonlinear
from friction_audit.effects.joint_data import Nominal
from friction_audit.effects.position import order_range
from friction_audit.joint_log import Bool, Float, Int
from friction_audit.parallel import per_joint as side_by_side
from friction_audit.preprocessing.interaction import Caution

# Every so many points of a grid: neighbours are refined afterwards.
EVERY = {"frictional_lag": 3, "presliding": 2, "nonlinear_viscous": 2}
LEAST_BEND = 0.05  # of the log's high speed: a curve in speed below is Coulomb friction with a smoothed sign
FARTHEST = 0.5  # by what share a link may change the nominal coefficients
# By what share it must, for its columns to be built again with them. With 2 %, effects_backlash_60009 ends in another
# minimum, 1.7 % off, and has one contact more.
CHANGED = 0.005
# Power of a link's torque over that of what the nominal model leaves, both free of that model: the coefficient is at
# most the root of the inverse, and below 0.4, the least of all links, from 6.25 on. Other effects in the model and the
# nominal model of the link itself change that by less than a factor of two.
TOO_LARGE = 12.5
ORDERS_SCANNED = 2
STORED = np.float32  # of columns alone, a thousand of them; products add up in double precision


@dataclass(eq=False, kw_only=True)
class Block:
    """Columns of one effect at one point of its grid."""

    effect: Effect
    shape: dict[str, float]  # the nonlinear parameters
    stored: NDArray[np.float32]  # columns on the samples, in the order of the folds, without zero ones, shape (p, m)
    back: Int  # place of each sample in that order, shape (m,)
    there: Bool  # which of the effect's columns these are, shape (q,)
    log_prior: float  # logarithm of the share of the prior that this point has among those of its effect
    numbers: int  # nonlinear parameters that vary over the grid
    refined: bool = False  # whether it lies between the points of the grid
    start: int = 0  # its first row in the Gram matrix
    penalty: float = 0.0  # 2 ln of the prior's mass that neighbours of this point share, from the last integration
    name: str = field(init=False)  # of the effect
    p: int = field(init=False)  # number of columns

    def __post_init__(self) -> None:
        """Read name and number of columns, which are asked for a thousand times a second."""
        self.name, self.p = self.effect.name, len(self.stored)

    @property
    def columns(self) -> Float:
        """Columns on the samples, in the order of time, shape (p, m)."""
        return self.stored[:, self.back].astype(np.float64)

    def moved(self, shape: dict[str, float], columns: Float) -> "Block":
        """The block at another point, between those of the grid; columns in the order of time, shape (p, m)."""
        stored = np.empty(columns.shape, STORED)
        stored[:, self.back] = columns
        return replace(self, shape=shape, stored=stored, refined=True, start=0)

    def whole(self, coefficients: Float) -> Float:
        """Coefficients of all the effect's columns, shape (q,), zero for columns of zeros."""
        if len(coefficients) == len(self.there):
            return coefficients
        out = np.zeros(len(self.there))
        out[self.there] = coefficients
        return out

    def possible(self, coefficients: Float) -> bool:
        """Whether signs and sizes are physically possible."""
        return bool(self.effect.possible(self.whole(coefficients), self.shape))


@dataclass(eq=False)
class Dictionary:
    """All blocks of a joint, and why the log cannot show the other effects."""

    problem: RegressionProblem
    effects: tuple[Effect, ...]
    baseline: Nominal
    response: Float  # what links are fitted to, at first that of the problem, shape (m,)
    blocks: list[Block] = field(default_factory=list)
    not_testable: dict[str, Caution] = field(default_factory=dict)
    # Points that are not built, by name of the effect: in a diagnosis, until ``complete`` asks for them.
    withheld: dict[str, list[Nonlinear]] = field(default_factory=dict)

    @cached_property
    def back(self) -> Int:
        """Place of each sample in the order of their folds, shape (m,)."""
        return np.argsort(self.problem.order)

    @classmethod
    def build(
        cls, problem: RegressionProblem, effects: Sequence[Effect], baseline: Nominal, *, whole: bool = True
    ) -> "Dictionary":
        """Ask every effect whether the log can show it, and build its columns over its grid, if not whole for a screen.

        Effects whose columns take long are screened by some points, links by some of one kind (sure independence
        screening: J. Fan, J. Lv, J. R. Stat. Soc. B 70 (2008) 849): to build all of them takes a third of the time.
        """
        made = cls(problem, tuple(e for e in effects if e.coefficients), baseline, problem.y)

        def of(k: int) -> tuple[Caution | None, list[Block]]:
            effect, data = made.effects[k], problem.data
            why = effect.not_identifiable(data, baseline)
            shapes: Sequence[Nonlinear] = effect.grid(data) if why is None else effect.identifiable_part(data)
            shapes = shapes[:: EVERY.get(effect.name, 1)]
            shapes = [shape for shape in shapes if not made.is_nuisance(shape)]
            first = shapes
            if effect.screened > 1 and not whole:
                name = effect.nonlinear[0].name
                # Of a link some that differ from the first one in the first parameter alone.
                alike = [s for s in shapes if not effect.transmits or {**s, name: shapes[0][name]} == shapes[0]]
                first = alike[:: effect.screened]
            if len(first) < len(shapes):
                made.withheld[effect.name] = [s for s in shapes if s not in first]
            return why, made.build_blocks(effect, first, shapes)

        for effect, (why, blocks) in zip(made.effects, side_by_side(of, len(made.effects)), strict=True):
            if why is not None:
                made.not_testable[effect.name] = why
            made.blocks += blocks
        return made

    def is_nuisance(self, shape: Nonlinear) -> bool:
        """Whether an effect of this shape is no physics of the joint: a smoothed sign, or a delay of the recorder.

        Both have a false name without: whole_arms "ur slow" none 200000, joint 4, "iiwa sines" none 200000, joint 5.
        """
        data, bend = self.problem.data, shape.get("curved_viscous_speed_rad_s", np.inf)
        if abs(shape.get("delay_step_s", np.inf)) <= PLAUSIBLE_SD * SAMPLE_SD * data.sample_s:
            return True
        smoothed = bend < max(LEAST_BEND * data.low_and_high_speed[1], SIGN_WIDTHS_RAD_S[-1])
        return bool(smoothed and shape["curved_viscous_exponent"] <= 0.0)

    def complete(self, name: str) -> list[Block]:
        """Build what was withheld of an effect."""
        own = [block for block in self.blocks if block.name == name and not block.refined]
        left = self.withheld.pop(name)
        grid = [*(block.shape for block in own), *left]
        made = self.build_blocks(own[0].effect, left, grid)
        for block in (*own, *made):
            block.log_prior = -float(np.log(len(grid)))
        self.blocks += made
        return made

    def build_blocks(
        self, effect: Effect, shapes: Sequence[Nonlinear], grid: Sequence[Nonlinear] | None = None
    ) -> list[Block]:
        """Blocks of one effect, some points of a grid or all; without those whose columns are zero."""
        if not shapes:
            return []
        grid = grid or shapes
        varying = [k for k in {name for s in grid for name in s} if len({s.get(k) for s in grid}) > 1]
        out: list[Block | None] = [None] * len(shapes)
        for place, columns in self._built(effect, shapes):
            there = np.asarray(columns.any(axis=1), bool)
            if there.any():
                out[place] = Block(
                    effect=effect,
                    shape=dict(shapes[place]),
                    stored=self._stored(columns, there),
                    back=self.back,
                    there=there,
                    log_prior=-float(np.log(len(shapes))),
                    numbers=sum(name in shapes[place] for name in varying),
                )
        return [block for block in out if block is not None]

    def _stored(self, columns: Float, there: Bool) -> NDArray[np.float32]:
        return np.take((columns if there.all() else columns[there]).astype(STORED), self.problem.order, axis=1)

    def _built(self, effect: Effect, shapes: Sequence[Nonlinear]) -> Iterator[tuple[int, Float]]:
        """Yield place and columns on the samples, shape (p, m), each link with a nominal model of its own.

        That is fitted with the link to the response. Half of the links keep the columns of the given one:
        they cannot be (safe screening; L. El Ghaoui, V. Viallon, T. Rabbani, Pacific J. Optimization 8 (2012) 667), or
        their own one is hardly another.
        """
        data, baseline, y = self.problem.data, self.baseline, self.response
        nominals, again = [baseline] * len(shapes), list(range(len(shapes)))
        if effect.transmits:
            X, again = self.problem.X, []
            inverse = np.linalg.pinv(X @ X.T, rcond=1e-12, hermitian=True)
            names = [name for name in self.problem.nominal.names if hasattr(baseline, name)]
            at = [self.problem.nominal.names.index(name) for name in names]
            own = np.array([getattr(baseline, name) for name in names])
            farthest, Xy = FARTHEST * np.abs(own), X @ y
            most = TOO_LARGE * float(y @ y - Xy @ inverse @ Xy)
            for places, rows in effect.regressors_of(data, nominals, shapes, self.problem.columns):
                torques = rows * [[effect.coefficient_of(shapes[place])] for place in places]
                along = torques @ X.T
                away = (Xy - along) @ inverse[:, at] - own
                power = np.einsum("km,km->k", torques, torques) - np.einsum("kb,kb->k", along @ inverse, along)
                kept = np.all(np.abs(away) <= CHANGED * np.abs(own), axis=1) | (power > most)
                changed = own + np.clip(away, -farthest, farthest)
                for place, columns, keep, values in zip(places, rows[:, None], kept, changed.tolist(), strict=True):
                    if keep:
                        yield place, columns
                    else:
                        nominals[place] = replace(baseline, **dict(zip(names, values, strict=True)))
                        again.append(place)
        grid = [shapes[k] for k in again]
        for places, rows in self._regressors(effect, [nominals[k] for k in again], grid):
            for k, columns in zip(places, rows.reshape(len(places), -1, rows.shape[-1]), strict=True):
                yield again[k], columns

    def _regressors(
        self, effect: Effect, nominals: Sequence[Nominal], grid: Sequence[Nonlinear]
    ) -> Iterator[tuple[Sequence[int], Float]]:
        """Yield places and columns on the samples, from what an effect needs of the fine grid: half, without memory."""
        if not effect.memoryless:
            return effect.regressors_of(self.problem.data, nominals, grid, self.problem.columns)
        (read, data, seen), nominal = self.problem.near, nominals[0]  # all have one
        one = replace(nominal, torque=nominal.torque[read])
        return effect.regressors_of(data, [one] * len(grid), grid, seen)

    def rebuild(self, baseline: Nominal, y: Float) -> None:
        """Build again what follows from the nominal model, better known; the response without other effects, (m,)."""
        self.baseline, self.response = baseline, y
        for effect in self.effects:
            own = [block for block in self.blocks if block.effect is effect]
            if effect.needs_nominal and own:
                for place, columns in self._built(effect, [block.shape for block in own]):
                    own[place].stored = self._stored(columns, own[place].there)

    def columns_at(self, block: Block, shape: Nonlinear, baseline: Nominal) -> Float:
        """Columns of a block's effect at another point, shape (p, m)."""
        _, columns = next(self._regressors(block.effect, [baseline], [shape]))
        return columns.reshape(-1, columns.shape[-1])[block.there]

    def torques_at(self, block: Block, shapes: Sequence[Nonlinear], nominal: Nominal, coefficients: Float) -> Float:
        """Torques of a block's effect at other points, its coefficients given if they do not follow, shape (k, m)."""
        if not block.effect.follows:
            return np.stack([coefficients @ self.columns_at(block, shape, nominal) for shape in shapes])
        out, nominals = np.empty((len(shapes), len(self.problem.y))), [nominal] * len(shapes)
        for places, rows in block.effect.regressors_of(self.problem.data, nominals, shapes, self.problem.columns):
            out[places] = rows * [[block.effect.coefficient_of(shapes[place])] for place in places]
        return out

    def scan_orders(self, residual: Float) -> list[Block]:
        """Ripples beyond the grid: the largest peaks of a Fourier transform of a residual over the position."""
        own = [block for block in self.blocks if block.name == "torque_ripple"]
        if not own:
            return []
        data = self.problem.data
        most, last = order_range(data)[1], max(block.shape["ripple_order"] for block in own)
        if most <= last:
            return []
        q = self.problem.kinematics[0]
        span, width = float(np.ptp(q)), float(np.pi / most / 4)
        n = int(2 ** np.ceil(np.log2(4 * span / width)))
        power = np.abs(np.fft.rfft(np.bincount(((q - q.min()) / width).astype(int), residual, n))) ** 2
        order = 2 * np.pi * np.arange(len(power)) / (n * width)
        power[(order < last) | (order > most)] = 0.0
        found: list[Block] = []
        for _ in range(ORDERS_SCANNED):
            k = int(np.argmax(power))
            if power[k] <= 0.0:
                break
            for block in self.build_blocks(own[0].effect, [{"ripple_order": float(order[k])}]):
                # As many independent orders as there are up to this one were looked through.
                block.log_prior, block.numbers = -float(np.log(max(span * order[k] / np.pi, 2.0))), 1
                found.append(block)
            power[np.abs(order - order[k]) < 4 * np.pi / span] = 0.0
        return found

    def bounds(self, block: Block) -> dict[str, tuple[float, float]]:
        """From where to where nonlinear parameters may be refined: the grid and half as much again."""
        effect, tried = block.effect, block.effect.grid(self.problem.data)
        free = {parameter.name: parameter for parameter in effect.nonlinear if not parameter.whole}
        found = {}
        for name in (name for name in block.shape if name in free):
            values = [s[name] for s in tried if name in s] + [block.shape[name]]
            least, most = min(values), max(values)
            if least == most and block.name != "torque_ripple":
                continue
            least, most = (least / 1.5 if least > 0 else least * 1.5), (most * 1.5 if most > 0 else most / 1.5)
            found[name] = (max(free[name].lower, least), min(free[name].upper, most))
        return found

    def spacing(self, block: Block, name: str) -> float:
        """Distance of the closest point of the grid to the next one."""
        values = np.unique([s[name] for s in block.effect.grid(self.problem.data) if name in s])
        away = np.abs(values - values[np.argmin(np.abs(values - block.shape[name]))]) if len(values) else values
        return float(away[away > 0].min()) if np.any(away > 0) else 0.2 * abs(block.shape[name]) + 1e-9
