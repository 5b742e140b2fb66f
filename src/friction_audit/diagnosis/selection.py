"""Group forward-backward selection by integrated evidence, its stability over folds, and indistinguishable effects.

The evidence of an effect given an active set is 2 ln of its Bayes factor: over the coefficients with the prior that
suits the data best (E. I. George, D. P. Foster, Biometrika 87 (2000) 731), over the nonlinear parameters as the mean
over their grid, which is the price of trying them all. One number is the prior against a name.
"""

from collections.abc import Callable, Collection, Sequence
from copy import copy
from dataclasses import dataclass, field
from itertools import combinations
from typing import NamedTuple

import numpy as np

from friction_audit.diagnosis.dictionary import Block
from friction_audit.diagnosis.gram import Gram, Training
from friction_audit.diagnosis.result import Evidence
from friction_audit.effects.registry import GRAVITY, PART_OF, same_as
from friction_audit.joint_log import Float

PRIOR = 13.0  # 2 ln of the prior odds against any one effect
PRIOR_OF_FOLDS = 0.5 * PRIOR  # a fold less holds less evidence, and asks again what was found already
ROUNDS_OF_FOLDS = 2
# Difference in evidence below which two effects cannot be separated: more is very strong (Kass and Raftery 1995).
# With 6 effects_cable_spring_90001, pairs_torque_bias+warm_up_90006 and stranger_gravity_error_90001 have a wrong name.
INDISTINGUISHABLE = 10.0
# Evidence of the screened points of an effect, of any size with the right sign, from which its others are built. With 4
# in its place no more true names are found in 75 joints of most kinds, half of which have 4 to 6 for some effect.
SCREENED = 6.0
LEAST_EVIDENCE = 2.0  # of a competing effect: less is hardly anything
ALIKE = 0.7  # correlation of their torques given everything else, from which they are the same thing
CLOSE = 40.0  # effects so near the best one are refined before one is chosen
REFINED_AT_ONCE = 4
LEAST_FOLDS = 2.0 / 3.0  # share of the folds that must choose an effect too
CHAIN_ERROR = 0.03  # of the torque of a chain's gravity: in logs of arms by MuJoCo false names are 1.5 to 2.5 %
LEANING = 0.5  # change of a torque from which it may be a part of another one
SAME = 0.9  # correlation with a constant, from which the constant is a competing name
MOST_EFFECTS = 8
TOLERANCE = 1e-6

Refine = Callable[[Block, Sequence[Block]], Block | None]


class Score(NamedTuple):
    """An effect given an active set."""

    evidence: float  # 2 ln of its Bayes factor, nonlinear parameters integrated
    block: Block  # its best point


def occam(gain: Float | float, numbers: Float | float) -> Float:
    """2 ln of the Bayes factor of coefficients that gain L, their prior as wide as suits the data best."""
    gain = np.maximum(gain, 1e-300)
    return np.where(gain > numbers, gain - numbers - numbers * np.log(gain / numbers), 0.0)


class Projected:
    """The whitened response, with the nominal model, the nuisances and some effects partialled out."""

    def __init__(self, training: Training, active: Sequence[Block]) -> None:
        gram, fit = training.gram, training.fit(active)
        rows = np.vstack([gram.base[fit.kept], *(gram.of(b) for b in active)])
        self.basis = np.linalg.solve(fit.factor, rows / fit.scale[:, None])
        self.left = gram.y - fit.projected @ self.basis
        self.rss, self.samples = fit.rss, training.samples

    def free(self, white: Float) -> Float:
        """Whitened columns, shape (k, m), without the rest of the model."""
        return np.asarray(white - (white @ self.basis.T) @ self.basis)

    def torque(self, white: Float) -> Float:
        """What whitened columns, shape (k, m), take of the response, shape (m,)."""
        free = self.free(white)
        return np.asarray(free.T @ np.linalg.lstsq(free @ free.T, free @ self.left, rcond=1e-10)[0])

    def and_also(self, white: Float) -> "Projected":
        """With more columns partialled out."""
        more = copy(self)
        _, size, right = np.linalg.svd(self.free(white), full_matrices=False)
        directions = right[size > 1e-6 * size.max()]
        more.basis = np.vstack([self.basis, directions])
        more.left = self.left - (directions @ self.left) @ directions
        more.rss = self.rss - float(np.sum((directions @ self.left) ** 2))
        return more

    def evidence(self, white: Float) -> float:
        """2 ln of the Bayes factor of whitened columns, shape (k, m); those that depend on each other count once."""
        free = self.free(white)
        sizes, directions = np.linalg.eigh(free @ free.T)
        kept = sizes > max(1e-12 * sizes[-1], 1e-300)
        along = directions.T[kept] @ (free @ self.left)
        left = max(float(self.left @ self.left - np.sum(along**2 / sizes[kept])), 1e-9 * self.rss)
        return float(occam(self.samples * np.log(self.rss / left), int(np.count_nonzero(kept))))


