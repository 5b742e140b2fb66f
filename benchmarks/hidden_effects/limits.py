"""How much a log holds of one effect, or of each of two: what a detector would see that knew their torques.

python -m benchmarks.hidden_effects.limits ROWS.csv... [--strength 0.2] [--output LIMITS.csv]

The files are those of ``run``; rows with nothing hidden, or nothing of the catalogue, are passed over. An effect's
torque is what it alone adds on ideal sensors. It is seen where n_eff ln(RSS without it / RSS with it), beside the
declared model and the other effect's torque if there is one, and over all cycles of the very log that was diagnosed, is
above what the best of all names of the catalogue brings by chance in one log of a hundred. Where an effect changes how
the joint moves, its torque is that of another motion, and the number is too small. Without ``--strength`` all logs
count whose effects have to be found, from 0.3 on.
"""

import argparse
import csv
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from friction_audit.diagnosis.ground import Ground, make_ground
from friction_audit.diagnosis.ranking import BY_CHANCE
from numpy.typing import NDArray
from scipy.special import chdtri

from benchmarks.hidden_effects.draw import Case, draw_case, model_of, settings_of
from benchmarks.hidden_effects.run import SIZES, scaled
from benchmarks.hidden_effects.strength import prepared, scales_for
from benchmarks.hidden_effects.table import CLEAR, Row, held, sets_of, share, table
from friction_audit.diagnosis.nominal_model import least_squares, nominal_model
from friction_audit.diagnosis.rows import Rows, make_rows
from friction_audit.effects.registry import effects
from friction_audit.joint_log import Float
from friction_audit.simulation.scenarios import simulate

PRICE = float(chdtri(1, BY_CHANCE / len(effects())))
"""Of an effect whose torque is known but for its factor."""
MUCH = 2.0
"""Times the price from which on an effect is plain."""
SAME_START_S = 0.05
"""A start from a standstill in one log and in another are the same one if they are no farther from each other."""
FIELDS = ("truth", "seed", "effect", "partial", "n_eff", "holds", "in_the_answer", "untestable")


def limits_of(row: Row) -> Iterator[dict[str, object]]:
    """What the log of a row holds of each of its effects."""
    seed, names = int(row["seed"]), tuple(row["truth"].split("+"))
    case = draw_case(seed, names, SIZES[seed % len(SIZES)])
    # Rows of earlier runs do not hold the scales.
    scales = tuple(map(float, filter(None, (row.get("scales") or "").split("/")))) or scales_for(case)
    if scales is None:
        return
    case = scaled(case, scales)
    every = (1.0,) * len(names)
    model, joint = model_of(case), case.number - 1
    data = prepared(simulate(settings_of(case, every), seed).log)[joint]
    ground = make_ground(data, None if model is None else model.joints[joint], seed)
    torques = [_torque_alone(case, k, ground) for k in range(len(names))]
    told = set().union(*sets_of(row))
    for k, name in enumerate(names):
        candidate = next(one for one in effects() if one.name == name)
        yield {
            "truth": row["truth"], "seed": seed, "effect": name, "partial": case.partial,
            "n_eff": round(_worth(ground, torques), 0),
            "holds": round(held_by(ground, torques, k), 1),
            "in_the_answer": name in told,
            "untestable": candidate.not_identifiable(data, ground.baseline()) is not None,
        }  # fmt: skip


def held_by(ground: Ground, torques: Sequence[Float], which: int) -> float:
    """n_eff ln(RSS without one torque / RSS with it), all beside the declared model and over all cycles."""
    without = [*torques[:which], *torques[which + 1 :]]
    return _worth(ground, torques) * float(np.log(_left(ground, without) / _left(ground, torques)))


def _worth(ground: Ground, torques: Sequence[Float]) -> float:
    return len(ground.y) / ground.memory(np.column_stack(torques))


def _left(ground: Ground, torques: Sequence[Float]) -> float:
    columns = np.column_stack([ground.base, *torques])
    return float(np.sum((ground.y - columns @ least_squares(columns, ground.y)) ** 2))


def _torque_alone(case: Case, which: int, ground: Ground) -> Float:
    """What one effect alone adds on ideal sensors, free of the declared model, on the rows of a ground, shape (m,)."""
    scales = tuple(1.0 if k == which else 0.0 for k in range(len(case.effects)))
    model, joint = model_of(case), case.number - 1
    data = prepared(simulate(settings_of(case, scales, ideal=True), case.seed).log)[joint]
    rows = make_rows(data, ground.rows.corner_hz)
    declared = nominal_model(data, rows, None if model is None else model.joints[joint])
    torque = np.zeros(len(ground.y))
    here, there = same_moments(ground.rows, rows)
    torque[here] = (declared.y - declared.columns @ least_squares(declared.columns, declared.y))[there]
    return torque


