"""The picture of the README and those of three pages: ``python docs/make_images.py [FOLDER]``.

Logs are simulated, but for the sample log, so that their friction is known. With FOLDER also small copies of what the
program draws in the runs that print the numbers on the pages:

    friction-audit reproduce -o FOLDER/paper
    friction-audit compare -o FOLDER/compare
"""  # noqa: INP001

import contextlib
import io
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from friction_audit.api import diagnose_log
from friction_audit.cli import main
from friction_audit.diagnosis.result import Profile
from friction_audit.io.readers import read_log
from friction_audit.pipeline import AuditSettings, estimate_log
from friction_audit.reporting.figures import figures_of
from friction_audit.reporting.figures.estimate import filtered_loop, series_of
from friction_audit.reporting.figures.profiles import mean_along
from friction_audit.reporting.figures.style import FILTERED, FITTED, MUTED, RAW, figure_style
from friction_audit.reporting.words import format_coefficient
from friction_audit.simulation.hide import hide
from friction_audit.simulation.scenarios import SCENARIOS, simulate

ROOT = Path(__file__).parents[1]
LOG = ROOT / "sample_logs" / "hand_guided.parquet"
IMAGES = ROOT / "docs" / "images"
SIZE_IN, DPI = (8.3, 2.8), 200
COLOURS = 96
WIDTH = 1050  # pixels of a picture, those of a column at 300 dpi
SESSIONS, BEFORE = 14, 9
"""Days of the second panel, and those before the friction rises."""
RUN = ("--duration", "40", "--rate", "250")


