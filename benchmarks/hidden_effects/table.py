"""Rows of ``run`` -> the tables in the documentation.

python -m benchmarks.hidden_effects.table FILE.csv... [--output docs/diagnosis.md]
"""

import argparse
import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

from scipy.stats import binomtest

from benchmarks.hidden_effects.outside import OUTSIDE
from friction_audit.discrepancy.candidates import CANDIDATES

Row = dict[str, str]
CLEAR = 0.3
"""Partial strength from which an effect has to be found."""
BEGIN, END = "<!-- hidden effects -->", "<!-- end of hidden effects -->"


def sets_of(row: Row) -> list[set[str]]:
    """Names of each effect in an answer with their alternatives."""
    return [set(one.split("|")) for one in row["sets"].split(";") if one]


def held(row: Row) -> bool:
    """Whether every hidden effect is in the answer."""
    return set(row["truth"].split("+")) <= set().union(*sets_of(row))


def exact(row: Row) -> bool:
    """Whether the hidden effects, all of them and nothing else, are named without alternatives."""
    return row["verdict"] == "named" and sorted(map(sorted, sets_of(row))) == sorted(
        [name] for name in row["truth"].split("+")
    )


def wrong(row: Row) -> bool:
    """Whether the answer is sure, and holds a name with none of the hidden effects among its alternatives."""
    truth = set(row["truth"].split("+"))
    return row["verdict"] in {"named", "ambiguous"} and any(not one & truth for one in sets_of(row))


def share(flags: Iterable[bool]) -> str:
    """A share in percent with its number and its 95 % interval (Wilson)."""
    given = list(flags)
    if not given:
        return "-"
    interval = binomtest(sum(given), len(given)).proportion_ci(method="wilson")
    return f"{100 * sum(given) / len(given):.0f} ({100 * interval.low:.0f} to {100 * interval.high:.0f})"


def table(head: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    rows = [head, ["---"] * len(head), *lines]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def by_effect(rows: Sequence[Row]) -> str:
    """One line per effect of the catalogue, pairs at the end."""
    names = [candidate.name for candidate in CANDIDATES]
    pairs = sorted({row["truth"] for row in rows if "+" in row["truth"]})
    head = ("hidden", "logs", "in the answer [%]", "the only name [%]", "a wrong name [%]", "in the answer at 0.2 [%]")
    lines = []
    for name in [*names, *pairs]:
        own = [row for row in rows if row["truth"] == name]
        clear = [row for row in own if float(row["partial"]) >= CLEAR]
        small = [row for row in own if float(row["partial"]) < CLEAR]
        if own:
            lines.append(
                (
                    name,
                    str(len(own)),
                    share(map(held, clear)),
                    share(map(exact, clear)),
                    share(map(wrong, clear)),
                    share(map(held, small)),
                )
            )
    return table(head, lines)


def without_effect(rows: Sequence[Row]) -> str:
    """Clean logs by noise colour, and torques that no catalogue holds."""
    head = ("log", "joints", "a name is given [%]", "verdict `unexplained` [%]")
    lines = []
    for noise in sorted({row["noise"] for row in rows if row["truth"] == "none"}):
        own = [row for row in rows if row["truth"] == "none" and row["noise"] == noise]
        lines.append(_line(f"nothing hidden, noise {noise}", own))
    for kind, _ in OUTSIDE:
        own = [row for row in rows if row["truth"] == kind and float(row["partial"]) >= CLEAR]
        if own:
            lines.append(_line(f"outside the catalogue: {kind.replace('_', ' ')}", own))
    return table(head, lines)


def _line(label: str, rows: Sequence[Row]) -> tuple[str, str, str, str]:
    named = [row["verdict"] in {"named", "ambiguous"} for row in rows]
    return label, str(len(rows)), share(named), share(row["verdict"] == "unexplained" for row in rows)


def gaps(rows: Sequence[Row]) -> str:
    """How far the gap closes where the right effects were named, by strength."""
    head = ("partial strength", "logs", "gap closed, median [%]", "left over the floor, median", "95 % of logs below")
    lines = []
    for size in sorted({float(row["partial"]) for row in rows}):
        own = [row for row in rows if float(row["partial"]) == size and row["truth"] != "none" and held(row)]
        if own:
            closed = sorted(float(row["shrink"]) for row in own)
            left = sorted(float(row["over_floor"]) for row in own)
            lines.append(
                (
                    f"{size:g}",
                    str(len(own)),
                    f"{100 * closed[len(own) // 2]:.0f}",
                    f"{left[len(own) // 2]:.3f}",
                    f"{left[int(0.95 * (len(own) - 1))]:.3f}",
                )
            )
    return table(head, lines)


def main() -> None:
    """Print the tables, or put them between the marks of a page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--output", type=Path)
    asked = parser.parse_args()
    rows = [row for path in asked.files for row in csv.DictReader(path.open()) if row["verdict"] not in {"", "error"}]
    text = "\n\n".join((by_effect(rows), without_effect(rows), gaps(rows)))
    if asked.output is None:
        print(text)
        return
    page = asked.output.read_text()
    before, after = page.split(BEGIN)[0], page.split(END)[1]
    asked.output.write_text(f"{before}{BEGIN}\n\n{text}\n\n{END}{after}")


if __name__ == "__main__":
    main()