def same_moments(rows: Rows, others: Rows) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Which rows of two logs are the same moment, and the same start from a standstill: places in both, shape (k,)."""
    here, there = [], []
    for starts, apart in ((False, rows.step_s / 2.0), (True, SAME_START_S)):
        one, other = np.flatnonzero(_starts(rows) == starts), np.flatnonzero(_starts(others) == starts)
        if not len(one) or not len(other):
            continue
        after = np.clip(np.searchsorted(others.t[other], rows.t[one]), 1, max(len(other) - 1, 1))
        both = np.stack([other[np.minimum(after, len(other) - 1)], other[after - 1]])
        nearest = both[np.abs(others.t[both] - rows.t[one]).argmin(axis=0), np.arange(len(one))]
        near = np.abs(others.t[nearest] - rows.t[one]) < apart
        here.append(one[near])
        there.append(nearest[near])
    return np.concatenate(here), np.concatenate(there)


def _starts(rows: Rows) -> NDArray[np.bool_]:
    """Which rows are starts from a standstill, shape (m,)."""
    starts = np.zeros(len(rows.used), bool)
    starts[rows.breakaway_row] = True
    return starts[rows.used]


def counts(row: Row, strength: float | None) -> bool:
    """Whether a row is of a strength, of one that has to be found without any."""
    partial = float(row["partial"])
    return partial >= CLEAR if strength is None else partial == strength


def judged(rows: Sequence[Row], strength: float | None) -> list[Row]:
    """Rows with an answer to effects of the catalogue, of the joint that their strength is measured in."""
    names = {candidate.name for candidate in effects()}
    return [
        row
        for row in rows
        if row["verdict"] not in {"", "error"}
        and set(row["truth"].split("+")) <= names
        and counts(row, strength)
        and int(row["joint"]) == draw_case(int(row["seed"]), row["truth"].split("+"), float(row["partial"])).number
    ]


def summary(rows: Sequence[Row], limits: Sequence[Row], strength: float | None = None) -> str:
    """A table of effects that were alone, of those of pairs, and of pairs, by what their logs hold.

    Args:
        rows: Rows of ``run``.
        limits: What their logs hold of each effect.
        strength: Which rows count; None for all that have to be found.
    """
    clear = [row for row in limits if counts(row, strength)]
    lines = []
    for label, two in (("one effect", False), ("effects of two", True)):
        lines += _by_what_is_held(label, [row for row in clear if ("+" in row["truth"]) == two])
    both = [row for row in rows if "+" in row["truth"] and _both_seen(row, clear)]
    lines += [("two, both at least the price", str(len(both)), share(map(held, both)))] if both else []
    return table(("what the log holds", "number", "in the answer [%]"), lines)


def _by_what_is_held(label: str, limits: Sequence[Row]) -> list[tuple[str, str, str]]:
    """One line for each part of some effects; none without any."""
    if not limits:
        return []
    shown = [row for row in limits if row["untestable"] == "False"]
    prices = [float(row["holds"]) / PRICE for row in shown]
    parts = [
        ("that the log cannot show, as the answer says", [row for row in limits if row not in shown]),
        ("less than the price", [row for row, so in zip(shown, prices, strict=True) if so < 1.0]),
        ("up to twice the price", [row for row, so in zip(shown, prices, strict=True) if 1.0 <= so < MUCH]),
        ("more", [row for row, so in zip(shown, prices, strict=True) if so >= MUCH]),
    ]
    return [
        (f"{label}, {words}", str(len(part)), share(row["in_the_answer"] == "True" for row in part))
        for words, part in parts
    ]


def _both_seen(row: Row, limits: Sequence[Row]) -> bool:
    """Whether the log of a pair can show both and holds the price of each."""
    own = [one for one in limits if (one["truth"], one["seed"]) == (row["truth"], row["seed"])]
    return bool(own) and all(one["untestable"] == "False" and float(one["holds"]) >= PRICE for one in own)


def main() -> None:
    """Run all logs of some files that the output does not hold, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", type=Path, nargs="+")
    parser.add_argument("--strength", type=float, help="of the logs that count; from 0.3 on if not given")
    parser.add_argument("--output", type=Path, default=Path("hidden_effects_limits.csv"))
    asked = parser.parse_args()
    rows = judged([row for path in asked.files for row in csv.DictReader(path.open())], asked.strength)
    started = asked.output.exists()
    done = {(row["truth"], row["seed"]) for row in csv.DictReader(asked.output.open())} if started else set()
    with asked.output.open("a", newline="") as file:
        writer = csv.DictWriter(file, FIELDS)
        if not started:
            writer.writeheader()
        for row in rows:
            if (row["truth"], row["seed"]) not in done:
                writer.writerows(limits_of(row))
                file.flush()
    asked_for = {(row["truth"], row["seed"]) for row in rows}
    limits = [one for one in csv.DictReader(asked.output.open()) if (one["truth"], one["seed"]) in asked_for]
    print(summary(rows, limits, asked.strength))


if __name__ == "__main__":
    main()
