"""Diagnose prepared joints (``subjects``) with one engine, write a row per joint, print the rates.

python -m benchmarks.diagnosis_engine.run FOLDER OUT.csv [--engine joint|old] [--match TEXT] [--limit N]
"""

import argparse
import csv
import hashlib
import pickle
import time
import traceback
from pathlib import Path
from typing import Any

import numpy as np

from friction_audit.diagnosis.conclusion import conclude
from friction_audit.diagnosis.diagnose_joint import FEWEST_CYCLES, Subject, diagnose_joint
from friction_audit.diagnosis.procedure import select
from friction_audit.diagnosis.samples import make_samples
from friction_audit.diagnosis.settings import DiagnosisSettings
from friction_audit.effects.registry import effects

FIELDS = ("name", "truth", "seed", "size", "scenario", "joint", "hidden_here", "outside", "verdict", "sets",
          "negligible", "checks", "folds", "cpu_s", "old_verdict", "old_sets", "error")  # fmt: skip


def answer(subject: Subject, engine: str) -> dict[str, Any]:
    """Verdict and sets of names."""
    if engine == "old":
        found = diagnose_joint(subject, effects(), DiagnosisSettings())
        return {"verdict": found.verdict, "sets": ";".join("|".join((e.name, *e.alternatives)) for e in found.effects)}
    if len(np.unique(make_samples(subject.data).cycle)) < FEWEST_CYCLES:
        return {"verdict": "not_testable"}
    state = select(subject.data, subject.model, effects())
    said = conclude(state)
    contact = ["contact_event"] if state.contacts else []
    return {
        "verdict": said.verdict,
        "sets": ";".join([*("|".join((n.block.name, *n.alternatives)) for n in said.named), *contact]),
        "negligible": ";".join(n.block.name for n in said.negligible),
        "checks": ";".join(f"{c.code} {c.along} {c.share:.2f}" for c in said.checks),
        "folds": ";".join(f"{n.folds}/5 z{n.gain.z:.1f} {100 * n.friction_share:.1f}%" for n in said.named),
    }


def rows_of(path: Path, engine: str) -> list[dict[str, Any]]:
    """One row per joint."""
    name, info, subjects = pickle.loads(path.read_bytes())
    found = []
    for subject in subjects:
        old = info["old"].get(str(subject.number), {})
        row = {"name": name, **{k: info[k] for k in ("truth", "seed", "size", "scenario", "outside")},
               "joint": subject.number, "old_verdict": old.get("verdict", ""), "old_sets": old.get("sets", ""),
               "hidden_here": not info["hidden_in"] or subject.number in info["hidden_in"]}  # fmt: skip
        began = time.process_time()
        try:
            row |= answer(subject, engine)
        except Exception:  # noqa: BLE001 - a row of its own
            row |= {"verdict": "failed", "error": traceback.format_exc()[-600:]}
        found.append(row | {"cpu_s": round(time.process_time() - began, 2)})
    return found


def rates(rows: list[dict[str, Any]], sets: str, verdict: str) -> dict[str, str]:
    """Rates by kind of log; ``sets`` and ``verdict`` are the columns that are judged."""
    rows = [row for row in rows if row.get(verdict)]
    kinds: dict[str, list[dict[str, Any]]] = {}
    for row in rows:
        truth, size = row["truth"], float(row["size"])
        generator = str(row["name"]).split("_")[0]
        source = {"stranger": "stranger ", "smoothed": "smoothed "}.get(generator, "")
        hidden = str(row["hidden_here"]) == "True"
        kind = ("none" if truth == "none" or not hidden else "outside" if str(row["outside"]) == "True"
                else "pair" if "+" in truth else "size 0.2" if size < 0.25 else "from 0.3")  # fmt: skip
        kinds.setdefault(source + kind, []).append(row)
    out = {}
    for kind, some in sorted(kinds.items()):
        n = len(some)
        answers = [[set(one.split("|")) for one in str(r.get(sets) or "").split(";") if one] for r in some]
        wanted = [set(r["truth"].split("+")) for r in some]
        if kind.endswith("none"):
            false = sum(bool(a) or r[verdict] == "unexplained" for a, r in zip(answers, some, strict=True))
            named = sum(bool(a) for a in answers)
            out[kind] = f"n {n:3d}  named {named}  named or unexplained {false}"
        elif kind.endswith("outside"):
            un = sum(r[verdict] == "unexplained" for r in some)
            wrong = sum(bool(a) and r[verdict] != "unexplained" for a, r in zip(answers, some, strict=True))
            out[kind] = f"n {n:3d}  unexplained {un}  named {wrong}"
        else:
            held = sum(w <= set().union(*a) for a, w in zip(answers, wanted, strict=True))
            exact = sum(sorted(map(sorted, a)) == sorted([x] for x in w) for a, w in zip(answers, wanted, strict=True))
            firsts = sum(len(a) == len(w) and w <= set().union(*a) for a, w in zip(answers, wanted, strict=True))
            only = sum(bool(a) and not any(x & w for x in a) for a, w in zip(answers, wanted, strict=True))
            wrong = sum(any(not x & w for x in a) for a, w in zip(answers, wanted, strict=True))
            un = sum(r[verdict] == "unexplained" for r in some)
            out[kind] = (f"n {n:3d}  in answer {held}  right number {firsts}  exact {exact}  only wrong {only}  "
                         f"any wrong {wrong}  unexplained {un}")  # fmt: skip
    return out


def main() -> None:
    """Run, write and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--engine", default="joint")
    parser.add_argument("--match", default="")
    parser.add_argument("--limit", type=int, default=10**6)
    parser.add_argument("--part", default="0/1")
    asked = parser.parse_args()
    np.seterr(all="ignore")
    which, parts = map(int, asked.part.split("/"))
    every = sorted(asked.folder.glob("*.pkl"), key=lambda p: hashlib.sha1(p.name.encode()).digest())
    paths = [p for p in every if asked.match in p.name][which::parts][: asked.limit]
    rows = []
    with asked.out.open("w", newline="") as file:
        writer = csv.DictWriter(file, FIELDS)
        writer.writeheader()
        for path in paths:
            for row in rows_of(path, asked.engine):
                rows.append(row)
                writer.writerow(row)
                file.flush()
    report(rows)


def report(rows: list[dict[str, Any]]) -> None:
    """Print the rates of an engine and of the committed answers, and the time."""
    for kind, text in rates(rows, "sets", "verdict").items():
        print(f"{kind:18s} {text}")
    committed = [r for r in rows if r["old_verdict"]]
    if committed:
        print("committed rows of the engine before")
        for kind, text in rates(committed, "old_sets", "old_verdict").items():
            print(f"{kind:18s} {text}")
    times = [float(r["cpu_s"]) for r in rows]
    print(f"CPU s per joint: median {np.median(times):.2f}, mean {np.mean(times):.2f}, largest {max(times):.1f}")
    print("failed", sum(r["verdict"] == "failed" for r in rows))


if __name__ == "__main__":
    main()
