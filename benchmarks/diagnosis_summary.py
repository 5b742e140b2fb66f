"""Rows of ``diagnosis_figures`` -> tables of figures with their goals, and a list of the answers that are wrong."""

import json
from collections.abc import Iterable, Sequence
from itertools import combinations
from pathlib import Path

import numpy as np
from scipy.stats import binom

from benchmarks import resampled, whole_arms
from benchmarks.answers import (
    CLEAR,
    UNANSWERED,
    Row,
    answered,
    exact,
    first,
    held,
    held_or_negligible,
    misnamed,
    named,
    own_name,
    sets_of,
    share,
    table,
    truth_of,
    unexplained,
    wrong,
)
from benchmarks.hidden_effects import limits, separable
from benchmarks.hidden_effects.table import hidden_here
from benchmarks.real_logs.run import NO_INERTIA
from benchmarks.resume import read
from benchmarks.stranger.effects import OUTSIDE, RECORDED
from friction_audit.effects.registry import effects

CATALOGUE = {effect.name for effect in effects()}
EFFECT_KINDS = ("effects", "on_arms", "pairs")
CLEAN = ("none", "arms", "smoothed", "coarse", "stranger_none")
ROW_KINDS = (*CLEAN, "effects", "on_arms", "pairs", "outside", "stranger", "resampled", "whole_arms", "real")
Tables = dict[str, list[Row]]
Figure = tuple[str, str, str, str, str]
"""What is measured, before, goal, measured with its 95 % interval, number."""
DETAILS = frozenset(
    {
        "all of these: `unexplained` [%]",
        "only wrong names [%]",
        "only wrong names there [%]",
        "hidden effect listed as negligible [%]",
        "of those whose log holds twice what chance brings [%]",
        "the same, in the answer or listed as negligible [%]",
        "any wrong name at 0.2 [%]",
        "resampled or filtered, nothing hidden: `unexplained` [%]",
        "residual over the noise floor, median",
        "parameters that the log does not identify [%]",
        "of those whose log holds both [%]",
        "real joints: same names and verdict, pairs of seeds 0, 1, 2 [%]",
        "the largest effect of the answer [%]",
        "in the answer, without those that the plain log has [%]",
    }
)
"""Figures that are on the page of all figures, and not in the documentation."""


def load(folder: Path) -> Tables:
    """All tables of a folder; ``time`` holds lines."""
    tables: Tables = {kind: list(read(folder / f"{kind}.csv")) for kind in (*ROW_KINDS, "limits", "separations")}
    tables["resampled"] = [resampled.judged(row) for row in tables["resampled"]]
    tables["whole_arms"] = [whole_arms.judged(row) for row in tables["whole_arms"]]
    time = folder / "time.md"
    tables["time"] = [{"text": time.read_text()}] if time.exists() else []
    return tables


def at_least(rows: Iterable[Row], least: float = CLEAR) -> list[Row]:
    """Answers to hidden effects of a strength."""
    return [row for row in answered(rows) if hidden_here(row) and float(row["partial"]) >= least]


def small(rows: Iterable[Row]) -> list[Row]:
    """Answers to hidden effects of 0.2."""
    return [row for row in answered(rows) if hidden_here(row) and float(row["partial"]) < CLEAR]


def figure(label: str, before: str, goal: str, flags: Iterable[bool], digits: int = 0) -> Figure:
    """A share."""
    given = list(flags)
    return label, before, goal, share(given, digits), f"{sum(given)} of {len(given)}"


def middle(label: str, before: str, goal: str, values: Sequence[float], form: str = "{:.2f}") -> Figure:
    """A median with the interval of its order statistics."""
    given = sorted(v for v in values if np.isfinite(v))
    if not given:
        return label, before, goal, "-", "0"
    n = len(given)
    low, high = (int(np.clip(binom.ppf(p, n, 0.5), 0, n - 1)) for p in (0.025, 0.975))
    text = " ".join(
        (form.format(float(np.median(given))), f"({form.format(given[low])} to {form.format(given[high])})")
    )
    return label, before, goal, text, str(n)


def clean(tables: Tables) -> list[Figure]:
    """Logs with nothing hidden."""
    own = answered((*tables["none"], *tables["arms"]))
    others = {"sign smoothed over 1 to 10 mrad/s": tables["smoothed"], "second generator": tables["stranger_none"],
              "position or velocity in coarse steps": tables["coarse"]}  # fmt: skip
    found = [
        figure("own simulator, nothing hidden: a name [%]", "0.4", "at most 1, upper bound 2.5", map(named, own), 1)
    ]
    found += [figure(f"{label}, nothing hidden: a name [%]", "33" if rows is not tables["coarse"] else "", "at most 2",
                     map(named, answered(rows)), 1) for label, rows in others.items()]  # fmt: skip
    every = [row for rows in (own, *others.values()) for row in answered(rows)]
    return [*found, figure("all of these: `unexplained` [%]", "", "", map(unexplained, every), 1)]


