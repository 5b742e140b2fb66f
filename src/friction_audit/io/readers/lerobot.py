"""LeRobot data sets, v2.1 and v3 -> Recording: one episode of a folder with ``meta/info.json``.

``data/chunk-000/episode_000003.parquet`` (v2.1) holds one episode, ``data/chunk-000/file-000.parquet`` (v3) many; the
features of a frame are lists whose elements ``info.json`` names: ``observation.state``, ``observation.velocity``,
``observation.effort``, or all of them in ``observation.state`` as ``elbow.pos``, ``elbow.vel``, ``elbow.torque``.
"""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from friction_audit.errors import InputError
from friction_audit.io.files import DATA_SET
from friction_audit.io.readers.arrays import ArrayTable, arrays_of_frame
from friction_audit.io.readers.channel_names import parse_name
from friction_audit.io.readers.reader import ReadOptions, SeveralLogsError, Topic, refuse_pointer
from friction_audit.io.readers.table import read_table
from friction_audit.io.recording import Recording

_STATE = "observation.state"


def recognises(path: Path) -> bool:
    """Return True for the folder of a data set."""
    return (path / DATA_SET).is_file()


def topics(path: Path) -> tuple[Topic, ...]:
    """List the episodes of a data set."""
    return tuple(
        Topic(name=name, type=f"episode in {file.name}", messages=frames, readable=True)
        for name, (file, frames) in _episodes(path).items()
    )


def read(path: Path, options: ReadOptions) -> Recording:
    """Read the only episode, or the one that ``--topic`` names; SeveralLogsError if it names none of several."""
    episodes = _episodes(path)
    wanted, _, arm = (options.topic or "").partition("#")
    if not wanted and len(episodes) > 1:
        what = f"{len(episodes)} episodes in one data set; choose one with --topic {next(iter(episodes))}"
        raise SeveralLogsError(f"{path}: {what}, or take all with batch-report", list(episodes))
    name = wanted or next(iter(episodes))
    if name not in episodes:
        raise InputError(f"{path}: no episode {name!r}; it has {', '.join([*episodes][:5])} ... ({len(episodes)})")
    try:
        features = json.loads((path / DATA_SET).read_text(encoding="utf-8"))["features"]
        features = {name: one for name, one in features.items() if isinstance(one, dict)}
    except (ValueError, LookupError, AttributeError, TypeError, RecursionError) as error:
        raise InputError(f"{path}: {DATA_SET} holds no features of a data set ({error}); copy it again") from error
    from pyarrow import compute

    from friction_audit.io.readers.parquet import is_of, opened

    with opened(file := episodes[name][0]) as parquet:
        kinds = {one.name: one.type.value_type if is_of(one.type, "list") else one.type for one in parquet.schema_arrow}
        frames = parquet.read([name for name, kind in kinds.items() if is_of(kind, "number")])
    own = compute.equal(frames["episode_index"], int(name.rpartition("_")[2]))
    table = _EpisodeTable(path, arrays_of_frame(frames.filter(own), str(file)), features)
    options = replace(options, topic=f"#{arm}" if arm else None, mapping={**table.mapping, **options.mapping})
    try:
        return replace(read_table(table, options), topic=name)
    except SeveralLogsError as several:
        raise SeveralLogsError(str(several), [f"{name}{one}" for one in several.topics]) from several


class _EpisodeTable(ArrayTable):
    """The frames of an episode; elements of the state are called by their quantity where their names say it."""

    may_be_long = False

    def __init__(self, path: Path, arrays: Mapping[str, NDArray[Any]], features: Mapping[str, Any]) -> None:
        super().__init__(path, arrays)
        names, labels = list(self.names), dict[int, str]()
        for feature, array in arrays.items():
            motors = _motors(features.get(feature, {}).get("names"))
            cells = [cell for cell, name in enumerate(names) if name.startswith(f"{feature}[")]
            if array.ndim == 1 or len(motors) != len(cells):
                continue
            split = [motor.rpartition(".") for motor in motors]
            if all(parse_name(f"{quantity}[0]") for _, _, quantity in split):
                counts: dict[str, int] = {}
                for cell, (motor, _, quantity) in zip(cells, split, strict=True):
                    place = counts[quantity] = counts.get(quantity, -1) + 1
                    names[cell], labels[cell] = f"{feature}.{quantity}[{place}]", motor
            else:
                labels |= dict(zip(cells, motors, strict=True))
        self.names, self.labels = names, labels
        found = {parsed.channel for name in names if (parsed := parse_name(name))}
        state = f"{_STATE}[0]" in names and "q" not in found
        self.mapping = {"q": _STATE} if state else {}


def _motors(names: Any) -> list[str]:  # noqa: ANN401 - JSON
    """Return the names of a feature's elements: a list, a list of one list, or a list under one key."""
    while isinstance(names, dict | list) and len(names) == 1:
        (inner,) = names.values() if isinstance(names, dict) else names
        if not isinstance(inner, dict | list):
            break
        names = inner
    return [str(name) for name in names] if isinstance(names, list) else []


def _episodes(path: Path) -> dict[str, tuple[Path, int]]:
    """Return by name the file that each episode is in, and its frames."""
    from friction_audit.io.readers.parquet import opened

    found: dict[int, tuple[Path, int]] = {}
    for file in sorted((path / "data").glob("**/*.parquet")):
        refuse_pointer(file)
        with opened(file) as parquet:
            if "episode_index" in parquet.schema_arrow.names:
                counts = parquet.read(["episode_index"])["episode_index"].value_counts().to_pylist()
                found |= {int(one["values"]): (file, one["counts"]) for one in counts}
    if not any(frames for _, frames in found.values()):
        raise InputError(f"{path}: 0 frames; expected episodes in data/*/*.parquet; fetch or record them")
    return {f"episode_{number:06d}": found[number] for number in sorted(found)}
