"""Several files of one log, joined on their clocks."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from friction_audit.errors import InputError
from friction_audit.io.readers import ReadOptions, read_log
from tests.each_case import with_thorough
from tests.in_this_process import Run

EPOCH = 1.7e9


def q_of(t: np.ndarray) -> np.ndarray:
    return 1.0 - np.cos(0.6 * t)


def clock(rate: float = 200.0, seconds: float = 60.0, shift: float = 0.0) -> np.ndarray:
    return np.arange(shift, seconds, 1.0 / rate)


def motion(start: float = 0.0) -> dict[str, np.ndarray]:
    t = clock()
    return {"time": t + start, "q_1": q_of(t), "dq_1": 0.6 * np.sin(0.6 * t)}


def torque(rate: float = 200.0, start: float = 0.0, shift: float = 0.0) -> dict[str, np.ndarray]:
    t = clock(rate, shift=shift)
    speed = 0.6 * np.sin(0.6 * t)
    return {"time": t + start, "tau_interaction_1": 0.5 * np.sign(speed) + 0.2 * speed}


def saved(path: Path, columns: Mapping[str, np.ndarray]) -> Path:
    frame = pd.DataFrame(dict(columns))
    if path.suffix == ".parquet":
        frame.to_parquet(path)
    elif path.suffix == ".npz":
        np.savez(path, **columns)  # type: ignore[arg-type]
    else:
        frame.to_csv(path, index=False, float_format="%.17g")
    return path


def joined(first: Path, *others: Path, **more: Any) -> Any:
    return read_log(first, ReadOptions(join=tuple(map(str, others)), **more))


THREE = ((".csv", ".parquet", ".npz"), (".npz", ".csv", ".csv.gz"), (".parquet",) * 3)
STARTS = (0.0, 123.4, EPOCH)


@pytest.mark.parametrize(("endings", "start"), with_thorough([*zip(THREE, STARTS, strict=True)], THREE, STARTS))
def test_three_files_are_one_log(tmp_path: Path, endings: tuple[str, ...], start: float) -> None:
    t = np.arange(-1.0, 62.0, 1.0)
    warmth = {"time": t + start, "temperature_1": 30.0 + 0.1 * t}
    tables = (motion(start), torque(start=start, rate=100.0), warmth)
    files = [saved(tmp_path / f"{k}{ending}", one) for k, (ending, one) in enumerate(zip(endings, tables, strict=True))]
    log = joined(*files)
    assert len(log.t) == 12000 - 1  # the last stamp of the torque is 10 ms before the end
    assert log.temperature[:, 0] == pytest.approx(30.0 + 0.1 * log.t, abs=1e-6)
    assert log.q[:, 0] == pytest.approx(q_of(log.t), abs=1e-6)
    assert (log.source.start_s is not None) == (start == EPOCH)
    digests = [hashlib.sha256(file.read_bytes()).hexdigest() for file in files]
    assert [log.source.sha256, *(one.sha256 for one in log.source.joined)] == digests
    assert [one.format for one in log.source.joined] == [name.lstrip(".").removesuffix(".gz") for name in endings[1:]]


def test_between_samples_the_joined_channel_is_linear(tmp_path: Path) -> None:
    log = joined(saved(tmp_path / "a.csv", motion()), saved(tmp_path / "b.csv", torque(rate=50.0, shift=0.0037)))
    knots = torque(rate=50.0, shift=0.0037)
    first = float(motion()["time"][1])  # the first stamp after the torque's first
    expected = np.interp(log.t + first, knots["time"], knots["tau_interaction_1"])
    assert log.tau_interaction[:, 0] == pytest.approx(expected, abs=1e-12)


def test_nothing_is_invented_in_a_gap(tmp_path: Path) -> None:
    columns = torque()
    kept = (columns["time"] < 20.0) | (columns["time"] > 25.0)
    part = {key: value[kept] for key, value in columns.items()}
    log = joined(saved(tmp_path / "a.csv", motion()), saved(tmp_path / "b.csv", part))
    assert not ((log.t > 20.0) & (log.t < 25.0)).any()
    (found,) = [one for one in log.source.findings if one.code == "joined"]
    assert found.amount == 1001.0  # the stamps from 20.0 to 25.0 s
    assert not any(one.damaged for one in log.source.findings)


def test_joints_are_joined_by_name(tmp_path: Path) -> None:
    t = motion()["time"]
    names = ("elbow_joint", "wrist_joint")
    first = {"time": t}
    for place, name in enumerate(names):
        first |= {f"{name}.position": (1 + place) * q_of(t), f"{name}.velocity": (1 + place) * 0.6 * np.sin(0.6 * t)}
    second = {"time": t} | {f"{name}.effort": np.sin(t) + place for place, name in reversed(list(enumerate(names)))}
    log = joined(saved(tmp_path / "a.csv", first), saved(tmp_path / "b.csv", second))
    assert (log.tau_J[:, 1] - log.tau_J[:, 0]) == pytest.approx(1.0)


def test_parts_of_a_joined_log_count_from_its_first_sample(tmp_path: Path) -> None:
    first, second = saved(tmp_path / "a.csv", motion()), saved(tmp_path / "b.csv", torque(shift=10.0))
    log = joined(first, second, t_start_s=12.0, t_end_s=40.0)
    assert (log.source.skipped_s, log.duration_s) == pytest.approx((12.0, 28.0), abs=0.006)


@pytest.mark.parametrize(("other", "message"), [
    (torque(start=100.0), r"b.csv: its clock runs from 100 to 159.995 s, that of .*a.csv from 0 to 59.995 s"),
    (torque(start=EPOCH), "says the date"),
    (motion(), "has q, dq, as .*a.csv; expected channels that it lacks"),
    ({"time": motion()["time"], "gauge": motion()["time"]}, "b.csv: no column for a torque|no column for"),
    ({"tau_J_1": motion()["time"]}, "b.csv: no column for t"),
    (torque() | {"tau_interaction_2": torque()["time"]}, "has 2 joints .* has 1"),
])  # fmt: skip
def test_what_cannot_be_joined_is_refused(tmp_path: Path, other: dict[str, np.ndarray], message: str) -> None:
    first = saved(tmp_path / "a.csv", motion())
    with pytest.raises(InputError, match=message):
        joined(first, saved(tmp_path / "b.csv", other))


def test_a_log_that_lacks_a_channel_in_all_files_says_which(tmp_path: Path) -> None:
    first = saved(tmp_path / "a.csv", {k: v for k, v in motion().items() if k != "q_1"})
    with pytest.raises(InputError, match=r"no q; a\.csv has dq; b\.csv has tau_interaction"):
        joined(first, saved(tmp_path / "b.csv", torque()))
    with pytest.raises(InputError, match="no column for --map tau_J=moment"):
        joined(saved(tmp_path / "c.csv", motion()), tmp_path / "b.csv", mapping={"tau_J": "moment"})
    with pytest.raises(InputError, match=r"nowhere\.csv: no such file"):
        joined(tmp_path / "c.csv", tmp_path / "nowhere.csv")


def test_map_names_columns_of_either_file(tmp_path: Path) -> None:
    t = motion()["time"]
    first = saved(tmp_path / "a.csv", {"clock": t, "winkel": q_of(t), "tempo": 0.6 * np.sin(0.6 * t)})
    second = saved(tmp_path / "b.csv", {"clock": t, "strom": np.sin(t)})
    log = joined(first, second, mapping={"q": "winkel", "dq": "tempo", "tau_J": "strom:A"}, torque_constant=(0.5,))
    assert log.tau_J[:, 0] == pytest.approx(0.5 * np.sin(t))


def test_commands_read_joined_files(run: Run, tmp_path: Path) -> None:
    first, second = saved(tmp_path / "a.csv", motion()), saved(tmp_path / "b.csv", torque())
    document = run("estimate", first, "--join", second, "--json").document()
    assert document["joints"][0]["coulomb_nm"]["value"] == pytest.approx(0.5, abs=0.01)
    digest = hashlib.sha256(second.read_bytes()).hexdigest()
    assert document["source"]["joined"] == [{"path": str(second), "sha256": digest, "format": "csv"}]
    assert document["settings"]["reading"]["join"] == [str(second)]
    info = run("info", first, "--join", second)
    assert info.code == 0
    assert "joined on the clock of a.csv" in info.out + info.err
    out = run("convert", first, "whole.parquet", "--join", second)
    assert out.code == 0, out.err
    assert run("estimate", "whole.parquet").code == 0
    assert run("convert", first, second, "--join", second, "--overwrite").code == 2
    for words in (("info", first, first), ("diff", first, first), ("batch-report", first, "-o", "drift")):
        refused = run(*words, "--join", second)
        assert refused.code == 2, words
        assert "convert LOG OUT --join FILE" in refused.err
