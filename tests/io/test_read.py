"""What is the same for files of all formats: what they are taken for, their hash, a part of them."""

import hashlib
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import friction_audit
from friction_audit.errors import UsageError
from friction_audit.io.files import sha256_of
from friction_audit.io.readers import ReadOptions, csv as reader, read_log
from friction_audit.io.readers.csv_lines import Dialect, sniff_csv
from friction_audit.io.recording import Recording
from friction_audit.io.writers.tables import Writer
from friction_audit.io.writers.write_log import write_log
from tests.each_case import EACH_WRITER
from tests.io.synthetic_recordings import read_text, refused, tidy_frame, write_tidy_csv


def test_an_unknown_format(tmp_path: Path) -> None:
    path = tmp_path / "photo.jpg"
    path.write_bytes(b"\xff\xd8\xff\xe0" + bytes(100))
    refused(r"photo.jpg: of no known format; what is read: .*csv \(.csv .tsv", read_log, path)
    path.write_text('{\n  "schema": "friction-audit/estimate/1",\n')
    refused("photo.jpg: a result of friction-audit, no log", read_log, path)


def test_the_hash_is_that_of_the_content_and_of_a_directory_that_of_its_files(tmp_path: Path) -> None:
    path = write_tidy_csv(tmp_path / "run.csv")
    log = read_log(str(path))
    assert log.source.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert log.source.path == str(path)
    path.rename(tmp_path / "b").write_bytes(b"two")
    (tmp_path / "a").write_bytes(b"one")
    assert sha256_of(tmp_path) == hashlib.sha256(b"onetwo").hexdigest()


def test_what_is_appended_later_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_tidy_csv(tmp_path / "run.csv")
    sniff = sniff_csv

    def sniff_and_grow(file: Path) -> Dialect:
        dialect = sniff(file)
        with file.open("a") as stream:
            stream.write("9,0,0,0,0,0,0,0,0,0\n" * 10)
        return dialect

    monkeypatch.setattr("friction_audit.io.readers.csv.sniff_csv", sniff_and_grow)
    log = read_log(path)
    assert len(log.t) == 300
    assert [f.code for f in log.source.findings] == ["file_grew"]


def test_an_error_of_the_disk_is_an_input_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_tidy_csv(tmp_path / "run.csv")

    def fail(_: Path, __: ReadOptions) -> Recording:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(reader, "read", fail)
    refused(r"run.csv: cannot be read: Input/output error", read_log, path)


def test_readers_and_writers_are_listed_without_their_libraries() -> None:
    heavy = ("pandas", "pyarrow", "rosbags", "mcap", "google.protobuf", "scipy")
    code = "import sys, friction_audit.io.readers, friction_audit.io.writers.write_log; "
    code += f"print([name for name in {heavy} if name in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


FOLDER = Path(__file__).parents[2] / "sample_logs" / "formats"
LOGS = sorted(FOLDER.iterdir())
WINDOWS = [(0.5, 1.5), (-3.0, 1.0), (1.0, None)]


@EACH_WRITER
def test_a_part_is_the_part_of_the_whole(writer: Writer, monkeypatch: pytest.MonkeyPatch) -> None:
    path = FOLDER / f"{writer.name}{writer.suffix}"
    whole = read_log(path)
    for is_large in (False, True):
        if is_large:  # so that readers leave out what lies outside the part; else they read all, and it is cut
            monkeypatch.setattr("friction_audit.io.readers.reader.WHOLE_BYTES", 0)
            monkeypatch.setattr("friction_audit.io.readers.csv_lines._BLOCK_BYTES", 20_000)
        for start_s, stop_s in WINDOWS if writer.name == "csv" else WINDOWS[1:] if is_large else WINDOWS[:1]:
            part = read_log(path, ReadOptions(t_start_s=start_s, t_end_s=stop_s))
            expected = whole.take_window(start_s, stop_s)
            np.testing.assert_array_equal(part.t, expected.t)
            for channel, array in expected.channels().items():
                np.testing.assert_array_equal(part.channels()[channel], array)
            assert part.source.start_s == expected.source.start_s
            assert part.source.skipped_s == expected.source.skipped_s
            assert part.take_window(start_s, stop_s) is part


def test_a_part_is_on_the_scaled_clock() -> None:
    options = ReadOptions(t_start_s=1.0, t_end_s=2.0, time_scale=2.0)
    expected = read_log(LOGS[0], ReadOptions(time_scale=2.0)).take_window(1.0, 2.0)
    np.testing.assert_array_equal(read_log(LOGS[0], options).t, expected.t)


def test_a_part_of_a_part_lies_within_it() -> None:
    part = friction_audit.read_log(LOGS[0], t_start_s=0.5, t_end_s=2.0)
    assert part.take_window(0.5, 1.0).source.skipped_s == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("path", LOGS, ids=[path.name for path in LOGS])
