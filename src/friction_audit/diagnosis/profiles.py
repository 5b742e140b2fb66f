"""A residual along a quantity: its mean in bins with standard errors, and the quantity that shows an effect."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from friction_audit.diagnosis.contact_events import touched
from friction_audit.diagnosis.problem import RegressionProblem
from friction_audit.diagnosis.procedure import State
from friction_audit.diagnosis.result import ContactTrace, NamedEffect, OwnAxis, Profile, Traces
from friction_audit.diagnosis.samples import without_each
from friction_audit.effects.slow import ContactEvent as Contact
from friction_audit.friction.history import Coefficient
from friction_audit.joint_log import Float
from friction_audit.preprocessing.even_grid import filtered

BINS = 12
FEWEST_ROWS = 5
FOLDS = 5
STRETCHES = 24  # of the axis, with equally many samples each
MOST_HIDDEN = 0.5  # share of the torque's mean square that may lie off the curve
ORDER = "ripple_order"  # parameter of an effect that repeats with the position: its waves per revolution
SOURCE = "gravity_error_source"  # 0 where the error follows the joint's own angle
OF_SEVERAL_JOINTS = ("inertial_coupling", "torque_crosstalk")


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


def _binned(
    residual: Float, values: Float, edges: Float, up: NDArray[np.bool_], cycle: NDArray[np.int64]
) -> dict[str, Float]:
    """Bins with means and standard errors of both directions, by the names that a profile has for them."""
    bins = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    centre = [values[bins == k].mean() if (bins == k).any() else np.nan for k in range(len(edges) - 1)]
    found = {"edges": edges, "centre": np.array(centre)}
    for name, which in (("forwards", up), ("backwards", ~up)):
        found[name], found[f"{name}_se"] = _bin_means(residual, bins, cycle, which, len(edges) - 1)
    return found


def _bin_means(
    residual: Float, bins: NDArray[np.int64], cycle: NDArray[np.int64], which: NDArray[np.bool_], count: int
) -> tuple[Float, Float]:
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


def _share(residual: Float, columns: Float, cycle: NDArray[np.int64]) -> float:
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
        alone = effect.name not in OF_SEVERAL_JOINTS and (source is None or (source.value == 0.0 and not free_of_chain))
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


def contact_effects(state: State, profiles: tuple[Profile, ...]) -> tuple[NamedEffect, ...]:
    """Contacts as one effect of the answer."""
    problem, X, whole, contacts = state.problem, state.problem.X, state.disturbed, state.contacts
    if whole is None:
        return ()
    coefficients = np.linalg.lstsq(X @ X.T, X @ problem.y, rcond=1e-12)[0]
    left, inside = (whole.y - coefficients @ whole.X) / whole.samples.weight, touched(whole, contacts)
    before, after = (float(np.sqrt(np.mean(one**2))) for one in (left, left[~inside]))
    largest = float(left[inside][np.argmax(np.abs(left[inside]))]) if inside.any() else 0.0
    lengths = [one.stop_s - one.start_s for one in contacts]
    numbers = {"contacts": float(len(contacts)), "first_contact_s": contacts[0].start_s,
               "longest_contact_s": max(lengths), "largest_contact_nm": largest}  # fmt: skip
    size = float(np.sqrt(max(before**2 - after**2, 0.0)))
    return (
        NamedEffect(
            name=Contact.name,
            label=Contact.label,
            parameters={k: Coefficient.around(v) for k, v in numbers.items()},
            axis=Contact.axis,
            gap_before_nm=before,
            gap_after_nm=after,
            torque=np.zeros(len(problem.y)),
            curve=next((one for one in profiles if one.axis == Contact.axis), profiles[0]),
            size_nm=size,
            residual_share=(size / before) ** 2 if before > 0 else 0.0,
            grade="major",
        ),
    )


def contact_trace(state: State) -> ContactTrace | None:
    """What the augmented model leaves over the whole log, samples of contacts included; None without contacts."""
    if not state.contacts:
        return None
    data, samples = state.problem.data, state.problem.samples
    fine = state.fitted().fine_residual
    left = filtered(fine[None], samples.kernel, np.arange(0, len(fine), samples.every))[0]
    seen = (data.moving & data.valid)[:: samples.every]
    return ContactTrace(
        t=data.t[:: samples.every],
        residual_nm=np.where(seen, left, np.nan),
        spans_s=tuple((contact.start_s, contact.stop_s) for contact in state.contacts),
    )