def run(*words: str) -> str:
    """Run the program and return what it prints."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.suppress(SystemExit):
        main([*words, "--quiet"])
    return said.getvalue()


def draw_friction(axes: Axes) -> None:
    """Torque against velocity of the sample log, and the friction that was estimated."""
    estimate = estimate_log(read_log(LOG), AuditSettings(joints=(1,)))
    (joint,) = estimate.friction.joints
    series = series_of(estimate, joint)
    axes.plot(series.dq[::4], series.driving[::4], ".", color=RAW, ms=1.2, mew=0, label="measured")
    dq, torque, _ = filtered_loop(series)
    axes.plot(dq, torque, color=FILTERED, lw=0.4, label="measured, filtered")
    speed = np.array([0.0, 1.02 * float(np.abs(series.dq).max())])
    line = joint.coulomb.value + joint.viscous.value * speed
    axes.plot(np.r_[-speed[::-1], speed], np.r_[-line[::-1], line], color=FITTED, lw=1.8, label="friction")
    axes.set(xlabel="Velocity [rad/s]", ylabel="Torque of the hand [N m]", ylim=(-2.6, 2.0))
    viscous = f"viscous {format_coefficient(joint.viscous)} N m s/rad"
    say(axes, "How much friction is in a joint?", f"Coulomb {format_coefficient(joint.coulomb)} N m\n{viscous}")
    axes.legend(loc="lower right", markerscale=5, fontsize=6.5)


def make_sessions(folder: Path) -> dict[str, Any]:
    """Return what ``batch-report`` says of a rig whose Coulomb friction rises by 15 % one day."""
    for day in range(1, SESSIONS + 1):
        level = "0.30" if day <= BEFORE else "0.345"
        name = str(folder / "rig" / f"2026-03-{day:02}.parquet")
        run("simulate", "joint", *RUN, "--seed", str(day), "--set", f"coulomb_nm={level}", "-o", name)
    document: dict[str, Any] = json.loads(run("batch-report", str(folder / "rig"), "-o", str(folder / "d"), "--json"))
    return document


def draw_drift(axes: Axes, folder: Path) -> None:
    """Coulomb friction of every session with its interval, and the change that was found."""
    (joint,) = make_sessions(folder)["joints"]
    found = joint["coefficients"]["coulomb_nm"]
    level = np.array([one["value"] for one in found["values"]])
    reach = np.abs(np.array([one["ci95"] for one in found["values"]]).T - level)
    axes.errorbar(np.arange(1, SESSIONS + 1), level, reach, fmt="o", color=FILTERED, ms=3, lw=0.8, label="recording")
    (step,) = found["change_points"]
    for days, part in (((0.5, step["session"] - 0.5), "before"), ((step["session"] - 0.5, SESSIONS + 0.5), "after")):
        label = "level, 95 %" if part == "before" else None
        axes.plot(days, [step[part]["value"]] * 2, color=FITTED, lw=1.8, label=label)
        axes.fill_between(days, *step[part]["ci95"], color=FITTED, alpha=0.2, lw=0)
    axes.set(xlabel="Recording", ylabel="Coulomb friction [N m]", xticks=range(2, SESSIONS + 1, 4))
    say(axes, "Is it changing?", wrapped(found["message"]))
    axes.legend(loc="upper left", fontsize=6.5)


def say(axes: Axes, question: str, answer: str) -> None:
    """Write a question above a panel, and below it what the program answered."""
    axes.set_title(answer)
    axes.annotate(
        question,
        (0.0, 1.0),
        (0.0, 26.0),
        xycoords="axes fraction",
        textcoords="offset points",
        fontweight="bold",
        fontsize=9,
    )


def wrapped(sentence: str) -> str:
    """Break a sentence into two lines."""
    at = sentence.find(" between")
    return f"{sentence[:at]}\n{sentence[at + 1 :]}" if at > 0 else sentence


def draw_missing(axes: Axes, folder: Path) -> None:
    """What the declared model leaves at each speed, and the effect that was named."""
    path = str(folder / "run.parquet")
    run("simulate", "joint", "--effect", "stribeck", "--seed", "3", "-o", path)
    found = diagnose_log(read_log(Path(path))).joints[0]
    (effect,) = found.effects
    assert found.traces is not None
    assert found.gap is not None
    draw_bins(axes, effect.curve)
    for forwards in (True, False):
        rows = (found.traces.dq > 0) == forwards
        along, torque = mean_along(found.traces.along[effect.axis][rows], effect.torque[rows])
        axes.plot(along, torque, color=FITTED, lw=1.8, label="effect as named" if forwards else None, zorder=5)
    axes.axhline(0.0, color=MUTED, lw=0.5)
    axes.set(xlabel="Speed [rad/s]", ylabel="Torque that the model misses [N m]", xlim=(0.0, 0.6))
    gap = f"gap {found.gap.before:.3f} -> {found.gap.after:.3f} N m, noise {found.gap.floor:.3f} N m"
    say(axes, "What does its model miss?", f"{effect.name}: {effect.label}\n{gap}")
    axes.legend(loc="upper right", fontsize=6.5)


def draw_bins(axes: Axes, curve: Profile) -> None:
    """Draw the means of the bins of both directions with two standard errors."""
    for mean, error, marker in ((curve.forwards, curve.forwards_se, "^"), (curve.backwards, curve.backwards_se, "v")):
        label = "forwards" if marker == "^" else "backwards"
        axes.errorbar(curve.centre, mean, 2 * error, fmt=marker, color=FILTERED, ms=3.5, lw=0.8, label=label)


def draw_overview(path: Path) -> None:
    """Draw the three questions that the program answers."""
    with figure_style(), tempfile.TemporaryDirectory() as folder:
        figure = Figure(figsize=SIZE_IN, layout="constrained")
        left, middle, right = figure.subplots(1, 3)
        draw_friction(left)
        draw_drift(middle, Path(folder))
        draw_missing(right, Path(folder))
        save(figure, path)


def draw_residual(path: Path) -> None:
    """Draw what ``diagnose -o DIR`` draws of ``simulate joint --effect stribeck --seed 3``."""
    settings = next(scenario.settings for scenario in SCENARIOS if scenario.name == "joint")
    log = simulate(hide(settings, ("stribeck",)), 3).log
    found = diagnose_log(log)
    kind = next(kind for kind in figures_of("diagnosis") if kind.name == "residual")
    figure = kind.draw(found, 1)
    with figure_style():
        save(figure, path)


def save(figure: Figure, path: Path) -> None:
    """Write a figure in few colours, to keep the file small."""
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=DPI, facecolor="white", metadata={"Software": None})
    with Image.open(drawn) as image:
        image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def copy_small(folder: Path) -> None:
    """Copy the pictures of a page no wider than a column, in few colours."""
    paths = sorted(folder.glob("*.png"))
    if not paths:
        raise SystemExit(f"{folder}: found no pictures; draw them first, as the top of this script says")
    (IMAGES / folder.name).mkdir(parents=True, exist_ok=True)
    for path in paths:
        with Image.open(path) as image:
            scale = min(1.0, WIDTH / image.width)
            size = (round(image.width * scale), round(image.height * scale))
            small = image.convert("RGB").resize(size, Image.Resampling.LANCZOS)
        small.quantize(160, dither=Image.Dither.NONE).save(IMAGES / folder.name / path.name, optimize=True)


if __name__ == "__main__":
    draw_overview(IMAGES / "overview.png")
    draw_residual(IMAGES / "diagnose" / "named-residual.png")
    for page in ("paper", "compare") if sys.argv[1:] else ():
        copy_small(Path(sys.argv[1]) / page)