def one_effect(tables: Tables) -> list[Figure]:
    """Logs with one effect of the catalogue."""
    clear, weak = at_least((*tables["effects"], *tables["on_arms"])), small((*tables["effects"], *tables["on_arms"]))
    apart = {(r["truth"], r["seed"]) for r in tables["separations"] if r["separates"] == "True"}
    visible = limits.visible(tables["limits"], 2.0)
    plain = [row for row in weak if (row["truth"], row["seed"]) in visible]
    second = [row for row in at_least(tables["stranger"]) if row["truth"] in CATALOGUE]
    return [
        figure("one effect from 0.3: in the answer [%]", "96", "97", map(held, clear)),
        figure("only wrong names [%]", "0.4", "0.5", map(misnamed, clear), 1),
        figure("any wrong name [%]", "2", "2", map(wrong, clear), 1),
        figure("hidden effect listed as negligible [%]", "", "",
               (held_or_negligible(r) and not held(r) for r in clear)),
        figure("the only name, where the log separates [%]", "94", "95",
               (exact(r) for r in separable.judged(clear) if (r["truth"], r["seed"]) in apart)),
        figure("one effect of 0.2: in the answer [%]", "74", "80", map(held, weak)),
        figure("of those whose log holds twice what chance brings [%]", "92", "95", map(held, plain)),
        figure("the same, in the answer or listed as negligible [%]", "", "", map(held_or_negligible, plain)),
        figure("any wrong name at 0.2 [%]", "", "", map(wrong, weak), 1),
        figure("second generator, one effect from 0.3: in the answer [%]", "95", "", map(held, second)),
        figure("any wrong name [%]", "2", "", map(wrong, second), 1),
    ]  # fmt: skip


def pairs_and_outside(tables: Tables) -> list[Figure]:
    """Two effects, and torques that no effect of the catalogue makes."""
    pairs, visible = at_least(tables["pairs"]), limits.visible(tables["limits"])
    both = [row for row in pairs if (row["truth"], row["seed"]) in visible]
    outside = at_least(tables["outside"])
    other = [row for row in at_least(tables["stranger"]) if row["truth"] in OUTSIDE]
    return [
        figure("two effects from 0.3: both in the answer [%]", "87", "90", map(held, pairs)),
        figure("of those whose log holds both [%]", "94", "95", map(held, both)),
        figure("any wrong name [%]", "", "", map(wrong, pairs), 1),
        figure("outside the catalogue, from 0.3: `unexplained` [%]", "80", "90", map(unexplained, outside)),
        figure("a name [%]", "5", "3", map(named, outside)),
        figure("second generator, outside: `unexplained` [%]", "", "", map(unexplained, other)),
        figure("a name [%]", "27", "", map(named, other)),
    ]


def resampled_logs(tables: Tables) -> list[Figure]:
    """Logs that were interpolated, held, filtered or differentiated before they are read."""
    rows = [row for row in answered(tables["resampled"]) if row["way"] != "as recorded"]
    nothing, hidden = ([row for row in rows if bool(truth_of(row)) is some] for some in (False, True))
    return [
        figure("resampled or filtered, nothing hidden: a name (not `time_delay` of a filtered torque) [%]", "", "",
               map(named, nothing), 1),
        figure("resampled or filtered, nothing hidden: `unexplained` [%]", "", "", map(unexplained, nothing), 1),
        figure("resampled or filtered, one effect: in the answer [%]", "", "", map(held, hidden)),
        figure("only wrong names there [%]", "", "", map(misnamed, hidden)),
    ]  # fmt: skip


def unmodelled_arms(tables: Tables) -> list[Figure]:
    """Whole arms without a model; what gravity and the other joints do is no name."""
    rows = answered(tables["whole_arms"])
    clean, hiding = ([row for row in rows if bool(truth_of(row)) is some] for some in (False, True))
    return [
        *(figure(f"nothing hidden in the joint, {kind or 'any motion'}: a name [%]", "", "",
                 (named(row) for row in clean if row["log"].endswith(kind))) for kind in (*whole_arms.MOTIONS, "")),
        figure("nothing hidden in the joint: `unexplained` [%]", "", "", map(unexplained, clean)),
        figure("one effect in the joint: in the answer [%]", "", "", map(held, hiding)),
        figure("any wrong name there [%]", "", "", map(wrong, hiding)),
    ]  # fmt: skip


