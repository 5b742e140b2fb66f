"""Whether a log holds the motion that separates a hidden effect from its rivals, whatever the noise happens to be.

The torque that the effect adds, on ideal sensors and in the rows of real ones, free of the declared model and of the
best shape of a rival, is what tells the truth from that rival. Over the noise it is the noncentrality with which the
sharpest test knows them apart:

    lambda = n_eff |what the rival leaves|^2 / (m sigma^2),    m rows, worth n_eff

The detector's candidates are the measuring stick: their columns, and the price of its test (``alternatives``).
"""

from dataclasses import dataclass, replace
from heapq import nsmallest

import numpy as np
from friction_audit.diagnosis.alternatives import ALIKE, WRONG_NAME
from friction_audit.diagnosis.beside import Beside
from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.library import Entry, Library, build_library
from friction_audit.diagnosis.naming import free_numbers
from friction_audit.diagnosis.refine import refine
from friction_audit.diagnosis.ripple_scan import with_scanned_orders
from scipy.optimize import brentq
from scipy.stats import chi2, ncx2

from benchmarks.hidden_effects.draw import Case, model_of, settings_of
from benchmarks.hidden_effects.strength import prepared, scales_for
from friction_audit.effects.contact_event import EFFECT as CONTACT
from friction_audit.effects.registry import effects
from friction_audit.joint_log import Float
from friction_audit.simulation.scenarios import simulate

POWER = 0.9
"""With which the test must reject a rival."""
NEARLY_ALIKE = 0.5
"""Correlation on the grid from which a rival's shape is refined: between its points it may come to run alike."""
SHAPES = 3
"""Best shapes of a rival's grid that are refined: the misfit over the width of a play has many valleys."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Rival:
    """What takes the place of the truth in a log without noise.

    Attributes:
        name: Name of the candidate.
        correlation: Of what it explains with the torque that the effect adds, free of the declared model, 0..1.
        noncentrality: Of the test of the truth beside it, on the noise of the log.
    """

    name: str
    correlation: float
    noncentrality: float

    @property
    def alike(self) -> bool:
        """Whether it is a rival at all: what runs otherwise is never an alternative."""
        return self.correlation > ALIKE


@dataclass(frozen=True, kw_only=True, slots=True)
class Separation:
    """How well a log tells the truth from its rivals.

    Attributes:
        rivals: All candidates that the log can show, but the truth and what no motion of this kind tells from it.
        numbers: How many numbers the truth's candidate takes: degrees of freedom of the test; 0 where the log cannot
            show the truth.
    """

    rivals: tuple[Rival, ...]
    numbers: int

    @property
    def needed(self) -> float:
        """Noncentrality from which the test rejects a rival in nine logs of ten."""
        return noncentrality_for(self.numbers, sum(rival.alike for rival in self.rivals))

    @property
    def close(self) -> tuple[str, ...]:
        """Names of rivals that the log does not tell from the truth."""
        return tuple(rival.name for rival in self.rivals if rival.alike and rival.noncentrality < self.needed)

    @property
    def separates(self) -> bool:
        """Whether the log shows the truth, and none of its rivals would do."""
        return self.numbers > 0 and not self.close


def noncentrality_for(numbers: int, rivals: int) -> float:
    """Noncentrality with which chi squared of so many degrees of freedom is above the test's price at its power."""
    price = float(chi2.isf(WRONG_NAME / max(rivals, 1), numbers))
    return float(brentq(lambda size: ncx2.sf(price, numbers, size) - POWER, 1e-3, 10.0 * price + 100.0))


