"""What a model leaves: is it noise, and where does it lie? Its mean in bins, and the quantity that shows an effect.

The checks have one threshold, a share of the residual's power. Each finds a structure that no noise has, and what share
of the mean square it holds: a curve over a quantity, a linear response to past motion (L. Ljung, System Identification
(1999), section 16.6), a spectral line in time or along the path, friction that scatters from stroke to stroke, an
effect of two sizes in two halves of the data (G. C. Chow, Econometrica 28 (1960) 591).
"""

from collections.abc import Mapping, Sequence

import numpy as np

from friction_audit.diagnosis.dictionary import Block
from friction_audit.diagnosis.fitted_model import FittedModel, held_out
from friction_audit.diagnosis.gram import Training
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.diagnosis.result import NamedEffect, OwnAxis, Profile, ResidualCheck, Traces
from friction_audit.diagnosis.samples import without_each
from friction_audit.diagnosis.selection import PRIOR, Projected
from friction_audit.joint_log import Bool, Float, Int

SHARE = 0.093  # 1 - 1 / 1.05^2: with an effect named the residual is 5 % above its floor
SHARE_OF_NONE = 0.02  # 1 - 1 / 1.01^2: the same where nothing is named (outside_hum_16000)
CHOW_Z = 5.0
STRONG = 6.0  # difference in evidence (Kass and Raftery 1995)
# What a structure must explain more than the effect it replaces: effects_inertia_error_70003 0.016 of the effect's own
# part, stranger_relaxing_hose_70001 0.12.
MORE = 0.05
LARGE_CHANGE = 0.5  # of a coefficient from one half of the data to the other
LINE_P = 1e-5
SCATTER_S, PAIRS_S, BLOCK_S = 0.3, 0.9, 1.2  # memory of friction within a stroke, longest distance of a pair, blocks
BINS = 12
FEWEST_ROWS = 5
FOLDS = 5
STRETCHES = 24  # of the axis, with equally many samples each
MOST_HIDDEN = 0.5  # share of the torque's mean square that may lie off the curve
ORDER = "ripple_order"  # parameter of an effect that repeats with the position: its waves per revolution
SOURCE = "gravity_error_source"  # 0 where the error follows the joint's own angle


def run(model: FittedModel) -> tuple[ResidualCheck, ...]:
    """All checks that found more than the threshold, the largest share first."""
    least = SHARE if model.active else SHARE_OF_NONE
    checks = (_curves, _lines, _scatter, _changes)
    found = [one for check in checks for one in check(model)]
    return tuple(sorted((c for c in found if c.share > least), key=lambda c: -c.share))


def _curves(model: FittedModel) -> list[ResidualCheck]:
    """Curves, and a response to past motion, that are significant in the whitened residual, on folds not fitted on."""
    gram, problem, given = model.gram, model.problem, Projected(model.training, model.active)
    found = [("curve", c.axis.name, c.columns, c.columns[:0]) for c in problem.curves]
    found = [one for one in found if given.evidence(gram.whiten(one[2])) > PRIOR]
    smoothed = given.and_also(gram.whiten(problem.smoothed))
    evidence, best = _integrated(smoothed, [gram.whiten(one) for one in problem.responses])
    if evidence > PRIOR:
        found.append(("response", "past motion", problem.responses[best], problem.smoothed))

    def rms(*columns: Float) -> float:
        return held_out(gram, model.active, np.vstack(columns)).rms

    return [
        ResidualCheck(code=code, along=along, share=1.0 - (rms(columns, known) / rms(known)) ** 2)
        for code, along, columns, known in found
    ]


def _integrated(given: Projected, white: Sequence[Float]) -> tuple[float, int]:
    """Evidence of whitened columns over a grid, and the place of the best."""
    evidence = np.array([given.evidence(one) for one in white])
    best = int(np.argmax(evidence))
    return float(evidence[best] + 2.0 * np.log(np.mean(np.exp(0.5 * (evidence - evidence[best]))))), best