@dataclass(eq=False)
class Search:
    """Selection on some folds."""

    training: Training  # scores of the blocks
    refine: Refine | None = None  # moves a block between the points of its grid; None for a search on the grid alone
    most_numbers: int = 1000  # that the cycles can carry
    prior: float = PRIOR  # 2 ln of the prior odds against any one effect
    rounds: int = MOST_EFFECTS  # forward steps, and rounds of improvement after each
    withheld: Collection[str] = ()  # names of effects of whose points some are not built yet
    complete: Callable[[str], list[Block]] = lambda _: []  # builds them
    _tried: set[int] = field(default_factory=set)
    _penalty: dict[int, float] = field(default_factory=dict)
    _scores: dict[tuple[object, ...], dict[str, Score]] = field(default_factory=dict)

    def scores(self, active: Sequence[Block]) -> dict[str, Score]:
        """Every effect that is not active, by name."""
        members = sorted(map(id, active))
        if (found := self._scores.get((self.training.gram.version, *members))) is None:
            found = self._integrated(active)  # which may add blocks: the version is another one then
            self._scores[self.training.gram.version, *members] = found
        return found

    def _integrated(self, active: Sequence[Block]) -> dict[str, Score]:
        gram = self.training.gram
        blocks, names = gram.blocks, gram.names
        gains, coefficients = self.training.gain(active)
        factor, found = occam(gains, gram.widths.astype(float)), {}
        signed = np.where(coefficients[:, 0] > 0.0, factor, 0.0)
        if promising := [name for name in self.withheld if signed[names == name].max(initial=0.0) >= SCREENED]:
            gram.add([block for name in promising for block in self.complete(name)])
            return self._integrated(active)
        possible, prior = gram.possible(coefficients), np.array([block.log_prior for block in blocks])
        given = {a.name for a in active}
        # Fewer waves of a drift where the cycles carry no more (ur10e_2 1 torque_drift 2.0 of the measured logs).
        carried = gram.numbers <= self.room(active)
        for name in (name for name in dict.fromkeys(names.tolist()) if name not in given):
            own = np.flatnonzero((names == name) & possible)
            own = own[carried[own]] if carried[own].any() else own
            if len(own):
                best = int(own[np.argmax(factor[own])])
                total = np.sum(np.exp(prior[own] + 0.5 * (factor[own] - factor[best])))
                evidence = float(factor[best] + 2.0 * np.log(total))
                self._penalty[id(blocks[best])] = float(factor[best]) - evidence
                if self.refine is not None:
                    blocks[best].penalty = float(factor[best]) - evidence
                found[name] = Score(evidence=evidence, block=blocks[best])
        return found

    def objective(self, active: Sequence[Block]) -> float:
        """2 ln of the posterior of an active set over that of the nominal model."""
        n, fit = self.training.samples, self.training.fit(active)
        total = n * float(np.log(self.training.fit(()).rss / fit.rss))
        for block in active:
            gain = n * float(np.log(self.training.fit([b for b in active if b is not block]).rss / fit.rss))
            penalty = self._penalty.get(id(block), block.penalty) + self.prior
            total -= block.p + block.p * float(np.log(max(gain, block.p) / block.p)) + penalty
        return total

    def room(self, active: Sequence[Block]) -> int:
        """How many numbers the cycles can carry with these effects; a constant, which cannot stand in, is free."""
        return self.most_numbers - sum(b.p + b.numbers for b in active if b.effect.misses != "nothing")

    def _impossible(self, active: Sequence[Block]) -> list[Block]:
        fit = self.training.fit(active)
        return [b for b, c in zip(active, fit.of_blocks, strict=True) if not b.possible(c)]

    def best(self, active: Sequence[Block]) -> list[Score]:
        """Effects given an active set, the best first, the best of them refined."""
        found = ranked(self.scores(active))
        if self.refine is None or not found:
            return found
        least = max(found[0].evidence - CLOSE, 0.5 * found[0].evidence, self.prior / 2)
        new = []
        for one in found[:REFINED_AT_ONCE]:
            if one.evidence >= least and id(one.block) not in self._tried and not one.block.refined:
                self._tried.add(id(one.block))
                moved = self.refine(one.block, active)
                new += [moved] if moved is not None else []
        if new:
            self.training.gram.add(new)
            found = ranked(self.scores(active))
        return found

    def run(self, active: Sequence[Block] = ()) -> list[Block]:
        """Forward selection; after every step effects are deleted, exchanged, split and merged."""
        chosen = list(active)
        for _ in range(self.rounds):
            least = self.objective(chosen) + TOLERANCE
            tries = (
                self.settle([*chosen, s.block])
                for s in self.best(chosen)
                if s.evidence >= self.prior and self.room([*chosen, s.block]) >= 0
            )
            better = next((trial for trial in tries if self.objective(trial) > least), None)
            if better is None:
                break
            chosen = better
        return chosen

    def settle(self, active: Sequence[Block]) -> list[Block]:
        """Improve an active set of one size by deletion, exchange, two by one and one by two."""
        chosen = list(active)
        for _ in range(self.rounds):
            before = self.objective(chosen)
            # Without refinement, on some of the folds, deletion and exchange suffice.
            wide = (self._merge, self._divide) if self.refine is not None else ()
            for step in (self._delete, self._exchange, *wide):
                chosen = step(chosen)
            if self.objective(chosen) <= before + TOLERANCE:
                break
        return chosen

    def _delete(self, active: list[Block]) -> list[Block]:
        for block in list(active):
            rest = [b for b in active if b is not block]
            if self.objective(rest) > self.objective(active):
                active = rest
        while active:
            wrong = self._impossible(active)
            if self.room(active) >= 0 and not wrong:
                break
            worst = max(wrong or active, key=lambda b: self.objective([x for x in active if x is not b]))
            active = [b for b in active if b is not worst]
        return active

    def _better(self, trial: list[Block], active: list[Block], by: float = TOLERANCE) -> bool:
        more = self.objective(trial) > self.objective(active) + by
        return more and self.room(trial) >= 0 and not self._impossible(trial)

    def _exchange(self, active: list[Block]) -> list[Block]:
        for block in active:
            rest = [b for b in active if b is not block]
            for score in self.best(rest)[:2]:
                if score.block is not block and self._better([*rest, score.block], active):
                    active = [*rest, score.block]
                    break
        return active

    def _merge(self, active: list[Block]) -> list[Block]:
        for pair in combinations(list(active), 2):
            rest = [b for b in active if b not in pair]
            score = next(iter(self.best(rest)), None)
            if score is not None and self._better([*rest, score.block], active):
                return [*rest, score.block]
        return active

    def _divide(self, active: list[Block]) -> list[Block]:
        """One by two: without it pairs_gravity_error+time_delay_100005 loses a name."""
        for block in list(active):
            rest = [b for b in active if b is not block]
            for first in ranked(self.scores(rest))[:6]:
                if first.block.name == block.name:
                    continue
                second = next(iter(ranked(self.scores([*rest, first.block]))), None)
                if second is not None and self._better([*rest, first.block, second.block], active, 2.0):
                    return [*rest, first.block, second.block]
        return active


