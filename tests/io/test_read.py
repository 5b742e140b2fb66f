import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from friction_audit.errors import InputError, UsageError
from friction_audit.io.files import sha256_of
from friction_audit.io.readers import READERS, ReadOptions, list_topics, read_log
from friction_audit.io.readers import csv as reader
from friction_audit.io.readers.csv_lines import Dialect, sniff_csv
from friction_audit.io.recording import Recording
from tests.io.synthetic_recordings import motion, tidy_frame, write_tidy_csv


def test_no_such_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none.csv: no such file or directory; check the path"):
        read_log(tmp_path / "none.csv")


@pytest.mark.parametrize("suffix", sorted({suffix for reader in READERS for suffix in reader.suffixes}))
def test_an_empty_file(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"run{suffix}"
    path.touch()
    with pytest.raises(InputError, match=r"the file is empty \(0 bytes\)"):
        read_log(path)


def test_a_directory_that_is_no_bag(tmp_path: Path) -> None:
    write_tidy_csv(tmp_path / "run.csv")
    with pytest.raises(InputError, match=r"without the storage files of a bag or .*; what is read: .*parquet"):
        read_log(tmp_path)


def test_no_permission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_tidy_csv(tmp_path / "run.csv")

    def refuse(self: Path, *_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(InputError, match=r"run.csv: no permission to read it"):
        read_log(path)
    with pytest.raises(InputError, match=r"run.csv: no permission to read it"):
        list_topics(path)


def test_an_unknown_format(tmp_path: Path) -> None:
    path = tmp_path / "photo.jpg"
    path.write_bytes(b"\xff\xd8\xff\xe0" + bytes(100))
    with pytest.raises(InputError, match=r"photo.jpg: of no known format; what is read: .*csv \(.csv .tsv"):
        read_log(path)


@pytest.mark.parametrize("suffix", [".parquet", ".npz"])
def test_a_table_under_a_wrong_name_is_read_by_content(tmp_path: Path, suffix: str) -> None:
    log = read_log(write_tidy_csv(tmp_path / f"run{suffix}"))
    assert log.source.format == "csv"
    assert [f.code for f in log.source.findings] == ["suffix_mismatch"]


def test_binary_under_the_name_of_a_text_table(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_bytes(bytes(range(256)) * 20)
    with pytest.raises(InputError, match=r"run\.csv: "):
        read_log(path)


def test_the_hash_is_that_of_the_content(tmp_path: Path) -> None:
    path = write_tidy_csv(tmp_path / "run.csv")
    log = read_log(str(path))
    assert log.source.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert log.source.path == str(path)


def test_the_hash_of_a_directory_is_that_of_its_files_in_order(tmp_path: Path) -> None:
    (tmp_path / "b").write_bytes(b"two")
    (tmp_path / "a").write_bytes(b"one")
    assert sha256_of(tmp_path) == hashlib.sha256(b"onetwo").hexdigest()


def test_a_file_that_grows_while_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_tidy_csv(tmp_path / "run.csv")
    csv_read = reader.read

    def read_and_grow(file: Path, options: ReadOptions) -> Recording:
        recording = csv_read(file, options)
        with file.open("a") as stream:
            stream.write("9,0,0,0,0,0,0,0,0,0\n")
        return recording

    monkeypatch.setattr(reader, "read", read_and_grow)
    log = read_log(path)
    assert [(f.code, f.damaged, f.amount) for f in log.source.findings] == [("file_grew", True, 20.0)]


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


def test_a_file_that_changes_and_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_tidy_csv(tmp_path / "run.csv")

    def grow_and_fail(file: Path, _: ReadOptions) -> Recording:
        with file.open("a") as stream:
            stream.write("9")
        raise InputError(f"{file}: torn")

    monkeypatch.setattr(reader, "read", grow_and_fail)
    with pytest.raises(InputError, match="torn; the file changed while it was read"):
        read_log(path)


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".npz"])
def test_a_table_has_no_topics(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"run{suffix}"
    if suffix == ".csv":
        write_tidy_csv(path)
    elif suffix == ".parquet":
        tidy_frame(300).to_parquet(path)
    else:
        np.savez(path, **motion(300))  # type: ignore[arg-type]
    with pytest.raises(InputError, match="a table has no topics, and --topic asks for /joint_states"):
        read_log(path, ReadOptions(topic="/joint_states"))


def test_an_error_of_the_disk_is_an_input_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_tidy_csv(tmp_path / "run.csv")

    def fail(_: Path, __: ReadOptions) -> Recording:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(reader, "read", fail)
    with pytest.raises(InputError, match=r"run.csv: cannot be read: Input/output error"):
        read_log(path)


def test_importing_ingest_is_light() -> None:
    heavy = ("pandas", "pyarrow", "rosbags", "mcap")
    code = f"import sys, friction_audit.io.readers; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_options_that_cannot_be() -> None:
    with pytest.raises(UsageError, match=r"--map torque: no such channel; channels are t, q, dq"):
        ReadOptions(mapping={"torque": "x"})
    with pytest.raises(UsageError, match=r"--map tau_j: no such channel \(did you mean tau_J"):
        ReadOptions(mapping={"tau_j": "x"})
    with pytest.raises(UsageError, match=r"--time-scale -1: expected a factor above zero"):
        ReadOptions(time_scale=-1.0)
