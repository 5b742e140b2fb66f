"""Contacts: stretches in which innovations of the augmented model stand out, and which the motion does not repeat.

A bank of matched filters (G. L. Turin, IRE Trans. Inf. Theory 6 (1960) 311) looks for pushes of several lengths in the
whitened residual. Each output is compared with outputs at similar states of motion in other cycles: their spread is
the local scale (ordered-statistic CFAR: H. Rohling, IEEE Trans. Aerosp. Electron. Syst. 19 (1983) 608), and what they
repeat is model error, not a contact. The threshold is Bonferroni's over all moments and filters, from Student's t since
the scale is estimated. Innovations of a contact are left out before the next one is looked for.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from friction_audit.diagnosis.noise import NoiseModel
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.effects.joint_data import SIGMA_PER_MEDIAN
from friction_audit.joint_log import Bool, Float, Int

LENGTHS_S = (0.1, 0.2, 0.4, 0.8)  # twice as long each: half a sine between two of them loses 5 % of its size
BY_CHANCE = 2e-3  # probability that normal noise holds a contact: model error has longer tails (flips, seed 16004)
CELLS = 120  # reference cells, each as long as the push; with 60, the quantile of Student's t is 7 % larger
ALIKE = 0.3  # distance of similar states of motion, in standard deviations of each quantity
FEWEST_AGAIN = 2  # similar states in other cycles from which it can be said what the motion repeats
NEAR_S = 0.1  # what the motion repeats comes so much earlier or later
GLITCH = 0.9  # output of a pulse over that of pushes, from which one sample is wrong (stranger_none_30034)
IMPULSE_S = 0.025  # half of the window of the median: a quarter of the shortest push, which stays
OUTLIER = 5.0  # standard deviations: 6e-7 of normal noise is beyond
APART_S = 0.2  # pushes between which less time passes are one contact
END_S = 1.0  # next to an end of the motion a drive settles, or bristles do, which no cycle repeats (measured Panda)
LEAST_SEEN = 0.2  # of the usual energy of a filter: next to a gap of the samples less of a push is seen
LEAST_OF_MODEL = 0.06  # of what a filter gives on the modelled torque: a smaller push is its error (smoothed, seed 5)
MOST_CYCLES = 0.6  # share of the cycles with a contact: what is more frequent is no event, and little is left to fit
MOST = 100  # moments that are looked at: what stands out more often is no event
TINY = float(np.finfo(float).tiny)
SIGMA_PER_NINTH_DECILE = 0.6080  # of the absolute value of a normal variable


class Contact(NamedTuple):
    """One stretch of time in which something touches the arm."""

    start_s: float
    stop_s: float


class MatchedFilters:
    """Filters for pushes that begin at each of s evenly spaced slots, f of them, on m samples."""

    def __init__(self, problem: RegressionProblem, residual: Float, noise: NoiseModel, errors: Sequence[Float]) -> None:
        samples, step_s, row = problem.samples, problem.data.step_s, problem.samples.place
        every = int(np.min(np.diff(row)[problem.age[1:] > 0], initial=int(row[-1]) + 1))
        self.slot, self.slot_s = (row - row[0]) // every, step_s * samples.every * every  # of samples; from one to next
        # Weights of each sample and of the p before it in its innovation, shape (m, p + 1).
        self.operator = operator = np.zeros((len(row), noise.predictors.shape[1] + 1))
        operator[:, 0] = noise.weight
        for lag in range(1, operator.shape[1]):
            operator[lag:, lag] = -noise.predictors[noise.age[lag:], lag - 1] * noise.weight[:-lag]
        # At a break-away the torque is that of the standstill before it, where friction holds a push.
        operator *= np.where(samples.breakaway, 0.0, noise.scales[noise.age])[:, None]
        forms = [np.ones(1)]
        for length_s in LENGTHS_S:
            n = max(round(length_s / step_s), 1)
            forms += [np.sin(np.pi * (np.arange(n) + 0.5) / n), np.ones(n)]
        # A pulse, then each push, as the samples see it; slots from its beginning to the last innovation that holds it.
        self.pushes = tuple(np.convolve(form, samples.kernel)[:: samples.every * every] for form in forms)
        self.reach = max(len(push) for push in self.pushes) + operator.shape[1]
        # Whitened residual, torque of the model, and errors of the formulas, shape (2 + e, m).
        white = noise.whiten(np.stack([residual, problem.y - residual, *errors]))
        self.innovations = np.where(samples.breakaway, 0.0, white)

    def sums(self, kept: Bool, which: slice, first: int, last: int) -> tuple[Float, Float]:
        """Products with some innovations, and energies, of pushes that begin at slots first to last, (f, i or 1, k)."""
        lags, reach = self.operator.shape[1], self.reach
        known = np.flatnonzero(kept & (self.slot >= first) & (self.slot < last + reach))
        operator, innovations, slot = self.operator[known], self.innovations[which, known], self.slot[known] - first
        products, energies = [], []
        for push in self.pushes:
            wide = len(push) + lags - 1
            white = operator @ np.stack([np.pad(push, (lag, lags - 1 - lag)) for lag in range(lags)])
            begin = (slot[:, None] + wide - np.arange(wide)).ravel()
            inside = slice(wide, wide + last - first)
            n = inside.stop + reach
            every = (white * one[:, None] for one in innovations)
            products.append([np.bincount(begin, one.ravel(), n)[inside] for one in every])
            energies.append([np.bincount(begin, (white**2).ravel(), n)[inside]])
        return np.array(products), np.array(energies)


class Reference:
    """Where else in a log of m samples the joint moves as at one moment."""

    def __init__(self, problem: RegressionProblem, slot: Int) -> None:
        q, dq, ddq = (one / max(float(np.std(one)), 1e-12) for one in problem.kinematics)
        self.states = np.column_stack([q, dq]), np.column_stack([dq, ddq])
        self.direction, self.cycle, self.slot = np.sign(dq), problem.samples.cycle, slot

    def compare(self, output: Float, at: int, wide: int, near: int) -> tuple[float, int, float, bool]:
        """Local scale of a filter's outputs, shape (s,), at a push, its degrees of freedom, what the motion repeats.

        Last, whether other cycles hold a similar velocity and acceleration at all.
        """
        from scipy.ndimage import maximum_filter1d

        i = min(int(np.searchsorted(self.slot, at + wide // 2)), len(self.slot) - 1)
        others = (self.cycle != self.cycle[i]) & (self.direction == self.direction[i]) & (self.slot >= wide // 2)
        place = np.flatnonzero(others)
        scale, cells, cycles, again = 1.0, 1, 0, []
        for state in self.states:
            distance = np.hypot(*(state[place] - state[i]).T)
            order = np.argsort(distance, kind="stable")
            begin, cycle = self.slot[place[order]] - wide // 2, self.cycle[place[order]]
            reference = output[begin[: CELLS * wide]]
            scale = max(scale, robust_scale(reference))
            cells = max(cells, int(np.count_nonzero(reference)) // wide)
            alike = distance[order] < ALIKE
            first = np.unique(cycle[alike], return_index=True)[1]
            again += begin[alike][first].tolist()
            cycles = len(first)
        if len(again) < FEWEST_AGAIN:
            return scale, cells, 0.0, cycles >= FEWEST_AGAIN
        largest = maximum_filter1d(output, 2 * near + 1, mode="constant")
        # Noise alone has a largest value within a short time too: that of the whole log is its share.
        repeated = max(float(np.median(largest[again]) - np.median(largest[self.slot])), 0.0)
        return scale, cells, repeated, cycles >= FEWEST_AGAIN


def robust_scale(outputs: Float) -> float:
    """Standard deviation of the outputs that are not 0, no smaller than their tails say."""
    size = np.abs(outputs[outputs != 0.0])
    median, decile = np.quantile(size, (0.5, 0.9)) if len(size) else (0.0, 0.0)
    return float(max(SIGMA_PER_MEDIAN * median, SIGMA_PER_NINTH_DECILE * decile))


def detect(
    problem: RegressionProblem, residual: Float, noise: NoiseModel, errors: Sequence[Float] = ()
) -> tuple[Contact, ...]:
    """Contacts in what a model leaves, where the formulas of effects may err, (m,) each; none if they are not rare."""
    filters = MatchedFilters(problem, residual, noise, errors)
    reach, start = len(problem.samples.kernel) // 2 * problem.data.step_s, float(problem.samples.t[0])
    spans = [
        (start + at * filters.slot_s + reach, start + (at + len(filters.pushes[k])) * filters.slot_s - reach)
        for k, at in _stand_out(filters, Reference(problem, filters.slot))
    ]
    first, last = problem.data.t[problem.data.moving][[0, -1]] + (END_S, -END_S)
    contacts: list[Contact] = []
    for start_s, stop_s in sorted(span for span in spans if first <= span[0] and span[1] <= last):
        if contacts and start_s - contacts[-1].stop_s <= APART_S:
            contacts[-1] = Contact(start_s=contacts[-1].start_s, stop_s=max(contacts[-1].stop_s, stop_s))
        else:
            contacts.append(Contact(start_s=start_s, stop_s=stop_s))
    inside, cycle = touched(problem, tuple(contacts)), problem.samples.cycle
    often = len(np.unique(cycle[inside])) > MOST_CYCLES * len(np.unique(cycle))
    return () if often else tuple(contacts)


def without_impulses(problem: RegressionProblem, left: Float, fine: Float) -> Float:
    """What a model leaves of the samples, shape (m,), without outliers of what it leaves of the fine grid, (n,). [N m]

    A velocity that jumps within a sample needs a torque that no sample holds, and is no push (Hampel's identifier:
    R. K. Pearson, IEEE Trans. Control Syst. Technol. 10 (2002) 55). A push is longer than the window of the median.
    Without this 16 rows of stranger_40000, whose motion has a corner, have a false contact. Outliers that the filter
    averages out with their neighbours, as where an encoder is coarse, would add to what is left.
    """
    from scipy.ndimage import median_filter

    data = problem.data
    apart = fine - median_filter(fine, 2 * max(round(IMPULSE_S / data.step_s), 1) + 1)
    sigma = SIGMA_PER_MEDIAN * float(np.median(np.abs(apart[data.used])))
    without = left - problem.samples.of(np.where(np.abs(apart) > OUTLIER * sigma, apart, 0.0))
    return np.where(np.abs(without) < np.abs(left), without, left)


def touched(problem: RegressionProblem, contacts: tuple[Contact, ...]) -> Bool:
    """Samples that the filter mixes with a contact, shape (m,)."""
    reach, t = len(problem.samples.kernel) // 2 * problem.data.step_s, problem.samples.t
    inside = np.zeros(len(t), bool)
    for contact in contacts:
        inside |= (t >= contact.start_s - reach) & (t <= contact.stop_s + reach)
    return inside


def _stand_out(filters: MatchedFilters, reference: Reference) -> list[tuple[int, int]]:
    """Filter and slot of each push, the largest first; none where no other cycle moves as during any of them.

    An inertia that is wrong is seen where the acceleration is largest (outside_acceleration_friction_16004).
    """
    from scipy.special import ndtri, stdtrit

    kept, slots = np.ones(len(filters.slot), bool), int(filters.slot[-1]) + 1
    products, energy = filters.sums(kept, slice(None), 0, slots)
    least_seen = np.maximum(LEAST_SEEN * np.median(energy[..., filters.slot], axis=-1, keepdims=True), TINY)

    def outputs_of(products: Float, energy: Float) -> Float:
        return np.asarray(np.where(energy > least_seen, products / np.sqrt(np.maximum(energy, least_seen)), 0.0))

    every = outputs_of(products, energy)
    usual = np.array([[max(robust_scale(one), TINY)] for one in every[:, 0]])
    whole, modelled, *wrong = every.transpose(1, 0, 2) / usual
    outputs, chance = whole.copy(), 0.5 * BY_CHANCE / max(int(np.count_nonzero(whole)), 1)
    near, found, any_known = max(round(NEAR_S / filters.slot_s), 1), [], False
    barred = np.zeros(outputs.shape[1], bool)
    for _ in range(MOST):
        size = np.where(barred, 0.0, np.abs(outputs))
        k, at = (int(i) for i in np.unravel_index(np.argmax(size[1:]), size[1:].shape))
        k += 1
        if size[k, at] < -ndtri(chance):
            break
        scale, cells, repeated, known = reference.compare(
            np.sign(outputs[k, at]) * whole[k], at, len(filters.pushes[k]), near
        )
        about = slice(max(at - near, 0), at + near + 1)
        by_formula = [float(np.abs(one[k, about]).max()) for one in (LEAST_OF_MODEL * modelled, *wrong)]
        least = max(-stdtrit(cells, chance) * scale, *by_formula)
        if size[k, at] - repeated < least or size[0, about].max() > GLITCH * size[k, at]:
            barred[about] = True
            continue
        any_known |= known
        found.append((k, at))
        stop = at + len(filters.pushes[k]) + filters.operator.shape[1] - 1
        kept &= (filters.slot < at) | (filters.slot >= stop)
        first, last = max(at - filters.reach, 0), min(stop, slots)
        outputs[:, first:last] = outputs_of(*filters.sums(kept, slice(1), first, last))[:, 0] / usual
    return found if any_known else []
