"""JointData -> Samples: torque and regression columns through one low-pass, at a rate near its Nyquist rate.

On them stands the nominal model: B ddq + mu_c sgn(dq) + mu_v dq, and the terms of a model file.

Columns are built on the fine grid, where the sign of the velocity is sharp, and pass the low-pass of the torque: a
reversal is smeared alike in both. The corner is 25 Hz, above the frequencies of the motion (below 4 Hz) and just below
the first resonance of a Panda (26 to 28 Hz); it is lower where the noise of inertia times acceleration would come near
that of the torque, and would be taken for a spring.

Where a joint leaves a standstill there is one noisier sample: torque and columns extrapolated to the moment of
break-away. Without these samples effects_stiction_16001, 16002, 16003 and 16005 are adequate.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from friction_audit.dynamics.motion import Motion
from friction_audit.effects.breakaway import FEWEST_BREAKAWAYS, Breakaways, breakaways_of, torque_known
from friction_audit.effects.joint_data import CORNER_HZ, SIGMA_PER_MEDIAN, JointData, Nominal
from friction_audit.effects.joint_model import FittedTerm, JointModel
from friction_audit.effects.transmission import MOTION_BELOW_HZ
from friction_audit.errors import AnalysisError
from friction_audit.joint_log import Bool, Float, Int
from friction_audit.preprocessing.even_grid import filtered, kaiser_low_pass, within
from friction_audit.preprocessing.interaction import Caution
from friction_audit.preprocessing.velocity import MEDIAN_OF_DENSITY, noise_density

INERTIA = "inertia_kg_m2"
FRICTION = {"coulomb": "coulomb_nm", "viscous": "viscous_nms_per_rad"}  # terms with their one coefficient
SAMPLE_HZ = 100.0
LOWEST_CORNER_HZ = 8.0
# Of the torque's noise: what a regressor's may be. With a third, a delay of 4 ms is lost; with all of it, half of the
# clean logs have a spring that is significant, if too small for a name.
QUIET_SHARE = 0.5
OBSERVED = 0.62  # of white noise, what a density from second differences finds: the grid's low-pass takes the rest
SMALL = 1e-3  # of the torque, what no diagnosis needs
MOST_UNCERTAIN = 0.02  # share of the filter's weight that may come from samples without a certain direction
REGULAR = 1e-8  # least eigenvalue of scaled products that are solved without their eigenvectors, in a tenth of the time


@dataclass(frozen=True, eq=False, kw_only=True)
class Samples:
    """The samples of one joint that a model is fitted to, m of them, from n on the fine grid."""

    kernel: Float  # weights of the filter, an odd number of them
    # standstills before the break-aways, b of the m samples; their weights make all samples equally noisy
    onsets: Breakaways
    corner_hz: float  # frequency of which half the amplitude passes [Hz]
    every: int  # fine samples per place
    place: Int  # number of each sample, counted with those that are left out, shape (m,)
    breakaway: Bool  # whether the sample is the moment of a break-away, shape (m,)
    weight: Float  # factor of torque and columns that makes all samples equally noisy, shape (m,)
    t: Float  # times, shape (m,) [s]
    y: Float  # torque, shape (m,) [N m]
    cycle: Int  # number of the cycle of each sample, shape (m,)

    @cached_property
    def fine(self) -> Int:
        """Place of each sample on the fine grid, shape (m,)."""
        return self.place * self.every

    def keep(self, kept: Bool) -> "Samples":
        """Some of the samples, shape (m,)."""
        names = ("place", "breakaway", "weight", "t", "y", "cycle")
        onsets = self.onsets.take(kept[self.breakaway])
        return replace(self, onsets=onsets, **{name: getattr(self, name)[kept] for name in names})

    def of(self, columns: Float) -> Float:
        """Filter and thin out columns of the fine grid, shape (n,) or (n, p), to shape (m,) or (m, p)."""
        rows = np.ascontiguousarray(np.atleast_2d(columns.T), np.float64)
        out = filtered(rows, self.kernel, self.fine)
        if len(self.onsets.onset):
            out[:, np.flatnonzero(self.breakaway)] = self.onsets.of(rows.T).T
        return out[0] if columns.ndim == 1 else out.T

    def near(self, n: int) -> tuple[Int, "Samples"]:
        """Where the filter reads a fine grid of n samples, and what makes the samples of columns given there alone."""
        half, last = len(self.kernel) // 2, self.onsets.samples
        begins = np.append(np.maximum(self.fine - half, 0), last[:, 0])
        read = within(begins, np.append(np.minimum(self.fine + half + 1, n), last[:, -1] + 1), n)
        onsets = replace(self.onsets, samples=np.searchsorted(read, last))
        return read, replace(self, every=1, place=np.searchsorted(read, self.fine), onsets=onsets)


@lru_cache(maxsize=1)  # of a joint they are needed to count its cycles, then to build its problem
def make_samples(data: JointData, corner_hz: float = CORNER_HZ) -> Samples:
    """Take the samples in which the direction of motion is certain, and those at which the joint breaks away.

    Half of the amplitude passes at the corner, or at a quarter of the samples' rate if that is lower.
    """
    from scipy.ndimage import maximum_filter1d

    every = max(int(1.0 / data.step_s / SAMPLE_HZ + 1e-9), 1)
    corner = min(corner_hz, 1.0 / data.step_s / every / 4)
    kernel = kaiser_low_pass(corner, 1.0 / data.step_s)
    whole = ~maximum_filter1d(~data.valid, len(kernel))[::every] & (data.cycle[::every] >= 0)
    doubt = (~(data.moving & data.valid)).astype(np.float64)[None]
    uncertain = filtered(doubt, np.abs(kernel), np.arange(0, len(data.t), every))[0]
    breakaways = breakaways_of(data)
    breakaways = breakaways.take(torque_known(data.without_gravity, breakaways, data.step_s))
    known = whole[breakaways.onset // every]
    # Fewer than show stiction are chance, and a few torques of a joint at rest weigh as much as all that slides.
    breakaways = breakaways.take(known & (np.count_nonzero(known) >= FEWEST_BREAKAWAYS))
    moving = np.setdiff1d(np.flatnonzero(whole & (uncertain <= MOST_UNCERTAIN)), breakaways.onset // every)
    place = np.concatenate([moving, breakaways.onset // every])
    order = np.argsort(place)
    breakaway = np.repeat([False, True], [len(moving), len(breakaways.onset)])
    # Noise that the highest corner leaves of white noise, over that which other weights leave. Where the corner is
    # lower the torque's noise is hardly white: a lower weight would be too low.
    relative = min(float(np.sqrt(2.0 * CORNER_HZ * data.step_s) / np.linalg.norm(breakaways.weights)), 1.0)
    samples = Samples(
        kernel=kernel,
        onsets=replace(breakaways, weights=relative * breakaways.weights),
        corner_hz=corner,
        every=every,
        place=place[order],
        breakaway=breakaway[order],
        weight=np.where(breakaway, relative, 1.0)[order],
        t=data.t[place[order] * every],
        y=np.zeros(0),
        cycle=data.cycle[place[order] * every],
    )
    return replace(samples, y=samples.of(data.torque))


def corner_for(data: JointData, inertia_kg_m2: float) -> tuple[float, float]:
    """Corner [Hz], and how many times too large the steps are in which the position, or the velocity, is read.

    Above the corner the noise of inertia times acceleration is more than half of that of the torque. White noise of the
    position grows with the square of the frequency in its second derivative, that of the velocity with the frequency,
    that of the mean of both as given below. Links' inertia that was removed left the noise of all joints' accelerations
    in the torque. Steps that are too large make it more than half at every corner, which all that follows the
    acceleration explains (W. A. Fuller, Measurement Error Models, 1987): coarse_118003 is unexplained.
    """
    # With 25 Hz everywhere, none_none_16001 is named time_delay, and effects_backlash_16001 presliding as well.
    order, step_s = 2 if data.derived_from == "q" else 1, data.step_s
    noise = noise_density(data.torque if data.load is None else data.torque + data.load, step_s, 0)
    # As if rounding, white in the log's samples, were all noise of the acceleration.
    median = data.rounding / SIGMA_PER_MEDIAN * float(np.sqrt(data.sample_s / (np.pi * step_s)))
    rounding = OBSERVED * (2.0 * np.pi) ** order * median
    apart = OBSERVED * MEDIAN_OF_DENSITY / float(np.sqrt(step_s)) * (2.0 * np.pi) ** order * data.noise_density
    own = inertia_kg_m2 * max(noise_density(data.ddq, step_s, order), rounding, apart)
    inertial = float(np.hypot(own, 0.0 if data.load is None else noise_density(data.load, step_s, order)))
    crossing = (QUIET_SHARE * noise / inertial) ** (1.0 / order) if inertial > 0 else CORNER_HZ
    # f^2 / sqrt(f^2 + crossover^2) in the place of f, solved for f
    crossing = np.sqrt((crossing**2 + np.hypot(crossing**2, 2.0 * crossing * data.crossover_hz)) / 2.0)
    # A torque without noise is as quiet as this share of it, white below the lowest corner.
    band = 2.0 * np.pi * LOWEST_CORNER_HZ * step_s
    least = SMALL * float(np.std(data.torque)) / SIGMA_PER_MEDIAN / float(np.sqrt(band))
    quiet = max(QUIET_SHARE * max(noise, least), np.finfo(float).tiny)
    coarse = inertia_kg_m2 * rounding * LOWEST_CORNER_HZ**order / quiet
    # Where noise is that large, half of the lowest corner is enough for friction (resampled: none 130002 held).
    lowest = LOWEST_CORNER_HZ / 2.0 if crossing < LOWEST_CORNER_HZ / 2.0 else LOWEST_CORNER_HZ
    return float(np.clip(crossing, lowest, CORNER_HZ)), coarse


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class NominalModel:
    """The nominal model, b columns."""

    # names of the coefficients with their unit: Coulomb and viscous friction, inertia unless a model file states it,
    # then the coefficients of other terms of the file; without those of terms that the file holds
    names: tuple[str, ...]
    fine: Float  # their columns on the fine grid, shape (n, b)
    columns: Float  # the same on the samples, shape (m, b)
    stated: Float  # torque of the numbers that are not fitted, on the fine grid, shape (n,) [N m]
    y: Float  # torque of the samples without it, shape (m,) [N m]
    model: JointModel | None  # the model file's model of the joint, None without one

    @classmethod
    def build(cls, data: JointData, samples: Samples, model: JointModel | None) -> "NominalModel":
        """Build the columns; the inertia of a model file and the terms that it holds are not fitted.

        Raises:
            AnalysisError: If everything is stated, so that nothing is left to fit.
        """
        fine = {"coulomb_nm": data.direction, "viscous_nms_per_rad": data.dq}
        stated = np.zeros(len(data.t))
        if model is None:
            fine[INERTIA] = data.ddq
        else:
            rest = model.rest(data.motion())
            stated = model.inertia_kg_m2 * data.ddq
            for term in model.terms:
                motion = _motion_of(term, model, data, samples) if term.effect.transmits else data.motion(rest)
                columns = _columns(term, motion)
                if term.name in model.held:
                    stated = stated + term.torque(motion)
                    fine = {name: column for name, column in fine.items() if name not in columns}
                else:
                    fine |= columns
        if not fine:
            raise AnalysisError((Caution("all_held"),))
        stacked = np.column_stack(list(fine.values()))
        return cls(
            names=tuple(fine),
            fine=stacked,
            columns=samples.of(stacked),
            stated=stated,
            y=samples.y - samples.of(stated),
            model=model,
        )

    def baseline(self, coefficients: Float) -> Nominal:
        """The fitted model, from coefficients, shape (b,), as columns of effects need it."""
        stated = {}
        if (model := self.model) is not None:
            held = {name: values[0] for name in model.held if (values := model.values(name)) is not None}
            stated = {INERTIA: model.inertia_kg_m2} | {FRICTION[name]: held[name] for name in FRICTION if name in held}
        value = stated | dict(zip(self.names, coefficients.tolist(), strict=True))
        return Nominal(
            inertia_kg_m2=value[INERTIA],
            coulomb_nm=value["coulomb_nm"],
            viscous_nms_per_rad=value["viscous_nms_per_rad"],
            torque=self.fine @ coefficients + self.stated,
            declared=frozenset(stated),
        )


def _motion_of(term: FittedTerm, model: JointModel, data: JointData, samples: Samples) -> Motion:
    """The motion as measured or low-passed, for a link amplifies noise: that with which the term explains more."""
    every = [data.motion(), data.motion_below(MOTION_BELOW_HZ)]
    motions = [replace(motion, rest=model.rest(motion)) for motion in every]
    simple = (data.direction, data.dq, data.ddq)
    left = []
    for motion in motions:
        columns = samples.of(np.column_stack([*simple, *_columns(term, motion).values()])).T
        left.append(np.linalg.norm(samples.y - least_squares(columns, samples.y) @ columns))
    return motions[int(np.argmin(left))]


def _columns(term: FittedTerm, motion: Motion) -> dict[str, Float]:
    """Columns of a term by name of their coefficient; none for what the file lacks."""
    regressor = term.effect.columns(motion, term.values[len(term.effect.coefficients) :])
    return {
        parameter.name: regressor[:, k]
        for k, (parameter, value) in enumerate(zip(term.effect.coefficients, term.values, strict=False))
        if value != 0.0 or not parameter.optional
    }


def least_squares(columns: Float, y: Float) -> Float:
    """Coefficients of least norm, shape (p,), of columns, shape (p, m); exactly 0 for a column of zeros."""
    scale = np.sqrt(np.mean(columns**2, axis=1))
    scale = np.where(scale > 0, scale, 1.0)
    scaled = columns / scale[:, None]
    return np.asarray(np.linalg.lstsq(scaled @ scaled.T, scaled @ y, rcond=1e-12)[0] / scale)


def without_each(grams: Float, rights: Float, prior: Float | float = 0.0) -> Float:
    """Coefficients of least squares without one group of samples each, shape (groups, p).

    Products of the columns with each other and with the response in each group have shapes (groups, p, p) and
    (groups, p), precisions of the coefficients (p,). Least norm where columns depend on each other.
    """
    own = np.diag(grams.sum(axis=0))
    scale = np.sqrt(np.where(own > 0, own, 1.0))
    total = grams.sum(axis=0) + np.diag(np.broadcast_to(prior, own.shape))
    scaled, right = (total - grams) / scale[:, None] / scale, ((rights.sum(axis=0) - rights) / scale)[..., None]
    try:
        np.linalg.cholesky(scaled - REGULAR * np.eye(len(scale)))
        found = np.linalg.solve(scaled, right)
    except np.linalg.LinAlgError:
        found = np.linalg.pinv(scaled, rcond=1e-12, hermitian=True) @ right
    return np.asarray(found[..., 0] / scale)
