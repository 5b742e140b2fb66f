"""What a diagnosis says of a joint as a row of a table, and whether that is right."""

import json
from collections.abc import Iterable, Mapping, Sequence

from scipy.stats import binomtest

from friction_audit.diagnosis.result import JointDiagnosis, NamedEffect
from friction_audit.reporting.notices import text_of

Row = Mapping[str, str]
CLEAR = 0.3
"""Partial strength from which an effect has to be found."""
SURE = ("named", "ambiguous")
UNANSWERED = ("", "error", "not_testable", "data_fault", "failed")
ANSWER = ("verdict", "sets", "negligible", "checks", "remainder", "shrink", "share_explained", "over_floor",
          "before_nm", "after_nm", "floor_nm", "effects", "reason")  # fmt: skip
"""Columns of ``answer_of``."""


def answer_of(joint: JointDiagnosis) -> dict[str, object]:
    """Columns of a row; sets of names as ``name|alternative;name``, the largest effect first."""
    gap = joint.gap
    return {
        "verdict": joint.verdict,
        "sets": ";".join("|".join((e.name, *e.alternatives)) for e in joint.effects),
        "negligible": ";".join(e.name for e in joint.negligible),
        "checks": ";".join(f"{c.code} {c.along} {c.share:.2f}" for c in joint.checks),
        "remainder": round(joint.remainder_share, 3),
        "shrink": gap and round(gap.shrink, 3), "share_explained": round(joint.share_explained, 3),
        "over_floor": gap and round(gap.over_floor, 3), "before_nm": gap and round(gap.before, 4),
        "after_nm": gap and round(gap.after, 4), "floor_nm": gap and round(gap.floor, 4),
        "effects": json.dumps([_size(e) for e in (*joint.effects, *joint.negligible)]),
        "reason": text_of(joint.reason) or joint.traceback,
    }  # fmt: skip


def _size(effect: NamedEffect) -> dict[str, object]:
    return {
        "name": effect.name, "size_nm": round(effect.size_nm, 4), "friction_share": round(effect.friction_share, 4),
        "chosen_in": effect.chosen_in, "p_value": round(effect.p_value, 5),
    }  # fmt: skip


def truth_of(row: Row) -> set[str]:
    """Names of the hidden effects; empty where nothing is hidden in this joint."""
    return set() if row["truth"] in {"", "none"} or row.get("hidden_here") == "False" else set(row["truth"].split("+"))


def sets_of(row: Row) -> list[set[str]]:
    """Names of each effect in an answer with what cannot be separated from it."""
    return [set(one.split("|")) for one in row["sets"].split(";") if one]


def named(row: Row) -> bool:
    """Whether any effect that is not negligible is named."""
    return row["verdict"] in SURE and bool(row["sets"])


def held(row: Row) -> bool:
    """Whether every hidden effect is in the answer."""
    return bool(truth_of(row)) and truth_of(row) <= set().union(*sets_of(row))


def held_or_negligible(row: Row) -> bool:
    """Whether every hidden effect is in the answer or listed as negligible."""
    return bool(truth_of(row)) and truth_of(row) <= set().union(*sets_of(row), set(row["negligible"].split(";")))


def exact(row: Row) -> bool:
    """Whether the hidden effects, all of them and nothing else, are named without alternatives."""
    return row["verdict"] == "named" and sorted(map(sorted, sets_of(row))) == sorted([name] for name in truth_of(row))


def first(row: Row) -> bool:
    """Whether the largest effect in the answer is a hidden one, under its own name."""
    return row["sets"].split(";")[0].split("|")[0] in truth_of(row)


def own_name(row: Row) -> bool:
    """Whether every hidden effect is in the answer under its own name, not as an alternative."""
    return bool(truth_of(row)) and truth_of(row) <= {one.split("|")[0] for one in row["sets"].split(";")}


def wrong(row: Row) -> bool:
    """Whether the answer is sure, and holds a name with none of the hidden effects among its alternatives."""
    return row["verdict"] in SURE and any(not one & truth_of(row) for one in sets_of(row))


def misnamed(row: Row) -> bool:
    """Whether the answer is sure, and holds wrong names and nothing else."""
    return wrong(row) and not set().union(*sets_of(row)) & truth_of(row)


def unexplained(row: Row) -> bool:
    """Whether the verdict is that nothing in the catalogue explains the residual."""
    return row["verdict"] == "unexplained"


def answered(rows: Iterable[Row]) -> list[Row]:
    """Rows of joints that were diagnosed."""
    return [row for row in rows if row["verdict"] not in UNANSWERED]


def share(flags: Iterable[bool], digits: int = 0) -> str:
    """A share in percent with its 95 % interval (Wilson)."""
    given = list(flags)
    if not given:
        return "-"
    interval = binomtest(sum(given), len(given)).proportion_ci(method="wilson")
    low, high = (f"{100 * end:.{digits}f}" for end in (interval.low, interval.high))
    return f"{100 * sum(given) / len(given):.{digits}f} ({low} to {high})"


def table(head: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    rows = [head, ["---"] * len(head), *lines]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)
