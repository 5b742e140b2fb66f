"""Rows of ``run`` -> how often the only name is right where the log holds the motion that separates the names.

Whether a log separates the hidden effect from competing ones is measured by ``separation``, on logs without noise.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from benchmarks.answers import CLEAR, Row, exact, share, table
from benchmarks.hidden_effects.draw import draw_case
from benchmarks.hidden_effects.run import NOT_REACHED, SIZES, parsed, scaled
from benchmarks.hidden_effects.separation import separate
from benchmarks.hidden_effects.table import hidden_here
from benchmarks.resume import Job

EFFECTS = (
    "stribeck", "presliding", "load_dependent_friction", "torque_ripple", "gravity_error", "torque_drift", "time_delay",
    "warm_up", "friction_step", "joint_elasticity", "backlash", "nonlinear_viscous",
)  # fmt: skip
"""That are to be the only name wherever the log separates them."""
FIELDS = ("truth", "seed", "separates", "close", "competing")
Key = tuple[str, str]


def judged(rows: Iterable[Row]) -> list[Row]:
    """Rows of one of the effects alone, strong enough, with an answer."""
    return [
        row
        for row in rows
        if row["truth"] in EFFECTS
        and row["verdict"] not in {"", "error"}
        and float(row["partial"]) >= CLEAR
        and hidden_here(row)
    ]


def separation_of(row: Row) -> list[dict[str, object]]:
    """One row of the table of separations, of a row of ``run`` or of ``strengths``."""
    truth, seed = row["truth"], int(row["seed"])
    found = separate(scaled(draw_case(seed, (truth,), SIZES[seed % len(SIZES)]), parsed(row["scales"]) or ()))
    competing = sorted(found.competing, key=lambda one: one.noncentrality)
    return [{
        "truth": truth, "seed": seed, "separates": found.separates, "close": "|".join(found.close),
        "competing": "|".join(f"{r.name}:{r.correlation:.3f}:{r.noncentrality:.1f}" for r in competing[:6]),
    }]  # fmt: skip


def job(rows: Iterable[Row]) -> Job:
    """Measure the logs of all rows whose strength is known, each once."""
    wanted = {(row["truth"], row["seed"]): dict(row) for row in rows if row["scales"] != NOT_REACHED}
    return Job(FIELDS, list(wanted.values()), separation_of)


def by_effect(rows: Sequence[Row], known: Mapping[Key, Row]) -> str:
    """One line per effect, and one for all."""
    head = (
        "hidden",
        "logs",
        "the log separates [%]",
        "the only name there [%]",
        "the only name elsewhere [%]",
        "cannot be separated from",
    )
    parts = [(name, [row for row in rows if row["truth"] == name]) for name in EFFECTS]
    return table(head, [_line(name, own, known) for name, own in (*parts, ("all", rows)) if own])


def _line(label: str, rows: Sequence[Row], known: Mapping[Key, Row]) -> tuple[str, ...]:
    found = [known[row["truth"], row["seed"]] for row in rows]
    apart = [one["separates"] == "True" for one in found]
    there = [exact(row) for row, separates in zip(rows, apart, strict=True) if separates]
    elsewhere = [exact(row) for row, separates in zip(rows, apart, strict=True) if not separates]
    names = Counter(name for one in found for name in one["close"].split("|") if name)
    close = ", ".join(f"{name} {times}" for name, times in names.most_common()) if label != "all" else ""
    return label, str(len(rows)), share(apart), share(there), share(elsewhere), close
