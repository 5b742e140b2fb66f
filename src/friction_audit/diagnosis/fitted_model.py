"""The nominal model with some effects, fitted together: torques, sizes, and what they leave."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from friction_audit.diagnosis.dictionary import Block, Dictionary
from friction_audit.diagnosis.gram import RIDGE, Training
from friction_audit.diagnosis.samples import least_squares
from friction_audit.effects.joint_data import Nominal
from friction_audit.effects.registry import GRAVITY
from friction_audit.joint_log import Float


class FittedModel:
    """The model fitted to all samples, m of them, with k effects."""

    def __init__(self, training: Training, active: Sequence[Block]) -> None:
        self.training, self.active = training, active
        self.gram, self.problem = training.gram, training.gram.problem
        self.fit = training.fit(active)
        self.coefficients = self.fit.of_blocks
        self._known = self.gram.base_raw[self.gram.precision == 0.0]  # the nominal model, and an offset that may be any

    @cached_property
    def nominal(self) -> Nominal:
        """The nominal model as fitted together with the effects."""
        return self.problem.nominal.baseline(self.fit.coefficients[: len(self.problem.X)])

    @cached_property
    def torques(self) -> list[Float]:
        """Torque of each effect on the samples, shape (m,). [N m]"""
        return [c @ block.columns for block, c in zip(self.active, self.coefficients, strict=True)]

    @cached_property
    def sizes(self) -> Float:
        """Rms of each effect's torque free of the nominal model, and of an offset that may be any, shape (k,). [N m]"""
        return np.array([_rms_without(self._known, torque) for torque in self.torques])

    @cached_property
    def residual(self) -> Float:
        """What the model leaves of all samples, in the order of time, shape (m,). [N m]"""
        kept = self.fit.kept
        base = self.fit.coefficients[: len(kept)] @ self.gram.base_raw[kept]
        return np.asarray(self.problem.y - base - sum(self.torques))

    @cached_property
    def fine_residual(self) -> Float:
        """What the model leaves on the fine grid, shape (n,). [N m]"""
        data, left = self.problem.data, self.problem.data.torque - self.nominal.torque
        for block, c in zip(self.active, self.coefficients, strict=True):
            left -= block.effect.regressor(data, self.nominal, block.shape)[:, block.there] @ c
        return left

    @cached_property
    def inflations(self) -> Float:
        """Variance inflation factor of each effect's size by the nuisances and the other effects, shape (k,)."""
        fit, gram = self.fit, self.gram
        whole = (fit.factor @ fit.factor.T) * np.outer(fit.scale, fit.scale)
        known, rows, found = np.flatnonzero(gram.precision[fit.kept] == 0.0), np.arange(len(whole)), []
        owner = np.repeat(np.arange(-1, len(self.active)), [len(fit.kept), *(b.p for b in self.active)])
        for k, coefficients in enumerate(self.coefficients):
            own, others = rows[owner == k], rows[owner != k]
            cross = whole[:, own] @ coefficients
            free = [
                cross[own] @ coefficients - cross[one] @ np.linalg.solve(whole[np.ix_(one, one)], cross[one])
                for one in (known, others)
            ]
            found.append(free[0] / max(free[1], RIDGE * free[0]))
        return np.array(found)

    def whole(self, dictionary: Dictionary) -> tuple[list[Float], Float]:
        """Torque of each effect, shape (m,), and its size, shape (k,), with what an unknown chain may take. [N m]

        Of the chain's own effects only what it does not take is known: the rest of their coefficients is a guess.
        """
        torques, size = [*self.torques], self.sizes.copy()
        each = zip(self.active, self.coefficients, strict=True)
        for k, whole in enumerate(self._with_chain(dictionary, each)):
            if whole is not None:
                torques[k], size[k] = whole
        return torques, size

    def taken_by_chain(self, dictionary: Dictionary) -> float:
        """Largest ratio of an effect's rms to what an unknown chain leaves of it, at a point of each; 1 without one."""
        points: dict[str, list[Block]] = {}
        for block in self.gram.blocks if self.problem.with_chain else ():
            points.setdefault(block.name, []).append(block)
        some = [(own[len(own) // 2], np.ones(own[len(own) // 2].p)) for own in points.values()]
        left = [_rms_without(self._known, c @ block.columns) for block, c in some]
        both = zip(self._with_chain(dictionary, some), left, strict=True)
        return max((one[1] / free for one, free in both if one is not None and free > 0.0), default=1.0)

    def _with_chain(
        self, dictionary: Dictionary, each: Iterable[tuple[Block, Float]]
    ) -> Iterator[tuple[Float, float] | None]:
        """Torque of effects, what a chain could take in it, and its rms free of the nominal model; none without one.

        None for the chain's own effects.
        """
        if (problem := self.problem.with_chain) is not None:
            unprojected = replace(dictionary, problem=problem)
            known = np.vstack([problem.X, problem.columns(np.ones((len(problem.data.t), 1)))])
            for block, c in each:
                if block.effect.axis == "neighbour" or block.name == GRAVITY:
                    yield None
                    continue
                torque = c @ unprojected.columns_at(block, block.shape, self.nominal)
                yield torque, _rms_without(known, torque)


def _rms_without(known: Float, torque: Float) -> float:
    return float(np.sqrt(np.mean((torque - least_squares(known, torque) @ known) ** 2)))
