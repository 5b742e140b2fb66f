"""Rows of ``run`` -> the tables in ``benchmarks/effects.md``."""

import json
from collections.abc import Sequence

import numpy as np

from benchmarks.answers import CLEAR, Row, exact, held, misnamed, share, table, unexplained, wrong
from benchmarks.hidden_effects.outside import OUTSIDE
from friction_audit.effects.registry import effects


def hidden_here(row: Row) -> bool:
    """Whether the effect is in this joint of an arm, and not in another one."""
    return row.get("hidden_here") != "False"


def by_effect(rows: Sequence[Row]) -> str:
    """One line per effect of the catalogue, on one joint, then on arms; all pairs together at the end."""
    head = (
        "hidden", "logs", "in the answer [%]", "the only name [%]", "a wrong name [%]", "only wrong names [%]",
        "in the answer at 0.2 [%]",
    )  # fmt: skip
    lines = []
    for name in (candidate.name for candidate in effects()):
        own = [row for row in rows if row["truth"] == name]
        lines += [_effect_line(label, part) for label, part in _by_place(name, own) if part]
    pairs = [row for row in rows if "+" in row["truth"]]
    lines += [_effect_line("two of them", pairs)] if pairs else []
    return table(head, lines)


def _by_place(label: str, rows: Sequence[Row]) -> list[tuple[str, list[Row]]]:
    """Rows of one joint, and those of arms."""
    arm = [row for row in rows if row["scenario"].startswith("panda")]
    return [(label, [row for row in rows if row not in arm]), (f"{label}, arm", arm)]


def _effect_line(label: str, rows: Sequence[Row]) -> tuple[str, ...]:
    clear = [row for row in rows if float(row["partial"]) >= CLEAR]
    small = [row for row in rows if float(row["partial"]) < CLEAR]
    shares = (map(held, clear), map(exact, clear), map(wrong, clear), map(misnamed, clear), map(held, small))
    return (label, str(len(rows)), *(share(flags) for flags in shares))


def by_strength(rows: Sequence[Row]) -> str:
    """One line per strength, all effects together, and one for all that have to be found."""
    head = (
        "one effect, strength", "logs", "in the answer [%]", "the only name [%]", "a wrong name [%]",
        "only wrong names [%]", "`adequate` [%]",
    )  # fmt: skip
    single = [row for row in rows if row["truth"] in {candidate.name for candidate in effects()}]
    sizes = sorted({float(row["partial"]) for row in single})
    parts = [(f"{size:g}", [row for row in single if float(row["partial"]) == size]) for size in sizes]
    parts.append((f"from {CLEAR:g}", [row for row in single if float(row["partial"]) >= CLEAR]))
    return table(head, [_strength_line(label, part) for label, part in parts])


def _strength_line(label: str, rows: Sequence[Row]) -> tuple[str, ...]:
    shares = (map(judge, rows) for judge in (held, exact, wrong, misnamed))
    return (label, str(len(rows)), *map(share, shares), share(row["verdict"] == "adequate" for row in rows))


def numbers(rows: Sequence[Row]) -> str:
    """How near the numbers of a named effect are to those that were hidden, where both sides mean the same."""
    found: dict[tuple[str, str], list[dict[str, float | bool | None]]] = {}
    for row in rows:
        for one in json.loads(row["numbers"] or "[]"):
            found.setdefault((one["effect"], one["parameter"]), []).append(one)
    lines = []
    for (effect, parameter), ones in sorted(found.items()):
        known = [one for one in ones if one["truth"] and one.get("identifiable", True)]
        off = [abs(float(one["estimate"] or 0) / float(one["truth"] or 0) - 1) for one in known]
        held_by = [bool(one["holds"]) for one in known if one["holds"] is not None]
        half = [float(one["half_width"] or 0) / float(one["truth"] or 0) for one in known if one.get("half_width")]
        shares = [f"{100 * float(np.median(one)):.1f}" if one else "-" for one in (off, half)]
        lines.append((effect, parameter, str(len(off)), *shares, share(held_by)))
    head = (
        "hidden",
        "number",
        "logs",
        "off, median [%]",
        "half of the interval, median [%]",
        "the interval holds it [%]",
    )
    return table(head, lines)


def without_effect(rows: Sequence[Row]) -> str:
    """Clean logs by noise colour, and torques that no catalogue holds."""
    head = ("log", "joints", "a name is given [%]", "verdict `unexplained` [%]")
    lines = []
    clean = [row for row in rows if row["truth"] == "none"]
    for noise in sorted({row["noise"] for row in clean}):
        places = _by_place(f"nothing hidden, noise {noise}", [row for row in clean if row["noise"] == noise])
        lines += [_line(label, own) for label, own in places if own]
    lines += [_line("nothing hidden, all", clean)] if clean else []
    elsewhere = [row for row in rows if not hidden_here(row)]
    lines += [_line("nothing hidden, an effect in another joint of the arm", elsewhere)] if elsewhere else []
    for kind, _ in OUTSIDE:
        own = [row for row in rows if row["truth"] == kind and float(row["partial"]) >= CLEAR]
        if own:
            lines.append(_line(f"outside the catalogue: {kind.replace('_', ' ')}", own))
    return table(head, lines)


def _line(label: str, rows: Sequence[Row]) -> tuple[str, str, str, str]:
    named = [row["verdict"] in {"named", "ambiguous"} for row in rows]
    return label, str(len(rows)), share(named), share(map(unexplained, rows))


def gaps(rows: Sequence[Row]) -> str:
    """How far the gap closes where the right effects were named, by strength."""
    head = (
        "partial strength", "logs", "gap closed, median [%]", "left over the floor, median", "95 % of logs below",
        "error of the simulated motion, after over before, median",
    )  # fmt: skip
    good = [row for row in rows if row["truth"] != "none" and held(row) and row["over_floor"]]
    sizes = sorted({float(row["partial"]) for row in good})
    return table(head, [_gap_line(size, [row for row in good if float(row["partial"]) == size]) for size in sizes])


def _gap_line(size: float, rows: Sequence[Row]) -> tuple[str, ...]:
    closed = [100.0 * float(row["shrink"]) for row in rows if row["shrink"] not in {"", "nan"}]
    left = [float(row["over_floor"]) for row in rows]
    motion = [float(row["motion_after"]) / float(row["motion_before"]) for row in rows if row["motion_before"]]
    middle, over, worst = (
        _quantile(closed, 0.5, "{:.0f}"),
        _quantile(left, 0.5, "{:.3f}"),
        _quantile(left, 0.95, "{:.3f}"),
    )
    return f"{size:g}", str(len(rows)), middle, over, worst, _quantile(motion, 0.5, "{:.2f}")


def _quantile(values: Sequence[float], q: float, form: str) -> str:
    return form.format(float(np.quantile(values, q))) if values else "-"


def everything(rows: Sequence[Row]) -> str:
    """All tables."""
    here = [row for row in rows if hidden_here(row)]
    return "\n\n".join((by_strength(here), by_effect(here), without_effect(rows), gaps(here), numbers(here)))