def ranked(scores: dict[str, Score]) -> list[Score]:
    """The best first; what differs by rounding only, as an offset and asymmetric friction, in catalogue order."""
    return sorted(scores.values(), key=lambda one: -round(one.evidence, 6))


def shares_of_folds(gram: Gram, active: Sequence[Block], numbers: int) -> dict[str, int]:
    """In how many of the selections without one fold each an effect, or one that stands for it there, is chosen."""
    count, given = dict.fromkeys((b.name for b in active), 0), Projected(Training(gram), ())
    for left_out in range(gram.problem.folds):
        others = Training(gram, tuple(k for k in range(gram.problem.folds) if k != left_out))
        search = Search(others, None, numbers, PRIOR_OF_FOLDS, ROUNDS_OF_FOLDS)
        chosen = search.run(search.settle(active))
        for block in active:
            own = given.torque(gram.of(block))
            same = (b.name == block.name or abs(correlation(given.torque(gram.of(b)), own)) > ALIKE for b in chosen)
            count[block.name] += any(same)
    return count


def correlation(one: Float, other: Float) -> float:
    """Correlation of two torques about zero; 0 where one is zero."""
    return float(one @ other) / max(float(np.sqrt((one @ one) * (other @ other))), 1e-300)


def competing_effects(search: Search, active: Sequence[Block], block: Block) -> tuple[Evidence, ...]:
    """Effects in the place of a selected one, the closest first."""
    rest = [b for b in active if b is not block]
    given, scores = Projected(search.training, rest), search.scores(rest)
    mine = scores[block.name].evidence if block.name in scores else 0.0
    gram = search.training.gram
    own, found = given.torque(gram.of(block)), []
    for name, score in scores.items():
        if name != block.name and score.evidence >= LEAST_EVIDENCE:
            same = correlation(own, given.torque(gram.of(score.block)))
            found.append(Evidence(name=name, two_ln_bayes_factor=mine - score.evidence, correlation=same))
    return tuple(sorted(found, key=lambda one: round(one.two_ln_bayes_factor, 6)))