def sizes(tables: Tables) -> list[Figure]:
    """How much is explained, and how near the parameters are."""
    good = [row for row in at_least((*tables["effects"], *tables["on_arms"])) if held(row)]
    every = [one for row in good for one in json.loads(row["numbers"] or "[]")]
    known = [one for one in every if one["identifiable"]]
    off = [abs(float(one["estimate"]) / float(one["truth"]) - 1.0) for one in known if one["truth"]]
    explained = [float(row["shrink"]) for row in good if row["shrink"] not in {"", "nan"}]
    over = [float(row["over_floor"]) for row in good if row["over_floor"]]
    return [
        middle("held-out share explained, median [%]", "met", "95", [100 * v for v in explained], "{:.0f}"),
        middle("residual over the noise floor, median", "met", "1.05", over, "{:.3f}"),
        middle("parameters off, median [%]", "met", "10", [100 * v for v in off], "{:.1f}"),
        figure("95 % intervals hold the truth [%]", "met", "90 to 98",
               (bool(one["holds"]) for one in known if one["holds"] is not None)),
        figure("parameters that the log does not identify [%]", "", "", (not one["identifiable"] for one in every)),
    ]  # fmt: skip


def same(one: Row, other: Row) -> bool:
    """Whether two answers give the same names in the same verdict."""
    return one["verdict"] == other["verdict"] and sorted(map(sorted, sets_of(one))) == sorted(
        map(sorted, sets_of(other))
    )


def in_the_other(one: Row, other: Row) -> list[bool]:
    """Of each name of one answer, whether it is in another answer."""
    there = set().union(*sets_of(other))
    return [part.split("|")[0] in there for part in one["sets"].split(";") if part]


def measured(tables: Tables) -> list[Figure]:
    """Measured logs."""
    rows = {(r["log"], r["part"], r["seed"], r["joint"]): r for r in tables["real"] if r["verdict"] not in UNANSWERED}
    whole = [r for (log, part, seed, _), r in rows.items() if part == "whole" and seed == "0" and log != NO_INERTIA]
    seeds = [[rows[r["log"], "whole", s, r["joint"]] for s in "012" if (r["log"], "whole", s, r["joint"]) in rows]
             for r in whole]  # fmt: skip
    halves = [(rows[log, "first", "0", joint], rows[log, "second", "0", joint]) for log, part, _, joint in rows
              if part == "first" and (log, "second", "0", joint) in rows]  # fmt: skip
    injected = [row for row in rows.values() if row["truth"]]
    testable = [row for row in injected if row["truth"] not in row["untestable"].split(";")]
    plain = {(r["log"], r["joint"]): set().union(*sets_of(r)) for r in whole}
    fresh = [row for row in testable if row["truth"] not in plain.get((row["log"], row["joint"]), set())]
    no_model = [r for (log, *_, joint), r in rows.items() if log == NO_INERTIA and int(joint) <= 4]
    return [
        figure("real joints: same names and verdict, pairs of seeds 0, 1, 2 [%]", "29", "100",
               (same(*pair) for joint in seeds for pair in combinations(joint, 2))),
        figure("names of one half in the answer on the other [%]", "63", "85",
               (flag for a, b in halves for flag in (*in_the_other(a, b), *in_the_other(b, a)))),
        figure("effects injected, that the log can show: in the answer [%]", "58", "90", map(held, testable)),
        figure("under its own name, first of its alternatives [%]", "42", "75", map(own_name, testable)),
        figure("the largest effect of the answer [%]", "", "", map(first, testable)),
        figure("in the answer, without those that the plain log has [%]", "", "", map(held, fresh)),
        figure("all injected: in the answer [%]", "", "", map(held, injected)),
        figure("testable real joints: verdict other than `unexplained` [%]", "9", "67",
               (not unexplained(r) for r in whole)),
        figure("Panda, `--inertia none`: `inertial_coupling` on joints 1 to 4 [%]", "100", "100",
               ("inertial_coupling" in set().union(*sets_of(r)) for r in no_model)),
    ]  # fmt: skip


