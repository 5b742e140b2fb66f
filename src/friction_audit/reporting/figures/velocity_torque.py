"""Estimate -> interaction torque over velocity, raw and filtered, with the fitted friction on it."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from friction_audit.friction.history import JointFriction
from friction_audit.joint_log import Float
from friction_audit.reporting.figures import panels as parts
from friction_audit.reporting.figures.series import JointSeries, choose_series
from friction_audit.reporting.figures.style import FILTERED, FITTED, RAW, figure_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from friction_audit.pipeline import Estimate

COLUMNS = 4
ARROWS, ARROW_LENGTH = 6, 0.06  # the length of a panel's width
NEAR_REST = 0.2  # share of the peak speed below which the curve is too steep and crowded for an arrow
POINTS_PER_PERIOD = 10  # of the filtered curve, per period of its highest frequency: enough for a smooth line
SMALLEST_CENTRE_NM = 0.0005  # the label's three decimals would round less to nothing
MOST_LOOPS = 60  # cycles of the filtered curve above which it would be a blot
SMALLEST_SPEED_RAD_S = 0.1  # half width of the panel of a joint that stands still


class Loop(NamedTuple):
    """The filtered curve: velocity, torque, and which part of the cycles it shows (1 in ``every``)."""

    dq: Float
    torque: Float
    every: int


@figure_style()
def draw_velocity_torque(estimate: "Estimate", joint: parts.Numbers) -> "Figure":
    """Draw one joint at column width, or every joint that moved on a sheet."""
    joints, sheet, note = choose_series(estimate, joint)
    figure, panels = parts.grid([1.75 if sheet else 2.4] * len(joints), sheet=sheet, across=COLUMNS, head_in=0.5)
    formulas = [_draw_panel(axes, series, sheet=sheet) for axes, series in zip(panels, joints, strict=True)]
    parts.add_legend(figure, formula=None if sheet else formulas[0])
    figure.supxlabel(f"Velocity [rad/s]{note}")
    compensated = joints[0].compensation is not None
    figure.supylabel("Interaction and compensator torque [N m]" if compensated else "Interaction torque [N m]")
    return figure


def draw_panel(axes: "Axes", estimate: "Estimate", joint: int) -> None:
    """Draw one joint into axes, and name them."""
    (series,), _, _ = choose_series(estimate, joint)
    _draw_panel(axes, series, sheet=False)
    axes.set(xlabel="Velocity [rad/s]", ylabel="Interaction torque [N m]")


def _draw_panel(axes: "Axes", series: JointSeries, *, sheet: bool) -> str | None:
    """Draw one joint; return the fitted curve's formula if there is one."""
    thinned = parts.every_nth(len(series.t))
    raw = "raw" if thinned.step == 1 else f"raw, 1 sample in {thinned.step}"
    parts.draw_dots(axes, series.dq[thinned], series.driving_torque[thinned], RAW, raw)
    curve = filtered_curve(series)
    loop = filtered_loop(series, curve)
    filtered = f"filtered, {parts.cutoff_hz(series.t):.3g} Hz{'' if loop.every == 1 else f', 1 cycle in {loop.every}'}"
    axes.plot(loop.dq, loop.torque, color=FILTERED, lw=0.35, rasterized=True, label=filtered)
    _add_arrows(axes, series, curve)
    reach = float(np.abs(series.dq).max())
    # Two points next to zero on each side make the step of the Coulomb term upright.
    dq = np.array([-reach, -1e-9, 1e-9, reach])
    fitted = None if series.not_determined else fitted_torque(series.friction, dq)
    formula = None
    if fitted is not None:
        centre = centre_nm(series)
        formula = fitted_label(series.friction, centre)
        # The numbers differ from panel to panel, so the sheet's legend cannot show them.
        label = "fitted friction" if sheet else formula
        axes.plot(dq, fitted + centre, color=FITTED, lw=1.3, zorder=4, label=label)
    axes.set_xlim(*np.array([-1.0, 1.0]) * max(SMALLEST_SPEED_RAD_S, 1.05 * reach))
    parts.label_panel(axes, series.title, across=None if parts.is_narrow(axes) else 3)
    parts.write_message(axes, series.not_determined, characters=24 if sheet else 40)
    return formula


def filtered_curve(series: JointSeries) -> tuple[Float, Float]:
    """Return velocity [rad/s] and torque [N m] after the filter, shape (n,) each."""
    return parts.smooth(series.t, series.dq), parts.smooth(series.t, series.driving_torque)


