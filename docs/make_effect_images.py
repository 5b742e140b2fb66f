"""The pictures of the effects, drawn from simulated logs without noise: ``python docs/make_effect_images.py``.

Each shows an effect on the axis where it shows itself: thin and grey without it, bold and coloured with it.
"""  # noqa: INP001

# ruff: noqa: D103, PLR2004 - the functions that draw are named as the effects they draw; numbers choose what is seen

import io
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from friction_audit.joint_log import Float, JointLog
from friction_audit.reporting.figures.style import figure_style
from friction_audit.simulation import (
    EFFECTS,
    IDEAL_SENSORS,
    ArmSettings,
    BenchSettings,
    HandGuidedPanda,
    Hidden,
    Operator,
    Simulation,
    simulate,
)
from friction_audit.simulation.periodic import Commanded, MotionSettings, Sinusoid
from friction_audit.simulation.strokes import SlowSweep, StopAndGo

FOLDER = Path(__file__).parent / "images" / "effects"
WIDTH_IN, HEIGHT_IN, DPI = 3.4, 2.1, 220
COLOURS = 64
GREY = "#8a8a8a"
FORM_COLOURS = ("#004c80", "#d55e00", "#009e73", "#cc79a7")
FORM_DASHES = ("-", (0, (4, 1.2)), (0, (1.2, 1.0)), (0, (5, 1, 1, 1)))
WIDE = 33
LAST_S, EARLY_S = 2.5, 3.0
CONTACT_S = (9.6, 10.0)
SEED = 3

# A firm grip follows the intended motion at any friction.
FIRM = {"stiffness_nm_per_rad": 400.0, "damping_nms_per_rad": 8.0}
LIGHT = {"stiffness_nm_per_rad": 60.0, "damping_nms_per_rad": 2.0}
USUAL = {"stiffness_nm_per_rad": 60.0, "damping_nms_per_rad": 9.0}


def _slow(reach_rad: float) -> Commanded:
    """Return one sine of 10 s about the start."""
    return Commanded(sines=1, lowest_hz=0.1, range_rad=(-reach_rad, reach_rad), peak_speed_rad_s=10.0)


SLOW, SLOW_S = _slow(1.0), 16.0

INERTIA_KG_M2 = 0.3
VISCOUS_NMS_PER_RAD = 0.07

VELOCITY = "velocity [rad/s]"
POSITION = "position [rad]"
TIME = "time [s]"
LESS_INERTIA = r"torque less inertia $F_m - B\ddot{q}$ [N m]"


@dataclass(frozen=True, eq=False, kw_only=True)
class Run:
    """One joint without noise: what the log holds, and what only the truth knows; shape (n,) each."""

    t: Float
    q: Float
    dq: Float
    ddq: Float
    read: Float
    friction: Float
    simulation: Simulation

    @property
    def less_inertia(self) -> Float:
        """The interaction torque as read, less the inertia that the model knows. [N m]"""
        return self.read - INERTIA_KG_M2 * self.ddq


def group(name: str, **values: Any) -> Hidden:  # noqa: ANN401 - numbers, and the word of a form
    """Return one hidden effect, all else as usual."""
    effect = next(one for one in EFFECTS if one.name == name)
    return Hidden(**{name: effect.make({key: str(value) for key, value in values.items()})})


def forms(name: str, **values: Any) -> list[tuple[str, Hidden]]:  # noqa: ANN401
    """Return the effect in all its forms, by their names."""
    words = next(one for one in EFFECTS if one.name == name).forms
    return [(word.replace("_", " "), group(name, form=word, **values)) for word in words] or [
        ("with", group(name, **values))
    ]


def less_gravity(log: JointLog) -> Float:
    """Return what the sensors of an arm read beyond gravity, shape (n, j). [N m]"""
    assert log.tau_J is not None
    assert log.gravity is not None
    return log.tau_J - log.gravity


def move(hidden: Hidden, motion: MotionSettings, duration_s: float, *, grip: Any = FIRM, **more: Any) -> Run:  # noqa: ANN401
    """Simulate one joint without noise."""
    operator = Operator(**grip, motion=motion)
    settings = BenchSettings(
        hidden=(hidden,), sensors=(IDEAL_SENSORS,), operator=operator, duration_s=duration_s, **more
    )
    simulation = simulate(settings, SEED)
    log, truth = simulation.log, simulation.truth.motion
    torque = log.tau_interaction if log.tau_interaction is not None else -less_gravity(log)
    return Run(
        t=log.t,
        q=log.q[:, 0],
        dq=log.dq[:, 0],
        ddq=truth.inner_ddq[:, 0],
        read=torque[:, 0],
        friction=truth.friction_nm[:, 0],
        simulation=simulation,
    )


