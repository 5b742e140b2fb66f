"""Rows of ``run`` -> the confusion table.

python -m benchmarks.stranger.table FILE.csv... [--output benchmarks/stranger/table.md]
"""

import argparse
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from benchmarks.answers import Row, exact, held, sets_of, table, truth_of, wrong
from benchmarks.resume import read
from benchmarks.stranger.effects import HIDDEN, OUTSIDE, RECORDED

HEAD = ("hidden", "logs", "in the answer", "the only name", "a wrong name", "`unexplained`", "`adequate`",
        "`not_testable`", "`data_fault`", "refused", "named instead, or beside")  # fmt: skip
INTRODUCTION = """\
# Answers on logs of a second generator

Made by `python -m benchmarks.stranger.table` from rows of `python -m benchmarks.stranger.run`. Sizes are partial:
{sizes} times the rms of the noise below 20 Hz. *In the answer*: every hidden effect is among the names or their
alternatives. *The only name*: it alone, without alternatives. *A wrong name*: a name, none of whose alternatives
is hidden, in a verdict that is sure (`named`, `ambiguous`). A log of one joint with a fault in its data is refused.
"""


def label_of(row: Row) -> str:
    """What a joint hides; nothing, too, beside one that hides something."""
    return row["hides"] or ("none" if row["truth"] == "none" else "")


def line(label: str, rows: Sequence[Row]) -> tuple[str, ...]:
    """Counts of one kind of log."""
    verdicts = Counter(row["verdict"] for row in rows)
    others = Counter(next(iter(row["sets"].split(";")[i].split("|"))) for row in rows if wrong(row)
                     for i, one in enumerate(sets_of(row)) if not one & truth_of(row))  # fmt: skip
    counts = (len(rows), sum(map(held, rows)), sum(map(exact, rows)), sum(map(wrong, rows)))
    words = ("unexplained", "adequate", "not_testable", "data_fault", "error")
    beside = ", ".join(f"{name} {n}" for name, n in others.most_common())
    return (label, *map(str, counts), *(str(verdicts[word]) for word in words), beside or "-")


def confusions(rows: Sequence[Row]) -> str:
    """One line per hidden effect, those of one kind together at the end."""
    beside = [row for row in rows if row["truth"] != "none" and not row["hides"]]
    own = {name: [row for row in rows if label_of(row) == name] for name in ("none", *RECORDED, *HIDDEN, *OUTSIDE)}
    alone = [row for row in rows if row["hides"] in HIDDEN]
    pairs = [row for row in rows if "+" in row["hides"]]
    lines = [line(name, part) for name, part in own.items() if part]
    lines += [line(f"one effect, size {size}", [row for row in alone if row["partial"] == size])
              for size in sorted({row["partial"] for row in alone}, key=float)]  # fmt: skip
    rest = {"one effect, all": alone, "two effects": pairs, "none, an effect in another joint": beside}
    lines += [line(label, part) for label, part in rest.items() if part]
    return table(HEAD, lines)


def main() -> None:
    """Print the table, or write its page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--output", type=Path)
    parser.add_argument("--note", default="", help="A sentence about the rows, put above the table.")
    asked = parser.parse_args()
    rows = [row for path in asked.files for row in read(path) if row["verdict"]]
    sizes = ", ".join(sorted({row["partial"] for row in rows}, key=float))
    text = f"{INTRODUCTION.format(sizes=sizes)}\n{asked.note}\n\n{confusions(rows)}\n"
    if asked.output is None:
        print(text)
    else:
        asked.output.write_text(text)


if __name__ == "__main__":
    main()