def joints(tables: Tables) -> str:
    """What is said of each joint of the measured logs, and how many of its names either half gives."""
    rows = {(r["log"], r["part"], r["joint"]): r for r in tables["real"] if r["seed"] == "0" and not r["truth"]}
    lines = []
    for (log, part, joint), row in sorted(rows.items()):
        if part != "whole" or row["verdict"] in UNANSWERED or log == NO_INERTIA:
            continue
        halves = [rows.get((log, half, joint)) for half in ("first", "second")]
        shown = [
            f"{sum(in_the_other(row, h))} of {len(sets_of(row))}"
            if h and h["verdict"] not in UNANSWERED
            else "not testable"
            for h in halves
        ]
        names = "; ".join(" or ".join(one.split("|")) for one in row["sets"].split(";"))
        lines.append((f"{log} {joint}", row["verdict"], names or "-", f"{100 * float(row['remainder']):.0f}", *shown))
    head = ("log, joint", "verdict", "names, the largest first", "without a name [%]",
            "in the first half", "second half")  # fmt: skip
    return table(head, lines)


def mistakes(tables: Tables) -> str:
    """Rows whose answer is wrong, or misses what has to be found, by kind."""
    visible, lines = limits.visible(tables["limits"], 2.0), []
    for kind in ROW_KINDS:
        for row in tables[kind]:
            what = "" if row["verdict"] in {"", "error"} else mistake(kind, row, visible)
            if what:
                place = " ".join(
                    row[name] for name in ("log", "scenario", "motion", "partial", "size", "way") if row.get(name)
                )
                line = (kind, what, row["truth"] or "-", row["seed"], place, row["joint"], row["verdict"])
                lines.append((*line, row["sets"].replace("|", " or "), row["negligible"]))
    head = ("kind", "what", "truth", "seed", "log and strength", "joint", "verdict", "names", "negligible")
    return table(head, sorted(lines))


def mistake(kind: str, row: Row, visible: set[tuple[str, str]]) -> str:
    """What is wrong in an answer; empty where nothing is."""
    shown = kind == "real" and row["verdict"] not in UNANSWERED and row["truth"] not in row["untestable"].split(";")
    needed = shown or kind in ("resampled", "whole_arms") or float(row.get("partial") or 0.0) >= CLEAR
    outside = kind == "outside" or row["truth"] in OUTSIDE
    plain = kind in CLEAN or row["truth"] in ("none", *RECORDED) or not hidden_here(row)
    looked_for = bool(truth_of(row)) and not plain and not outside
    needed_here = looked_for and (needed or (row["truth"], row["seed"]) in visible)
    found = {
        "failed": row["verdict"] == "failed",
        "a name": (plain or (outside and needed)) and named(row),
        "unexplained": plain and unexplained(row),
        "not unexplained": outside and needed and not unexplained(row),
        "only wrong names": looked_for and kind != "real" and misnamed(row),
        "a wrong name too": looked_for and kind != "real" and wrong(row),
        "listed as negligible": needed_here and not held(row) and held_or_negligible(row),
        "not in the answer": needed_here and not held(row),
    }
    return next((what for what, true in found.items() if true), "")


HEAD = ("figure", "before", "goal", "measured (95 % interval)", "number")


def simulated(tables: Tables) -> str:
    """The main figures of logs with a known truth."""
    return _shown(
        [one for make in (clean, one_effect, pairs_and_outside, resampled_logs, sizes) for one in make(tables)]
    )


def real(tables: Tables) -> str:
    """The main figures of measured logs."""
    return _shown(measured(tables))


def _shown(figures: Iterable[Figure]) -> str:
    rows = [(one[0], *one[3:]) for one in figures if one[3] != "-" and one[0] not in DETAILS]
    return table((HEAD[0], *HEAD[3:]), rows)


def separated(tables: Tables) -> str:
    """The only name, effect by effect, where the log separates it and elsewhere."""
    known = {(row["truth"], row["seed"]): row for row in tables["separations"]}
    rows = [
        row
        for row in separable.judged(at_least((*tables["effects"], *tables["on_arms"])))
        if (row["truth"], row["seed"]) in known
    ]
    return separable.by_effect(rows, known)


def page(tables: Tables) -> str:
    """The whole page."""
    parts = {
        "Nothing hidden": clean,
        "One effect": one_effect,
        "Two effects, and outside the catalogue": pairs_and_outside,
        "Resampled or filtered logs": resampled_logs,
        "Size": sizes,
        "Measured logs": measured,
    }
    if tables["whole_arms"]:
        parts["Whole arms"] = unmodelled_arms
    text = ["# Figures of the diagnosis", "",
            "Made by `python -m benchmarks.diagnosis_figures`; *before* is the engine that was replaced."]  # fmt: skip
    for title, make in parts.items():
        text += ["", f"## {title}", "", table(HEAD, make(tables))]
    text += ["", joints(tables), "", "## Time", "", *(one["text"] for one in tables["time"])]
    return "\n".join([*text, "", "## Answers that are wrong or miss an effect", "", mistakes(tables), ""])
