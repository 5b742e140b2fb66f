"""Scatter between sessions beyond the intervals of their estimates: the random effect of a session."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_audit.drift.session import Series
from friction_audit.joint_log import Float

MAD_TO_SD = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""


def steps_scatter(y: Float, error: Float) -> float:
    """Return the scatter that the differences of sessions in a row show; a few steps or a slow ramp do not matter.

    The variance of a difference is 2 tau^2 + s_i^2 + s_{i+1}^2.

    Args:
        y: Estimates in the order of the sessions, shape (n,).
        error: Their standard errors, shape (n,).
    """
    if len(y) <= 1:
        return 0.0
    spread = (MAD_TO_SD * float(np.median(np.abs(np.diff(y))))) ** 2
    own = float(np.median(error[1:] ** 2 + error[:-1] ** 2))
    return float(np.sqrt(max(spread - own, 0.0) / 2))


def residual_scatter(residual: Float, error: Float, freedom: int) -> float:
    """Return tau with which the weighted residuals are as large as they should be (Paule and Mandel 1982).

    Solves sum r_i^2 / (s_i^2 + tau^2) = degrees of freedom; 0 where the errors alone explain the residuals.

    Args:
        residual: Of a model of the drift, shape (n,).
        error: Standard errors, shape (n,).
        freedom: Sessions minus parameters.
    """
    from scipy.optimize import brentq

    def excess(tau: float) -> float:
        return float(np.sum(residual**2 / (error**2 + tau**2))) - freedom

    if freedom < 1 or excess(0.0) <= 0.0:
        return 0.0
    return float(brentq(excess, 0.0, float(np.sqrt(np.sum(residual**2) / freedom)) + 1e-300, xtol=1e-12))


SHORTEST_SEGMENT = 2
"""Sessions before and after a step."""

MOST_STEPS = 80
"""So many places of a step are tried; more only cost time, for neighbours say nearly the same."""

SHORTEST_EPISODE = 10
"""Sessions of a change that comes and goes: shorter ones are like scatter with a memory, and cost sensitivity."""

MOST_PLACES = 32
"""So many places of a step are paired to changes that come and go."""

HANDICAP = 0.7
"""Factor on the statistic of a change that comes and goes: there are many, and they must not hide the single steps."""

COLLINEAR = 1e-6
"""A direction with a smaller part of its square left beside the temperature is none."""


ROUNDING = 1e-4
"""If no session is off by so much of its error, nothing changes but the last digits."""


@dataclass(frozen=True, eq=False, kw_only=True, slots=True)
class Directions:
    """What the tests look along, whitened: every session's error is 1.

    Attributes:
        split: First session after the step, shape (k,); 0 for a ramp.
        back: First session after the step back, shape (k,); n where there is none.
        direction: Unit vectors, orthogonal to level and temperature, shape (n, k); 0 where nothing is left of one.
        length: Length of each shape beside level and temperature, before it was made a unit vector, shape (k,).
        base: Orthonormal basis of level and temperature, shape (n, b).
        residual: What level and temperature leave of y, shape (n,).
        weight: One over the standard error with scatter, shape (n,).
        ramp: Ramps as they are, shape (n, r); the last r of the directions.
    """

    split: NDArray[np.int64]
    back: NDArray[np.int64]
    direction: Float
    length: Float
    base: Float
    residual: Float
    weight: Float
    ramp: Float

    @property
    def freedom(self) -> int:
        """Degrees of freedom beside level, temperature and one direction."""
        return int(len(self.residual) - self.base.shape[1] - 1)

    @property
    def episodes(self) -> NDArray[np.bool_]:
        """Which directions are changes that come and go, shape (k,)."""
        return np.asarray(self.back < len(self.residual))

    @property
    def handicap(self) -> Float:
        """Factor on the statistic of each direction, shape (k,)."""
        return np.where(self.episodes, HANDICAP, 1.0)

    @property
    def ramps(self) -> NDArray[np.bool_]:
        """Which directions are ramps, shape (k,)."""
        return np.asarray(self.split == 0)


def make_directions(series: Series) -> Directions:
    """Return the directions of drift for the sessions that count, steps first.

    Args:
        series: At least three sessions, all of them counted.
    """
    n, ramps = len(series.place), ramp_shapes(series)
    steps = step_places(n)
    there, back = episode_places(steps)
    split, back = np.append(steps, there), np.append(np.full(len(steps), n), back)
    between = (np.arange(n)[:, None] >= split) & (np.arange(n)[:, None] < back)
    none = np.zeros(ramps.shape[1], dtype=np.int64)
    return orthogonal(
        np.column_stack([between.astype(float), ramps]),
        split=np.append(split, none),
        back=np.append(back, none + n),
        base=base_shapes(series),
        y=series.y,
        weight=robust_weight(series),
    )


def orthogonal(
    shapes: Float,
    *,
    split: NDArray[np.int64],
    base: Float,
    y: Float,
    weight: Float,
    back: NDArray[np.int64] | None = None,
) -> Directions:
    """Whiten shapes, base and y, and take the base out of the others."""
    basis, _ = np.linalg.qr(base * weight[:, None])
    whitened = shapes * weight[:, None]
    left = whitened - basis @ (basis.T @ whitened)
    square, whole = np.sum(left**2, axis=0), np.sum(whitened**2, axis=0)
    length = np.where(square > COLLINEAR * whole, np.sqrt(square), 0.0)
    direction = np.divide(left, length, out=np.zeros_like(left), where=length > 0)
    scaled = (y - np.average(y, weights=weight**2)) * weight
    residual = scaled - basis @ (basis.T @ scaled)
    if np.max(np.abs(residual), initial=0.0) < ROUNDING:
        residual = np.zeros_like(residual)
    return Directions(
        split=split,
        back=np.full(len(split), len(y)) if back is None else back,
        direction=direction,
        length=length,
        base=basis,
        residual=residual,
        weight=weight,
        ramp=shapes[:, split == 0],
    )


def step_places(sessions: int) -> NDArray[np.int64]:
    """Return the sessions that a step is tried before, all of them or densely near both ends, shape (k,)."""
    places = np.arange(SHORTEST_SEGMENT, sessions - SHORTEST_SEGMENT + 1)
    if len(places) <= MOST_STEPS:
        return places
    share = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, MOST_STEPS)))
    return places[np.unique(np.round(share * (len(places) - 1)).astype(np.int64))]


def episode_places(steps: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the first sessions in and after each change that comes and goes, from the places of steps."""
    chosen = steps[np.unique(np.linspace(0, len(steps) - 1, min(len(steps), MOST_PLACES)).astype(np.int64))]
    there, back = chosen[np.array(np.triu_indices(len(chosen), 1))]
    long = back - there >= SHORTEST_EPISODE
    return there[long], back[long]