def competing_structure(training: Training, active: Sequence[Block], block: Block) -> str:
    """Quantity a curve over which replaces an effect, or a linear response to past motion; empty without one.

    It has more evidence, its knots paid for, explains clearly more, and leaves no evidence for the effect: a formula
    that stands in for what the catalogue lacks (outside_acceleration_friction_16002). A test of models that are not
    nested: R. Davidson, J. G. MacKinnon, Econometrica 49 (1981) 781. A constant is part of many curves, and an effect
    of one over its own quantity, unless it holds torque of the nominal model. A torque of the position or time is part
    of those where the motion repeats: there the other must tell more than it with a curve over its own quantity.
    """
    if block.effect.misses == "nothing":
        return ""
    gram, given = training.gram, Projected(training, [b for b in active if b is not block])
    own = gram.of(block)
    evidence, effect_rss = given.evidence(own), given.and_also(own).rss
    others = {c.axis.name: [gram.whiten(c.columns)] for c in gram.problem.curves}
    others["past motion"] = [gram.whiten(one) for one in gram.problem.responses]
    free = [] if block.effect.needs_nominal else others.pop(block.effect.axis, [])
    helped = given.and_also(np.vstack([own, *free])) if block.effect.misses == "even" else given
    for name, white in others.items():
        found, best = _integrated(given, white)
        other = given.and_also(white[best])
        more = given.rss - other.rss > (1.0 + MORE) * (given.rss - effect_rss)
        more &= helped.evidence(white[best]) > PRIOR
        if more and found >= evidence + STRONG and other.evidence(own) < PRIOR:
            return name
    return ""


def _lines(model: FittedModel) -> list[ResidualCheck]:
    problem, left = model.problem, model.residual
    _, dq, _ = problem.kinematics
    path = np.cumsum(np.abs(problem.data.dq) * problem.data.moving)[problem.samples.fine] * problem.data.step_s
    highest = min(0.9 * problem.samples.corner_hz, 40.0)
    found = []
    for along, residual, x, low, high, weight in (
        ("time", left, problem.samples.t, 0.6, highest, np.ones(len(left))),
        ("path", left, path, 0.05, 10.0, np.abs(dq)),
        ("path", np.sign(dq) * left, path, 0.05, 10.0, np.abs(dq)),
    ):
        line = spectral_line(residual, x, low, high, weight)
        if line is not None:
            found.append(ResidualCheck(code="line", along=along, share=line[1], frequency=line[0]))
    return found


