"""Damage undamaged logs at random, estimate each from the command line, count what was refused, left out and missed.

    python -m benchmarks.damaged_files.run --count 10000 [--first 0] [--output rows.csv] [--table table.md] [--more]

One number makes one damaged file: the same number, the same file. ``--more``: of formats that this program does not
write, and of files that are joined. "Silent" is a coefficient that is off by more than
5 % with exit code 0 and no warning that the undamaged log does not have.
"""

import argparse
import csv
import shutil
import tempfile
from collections import defaultdict
from pathlib import Path

import numpy as np

from benchmarks.damaged_files.damage import damage
from benchmarks.damaged_files.seeds import more_seeds, seeds
from benchmarks.damaged_files.watched import GIGABYTE, Outcome, preload, run

SAMPLES = Path(__file__).resolve().parents[2] / "sample_logs" / "formats"
FIELDS = ("number", "seed", "container", "damage", "code", "kind", "worst_change", "cpu_s", "peak_bytes", "error")
FOLDERS = (".lerobot", ".joined")
CHANNELS = ("q", "dq", "tau_J")
OFF = 0.05
SLOW_S = 10.0


def container(path: Path) -> str:
    """Return the name of the container that holds a log."""
    if path.suffix in FOLDERS:
        return path.suffix[1:]
    storage = storage_of(path)
    return {".bag": "ROS 1 bag", ".db3": "sqlite3 bag"}.get(storage.suffix, storage.suffix[1:])


def storage_of(path: Path, draw: np.random.Generator | None = None) -> Path:
    """Return the file itself, the storage file in the directory of a bag, or a file of a data set or joined log."""
    if not path.is_dir():
        return path
    files = [one for one in sorted(path.rglob("*")) if one.is_file() and one.suffix != ".yaml"]
    return files[0 if draw is None or path.suffix not in FOLDERS else draw.integers(len(files))]


def words_of(path: Path) -> list[str]:
    """Return the command that estimates a log."""
    if path.suffix == ".joined":
        first, second = sorted(path.iterdir())
        return ["estimate", str(first), "--join", str(second), "--json"]
    more = []
    if path.suffix == ".npy" and "plain" in path.name:
        joints = (np.load(path, mmap_mode="r").shape[1] - 1) // 3
        places = (f"#{2 + k * joints}-#{1 + (k + 1) * joints}" for k in range(3))
        more = ["--map", "t=#1", *(f"--map={channel}={one}" for channel, one in zip(CHANNELS, places, strict=True))]
    return ["estimate", str(path), "--json", *more]


def change(outcome: Outcome, undamaged: Outcome) -> float:
    """Return the largest relative change of a coefficient that both have."""
    pairs = [(value, undamaged.coefficients.get(key)) for key, value in outcome.coefficients.items()]
    return max((abs(value / true - 1.0) for value, true in pairs if true), default=0.0)


def kind(outcome: Outcome, undamaged: Outcome) -> str:
    """Name how a command ended."""
    if outcome.failed:
        return "crash" if outcome.crashed else "traceback"
    if outcome.code < 0 or outcome.cpu_s > SLOW_S:
        return "slow"
    if outcome.peak_bytes > GIGABYTE:
        return "large"
    if outcome.code in (3, 6):
        return {3: "refused", 6: "left out"}[outcome.code]
    if change(outcome, undamaged) <= OFF:
        return "same" if change(outcome, undamaged) == 0.0 else "near"
    return "warned" if outcome.warnings - undamaged.warnings else "silent"


def rows(first: int, count: int, folder: Path, *, more: bool = False) -> list[dict[str, object]]:
    """Make, run and judge damaged files."""
    paths = more_seeds(folder) if more else seeds(folder, SAMPLES)
    names = sorted(paths)
    preload(paths[names[0]])
    words = {name: words_of(path) for name, path in paths.items()}
    whole = {name: run(words[name]) for name in paths}
    names = [name for name in names if whole[name].code in (0, 4)]
    found: list[dict[str, object]] = []
    for number in range(first, first + count):
        draw = np.random.default_rng([20261123, number])
        name = names[draw.integers(len(names))]
        target = folder / ("damaged" + "".join(paths[name].suffixes))
        (shutil.copytree if paths[name].is_dir() else shutil.copyfile)(paths[name], target)
        done = damage(storage_of(target, draw), draw)
        outcome = run([word.replace(str(paths[name]), str(target)) for word in words[name]])
        found.append({
            "number": number, "seed": name, "container": container(paths[name]), "damage": done, "code": outcome.code,
            "kind": kind(outcome, whole[name]), "worst_change": f"{change(outcome, whole[name]):.3g}",
            "cpu_s": f"{outcome.cpu_s:.2f}", "peak_bytes": outcome.peak_bytes,
            "error": outcome.errors.strip().splitlines()[-1][:200] if outcome.errors.strip() else "",
        })  # fmt: skip
        shutil.rmtree(target) if target.is_dir() else target.unlink()
    return found


def table(found: list[dict[str, object]]) -> str:
    """Return the counts by container as a Markdown table."""
    kinds = ("refused", "left out", "same", "near", "warned", "silent", "traceback", "crash", "slow", "large")
    counts: dict[str, dict[str, int]] = defaultdict(lambda: defaultdict(int))
    for row in found:
        for group in (str(row["container"]), "all"):
            counts[group][str(row["kind"])] += 1
    lines = [f"| container | tried | {' | '.join(kinds)} |", "|---" * (len(kinds) + 2) + "|"]
    for group in sorted(counts, key=lambda one: (one == "all", one)):
        values = [counts[group][one] for one in kinds]
        lines.append(f"| {group} | {sum(values)} | {' | '.join(map(str, values))} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--output", type=Path)
    parser.add_argument("--table", type=Path)
    parser.add_argument("--more", action="store_true")
    parser.add_argument("--of", type=Path, nargs="+", default=[], help="only make the table, of rows written before")
    chosen = parser.parse_args()
    found: list[dict[str, object]] = []
    for path in chosen.of:
        with path.open(newline="") as stream:
            found += csv.DictReader(stream)
    if not found:
        with tempfile.TemporaryDirectory() as folder:
            found = rows(chosen.first, chosen.count, Path(folder), more=chosen.more)
    if chosen.output:
        with chosen.output.open("w", newline="") as stream:
            writer = csv.DictWriter(stream, FIELDS)
            writer.writeheader()
            writer.writerows(found)
    text = table(found)
    print(text)
    if chosen.table:
        chosen.table.write_text(text)


if __name__ == "__main__":
    main()