def indistinguishable(
    gram: Gram, competing: Sequence[Evidence], block: Block, active: Sequence[Block]
) -> tuple[str, ...]:
    """Names that the log cannot separate from a selected effect."""
    names = [c.name for c in competing if c.two_ln_bayes_factor < INDISTINGUISHABLE and c.correlation > ALIKE]
    constants = {b.name: b for b in gram.blocks if b.effect.misses == "nothing"}
    # A curve that bends little over the range contains a constant: an offset may be most of it.
    names += [c.name for c in competing if c.name in constants and c.correlation > SAME]
    names += same_as(block.name) - {block.name}
    others = [b for b in active if b is not block]
    if block.effect.misses == "even":
        # An offset may be the constant of a cable, or be refused as what the formula of gravity may get wrong.
        columns = block.columns / gram.problem.samples.weight
        varying = np.ptp(columns, axis=1) > TOLERANCE * np.abs(columns).max(axis=1)
        given = Projected(Training(gram), others).and_also(gram.of(block)[varying])
        names += [name for name, one in constants.items() if given.evidence(gram.of(one)) >= PRIOR]
    # Gravity that the torque holds changes with other joints too, and what follows their motion may be it.
    names += [GRAVITY] * (gram.problem.data.unknown_gravity and block.effect.axis == "neighbour")
    names += [GRAVITY] * _small_to_chain(gram, block, active)
    wholes = PART_OF.get(block.name, ())
    certain = {GRAVITY} if gram.problem.data.weighs else set()  # the torque holds it
    leaning = (b for b in others if b.name not in certain and _leans(Training(gram), block, b, others))
    names += [*(b.name for b in others if b.name in wholes), *(b.name for b in leaning)]
    return tuple(dict.fromkeys(names))


def _small_to_chain(gram: Gram, block: Block, active: Sequence[Block]) -> bool:
    """Whether an effect's torque may be what the processes of a chain without a model leave of its gravity."""
    load = gram.problem.data.load
    if load is None or block.name == GRAVITY or not len(gram.problem.chain):
        return False
    torque = Training(gram).fit(active).of_blocks[list(active).index(block)] @ block.columns
    return bool(np.std(torque) < CHAIN_ERROR * np.std(load[gram.problem.samples.fine]))


def _leans(training: Training, block: Block, other: Block, others: Sequence[Block]) -> bool:
    """Whether an effect's torque changes by more than half where another one is left out.

    Collinearity: D. A. Belsley, E. Kuh, R. E. Welsch, Regression Diagnostics (1980), ch. 3. Such names are mostly wrong
    (effects_joint_elasticity_90003, pairs_asymmetric_viscous+time_delay_120014).
    """
    sets = [block, *others], [block, *(b for b in others if b is not other)]
    whole, without = (training.fit(chosen).of_blocks[0] @ block.columns for chosen in sets)
    return bool(np.linalg.norm(whole - without) > LEANING * np.linalg.norm(whole))