def spectral_line(residual: Float, x: Float, low: float, high: float, weight: Float) -> tuple[float, float] | None:
    """Frequency at which the periodogram stands out of its neighbours, and its share of the power; None without one.

    Over time or path, ascending, in samples of some weight, shape (m,) each.
    """
    span = float(x[-1] - x[0])
    low = max(low, 5.0 / max(span, 1e-9))
    if span <= 0 or high <= low:
        return None
    n = int(2 ** np.ceil(np.log2(max(4 * high * span, 64))))
    cell = ((x - x[0]) / span * (n // 2 - 1)).astype(int)
    power = np.abs(np.fft.rfft(np.bincount(cell, weight * residual, n))) ** 2
    frequency = np.arange(len(power)) * (n // 2 - 1) / span / n
    inside = (frequency >= low) & (frequency <= high)
    power, frequency = power[inside], frequency[inside]
    if len(power) < 20:  # noqa: PLR2004 - no neighbours
        return None
    k = int(np.argmax(power))
    near = np.abs(np.arange(len(power)) - k)
    level = float(np.median(power[(near > 3) & (near < 60)])) / np.log(2.0)  # noqa: PLR2004
    if power[k] <= level * np.log(len(power) / LINE_P):
        return None
    return float(frequency[k]), float(2.0 * (power[k] - level) / max(np.sum(weight**2) * np.sum(residual**2), 1e-300))


def _scatter(model: FittedModel) -> list[ResidualCheck]:
    """Friction too high or too low for a while: products of samples within a stroke against those across a reversal.

    Noise knows no direction; friction that scatters changes its sign with it.
    """
    problem, left = model.problem, model.residual
    t, sign = problem.samples.t, np.sign(problem.kinematics[1])
    step = float(np.median(np.diff(t)))
    slot = np.round((t - t[0]) / step).astype(int)
    r, s = np.zeros(slot[-1] + 1), np.zeros(slot[-1] + 1)
    r[slot], s[slot] = left, sign
    part, norm = np.zeros(len(r)), 0.0
    for lag in range(1, int(PAIRS_S / step)):
        first, second = slice(0, len(r) - lag), slice(lag, None)
        both = (s[first] != 0) & (s[second] != 0)
        if np.count_nonzero(both) < 50:  # noqa: PLR2004 - no mean
            continue
        agree = s[first] * s[second]
        usual, weight = float(agree[both].mean()), float(np.exp(-lag * step / SCATTER_S))
        part[first] += weight * np.where(both, r[first] * r[second] * (agree - usual), 0.0)
        norm += weight * np.count_nonzero(both) * (1.0 - usual**2)
    block = np.add.reduceat(part, np.arange(0, len(part), max(int(BLOCK_S / step), 1)))
    turns = np.count_nonzero(np.diff(sign))
    if block.sum() <= 3.0 * np.sqrt(np.sum(block**2)) or turns < 12:  # noqa: PLR2004
        return []
    share = min(float(block.sum() / max(norm, 1e-12) / np.mean(left**2)), 1.0)
    return [ResidualCheck(code="scatter", along="stroke", share=share)]


def _changes(model: FittedModel) -> list[ResidualCheck]:
    """Effects whose coefficients differ by more than half between two halves of the data."""
    gram, given = model.gram, Projected(model.training, model.active)
    variance = given.rss / given.samples
    _, dq, ddq = gram.problem.kinematics
    t = gram.problem.samples.t
    halves = {
        "direction": dq > 0,
        "speeding up": dq * ddq > 0,
        "speed": np.abs(dq) > np.median(np.abs(dq)),
        "acceleration": np.abs(ddq) > np.median(np.abs(ddq)),
        "time": t > np.median(t),
    }
    power, found = float(np.sum(model.residual**2)), []
    for block, torque in zip(model.active, model.torques, strict=True):
        for half in halves.values():
            column = np.where(half, 0.5, -0.5) * torque
            whole = gram.whiten(column)[0]
            free = whole - (given.basis @ whole) @ given.basis
            size = float(free @ free)
            if size <= 0.1 * float(whole @ whole):  # and a torque of zero
                continue
            change = float(free @ given.left) / size
            if abs(change) > LARGE_CHANGE and abs(change) * np.sqrt(size / variance) > CHOW_Z:
                share = float(np.sum((change * column) ** 2)) / power
                found.append(ResidualCheck(code="change", along=block.name, share=max(share, 2 * SHARE)))
                break
    return found


def profiles_of(
    problem: RegressionProblem, residual: Float, p_values: Mapping[str, float], axis: str = ""
) -> tuple[Profile, ...]:
    """What a model leaves along each axis, or one of that name, what takes most first; p-values by name of the axis."""
    found, dq, cycle = [], problem.kinematics[1], problem.samples.cycle
    for curve in [one for one in problem.curves if one.axis.name == axis] or problem.curves:
        edges = np.unique(np.quantile(curve.values, np.linspace(0.0, 1.0, BINS + 1)))
        found.append(
            Profile(
                axis=curve.axis.name,
                label=curve.axis.label,
                **_binned(residual, curve.values, edges, dq > 0, cycle),
                share=_share(residual, curve.columns.T, cycle),
                p_value=p_values.get(curve.axis.name, float("nan")),
            )
        )
    return tuple(sorted(found, key=lambda profile: -profile.share))


def _binned(residual: Float, values: Float, edges: Float, up: Bool, cycle: Int) -> dict[str, Float]:
    """Bins with means and standard errors of both directions, by the names that a profile has for them."""
    bins = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    centre = [values[bins == k].mean() if (bins == k).any() else np.nan for k in range(len(edges) - 1)]
    found = {"edges": edges, "centre": np.array(centre)}
    for name, which in (("forwards", up), ("backwards", ~up)):
        found[name], found[f"{name}_se"] = _bin_means(residual, bins, cycle, which, len(edges) - 1)
    return found


def _bin_means(residual: Float, bins: Int, cycle: Int, which: Bool, count: int) -> tuple[Float, Float]:
    """Mean of each bin and its standard error, the means of the cycles taken as independent, shape (count,) each.

    NaN where hardly any of the samples that count are in a bin, the error also where one cycle is.
    """
    bins, left, cycle = bins[which], residual[which], cycle[which] - cycle.min()
    cycles = int(cycle.max(initial=0)) + 1
    samples = np.bincount(bins, minlength=count)
    enough = samples >= FEWEST_ROWS
    mean = np.where(enough, np.bincount(bins, left, count) / np.maximum(samples, 1), np.nan)
    cell = bins * cycles + cycle
    deviation = np.bincount(cell, left - mean[bins], count * cycles).reshape(count, cycles)
    number = np.count_nonzero(np.bincount(cell, minlength=count * cycles).reshape(count, cycles), axis=1)
    several = enough & (number > 1)  # of one cycle the sum of squares is rounding
    spread = np.sum(deviation**2, axis=1) * number / np.where(several, number - 1, 1)
    return mean, np.where(several, np.sqrt(spread) / np.maximum(samples, 1), np.nan)


def _share(residual: Float, columns: Float, cycle: Int) -> float:
    """Share of the mean square that the curve predicts of cycles it has not seen, at least 0."""
    numbers, place = np.unique(cycle, return_inverse=True)
    fold = place % min(FOLDS, len(numbers))
    left, parts = residual.copy(), [np.flatnonzero(fold == k) for k in range(int(fold.max()) + 1)]
    grams = np.stack([(own := columns[part]).T @ own for part in parts])
    rights = np.stack([residual[part] @ columns[part] for part in parts])
    for part, factors in zip(parts, without_each(grams, rights), strict=True):
        left[part] -= columns[part] @ factors
    total = float(np.sum(residual**2))
    return max(0.0, 1.0 - float(np.sum(left**2)) / total) if total > 0 else 0.0


def shows_along(torque: Float, along: Float, dq: Float) -> bool:
    """Return whether most of a torque is a curve over a quantity, one for each direction of motion.

    A torque that rings, comes late or follows other joints has both signs at each place of any axis of this joint's
    motion: its mean there is next to nothing, and where that mean is largest is chance. All have shape (m,).
    """
    off_curve = 0.0
    for which in (dq > 0, dq <= 0):
        parts = np.array_split(torque[which][np.argsort(along[which], kind="stable")], STRETCHES)
        off_curve += float(sum(len(part) * part.var() for part in parts if len(part)))
    return off_curve <= MOST_HIDDEN * float(torque @ torque)


def own_axis(effect: NamedEffect, traces: Traces, *, free_of_chain: bool = False) -> OwnAxis | None:
    """Return what an effect is drawn along; None where the axis of its curve shows it.

    A ripple is drawn over one wave, for bins in place would average it away. What follows several joints, or is no
    curve over its axis, as the ringing of a spring or gravity free of that of an unknown chain, is drawn over the
    torque that was fitted: on the diagonal the log holds all of the effect.
    """
    if ORDER in effect.parameters:
        waves = effect.parameters[ORDER].value * traces.q / (2 * np.pi)
        label, values = "Position within a wave [waves]", np.mod(waves, 1.0)
    else:
        source = effect.parameters.get(SOURCE)
        alone = effect.axis != "neighbour" and (source is None or (source.value == 0.0 and not free_of_chain))
        if alone and shows_along(effect.torque, traces.along[effect.curve.axis], traces.dq):
            return None
        label, values = f"Fitted torque of {effect.name} [N m]", effect.torque
    before, after = traces.measured - traces.before, traces.measured - traces.after
    edges = np.linspace(values.min(), values.max(), BINS + 1)
    curve, without, left = (
        Profile(
            axis=label,
            label=label,
            **_binned(torque, values, edges, traces.dq > 0, traces.cycle) | {"centre": 0.5 * (edges[:-1] + edges[1:])},
            share=float("nan"),
            p_value=float("nan"),
        )
        for torque in (after + effect.torque, before, after)
    )
    return OwnAxis(label=label, values=values, curve=curve, before=without, after=left)