def ramp_shapes(series: Series) -> Float:
    """Return straight changes from 0 at the first session to 1 at the last, over sessions and days, shape (n, r)."""
    clocks = [series.place] if series.day is None else [series.place, series.day]
    spans = [(clock - clock[0]) / (clock[-1] - clock[0]) for clock in clocks if clock[-1] > clock[0]]
    return np.column_stack(spans) if spans else np.zeros((len(series.place), 0))


def base_shapes(series: Series) -> Float:
    """Return what is no drift: the level and, where it can be used, the temperature, shape (n, b)."""
    level = np.ones(len(series.place))
    if series.temperature is None:
        return level[:, None]
    return np.column_stack([level, series.temperature - np.mean(series.temperature)])


def robust_weight(series: Series) -> Float:
    """Return one over the standard error, the scatter between neighbouring sessions included, shape (n,)."""
    y = series.y
    if series.temperature is not None:
        base = base_shapes(series)
        y = y - base @ np.linalg.lstsq(base, y, rcond=None)[0]
    return 1.0 / np.sqrt(series.y_error**2 + steps_scatter(y, series.y_error) ** 2)


def studentise(residual: Float, directions: Directions) -> Float:
    """Return t of each direction, its own variance around each, shape (orders, k).

    Args:
        residual: Whitened, shape (orders, n).
        directions: Unit vectors beside level and temperature.
    """
    along = residual @ directions.direction
    square = np.sum(residual**2, axis=1) - np.sum((residual @ directions.base) ** 2, axis=1)
    rest = np.maximum(square[:, None] - along**2, 1e-12 * square[:, None] + 1e-300)
    return np.asarray(along * directions.handicap * np.sqrt(max(directions.freedom, 1) / rest), dtype=float)


def studentise_orders(directions: Directions, order: NDArray[np.int64]) -> Float:
    """Return t of each shape with the sessions in other orders, shape (orders, k).

    A session takes its error and its temperature along: an estimate that is worse than its error says stays as it is.

    Args:
        directions: In the true order.
        order: Sessions in other orders, shape (orders, n).
    """
    weight = directions.weight[order]
    along = _along_shapes(directions.residual[order] * weight, directions, directions.ramp)
    whole = _along_shapes(weight**2, directions, directions.ramp**2)
    square = whole.copy()
    for base in directions.base.T:
        square -= _along_shapes(base[order] * weight, directions, directions.ramp) ** 2
    unit = np.divide(
        along, np.sqrt(np.maximum(square, 0.0)), out=np.zeros_like(along), where=square > COLLINEAR * whole
    )
    total = float(np.sum(directions.residual**2))
    rest = np.maximum(total - unit**2, 1e-12 * total + 1e-300)
    return np.asarray(unit * directions.handicap * np.sqrt(max(directions.freedom, 1) / rest), dtype=float)


def _along_shapes(rows: Float, directions: Directions, ramp: Float) -> Float:
    """Return the sum of each row from each step to the step back, and along each ramp, shape (orders, k)."""
    before = np.cumsum(np.insert(rows, 0, 0.0, axis=1), axis=1)
    steps = ~directions.ramps
    return np.column_stack([before[:, directions.back[steps]] - before[:, directions.split[steps]], rows @ ramp])