def test_a_part_beyond_the_end_is_refused_with_the_duration(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("friction_audit.io.readers.reader.WHOLE_BYTES", 0)
    with pytest.raises(UsageError, match=r"0 samples between 5000 s and its end; the log lasts from 0 to"):
        read_log(path, ReadOptions(t_start_s=5000.0))


def wrapped(table: pd.DataFrame) -> pd.DataFrame:
    """Three times the angle, within one turn."""
    return table.assign(**{f"q_{j}": (3.0 * table[f"q_{j}"] + np.pi) % (2.0 * np.pi) - np.pi for j in (1, 2, 3)})


def held(table: pd.DataFrame) -> pd.DataFrame:
    """Every tenth sample, written ten times."""
    kept = table[table.index // 10 * 10 == table.index]
    return table[["time"]].join(kept.drop(columns="time")).ffill()


@pytest.mark.parametrize(
    ("change", "factor", "options"),
    [
        (lambda table: table[np.random.default_rng(0).uniform(size=len(table)) > 0.2], 1.0, {}),
        (lambda table: table.assign(q_2=table["q_2"].mask(table.index % 500 == 2)), 1.0, {}),
        (lambda table: table.assign(q_2=table["q_2"].mask(table.index == 1234, 50.0)), 1.0, {}),
        (lambda table: table.assign(dq_2=np.nan, dq_1=np.nan, dq_3=np.nan), 1.0, {}),
        (lambda table: table.assign(ddq_1=0.0, ddq_2=0.0, ddq_3=0.0), 1.0, {}),
        (wrapped, 3.0, {}),
        (held, 1.0, {}),
        (lambda table: table, 0.5, {"time_scale": 2.0}),
        (lambda table: table.assign(dq_1=0.0, dq_2=0.0, dq_3=0.0), 1.0, {"mapping": {"dq": "derivative"}}),
    ],
    ids=["uneven", "rows lost", "wild", "empty", "acceleration", "wrapped", "held", "scaled", "asked for"],
)
def test_a_velocity_is_made_from_a_position_whose_faults_are_mended(
    tmp_path: Path, change: Callable[[pd.DataFrame], pd.DataFrame], factor: float, options: dict[str, Any]
) -> None:
    """KUKA's FRI gives no velocity, and many ROS drivers leave it empty, or fill it with zeros."""
    table = tidy_frame()
    if "mapping" in options:
        refused(r"velocity was not recorded: .* --map dq=derivative", read_text, tmp_path, change(table))
    log = read_text(tmp_path, change(table.drop(columns=["dq_1", "dq_2", "dq_3"])), **options)
    rows = np.rint(log.t * 1000.0 * (factor if "time_scale" in options else 1.0)).astype(int)
    expected = factor * table[["dq_1", "dq_2", "dq_3"]].to_numpy()[rows]
    np.testing.assert_allclose(log.dq, expected, atol=0.05)
    assert (log.source.clock_windows, log.source.channels["dq"]) == (0, "derivative")
    assert "velocity_derived" in {finding.code for finding in log.source.findings}


@EACH_WRITER
def test_a_velocity_that_was_made_is_not_written_as_logged(tmp_path: Path, writer: Writer) -> None:
    t = np.arange(0.0, 2.0, 0.002)
    turn = np.pi * t[:, np.newaxis] + np.arange(7)
    names = [*(f"q_{j}" for j in range(1, 8)), *(f"tau_J_{j}" for j in range(1, 8))]
    arrays = dict(zip(names, [*np.sin(turn).T, *np.sign(np.cos(turn)).T], strict=True))
    log = friction_audit.log_from_frame({"time": t} | arrays)
    path = tmp_path / f"run{writer.suffix}"
    write_log(log, path, dialect=writer.name)
    again = read_log(path)
    assert again.source.channels["dq"] == "derivative"
    inside = slice(-len(again.t) + 20, None)  # the first row of libfranka's tables is left out; they have six digits
    np.testing.assert_allclose(again.dq[inside], log.dq[inside], atol=1e-2)


@pytest.mark.parametrize(("count", "omega", "most"), [(1.5e-3, 1.0, 0.005), (6e-6, 1.0, 0.001), (1.5e-3, 8.0, 0.02)])
def test_the_velocity_of_a_coarse_position_is_not_mostly_noise(count: float, omega: float, most: float) -> None:
    t = np.arange(0.0, 20.0, 0.002)
    wild = 3.0 * (t == t[5000])  # is left out, and no noise
    q = np.rint((0.5 * np.sin(omega * t) + wild) / count) * count
    log = friction_audit.log_from_frame({"time": t, "q_1": q, "tau_J_1": np.sign(np.cos(omega * t)) + 1e-3 * t})
    error = log.dq[50:-50, 0] - 0.5 * omega * np.cos(omega * log.t[50:-50])
    assert np.std(error) < most  # [rad/s]; of 20 ms of the slow coarse one 0.017; of 100 ms of the fast one 0.047
    assert ("through 21 samples" in str(log.source.findings)) == (count < 1e-5)


def test_two_samples_have_a_velocity_too(tmp_path: Path) -> None:
    assert read_text(tmp_path, "time_s,q,tau\n0,1,1\n0.5,2,1\n").dq[:, 0].tolist() == [2.0, 2.0]