def plain(axes: Axes, x: Float, y: Float, label: str | None = "without") -> None:
    """Draw what there is without the effect."""
    axes.plot(x, y, color=GREY, linewidth=0.7, label=label, zorder=1)


def bold(axes: Axes, x: Float, y: Float, k: int = 0, label: str | None = None) -> None:
    """Draw what there is with the effect in its form k."""
    axes.plot(x, y, color=FORM_COLOURS[k], linestyle=FORM_DASHES[k], linewidth=1.4, label=label, zorder=2 + k)


def draw(axes: Axes, k: int, x: Float, y: Float, label: str | None = None) -> None:
    """Draw what there is without the effect, k = 0, or with it in its form k - 1."""
    if k == 0:
        plain(axes, x, y, label)
    else:
        bold(axes, x, y, k - 1, label)


def curves(
    axes: Axes,
    name: str,
    motion: MotionSettings,
    duration_s: float,
    pick: Callable[[Run], tuple[Float, Float]],
    **more: Any,  # noqa: ANN401
) -> None:
    """Draw a joint without the effect and with every form of it."""
    for k, (word, hidden) in enumerate([("without", Hidden()), *forms(name)]):
        draw(axes, k, *pick(move(hidden, motion, duration_s, **more)), word)


def named(axes: Axes, x: str, y: str, *, legend: Any = "best") -> None:  # noqa: ANN401 - a word of matplotlib, or None
    """Name the axes; a legend ``above`` is outside of them."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if legend == "above":
        lines, words = axes.get_legend_handles_labels()
        columns = len(words) if len("".join(words)) < WIDE else 3
        figure = axes.get_figure(root=True)
        assert figure is not None
        figure.legend(lines, words, loc="outside upper center", ncols=columns)
    elif legend:
        axes.legend(loc=legend)


def whole_period(run: Run, x: Float, y: Float, period_s: float = 10.0) -> tuple[Float, Float]:
    """Return one period that is over some time before the end."""
    last = run.t[-1] - LAST_S
    chosen = (run.t > last - period_s) & (run.t <= last)
    return x[chosen], y[chosen]


def turning(run: Run) -> int:
    """Return the sample at which the joint first turns after it got under way."""
    return int(np.argmax((run.t > EARLY_S) & (run.dq * np.sign(run.dq[int(EARLY_S * 1000)]) <= 0.0)))


def sheet(rows: int = 1, columns: int = 1, **more: Any) -> tuple[Figure, Any]:  # noqa: ANN401
    """Return an empty figure as wide as a column."""
    figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN), layout="constrained")
    return figure, figure.subplots(rows, columns, **more)


def over_velocity(name: str, motion: Sinusoid | Commanded, *, limit: float) -> Figure:
    """Draw the torque less inertia against the velocity."""
    figure, axes = sheet()
    period_s = motion.period_s if isinstance(motion, Sinusoid) else 1.0 / motion.lowest_hz
    duration_s = 2.0 * LAST_S + 2.0 * period_s
    curves(axes, name, motion, duration_s, lambda run: whole_period(run, run.dq, run.less_inertia, period_s))
    axes.set_xlim(-limit, limit)
    named(axes, VELOCITY, LESS_INERTIA, legend="upper left")
    return figure


def over_position(name: str, motion: MotionSettings) -> Figure:
    """Draw the torque less inertia against the position."""
    figure, axes = sheet()
    curves(axes, name, motion, SLOW_S, lambda run: whole_period(run, run.q, run.less_inertia))
    named(axes, POSITION, LESS_INERTIA, legend="above")
    return figure


def breakaways(run: Run) -> tuple[Float, Float]:
    """Return how long each rest took [s] and what the sensor read at its end [N m]."""
    still = np.concatenate([[0], (run.dq == 0.0).astype(int), [0]])
    begin, end = np.flatnonzero(np.diff(still) == 1), np.flatnonzero(np.diff(still) == -1) - 1
    inside = (begin > 0) & (end < len(run.t) - 1)
    # At the tick at which it breaks away, the joint slides already, its velocity still zero.
    peak = np.maximum(np.abs(run.read[end]), np.abs(run.read[end - 1]))
    return (run.t[end] - run.t[begin])[inside], peak[inside]


def stiction() -> Figure:
    figure, (left, right) = sheet(1, 2, width_ratios=(1, 1.25))
    motion = SlowSweep(speeds_rad_s=(0.05, 0.05), steps=1, range_rad=(-0.08, 0.08), dwell_s=1.0, ease_s=1.0)
    for k, hidden in enumerate((Hidden(), group("stiction"))):
        run = move(hidden, motion, 12.0, grip=USUAL)
        draw(left, k, run.t, run.read)
    left.set_xlim(4.3, 5.3)
    left.set_ylim(0.0, 0.55)
    named(left, TIME, "interaction torque [N m]", legend=None)
    pauses = StopAndGo(pause_s=(0.05, 6.0), stroke_s=(0.9, 1.0), speed_rad_s=0.3, range_rad=(-0.6, 0.6), reversing=1.0)
    right.plot(*breakaways(move(Hidden(), pauses, 120.0, grip=USUAL)), ".", color=GREY, markersize=2, label="without")
    for k, (word, hidden) in enumerate(forms("stiction")):
        points = breakaways(move(hidden, pauses, 120.0, grip=USUAL))
        right.plot(*points, "osv"[k], color=FORM_COLOURS[k], markersize=2.5, label=word)
    right.set_ylim(0.25, 0.75)
    named(right, "rest [s]", "torque at break-away [N m]", legend="upper left")
    return figure


def presliding() -> Figure:
    figure, axes = sheet()

    def since_reversal(run: Run) -> tuple[Float, Float]:
        turn = turning(run)
        chosen, direction = slice(turn - 2, turn + 900), -np.sign(run.dq[turn - 200])
        return 1e3 * direction * (run.q[chosen] - run.q[turn]), direction * run.friction[chosen]

    curves(axes, "presliding", SLOW, SLOW_S, since_reversal)
    axes.set_xlim(-1.0, 30.0)
    named(axes, "displacement since the reversal [mrad]", "friction in the new direction [N m]", legend="lower right")
    return figure


def frictional_lag() -> Figure:
    figure, axes = sheet()
    weak = group("stribeck").stribeck
    motion = Sinusoid(amplitude_rad=0.12, period_s=1.5)
    runs = [("Stribeck without lag", Hidden(stribeck=weak))]
    runs += [(word, Hidden(stribeck=weak, frictional_lag=one.frictional_lag)) for word, one in forms("frictional_lag")]
    for k, (word, hidden) in enumerate(runs):
        run = move(hidden, motion, 4.5)
        chosen = (run.t > 1.5) & (run.t < 3.0)
        draw(axes, k, run.dq[chosen], run.friction[chosen], word)
    named(axes, VELOCITY, "friction [N m]", legend="upper left")
    return figure


def load_dependent_friction() -> Figure:
    figure, axes = sheet()

    def fan(run: Run) -> tuple[Float, Float]:
        port = run.simulation.truth.motion.port_nm[:, 0]
        moving = np.abs(run.dq) > 0.02
        return np.where(moving, port, np.nan), run.friction - VISCOUS_NMS_PER_RAD * run.dq

    curves(axes, "load_dependent_friction", _slow(1.5), SLOW_S, fan, gravity_nm=10.0, logs_sensor=True)
    named(axes, "transmitted torque [N m]", "friction less viscous part [N m]", legend="above")
    return figure


def torque_ripple() -> Figure:
    figure, axes = sheet()
    curves(axes, "torque_ripple", SLOW, SLOW_S, lambda run: whole_period(run, run.q, run.less_inertia))
    axes.set_xlim(0.30, 0.40)
    named(axes, POSITION, LESS_INERTIA, legend="center right")
    return figure


def gravity_error() -> Figure:
    figure, axes = sheet()
    plain(axes, *_place(move(Hidden(), _slow(2.0), SLOW_S)))
    for k, (phase, word) in enumerate(((0.0, "phase 0"), (np.pi / 2, "phase a quarter turn"))):
        bold(axes, *_place(move(group("gravity_error", phase_rad=phase), _slow(2.0), SLOW_S)), k, word)
    named(axes, POSITION, LESS_INERTIA, legend="above")
    return figure


def _place(run: Run) -> tuple[Float, Float]:
    return whole_period(run, run.q, run.less_inertia)


def joint_limit_stop() -> Figure:
    figure = over_position("joint_limit_stop", SLOW)
    (axes,) = figure.axes
    axes.set_xlim(0.45, 1.0)
    axes.set_ylim(-1.0, 8.0)
    return figure


def torque_drift() -> Figure:
    figure, axes = sheet()
    motion = Sinusoid(amplitude_rad=0.5, period_s=4.0)
    run = move(Hidden(), motion, 60.0)
    plain(axes, run.t, run.less_inertia)
    for k, (word, hidden) in enumerate(forms("torque_drift")):
        drifting = move(hidden, motion, 60.0)
        bold(axes, drifting.t, drifting.read - run.read, k, f"error, {word.replace('_', ' ')}")
    named(axes, TIME, LESS_INERTIA, legend=None)
    figure.legend(loc="outside upper center", ncols=2)
    return figure


def time_delay() -> Figure:
    figure, axes = sheet()
    motion = Sinusoid(amplitude_rad=0.25, period_s=0.8)

    def loop(run: Run) -> tuple[Float, Float]:
        chosen = (run.t > 1.6) & (run.t < 2.4)
        known = INERTIA_KG_M2 * np.gradient(run.dq, run.t)  # of the velocity as it is logged
        return run.dq[chosen], (run.read - known)[chosen]

    curves(axes, "time_delay", motion, 3.2, loop)
    named(axes, VELOCITY, LESS_INERTIA, legend="upper left")
    return figure


def torque_crosstalk() -> Figure:
    figure, (above, below) = sheet(2, 1, sharex=True)
    logs = []
    for entry in (Hidden(), group("torque_crosstalk", form="previous")):
        hidden = (Hidden(), entry, *(Hidden(),) * 5)
        settings = HandGuidedPanda(hidden=hidden, sensors=(IDEAL_SENSORS,) * 7, duration_s=8.0)
        logs.append(simulate(settings, SEED).log)
    draw(above, 0, logs[0].t, less_gravity(logs[0])[:, 0])
    for k, log in enumerate(logs):
        draw(below, k, log.t, less_gravity(log)[:, 1], ("without", "with")[k])
    named(above, "", "joint 1, moved:\ntorque less\ngravity [N m]", legend=None)
    named(below, TIME, "joint 2, at rest:\ntorque less\ngravity [N m]", legend="upper right")
    return figure


def joint_elasticity() -> Figure:
    figure, axes = sheet()
    motion = StopAndGo(pause_s=(0.5, 0.5), stroke_s=(0.9, 0.9), range_rad=(-0.8, 0.8))
    curves(axes, "joint_elasticity", motion, 5.0, lambda run: (run.t, run.read), grip=LIGHT)
    axes.set_xlim(1.1, 2.4)
    named(axes, TIME, "interaction torque [N m]", legend="above")
    return figure


def backlash() -> Figure:
    figure, (above, below) = sheet(2, 1, sharex=True)
    for k, hidden in enumerate((Hidden(), group("backlash"))):
        run = move(hidden, SLOW, SLOW_S)
        truth = run.simulation.truth.motion
        draw(above, k, run.t, run.read)
        draw(below, k, run.t, 1e3 * (truth.inner_q - truth.q)[:, 0])
        turn = run.t[turning(run)]
    below.set_xlim(turn - 0.2, turn + 0.8)
    named(above, "", "interaction\ntorque [N m]", legend=None)
    named(below, TIME, "motor less\nlink [mrad]", legend=None)
    return figure


def inertia_error() -> Figure:
    figure, axes = sheet()
    motion = Sinusoid(amplitude_rad=0.5, period_s=2.5)

    def moving(run: Run) -> tuple[Float, Float]:
        return whole_period(run, run.ddq, np.where(run.dq == 0.0, np.nan, run.less_inertia), motion.period_s)

    curves(axes, "inertia_error", motion, 10.0, moving)
    named(axes, "acceleration [rad/s$^2$]", LESS_INERTIA, legend="upper left")
    return figure


def inertial_coupling() -> Figure:
    figure, axes = sheet()
    for k, entry in enumerate((Hidden(), group("inertial_coupling"))):
        hidden = (*(Hidden(),) * 4, entry, Hidden(), Hidden())
        settings = ArmSettings(hidden=hidden, sensors=(IDEAL_SENSORS,) * 7, duration_s=12.0, driven=False)
        truth = simulate(settings, SEED).truth.motion
        inertia = settings.joints[4].inertia_kg_m2
        rest = (truth.interaction_nm - truth.friction_nm - inertia * truth.inner_ddq)[:, 4]
        draw(axes, k, truth.inner_ddq[:, 3], rest, ("without", "with")[k])
    named(axes, "acceleration of joint 4 [rad/s$^2$]", "joint 5: torque less\nfriction and inertia [N m]")
    return figure


def stroke_levels(run: Run) -> tuple[Float, Float]:
    """Return time [s] and friction [N m] of the fastest moment of every stroke."""
    speed = np.abs(run.dq)
    top = np.flatnonzero((speed[1:-1] >= speed[:-2]) & (speed[1:-1] > speed[2:]) & (speed[1:-1] > 0.3)) + 1
    return run.t[top], np.abs(run.less_inertia[top])


def over_time(name: str, duration_s: float) -> Figure:
    """Draw the friction of every stroke over time."""
    figure, axes = sheet()
    motion = Sinusoid(amplitude_rad=0.5, period_s=2.0)
    plain(axes, *stroke_levels(move(Hidden(), motion, duration_s)))
    for k, (word, hidden) in enumerate(forms(name)):
        t, level = stroke_levels(move(hidden, motion, duration_s))
        axes.plot(t, level, "osv"[k], color=FORM_COLOURS[k], markersize=2.0, label=word)
    axes.set_ylim(bottom=0.0)
    named(axes, TIME, "friction at the fastest\nmoment of each stroke [N m]", legend="lower right")
    return figure


def contact_event() -> Figure:
    figure, (left, right) = sheet(1, 2, width_ratios=(1.3, 1))
    motion = Sinusoid(amplitude_rad=0.5, period_s=4.0)
    runs = [("without", Hidden()), *forms("contact_event", per_minute=20)]
    for k, (word, hidden) in enumerate(runs):
        run = move(hidden, motion, 12.0)
        for axes in (left, right)[k > 1 :]:
            draw(axes, k, run.t, run.less_inertia, word)
    named(left, TIME, LESS_INERTIA, legend=None)
    right.set_xlim(*CONTACT_S)
    named(right, TIME, "", legend="above")
    return figure


FAST = Sinusoid(amplitude_rad=1.0, period_s=3.5)
STEADY = Sinusoid(amplitude_rad=0.5, period_s=5.0)
PICTURES: dict[str, Callable[[], Figure]] = {
    "stribeck": partial(over_velocity, "stribeck", STEADY, limit=0.65),
    "nonlinear_viscous": partial(over_velocity, "nonlinear_viscous", FAST, limit=1.9),
    "asymmetric_coulomb": partial(over_velocity, "asymmetric_coulomb", SLOW, limit=0.65),
    "asymmetric_viscous": partial(over_velocity, "asymmetric_viscous", FAST, limit=1.9),
    "torque_bias": partial(over_velocity, "torque_bias", SLOW, limit=0.65),
    "unlogged_compensation": partial(over_velocity, "unlogged_compensation", STEADY, limit=0.65),
    "position_dependent_friction": partial(over_position, "position_dependent_friction", _slow(1.5)),
    "cable_spring": partial(over_position, "cable_spring", SLOW),
    "warm_up": partial(over_time, "warm_up", 240.0),
    "friction_step": partial(over_time, "friction_step", 40.0),
    **{
        picture.__name__: picture
        for picture in (
            *(stiction, presliding, frictional_lag, load_dependent_friction, torque_ripple, gravity_error),
            *(joint_limit_stop, torque_drift, time_delay, torque_crosstalk, joint_elasticity, backlash),
            *(inertia_error, inertial_coupling, contact_event),
        )
    },
}


def save(figure: Figure, path: Path) -> None:
    """Write a figure in few colours, to keep the file small."""
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=DPI, metadata={"Software": None})
    with Image.open(drawn) as image:
        image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in sys.argv[1:] or PICTURES:
        with figure_style(mathematics=True):
            save(PICTURES[name](), FOLDER / f"{name}.png")
