"""T-optimal design: which candidate motions, how often, so that the competing effects differ most.

A. C. Atkinson and V. V. Fedorov (Biometrika 62 (1975) 57): with one effect true, the best fit of another one leaves a
sum of squares; over the variance of the noise it is the expected 2 ln of the likelihood ratio between the two. The
design makes the sum over all pairs of ln(1 + that) large (a compound criterion), by adding the candidate with the
largest gain per second and then exchanging candidates as long as one gains (V. V. Fedorov, Theory of Optimal
Experiments, 1972). Sums of squares add up over candidates, for each starts and ends at rest.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.dictionary import Block, Dictionary
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.diagnosis.samples import NoiseModel
from friction_audit.effects.effect import Effect
from friction_audit.effects.joint_model import FittedTerm
from friction_audit.effects.registry import effect_of
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Float
from friction_audit.planning.motion import Candidate
from friction_audit.planning.task import Joint, subject_of
from friction_audit.simulation.strokes import Prescribed, starts_of

MOST_POINTS = 16  # of an effect's grid: neighbours differ little
ENOUGH = 20.0  # of 2 ln of a likelihood ratio: from 10 on evidence is very strong (Kass, Raftery)
OTHERS = 0.1  # weight of effects that the log has ruled out: the new log must rule them out again
SWEEPS = 4  # of exchanges; two usually suffice
RIDGE = 1e-9


class Information(NamedTuple):
    """Sums of squares and products of whitened columns, by candidate; c candidates, h true effects, k competitors."""

    rows: Float  # of nominal model, nuisances and a competing effect with themselves, shape (c, k, r, r)
    cross: Float  # of these with the torques of the true effects, shape (c, k, r, h)
    own: Float  # of each torque with itself, shape (c, h)
    names: NDArray[np.str_]  # effect of each competitor, of which several are points of one grid, shape (k,)
    truths: tuple[str, ...]  # names of the true effects
    prior: Float  # precision of the rows, shape (r, r)
    seconds: Float  # length of each candidate [s]

    def separation(self, counts: Float) -> tuple[tuple[str, ...], Float]:
        """Return the competing names, and of designs (..., c) the 2 ln of each ratio, shape (..., h, names)."""
        rows = np.tensordot(counts, self.rows, 1) + self.prior
        cross, own = np.tensordot(counts, self.cross, 1), counts @ self.own
        scale = np.sqrt(np.einsum("...rr->...r", rows)) + 1e-300
        scaled = rows / scale[..., None] / scale[..., None, :] + RIDGE * np.eye(rows.shape[-1])
        cross = cross / scale[..., None]
        left = own[..., None, :] - np.einsum("...rh,...rh->...h", cross, np.linalg.solve(scaled, cross))
        names = tuple(dict.fromkeys(self.names.tolist()))
        found = np.stack([left[..., self.names == name, :].min(axis=-2) for name in names], axis=-1)
        return names, np.maximum(found, 0.0)


def information_of(
    joint: Joint,
    candidates: Sequence[Candidate],
    truths: Mapping[str, FittedTerm],
    certain: Sequence[FittedTerm],
    competing: Sequence[Effect],
) -> Information:
    """Simulate the joint along all candidates; one of the ``truths`` is there, and the ``certain`` in any case."""

    def torque_of(terms: Iterable[FittedTerm]) -> Float:
        torques = [term.torque(data.motion(nominal.torque)) for term in terms]
        return problem.samples.of(np.sum(torques, axis=0))

    motion = Prescribed(strokes=tuple(one for c in candidates for one in c.strokes))
    data = subject_of(joint, joint.settings(motion, float(starts_of(motion)[-1]) + 0.5), seed=1).data
    problem = RegressionProblem.build(data, None)
    nominal = joint.nominal(data)
    nuisances = problem.nuisances(nominal)
    base = np.vstack([problem.X, *(one.column for one in nuisances), *([torque_of(certain)] if certain else [])])
    fit = np.linalg.lstsq(base.T, problem.y)[0]
    noise = NoiseModel.fit(problem.age, [problem.y - fit @ base], problem.model_error(nominal))
    torques = np.array([torque_of([one]) for one in truths.values()]).reshape(len(truths), len(problem.y))
    grids: dict[str, list[Block]] = {}
    for block in Dictionary.build(problem, competing, nominal).blocks:
        grids.setdefault(block.name, []).append(block)
    blocks = [block for grid in grids.values() for block in grid[:: max(1, len(grid) // MOST_POINTS)]]
    ends = np.cumsum([len(c.strokes) for c in candidates])
    place = np.searchsorted(starts_of(motion)[ends], problem.samples.t, side="right")
    slices = [np.flatnonzero(place == k) for k in range(len(candidates))]
    if not blocks or not len(problem.y):
        raise AnalysisError("no candidate motion shows any effect; widen the limits")
    width = max(b.p for b in blocks)
    white, seen = noise.whiten(base), noise.whiten(torques)
    shape = (len(candidates), len(blocks), len(base) + width)
    rows, cross = np.zeros((*shape, shape[2])), np.zeros((*shape, len(torques)))
    for k, block in enumerate(blocks):
        own = np.vstack([white, noise.whiten(block.columns), np.zeros((width - block.p, len(problem.y)))])
        for c, at in enumerate(slices):
            part = own[:, at]
            rows[c, k], cross[c, k] = part @ part.T, part @ seen[:, at].T
    prior = np.zeros(shape[2])
    prior[len(problem.X) : len(problem.X) + len(nuisances)] = [1.0 / one.sd**2 for one in nuisances]
    size = np.stack([np.sum(seen[:, at] ** 2, axis=1) for at in slices])
    names, seconds = np.array([b.name for b in blocks]), np.array([c.duration_s for c in candidates])
    return Information(rows, cross, size, names, tuple(truths), np.diag(prior) + RIDGE * np.eye(shape[2]), seconds)


def value_of_separation(about: Information, counts: Float) -> Float:
    """Return the compound T-criterion of designs (..., c)."""
    names, found = about.separation(counts)
    weight = np.array([1.0 if name in about.truths else OTHERS for name in names])
    same = [[name in (one, *effect_of(one).indistinguishable) for name in names] for one in about.truths]
    return np.asarray(np.sum(np.where(same, 0.0, weight) * found / (found + ENOUGH), axis=(-2, -1)))


def value_for_coefficients(about: Information, counts: Float) -> Float:
    """Return the D-criterion of inertia, Coulomb and viscous friction of designs, the rest of the model free."""
    first = (np.tensordot(counts, about.rows[:, 0], 1) + about.prior)[..., :3, :3]
    return np.asarray(np.linalg.slogdet(first + RIDGE * np.eye(3))[1])


Criterion = Callable[[Information, Float], Float]


def exchange(about: Information, criterion: Criterion, duration_s: float) -> NDArray[np.int64]:
    """Return how often each candidate is run in a time [s], shape (c,), with the value of a design by a criterion."""
    counts, units = np.zeros(len(about.seconds)), np.eye(len(about.seconds))
    best = float(criterion(about, counts))

    def one_more(counts: Float) -> tuple[NDArray[np.intp], Float]:
        fits = np.flatnonzero(about.seconds <= duration_s - counts @ about.seconds)
        return fits, criterion(about, counts + units[fits])

    while True:
        fits, values = one_more(counts)
        if not len(fits):
            break
        chosen = int(np.argmax((values - best) / about.seconds[fits]))
        counts, best = counts + units[fits[chosen]], float(values[chosen])
    for _ in range(SWEEPS):
        before = best
        for out in np.flatnonzero(counts):
            fits, values = one_more(counts - units[out])  # never none: what is taken out fits
            if values.max() > best + 1e-9:
                counts, best = counts - units[out] + units[fits[int(np.argmax(values))]], float(values.max())
        if best <= before + 1e-9:
            break
    return counts.astype(np.int64)


def in_order(candidates: Sequence[Candidate], counts: NDArray[np.int64]) -> tuple[Candidate, ...]:
    """Return the runs spread over the time, so that neither warming up nor drift goes with one of them."""
    moments = [((k + 0.5) / count, n) for n, count in enumerate(counts) for k in range(count)]
    return tuple(candidates[n] for _, n in sorted(moments))
