"""Estimate -> interaction torque over velocity, raw and filtered, with the fitted friction on it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes

from friction_audit.friction.history import JointFriction
from friction_audit.joint_log import Float
from friction_audit.pipeline import Estimate
from friction_audit.reporting.figures import panels as parts
from friction_audit.reporting.figures.over_time import SIGNALS, JointSeries, series_of
from friction_audit.reporting.figures.style import FILTERED, FITTED, RAW

NEAR_REST = 0.2  # share of the peak speed below which the torque of a reversal hides an offset
POINTS_PER_PERIOD = 10  # of the filtered curve, per period of its highest frequency: enough for a smooth line
SMALLEST_CENTRE_NM = 0.0005  # the label's three decimals would round less to nothing
MOST_LOOPS = 60  # cycles of the filtered curve above which it would be a blot
SMALLEST_SPEED_RAD_S = 0.1  # half width of the panel of a joint that stands still


def _draw(panels: Sequence[Axes], estimate: Estimate, friction: JointFriction) -> None:
    (axes,), series = panels, series_of(estimate, friction)
    alone = len(axes.figure.axes) == 1
    thinned = parts.every_nth(len(series.t))
    raw = "raw" if thinned.step == 1 else f"raw, 1 sample in {thinned.step}"
    parts.draw_dots(axes, series.dq[thinned], series.driving[thinned], RAW, raw)
    dq, torque, every = filtered_loop(series)
    filtered = f"filtered, {parts.cutoff_hz(series.t):.3g} Hz{'' if every == 1 else f', 1 cycle in {every}'}"
    axes.plot(dq, torque, color=FILTERED, lw=0.35, rasterized=True, label=filtered)
    if alone:  # on a sheet there is no room for arrows
        parts.draw_arrows(axes, dq, torque)
    reach = float(np.abs(series.dq).max())
    # Two points next to zero on each side make the step of the Coulomb term upright.
    speed = np.array([-reach, -1e-9, 1e-9, reach])
    fitted = fitted_torque(friction, speed)
    if fitted is not None:
        centre = centre_nm(series)
        # The numbers differ from panel to panel, so the sheet's legend cannot show them.
        label = fitted_label(friction, centre) if alone else "fitted friction"
        axes.plot(speed, fitted + centre, color=FITTED, lw=1.3, zorder=4, label=label)
    axes.set_xlim(*np.array([-1.0, 1.0]) * max(SMALLEST_SPEED_RAD_S, 1.05 * reach))
    parts.label_panel(axes, series.title, across=None if alone else 3)
    parts.write_message(axes, series.not_determined, characters=40 if alone else 24)


def filtered_loop(series: JointSeries) -> tuple[Float, Float, int]:
    """Return filtered velocity and torque, thinned to smooth lines, and which cycles they are (1 in so many).

    Of a long log every k-th cycle is kept, gaps between them as NaN.
    """
    step = max(1, int(parts.median_rate_hz(series.t) / (POINTS_PER_PERIOD * parts.CUTOFF_HZ)))
    dq, torque = (parts.smooth(series.t, signal)[::step] for signal in (series.dq, series.driving))
    every = max(-(-len(dq) // parts.MOST_POINTS), -(-len(series.cycles.joint) // MOST_LOOPS))
    if every <= 1:
        return dq, torque, 1
    every |= 1  # odd, so that strokes there and strokes back are both shown
    shown = np.zeros(len(series.t), dtype=np.bool_)
    for start, stop in zip(series.cycles.start[::every], series.cycles.stop[::every], strict=True):
        shown[start:stop] = True
    return np.where(shown[::step], dq, np.nan), torque, every


def fitted_torque(friction: JointFriction, dq: Float) -> Float | None:
    """Return the friction torque [N m] of the whole-log estimate at velocities of shape (n,); None without estimate."""
    coulomb = 0.0 if friction.model == "viscous" else friction.coulomb.value
    viscous = 0.0 if friction.model == "coulomb" else friction.viscous.value
    torque = coulomb * np.sign(dq) + viscous * dq
    return None if friction.reason or np.isnan(coulomb + viscous) else torque


def centre_nm(series: JointSeries) -> float:
    """Return the constant around which the fitted curve is drawn. [N m]

    It is the median of what friction leaves while the joint moves: an offset of the torque sensor or an error of
    gravity shifts the measured curve; friction itself has no constant.
    """
    moving = np.abs(series.dq) > NEAR_REST * np.abs(series.dq).max()
    friction = fitted_torque(series.friction, series.dq[moving])
    return 0.0 if friction is None else float(np.median(series.driving[moving] - friction))


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


def _label(estimate: Estimate) -> str:
    return f"Interaction{'' if estimate.interaction.compensation is None else ' and compensator'} torque [N m]"


VELOCITY_TORQUE = replace(
    SIGNALS, draw=_draw, panels=1, across=4, height_in=(1.75, 2.4), head_in=0.5, x="Velocity [rad/s]", y=_label,
    shared=False,
)  # fmt: skip