def filtered_loop(series: JointSeries, curve: tuple[Float, Float]) -> Loop:
    """Return the filtered curve, thinned to smooth lines; of a long log every k-th cycle, gaps between them as NaN."""
    step = max(1, int(parts.median_rate_hz(series.t) / (POINTS_PER_PERIOD * parts.CUTOFF_HZ)))
    dq, torque = (signal[::step] for signal in curve)
    every = max(-(-len(dq) // parts.MOST_POINTS), -(-len(series.cycles.joint) // MOST_LOOPS))
    if every <= 1:
        return Loop(dq, torque, 1)
    every |= 1  # odd, so that strokes there and strokes back are both shown
    shown = np.zeros(len(series.t), dtype=np.bool_)
    for start, stop in zip(series.cycles.start[::every], series.cycles.stop[::every], strict=True):
        shown[start:stop] = True
    return Loop(np.where(shown[::step], dq, np.nan), torque, every)


def fitted_torque(friction: JointFriction, dq: Float) -> Float | None:
    """Return the friction torque [N m] of the whole-log estimate at velocities of shape (n,); None without estimate."""
    coulomb = 0.0 if friction.model == "viscous" else friction.coulomb.value
    viscous = 0.0 if friction.model == "coulomb" else friction.viscous.value
    torque = coulomb * np.sign(dq) + viscous * dq
    return None if np.isnan(coulomb + viscous) else torque


def centre_nm(series: JointSeries) -> float:
    """Return the constant around which the fitted curve is drawn. [N m]

    It is the median of what friction leaves while the joint moves: an offset of the torque sensor or an error of
    gravity shifts the measured curve; friction itself has no constant.
    """
    moving = np.abs(series.dq) > NEAR_REST * np.abs(series.dq).max()
    friction = fitted_torque(series.friction, series.dq[moving])
    return 0.0 if friction is None else float(np.median(series.driving_torque[moving] - friction))


def fitted_label(friction: JointFriction, centre: float) -> str:
    """Return the fitted curve's formula with its numbers, drawn around a constant [N m], for the legend."""
    terms = []
    if friction.model != "viscous":
        terms.append(rf"{friction.coulomb.value:.3f}\,\mathrm{{sgn}}\,\dot{{q}}")
    if friction.model != "coulomb":
        terms.append(rf"{friction.viscous.value:+.3f}\,\dot{{q}}")
    if abs(centre) >= SMALLEST_CENTRE_NM:
        terms.append(f"{centre:+.3f}")
    return f"fitted: ${''.join(terms).removeprefix('+')}$"


def typical_strokes(series: JointSeries) -> slice:
    """Return the samples of two neighbouring cycles of middling peak speed, if possible there and back."""
    kept = series.cycles.rows(series.cycles.reason == 0)
    if len(kept.joint) < 2:  # noqa: PLR2004
        return slice(0, 0)
    direction = np.array([np.sign(series.dq[a:b].sum()) for a, b in zip(kept.start, kept.stop, strict=True)])
    distance = np.abs(kept.peak_speed_rad_s - np.median(kept.peak_speed_rad_s))
    apart = distance[1:] + distance[:-1] + 2 * distance.max() * (direction[1:] == direction[:-1])
    row = int(np.argmin(apart))
    return slice(int(kept.start[row]), int(kept.stop[row + 1]) + 1)


def _add_arrows(axes: "Axes", series: JointSeries, curve: tuple[Float, Float]) -> None:
    """Add arrows in the direction of time, evenly spread along a typical pair of strokes, away from rest."""
    strokes = typical_strokes(series)
    if strokes.stop - strokes.start < 2 * ARROWS:
        return
    dq, torque = (signal[strokes] for signal in curve)
    # A white rim keeps the strokes apart from the curve around them.
    axes.plot(dq, torque, color="white", lw=2.2, rasterized=True)
    axes.plot(dq, torque, color=FILTERED, lw=0.9, rasterized=True)
    steps = np.hypot(np.diff(dq) / np.ptp(dq), np.diff(torque) / (np.ptp(torque) or 1.0))  # a torque may be constant
    steps[np.abs(dq[1:]) < NEAR_REST * np.abs(dq).max()] = 0.0
    length = np.concatenate([[0.0], np.cumsum(steps)])
    for share in (np.arange(ARROWS) + 0.5) / ARROWS:
        tail, head = np.searchsorted(length, share * length[-1] + np.array([0.0, ARROW_LENGTH]))
        head = min(int(head), len(dq) - 1)
        ends = [(float(dq[k]), float(torque[k])) for k in (tail, head)]
        parts.draw_arrow(axes, ends[0], ends[1], FILTERED, 0.5)