def separate(case: Case, scales: tuple[float, ...] | None = None) -> Separation | None:
    """Tell how well the log of a case with one effect separates it; None where its strength cannot be reached.

    Args:
        case: The case, its strength not yet scaled.
        scales: Scale of its strength, where it is known.
    """
    scales = scales or scales_for(case)
    if scales is None:
        return None
    (truth,) = case.effects
    clean, noisy = _ideal(case, (0.0,))
    hidden, _ = _ideal(case, scales)
    library = _library(hidden, truth)
    own = [entry for entry in library.entries if entry.candidate.name == truth]
    if not own:
        return Separation(rivals=(), numbers=0)
    floor = _square(clean.residual())
    worth = len(hidden.y) / noisy.memory() / _square(noisy.residual())
    whole = _square(hidden.residual()) - floor
    others = [entry for entry in library.entries if entry.candidate.name != truth]
    left = np.clip([_least(hidden, entry) - floor for entry in others], 0.0, whole)
    rivals = (
        Rival(name=entry.candidate.name, correlation=float(np.sqrt(1.0 - rest / whole)), noncentrality=worth * rest)
        for entry, rest in zip(others, left.tolist(), strict=True)
    )
    return Separation(rivals=tuple(rivals), numbers=_numbers(hidden, *own))


def _square(signal: Float) -> float:
    return float(np.mean(signal**2))


def _ideal(case: Case, scales: tuple[float, ...]) -> tuple[Ground, Ground]:
    """The joint on ideal sensors, in the rows and below the corner that noisy ones allow, and on those; all cycles.

    Where an encoder's noise hides which way the joint moves, as next to a reversal, nobody sees anything.
    """
    joint, model = case.number - 1, model_of(case)
    stated = None if model is None else model.joints[joint]
    noisy, ideal = (
        prepared(simulate(settings_of(case, scales, ideal=ideal), case.seed).log)[joint] for ideal in (False, True)
    )
    seen = make_ground(noisy, stated, 0)
    at = np.clip(np.rint((ideal.t - noisy.t[0]) / noisy.step_s).astype(int), 0, len(noisy.t) - 1)
    ideal = replace(ideal, moving=ideal.moving & noisy.moving[at])
    grounds = (make_ground(ideal, stated, 0, seen.rows.corner_hz), seen)
    first, second = (replace(ground, working=np.ones_like(ground.working)) for ground in grounds)
    return first, second


def _library(ground: Ground, truth: str) -> Library:
    """The truth and what may be taken for it."""
    same = next(candidate.indistinguishable for candidate in effects() if candidate.name == truth)
    asked = [candidate for candidate in effects() if candidate.name not in {CONTACT.name, *same}]
    return with_scanned_orders(ground, build_library(asked, ground.data, ground.baseline(), ground.rows))


def _fits(ground: Ground, entry: Entry) -> list[float]:
    """Mean square that each shape leaves; what the declared model leaves where its factors are impossible."""
    beside, fits = Beside(ground.base, ground.y), []
    for shape, columns in zip(entry.shapes, entry.columns, strict=True):
        factors, left = beside.fit(columns)
        fits.append((left if entry.candidate.admissible(factors, shape) else beside.without) / len(ground.y))
    return fits


def _least(ground: Ground, entry: Entry) -> float:
    """Mean square that the best possible shape of a candidate leaves, between the points of its grid too."""
    fits = _fits(ground, entry)
    nothing, least = _square(ground.residual()), min(fits)
    if least > (1.0 - NEARLY_ALIKE**2) * nothing:
        return least
    return min([least, *(_refined(ground, entry, k) for k in nsmallest(SHAPES, range(len(fits)), fits.__getitem__))])


def _refined(ground: Ground, entry: Entry, at: int) -> float:
    """What a shape leaves once it is refined, and leans on the declared model as fitted beside it."""
    candidate, baseline = entry.candidate, ground.baseline(entry.columns[at])
    shape = refine(candidate, entry.shapes[at], entry.shapes, ground, baseline, ground.base)
    columns = ground.rows.of(candidate.regressor(ground.data, baseline, shape))
    return _fits(ground, replace(entry, shapes=(shape,), columns=(columns,)))[0]


def _numbers(ground: Ground, entry: Entry) -> int:
    """Factors and numbers of the shape with which a candidate fits best."""
    fits = _fits(ground, entry)
    best = fits.index(min(fits))
    return int(entry.group.shapes[best].shape[1]) + free_numbers(entry.shapes)[best]
