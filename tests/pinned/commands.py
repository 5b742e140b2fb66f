"""The commands whose answers are pinned while the code is rebuilt, and how an answer becomes numbers and words."""

import hashlib
import json
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from friction_audit.simulation import SCENARIOS
from tests.in_this_process import run

ROOT = Path(__file__).resolve().parents[2]
SAMPLES = ROOT / "sample_logs"
LONG = 24
"""A longer list of numbers is pinned by its length, mean, spread and ends."""
PASSING = {"version", "sha256", "duration_of_run_s", "created", "elapsed_s", "cpu_s"}
"""Keys whose values differ between versions or runs."""

SIMULATED = {
    "stribeck": "simulate joint --seed 4 --duration 40 --rate 500 --effect stribeck --effect torque_ripple",
    "backlash": "simulate joint --seed 5 --duration 40 --rate 500 --effect backlash",
    "nothing": "simulate joint --seed 6 --duration 40 --rate 500",
    "arm": "simulate panda --seed 7 --duration 12 --rate 200",
    **{
        f"rig-{n}": f"simulate joint --duration 20 --rate 200 --seed {n} --set coulomb_nm=0.{30 if n < 4 else 36}"
        for n in range(1, 6)
    },
}
"""Name -> command that makes a log."""

COMMANDS = {
    **{f"info {path.name}": f"info {path} --json" for path in sorted((SAMPLES / "formats").iterdir())},
    "estimate csv": f"estimate {SAMPLES}/formats/csv.csv --json",
    "estimate bag": f"estimate {SAMPLES}/formats/rosbag1-franka-state.bag --json",
    "estimate mcap": f"estimate {SAMPLES}/formats/mcap-franka-robot-state.mcap --json",
    "estimate hand_guided": f"estimate {SAMPLES}/hand_guided.parquet --json",
    "estimate paper": f"estimate {SAMPLES}/hand_guided.parquet --estimator paper --json",
    "estimate bench_rig": f"estimate {SAMPLES}/bench_rig.csv --json",
    "estimate compensated": f"estimate {SAMPLES}/compensated.parquet --json",
    "estimate arm": "estimate {arm} --json",
    "replay hand_guided": f"replay {SAMPLES}/hand_guided.parquet --json",
    "replay same-operator": f"replay {SAMPLES}/bench_rig.csv --assume same-operator --json",
    "diagnose stribeck": "diagnose {stribeck} --json",
    "diagnose backlash": "diagnose {backlash} --json",
    "diagnose nothing": "diagnose {nothing} --json",
    "diagnose bench_rig": f"diagnose {SAMPLES}/bench_rig.csv --json",
    "report bench_rig": f"report {SAMPLES}/bench_rig.csv --format json --json -o report.json",
    "batch-report": "batch-report rig --baseline 3 --json -o drift",
    "compare": "compare --persons 2 --duration 10 --margin-persons 0 --json",
    "reproduce": "reproduce --figures 3,7 --json",
    "damaged": "estimate cut.csv --json",
    "no such column": "estimate strange.csv --json",
    "no file": "estimate nowhere.csv --json",
    "wrong option": f"estimate {SAMPLES}/bench_rig.csv --joints 9 --json",
}
"""Name -> command whose exit code and document are pinned; names in braces are simulated logs."""
SLOW = ("diagnose", "report", "batch-report", "compare", "reproduce")


def make_logs(folder: Path, *, slow: bool) -> dict[str, Path]:
    """Simulate the logs that commands read, those of slow ones too; the current folder becomes theirs."""
    logs = {name: folder / f"{name}.parquet" for name in SIMULATED}
    for name in SIMULATED if slow else ("stribeck", "arm"):
        run(*f"{SIMULATED[name]} -q -o {logs[name]}".split())
    (folder / "rig").mkdir()
    for n in range(1, 6 if slow else 1):
        logs[f"rig-{n}"].rename(folder / "rig" / f"2026-03-0{n}.parquet")
    whole = (SAMPLES / "bench_rig.csv").read_text()
    (folder / "cut.csv").write_text(whole[:-20])
    (folder / "strange.csv").write_text("a,b\n" + "1,2\n" * 50)
    return logs


def answers(folder: Path, *, slow: bool) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield name and pinned content of every answer, ``slow`` ones too, from a folder that is the current one."""
    logs = make_logs(folder, slow=slow)
    for name, words in COMMANDS.items():
        if words.startswith(SLOW) and not slow:
            continue
        answer = run(*words.format(**logs).split())
        document = json.loads(answer.out) if answer.out.lstrip().startswith("{") else None
        yield name, {"exit": answer.code, **pinned(document, str(folder))}
    for name, path in logs.items():
        if path.exists():
            yield f"log {name}", log_content(path)


def scenario_hashes(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield scenario and hash of the numbers of a short log of it."""
    for scenario in SCENARIOS:
        path = folder / f"{scenario.name}.npz"
        run(*f"simulate {scenario.name} --seed 3 --duration 8 -q -o {path}".split())
        if path.exists():
            with zipfile.ZipFile(path) as archive:
                content = b"".join(archive.read(name) for name in sorted(archive.namelist()))
            yield scenario.name, hashlib.sha256(content).hexdigest()


def log_content(path: Path) -> dict[str, Any]:
    """Return rows, and mean and spread of each column of a log."""
    import pyarrow.parquet as pq  # noqa: PLC0415  # this module is imported to collect the tests

    table = pq.read_table(path)
    return {name: summary(np.asarray(table[name], dtype=float)) for name in table.column_names}


def summary(values: np.ndarray) -> list[float]:
    """Return length, mean, standard deviation, first and last value."""
    finite = values[np.isfinite(values)]
    return [len(values), *map(float, (finite.mean(), finite.std(), finite[0], finite[-1]) if len(finite) else ())]


def pinned(document: object, folder: str) -> dict[str, Any]:
    """Return a document as one level of paths, without what differs between runs; long lists are summarised."""
    return dict(_leaves(document, "", folder))


def _leaves(value: object, path: str, folder: str) -> Iterator[tuple[str, Any]]:
    if isinstance(value, dict):
        for key, item in value.items():
            if key not in PASSING:
                yield from _leaves(item, f"{path}/{key}", folder)
    elif isinstance(value, list):
        numbers = [item for item in value if isinstance(item, int | float)]
        if len(value) > LONG and len(numbers) == len(value):
            yield path, summary(np.array(numbers, dtype=float))
            return
        yield f"{path}/#", len(value)
        for i, item in enumerate(value[:LONG]):
            yield from _leaves(item, f"{path}/{i}", folder)
    elif isinstance(value, str):
        yield path, re.sub(r"\d{4}-\d\d-\d\dT[\d:.+Z-]+", "TIME", value.replace(folder, "").replace(str(ROOT), ""))
    else:
        yield path, value
